"""Calibration of random hexapods from hostile files: no fit that misses held-out rows is called
believable.

    python tests/campaigns/hostile_files.py [--trials 100] [--seed 0] [--rows 48] [--kind NAME]
        [--verbose]

Each trial draws a platform on six rods (some files have a reference pose, some an example, some
neither), a true machine within 0.2 % of its size, and a file of joints and poses, and spoils the
file in one way. The file goes the way of `symkin calibrate fit`; the mechanism that would be
written is read back, and its direct problem at exact joints of held-out poses is compared with
these poses, over the standard deviation that the fit's covariance gives there, frames of base and
platform included (the report's figure is in aligned frames). The data, the files and the
held-out poses are made here in plain NumPy.

The exit status is 1 where a believable fit misses a held-out row by more than `MOST` standard
deviations, where a file of another machine or with a wrong column is believable, or where fewer
than `LEAST_GOOD` of the files without a slip (clean, blanks) are.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from helpers.hexapods import matrices
from helpers.inside import (
    ClosedConfigurations,
    FitReport,
    build_closure,
    calibrated_mechanism,
    covariance_root,
    fit_file,
    pose_slopes,
    read_measurements,
    variables_of,
    with_parameters,
)
from symkin import SymkinError

MOST = 5.0
"""Largest error at a held-out row over its stated standard deviation."""
LEAST_GOOD = 0.95
"""Least share of believable fits among files without a slip."""
HELD_OUT = 12
SIGMA_LEG, SIGMA_POSITION, SIGMA_ANGLE = 2e-6, 1e-5, 2e-5
"""Noise of legs and positions, over the radius of the base, and of each component of an orientation
(rad).
"""


@dataclass(frozen=True)
class Hexapod:
    """Joint centres (6, 3) of base and platform, offsets (6,), the pose of its home."""

    base: np.ndarray
    platform: np.ndarray
    offset: np.ndarray
    height: float

    def legs(self, position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
        """Leg readings (n, 6) at poses."""
        ends = position[:, None] + np.einsum("nij,kj->nki", matrices(quaternion), self.platform)
        return np.linalg.norm(ends - self.base, axis=2) - self.offset

    def near(self, spread: float, rng: np.random.Generator) -> Hexapod:
        """Another one with every joint centre and offset within `spread`."""
        return Hexapod(
            *(
                t + rng.uniform(-spread, spread, t.shape)
                for t in (self.base, self.platform, self.offset)
            ),
            self.height,
        )


@dataclass(frozen=True)
class Table:
    """What a file holds; NaN is an empty cell."""

    legs: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    oriented: bool = True


def turned(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) turned by rotation vectors (n, 3) in the platform's frame."""
    angle = np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)
    w, u = np.cos(angle / 2), np.sin(angle / 2) * v / angle
    a, b = q[:, :1], q[:, 1:]
    return np.hstack([a * w - np.sum(b * u, axis=1, keepdims=True), a * u + w * b + np.cross(b, u)])


# --- machines -------------------------------------------------------------------------------------


def random_hexapod(rng: np.random.Generator) -> Hexapod:
    """Pairs of joints on two rings, base and platform paired the other way, each joint off its
    place by some per cent.
    """
    radius = 10 ** rng.uniform(2.0, 2.9)
    ratio, height = rng.uniform(0.45, 0.9), rng.uniform(0.7, 1.4) * radius
    gaps = np.radians(rng.uniform(12, 40, 2))
    thirds = np.repeat(np.radians([0, 120, 240]), 2)
    side = np.tile([-0.5, 0.5], 3)
    below = thirds + side * gaps[0]
    above = thirds + side * (np.radians(120) - gaps[1])
    ring = [
        r * np.column_stack([np.cos(a), np.sin(a), np.zeros(6)])
        + 0.04 * radius * rng.uniform(-1, 1, (6, 3))
        for r, a in ((radius, below), (ratio * radius, above))
    ]
    offset = rng.uniform(0.3, 0.5) * radius * np.ones(6) if rng.random() < 0.5 else np.zeros(6)
    return Hexapod(ring[0], ring[1], offset, height)


