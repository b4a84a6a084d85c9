"""How do fits of simulated readings end? Machines of all kinds, their geometry off at random, whole
poses (the shipped delta: positions) read with noise; right data sets and wrong ones.

    python tests/campaigns/calibration.py [MACHINE ...] [--sets 40] [--off 1e-3] [--noise 1e-4]
        [--postures 40] [--any-machine] [--wrong | --covariance] [--seed 0]

`--off` and `--noise` are shares of the size (angles: radians). Of right sets it counts those that
end well, those that are believable, and those whose held-out readings (a fifth) agree, whitened by
noise and covariance (p > 0.001); what is off by more than a correction of the file's machine is
believable with `--any-machine` alone. With `--covariance` one machine is read anew in each set, and
what the geometry fitted says of the readings is compared with readings without errors, along the
directions that the readings tell, over the standard deviation that is stated there: the ratio of
variances is 1. With `--wrong` the sets are spoilt, a fault each in turn: two columns exchanged, a
joint's sign reversed, three times the noise, one outlier kept; none may be believable.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from helpers import samples
from helpers.built_machines import built, explained_errors, random_postures
from helpers.inside import (
    Noise,
    draw_held_out,
    predict_held_out,
    simulate_readings,
)
from symkin import SymkinError

MACHINES: dict[str, tuple[Callable[[], symkin.Mechanism], tuple[str, ...]]] = {
    "five_bar": (lambda: replace(samples.five_bar(), motion="planar"), ("pose",)),
    "three_rps": (samples.three_rps, ("pose",)),
    "three_rrr": (lambda: samples.three_rrr("planar"), ("pose",)),
    "delta_six": (lambda: replace(samples.delta(), motion="spatial"), ("pose",)),
    "delta": (lambda: replace(symkin.load("delta"), motion="spatial"), ("position",)),
    "ankle": (lambda: symkin.load("ankle"), ("pose",)),
    "gluon_6l3": (lambda: symkin.load("gluon_6l3"), ("pose",)),
    "ur5e": (lambda: symkin.load("ur5e"), ("pose",)),
    "ren2008": (lambda: symkin.load("ren2008"), ("pose",)),
}
_MOST_TRIES = 20
"""Machines that are drawn until one moves."""
FAULTS = ("exchanged columns", "reversed sign", "tripled noise", "outlier kept")


@dataclass(frozen=True)
class Draw:
    """A nominal machine and readings of a true one, with their standard deviations as stated."""

    nominal: symkin.Mechanism
    readings: symkin.Measurements


def drawn(
    name: str,
    off: float,
    noise: float,
    postures: int,
    seed: int,
    more: float = 1.0,
    again: int = 0,
) -> Draw:
    """A set of readings with errors of `more` times the standard deviation that is stated; `again`
    draws other errors at the same postures.
    """
    make, kinds = MACHINES[name]
    nominal = make()
    rng, size = np.random.default_rng([seed, len(name)]), nominal.characteristic_length
    for tried in range(1, _MOST_TRIES + 1):
        true = built(nominal, off, rng)
        try:
            made = random_postures(nominal, true, postures, rng)
            break
        except SymkinError:
            if tried == _MOST_TRIES:
                raise
    louder = Noise(position=more * noise * size, orientation=more * noise)
    groups, own = np.full(postures, -1), np.random.default_rng([seed, 1, again])
    taken = simulate_readings(true, made, groups, kinds, louder, own)
    turns = None if taken.orientation is None else noise
    stated = replace(taken, position_sigma=noise * size, orientation_sigma=turns)
    return Draw(nominal, stated)


def spoilt(draw: Draw, fault: str, seed: int) -> symkin.Measurements:
    """The readings of a draw with a fault."""
    m, rng = draw.readings, np.random.default_rng([seed, 2])
    joints = m.joints.copy()
    if fault == "exchanged columns":
        a, b = rng.choice(joints.shape[1], 2, replace=False)
        joints[:, [a, b]] = joints[:, [b, a]]
        return replace(m, joints=joints)
    if fault == "reversed sign":
        joints[:, rng.integers(joints.shape[1])] *= -1.0
        return replace(m, joints=joints)
    if fault == "outlier kept":
        position = m.position.copy()
        k = rng.choice(np.flatnonzero(~_held_out(m, seed)))
        away = rng.normal(size=3)
        position[k] += 20.0 * float(np.max(m.position_sigma)) * away / np.linalg.norm(away)
        return replace(m, position=position)
    return m


def _held_out(m: symkin.Measurements, seed: int) -> np.ndarray:
    return draw_held_out(m, max(1, len(m) // 5), seed)


def fitted(draw: Draw, m: symkin.Measurements, seed: int, **options):
    """The fit to four fifths of the readings, and its prediction of the rest."""
    held = _held_out(m, seed)
    fit = symkin.calibrate(draw.nominal, m.subset(~held), seed=seed, **options)
    return fit, predict_held_out(fit, m.subset(held), seed)


def right_sets(name: str, args: argparse.Namespace) -> None:
    ended = believed = agreed = 0
    steps, seconds, why = [], [], []
    for k in range(args.sets):
        draw = drawn(name, args.off, args.noise, args.postures, args.seed + k)
        begin = time.process_time()
        try:
            fit, held = fitted(draw, draw.readings, k, any_machine=args.any_machine)
        except SymkinError as error:
            why.append(f"{k}: {error}")
            continue
        seconds.append(time.process_time() - begin)
        steps.append(fit.iterations)
        ended += fit.status == "ok"
        believed += fit.believable
        agreed += fit.believable and held.believable
        if not (fit.believable and held.believable):
            chi = fit.chi_square / max(fit.degrees, 1)
            why.append(
                f"{k}: {fit.status} chi2/dof {chi:.3g} rank {fit.rank}/{len(fit.problem.names)} "
                f"condition {fit.identifiability.condition:.3g} unsolved "
                f"{len(fit.unsolved)} refused {fit.refused} held p {held.p_value}"
            )
    print(
        f"{name:12s} ended {ended:3d} believable {believed:3d} agreed {agreed:3d} of {args.sets}; "
        f"evaluations {np.median(steps or [0]):.0f}, {np.median(seconds or [0]):.2f} s each",
        flush=True,
    )
    for text in why[: args.shown]:
        print("   ", text[:240], flush=True)


def covariance(name: str, args: argparse.Namespace) -> None:
    """Print the mean square of what the fits' readings are off those without errors, over what is
    stated, and the least and largest of single directions, strongest first; then the largest
    scatter of a parameter over its standard deviation.
    """
    draw = drawn(name, args.off, args.noise, args.postures, args.seed)
    exact = drawn(name, args.off, args.noise, args.postures, args.seed, more=0.0).readings
    squares, values, sigmas = [], [], []
    for k in range(args.sets):
        again = drawn(name, args.off, args.noise, args.postures, args.seed, again=k)
        fit = symkin.calibrate(draw.nominal, again.readings, outliers="ignore")
        if fit.status == "ok":
            squares.append(explained_errors(fit, exact) ** 2)
            values.append(fit.state.p)
            sigmas.append([p.sigma or np.inf for p in fit.parameters])
    width = min(map(len, squares))
    mean = np.mean([s[:width] for s in squares], axis=0)
    scatter = np.std(values, axis=0, ddof=1) / np.sqrt(np.mean(np.square(sigmas), axis=0))
    print(
        f"{name:12s} variance over the stated one: mean {np.mean(mean):.3f}, of {width} directions "
        f"{np.min(mean):.2f} to {np.max(mean):.2f}; scatter of a parameter over its standard "
        f"deviation up to {np.max(scatter):.2f}; {len(squares)} of {args.sets} fits",
        flush=True,
    )


def wrong_sets(name: str, args: argparse.Namespace) -> None:
    believed = 0
    for k in range(args.sets):
        fault = FAULTS[k % len(FAULTS)]
        more = 3.0 if fault == "tripled noise" else 1.0
        draw = drawn(name, args.off, args.noise, args.postures, args.seed + k, more)
        options = {"outliers": "ignore"} if fault == "outlier kept" else {}
        try:
            fit, held = fitted(draw, spoilt(draw, fault, k), k, **options)
        except SymkinError:
            continue
        if fit.believable and held.believable:
            believed += 1
            print(f"    {name} {k}: {fault} is believed", flush=True)
    print(f"{name:12s} wrong sets believed {believed} of {args.sets}", flush=True)


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("machines", nargs="*", metavar="MACHINE")
    parser.add_argument("--sets", type=int, default=40)
    parser.add_argument("--off", type=float, default=1e-3)
    parser.add_argument("--noise", type=float, default=1e-4)
    parser.add_argument("--postures", type=int, default=40)
    parser.add_argument("--any-machine", action="store_true")
    parser.add_argument("--wrong", action="store_true")
    parser.add_argument("--covariance", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--shown", type=int, default=3)
    args = parser.parse_args()
    for name in args.machines or MACHINES:
        run = wrong_sets if args.wrong else covariance if args.covariance else right_sets
        run(name, args)


if __name__ == "__main__":
    main()