def random_poses(
    machine: Hexapod, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    radius = float(np.linalg.norm(machine.base[0]))
    position = np.array([0, 0, machine.height]) + radius * rng.uniform(
        [-0.25, -0.25, -0.12], [0.25, 0.25, 0.12], (count, 3)
    )
    return position, turned(
        np.tile([1.0, 0, 0, 0], (count, 1)), np.radians(15) * rng.uniform(-1, 1, (count, 3))
    )


def toml(machine: Hexapod, known: str) -> str:
    """A mechanism file; `known` says what of home stands in it: reference, example or nothing."""
    lines = ["format = 1", 'name = "hexapod"', 'length_unit = "mm"', 'angle_unit = "deg"']
    for k in range(6):
        base, platform = (
            ", ".join(repr(float(v)) for v in t[k]) for t in (machine.base, machine.platform)
        )
        lines += [
            "[[limb]]",
            f'name = "leg{k + 1}"',
            'type = "UPS"',
            f"base = [{base}]",
            f"platform = [{platform}]",
        ]
        lines += [f"offset = {float(machine.offset[k])!r}"]
    if known == "reference":
        lines += ["[platform]", f"position = [0.0, 0.0, {machine.height!r}]"]
    if known == "example":
        home = machine.legs(np.array([[0, 0, machine.height]]), np.array([[1.0, 0, 0, 0]]))[0]
        lines += [
            "[example]",
            f"joints = {[float(v) for v in home]}",
            f"start = [0.0, 0.0, {machine.height!r}, 1.0, 0.0, 0.0, 0.0]",
        ]
    return "\n".join(lines) + "\n"


def csv(table: Table, sigmas: tuple[float, float, float]) -> str:
    """A measurement file with standard deviations."""
    names = (
        [f"leg{k}[mm]" for k in range(1, 7)]
        + [f"sigma_leg{k}[mm]" for k in range(1, 7)]
        + ["x[mm]", "y[mm]", "z[mm]"]
    )
    names += ["sigma_x[mm]", "sigma_y[mm]", "sigma_z[mm]"]
    count = len(table.legs)
    columns = [
        table.legs,
        np.full((count, 6), sigmas[0]),
        table.position,
        np.full((count, 3), sigmas[1]),
    ]
    if table.oriented:
        names += ["qw", "qx", "qy", "qz", "sigma_orientation[deg]"]
        columns += [table.quaternion, np.full((count, 1), np.degrees(sigmas[2]))]
    rows = [
        ",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in np.hstack(columns)
    ]
    return "\n".join([",".join(names), *rows]) + "\n"


# --- hostility ------------------------------------------------------------------------------------

Spoiler = Callable[[Table, np.random.Generator], Table]


def exchanged(order: Callable[[np.random.Generator], np.ndarray]) -> Spoiler:
    return lambda t, rng: replace(t, legs=t.legs[:, order(rng)])


def two(rng: np.random.Generator) -> np.ndarray:
    order = np.arange(6)
    a, b = rng.choice(6, 2, replace=False)
    order[[a, b]] = order[[b, a]]
    return order


def any_order(rng: np.random.Generator) -> np.ndarray:
    while True:
        order = rng.permutation(6)
        if np.any(order != np.arange(6)):
            return order


def one_sign(t: Table, rng: np.random.Generator) -> Table:
    return replace(t, legs=t.legs * np.where(np.arange(6) == rng.integers(6), -1.0, 1.0))


def mirrored(t: Table, rng: np.random.Generator) -> Table:
    return replace(t, position=t.position * np.where(np.arange(3) == rng.integers(3), -1.0, 1.0))


def one_in_metres(t: Table, rng: np.random.Generator) -> Table:
    return replace(t, legs=t.legs * np.where(np.arange(6) == rng.integers(6), 1e-3, 1.0))


def blanked(share: float, *, position: bool = False) -> Spoiler:
    def spoil(t: Table, rng: np.random.Generator) -> Table:
        rows = rng.random(len(t.legs)) < share
        rows[rng.integers(len(rows))] = True
        what = "position" if position else "quaternion"
        return replace(t, **{what: np.where(rows[:, None], np.nan, getattr(t, what))})

    return spoil


def outliers(share: float) -> Spoiler:
    """Rows, by share, where one leg, a position or an orientation is off by 20 to 2000 times its
    noise.
    """

    def spoil(t: Table, rng: np.random.Generator) -> Table:
        legs, position, q, radius = (
            t.legs.copy(),
            t.position.copy(),
            t.quaternion.copy(),
            float(np.max(np.abs(t.position))),
        )
        for k in rng.choice(len(legs), max(1, round(share * len(legs))), replace=False):
            size = 10 ** rng.uniform(1.3, 3.3) * rng.choice([-1, 1])
            what = rng.integers(3)
            if what == 0:
                legs[k, rng.integers(6)] += size * SIGMA_POSITION * radius
            elif what == 1:
                position[k, rng.integers(3)] += size * SIGMA_POSITION * radius
            else:
                q[k] = turned(q[k : k + 1], size * SIGMA_ANGLE * np.eye(3)[[rng.integers(3)]])[0]
        return replace(t, legs=legs, position=position, quaternion=q)

    return spoil


KINDS: dict[str, Spoiler] = {
    "clean": lambda t, _: t,
    "positions only": lambda t, _: replace(t, oriented=False),
    "blank orientations, 2 %": blanked(0.02),
    "blank orientations, 40 %": blanked(0.4),
    "blank positions, 10 %": blanked(0.1, position=True),
    "two legs exchanged": exchanged(two),
    "legs in any order": exchanged(any_order),
    "legs exchanged, positions only": lambda t, rng: replace(
        exchanged(two)(t, rng), oriented=False
    ),
    "one leg's sign": one_sign,
    "all legs' signs": lambda t, _: replace(t, legs=-t.legs),
    "mirrored axis": mirrored,
    "inverse orientations": lambda t, _: replace(t, quaternion=t.quaternion * (1, -1, -1, -1)),
    "all legs in metres": lambda t, _: replace(t, legs=1e-3 * t.legs),
    "one leg in metres": one_in_metres,
    "positions in metres": lambda t, _: replace(t, position=1e-3 * t.position),
    "outliers, 1 row": outliers(0.0),
    "outliers, 5 %": outliers(0.05),
    "outliers, 15 %": outliers(0.15),
    "outliers, 30 %": outliers(0.30),
    "another machine": lambda t, _: t,
}
SLIPS = tuple(
    kind
    for kind in KINDS
    if any(
        word in kind
        for word in ("exchanged", "order", "sign", "mirrored", "inverse", "metres", "another")
    )
)
HARMLESS = (
    "clean",
    "positions only",
    "blank orientations, 2 %",
    "blank orientations, 40 %",
    "blank positions, 10 %",
)


# --- one trial ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Outcome:
    """The verdict of one file, and the largest error at held-out rows over its stated sigma (None:
    no file is written).
    """

    kind: str
    believable: bool
    verdict: str
    miss: float | None


def trial(kind: str, number: int, seed: int, rows: int, folder: Path) -> Outcome:
    rng = np.random.default_rng([seed, number])
    nominal = random_hexapod(rng)
    radius = float(np.linalg.norm(nominal.base[0]))
    truth = (random_hexapod(rng) if kind == "another machine" else nominal).near(2e-3 * radius, rng)
    if kind == "another machine":
        scale = radius / float(np.linalg.norm(truth.base[0]))
        truth = Hexapod(
            scale * truth.base, scale * truth.platform, nominal.offset, scale * truth.height
        )
    sigmas = (SIGMA_LEG * radius, SIGMA_POSITION * radius, SIGMA_ANGLE)
    position, q = random_poses(truth, rows, rng)
    table = Table(
        truth.legs(position, q) + sigmas[0] * rng.normal(size=(rows, 6)),
        position + sigmas[1] * rng.normal(size=(rows, 3)),
        turned(q, sigmas[2] * rng.normal(size=(rows, 3))),
    )
    spoilt = KINDS[kind](table, rng)
    mechanism, data = folder / "hexapod.toml", folder / "data.csv"
    mechanism.write_text(toml(nominal, str(rng.choice(["reference", "example", "nothing"]))))
    data.write_text(csv(spoilt, sigmas))
    loaded = symkin.load(str(mechanism))
    try:
        report = fit_file(loaded, read_measurements(data, loaded))
    except SymkinError as error:
        return Outcome(kind, False, f"refused: {error}", None)
    miss = (
        largest_miss(report, truth, *random_poses(truth, HELD_OUT, rng), oriented=spoilt.oriented)
        if report.usable
        else None
    )
    return Outcome(kind, report.believable, report.verdict, miss)


def largest_miss(
    report: FitReport, truth: Hexapod, position: np.ndarray, q: np.ndarray, *, oriented: bool
) -> float:
    """Largest component of position and rotation by which the written file misses poses, over the
    stated standard deviation.
    """
    legs = truth.legs(position, q)
    starts = np.hstack([position, q])
    written = Path(report.data).with_name("written.toml")
    written.write_text(calibrated_mechanism(report).to_toml())
    made, misses = symkin.load(str(written)), []
    results = [
        symkin.solve(made, joints=given, start=start, check=False)
        for given, start in zip(legs, starts, strict=True)
    ]
    if any(found.status != "ok" for found in results):
        return np.inf
    fit = report.fit
    identified = with_parameters(replace(fit.mechanism, example=None), fit.values)
    closure = build_closure(identified)
    values = np.array([variables_of(closure, found.solution.values) for found in results])
    poses = np.array([[*r.solution.position, *r.solution.quaternion] for r in results])
    taken = ClosedConfigurations(values, legs, poses)
    slopes, _ = pose_slopes(identified, taken, fit.problem.names)
    # misses are of the frames, too, which the report's figures take away
    stated = np.linalg.norm(slopes @ covariance_root(fit.covariance, fit.problem), axis=2)
    for k, found in enumerate(results):
        off = np.asarray(found.solution.position) - position[k]
        turn = matrices(q[k : k + 1])[0].T @ np.asarray(found.solution.pose.rotation)
        angle = 0.5 * np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        misses.append(
            np.abs(np.concatenate([off, angle if oriented else []]))
            / stated[k][: 6 if oriented else 3]
        )
    return float(np.max(misses))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rows", type=int, default=48)
    parser.add_argument("--kind", choices=list(KINDS))
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    kinds = [options.kind] if options.kind else list(KINDS)
    found: list[Outcome] = []
    begin = time.process_time()
    for number in range(options.trials):
        kind = kinds[number % len(kinds)]
        with tempfile.TemporaryDirectory() as folder:
            found.append(trial(kind, number, options.seed, options.rows, Path(folder)))
        if options.verbose:
            o = found[-1]
            print(
                f"{number:4d} {o.kind:32s} {'' if o.miss is None else f'{o.miss:.3g}':>8s}  "
                f"{o.verdict[:240]}",
                flush=True,
            )
    print(
        f"seed {options.seed}, {options.trials} hexapods, {options.rows} rows each, "
        f"{time.process_time() - begin:.0f} s of processor time"
    )
    print(
        f"{'kind of file':32s} {'files':>6s} {'believable':>11s} {'written':>8s} "
        f"{'largest miss when believable, in sigma':>40s}"
    )
    lies = 0
    for kind in kinds:
        same = [o for o in found if o.kind == kind]
        misses = [o.miss for o in same if o.believable and o.miss is not None]
        lies += sum(miss > MOST for miss in misses)
        written = sum(o.miss is not None for o in same)
        print(
            f"{kind:32s} {len(same):6d} {sum(o.believable for o in same):11d} {written:8d} "
            f"{f'{max(misses):.3g}' if misses else '-':>40s}"
        )
    slips = sum(o.believable for o in found if o.kind in SLIPS)
    harmless = [o for o in found if o.kind in HARMLESS]
    good = sum(o.believable for o in harmless) / len(harmless) if harmless else 1.0
    print(f"believable and off by more than {MOST:g} sigma: {lies} of {len(found)} (0 is allowed)")
    print(f"believable although a column or the machine is wrong: {slips} (0 is allowed)")
    print(
        f"believable among files without a slip: {100 * good:.0f} % (at least "
        f"{100 * LEAST_GOOD:.0f} %)"
    )
    return 0 if lies == slips == 0 and good >= LEAST_GOOD else 1


if __name__ == "__main__":
    sys.exit(main())
