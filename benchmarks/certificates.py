"""Whether what the quick test certifies is true: every box is held against ball arithmetic with 128
bits.

    python benchmarks/certificates.py [--points 1000000] [--seed 0] [--cases 6-6,delta]
        [--engine compiled]

Points are roots of the mechanisms that `enumeration.py` measures, at random inputs, and of small
systems with nearly double roots; each is taken many times, moved by 1e-17 to 1e-7, rays also turned
and scaled. A certificate fails if balls find no root near the point, or one that is not proved to
lie in the box, or cannot show that the box holds no other. The exit status is the number of
failures, 1 at most.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import casadi as ca
import numpy as np

import symkin
from cases import QUICK, all_cases
from symkin.certificate import certificate
from symkin.certificate.ball_system import BallSystem
from symkin.certificate.coordinates import in_phase
from symkin.certificate.discs import Knowns
from symkin.certificate.krawczyk import chart_of, enclose
from symkin.certificate.quick_test import Enclosures, enclose_all
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.model.joint import Coordinate
from symkin.numeric.balls import COMPLEX, REAL, precision, upper
from timing import Figure, seconds

BITS = 128
CLOSEST, FARTHEST = -17.0, -7.0
"""Powers of ten between which points are moved from roots."""
BALLS = 20
"""Boxes of one set of roots that balls judge in a quick run."""
REPEATS = 100
"""Points about each root."""


@dataclass(frozen=True, eq=False)
class Roots:
    """Approximate roots z (width, n) of one instance."""

    name: str
    system: AlgebraicSystem
    knowns: Knowns
    z: np.ndarray


def main() -> int:
    options = arguments()
    if options.engine == "numpy":
        os.environ["SYMKIN_ENGINE"] = "numpy"
    counts: dict[str, list[int]] = {}
    begin = time.perf_counter()
    try:
        judge(options, counts)
    except KeyboardInterrupt:
        print("interrupted; so far:")
    everything = [sum(column) for column in zip(*counts.values(), strict=True)] or [0, 0, 0]
    print(f"{'case':20}{'points':>10}{'certified':>11}{'failures':>10}")
    for name, (tried, certified, failures) in [*counts.items(), ("all", everything)]:
        print(f"{name:20}{tried:10d}{certified:11d}{failures:10d}")
    print(f"{time.perf_counter() - begin:.0f} s")
    return min(1, everything[2])


def judge(options: argparse.Namespace, counts: dict[str, list[int]]) -> None:
    """Fill, for each case, points, certified ones and failures."""
    rng = np.random.default_rng(options.seed)
    for roots in families(rng, options.seed, options.cases.split(",")):
        if sum(tried for tried, *_ in counts.values()) >= options.points:
            return
        counted = counts.setdefault(roots.name, [0, 0, 0])
        for i, value in enumerate(count_failures(roots, rng)):
            counted[i] += value


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--cases", default="", help="parts of names, separated by commas; default: all"
    )
    parser.add_argument("--engine", choices=("compiled", "numpy"), default="compiled")
    return parser.parse_args()


# --- points ---------------------------------------------------------------------------------------


def families(rng: np.random.Generator, seed: int, parts: list[str]) -> Iterator[Roots]:
    """Roots of mechanisms at random inputs and of nearly singular systems, in turn and without
    end.
    """
    sources: list[tuple[str, Callable[[], list[Roots]]]] = [
        (case.name, lambda case=case: roots_of(case, rng)) for case in all_cases(seed)
    ]
    sources += [
        (name, lambda name=name: [nearly_double(name, rng)])
        for name in ("squares", "angles", "rays")
    ]
    chosen = [source for name, source in sources if any(part in name for part in parts)]
    while True:
        for source in chosen:
            yield from source()


def roots_of(case, rng: np.random.Generator) -> list[Roots]:
    """The complex roots that `symkin.modes` has certificates made of, at inputs drawn for a
    case.
    """
    found: list[Roots] = []
    original = certificate.certify_batch

    def noted(system, z, knowns, *rest, **named):
        found.append(Roots(case.name, system, knowns, np.asarray(z)))
        return original(system, z, knowns, *rest, **named)

    certificate.certify_batch = noted
    try:
        symkin.modes(case.mechanism, **case.draw(rng))
    finally:
        certificate.certify_batch = original
    return [roots for roots in found if roots.z.size]


def nearly_double(name: str, rng: np.random.Generator) -> Roots:
    """A random system of three rows with two roots about c apart, c from 1e-12 to 1: in lengths, in
    angles, or in a ray.
    """
    width = 4 if name == "rays" else 3
    z, k = ca.SX.sym("z", width), ca.SX.sym("k", 3)
    point, c = rng.normal(size=width), 10.0 ** rng.uniform(-12, 0)
    a, b = rng.normal(size=(3, width)), rng.normal(size=(3, 3))
    place = ca.sin(z) if name == "angles" else z
    there = np.sin(point) if name == "angles" else point
    if name == "rays":
        # rows that vanish at `point` and, with the first one off by c, at a ray next to it
        b = a - np.outer(a @ point, point) / (point @ point)
        linear = ca.mtimes(ca.DM(b), z)
        rows = ca.vertcat(linear[0] * (linear[0] - c * z[0]), linear[1:])
        values, unknowns, ray = np.zeros(3), (), tuple(range(width))
    else:
        linear = ca.mtimes(ca.DM(b), place - ca.DM(there))
        rows = ca.vertcat(linear[0] ** 2 - k[0] * k[1], linear[1:] + k[2] * linear[0] ** 2)
        values = np.array([c, c * rng.choice([-1.0, 1.0]), rng.normal()])
        kind = "angle" if name == "angles" else "length"
        unknowns, ray = tuple(Coordinate(f"x{i}", kind, "passive") for i in range(3)), ()
    system = AlgebraicSystem(1.0, unknowns, z, k, rows, ray)
    root = np.sqrt(values[0] * values[1] + 0j)
    z = (
        point + 0j
        if ray
        else there + np.linalg.solve(b, [root, -values[2] * root**2, -values[2] * root**2])
    )
    return Roots(
        name,
        system,
        Knowns.exact(values[None]),
        newton(system, (np.arcsin(z) if name == "angles" else z)[:, None], values),
    )


def newton(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Least-squares Newton steps."""
    for _ in range(60):
        f, j = system.linearise(z, k[:, None].astype(complex))
        z = z - (np.linalg.pinv(j[0]) @ f[0])[:, None]
    return np.asarray(z)


def moved(roots: Roots, rng: np.random.Generator) -> np.ndarray:
    """Each root many times: moved by little or nothing, by real numbers or complex ones, rays
    turned and scaled.
    """
    z = np.repeat(roots.z, REPEATS, axis=1)
    size = 10.0 ** rng.uniform(CLOSEST, FARTHEST, z.shape[1]) * rng.integers(0, 2, z.shape[1])
    z = z + size * (
        rng.normal(size=z.shape) + 1j * rng.normal(size=z.shape) * rng.integers(0, 2, z.shape[1])
    )
    ray = list(roots.system.projective)
    z[ray] *= np.exp(rng.normal(size=z.shape[1]) + 2j * np.pi * rng.uniform(size=z.shape[1]))
    return in_phase(roots.system, z)


# --- the judge ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tried:
    """Points about roots, boxes that the quick test certifies, those of them that balls do not
    confirm, and processor seconds a point of both.
    """

    points: int
    certified: int
    failures: int
    quick_s: float
    balls_s: float


def count_failures(roots: Roots, rng: np.random.Generator) -> tuple[int, int, int]:
    """Points, those that the quick test certifies, and those of them that balls do not confirm."""
    found = tried(roots, rng)
    return found.points, found.certified, found.failures


def tried(roots: Roots, rng: np.random.Generator, most: int | None = None) -> Tried:
    """Hold the boxes of the quick test, all or `most` of them, against balls."""
    points = moved(roots, rng)
    near = np.max(np.abs(points.imag), axis=0) < 1e-7
    start = np.where(near, points.real, points)
    inputs = np.zeros(points.shape[1], dtype=int)
    boxes: list[Enclosures] = []
    quick = seconds(
        lambda: boxes.append(enclose_all(roots.system, start, near, roots.knowns, inputs))
    )
    found = boxes[0]
    proved = np.flatnonzero(found.found)[:most].tolist()
    # a structure's known values are wide balls: a box holds for all in them, so for the middles
    known = roots.knowns.numbers(0)
    thin = tuple(k if isinstance(k, float) else k.mid() for k in known)
    balls, failures = BallSystem(roots.system, thin), list[int]()
    slow = seconds(
        lambda: failures.extend(i for i in proved if not is_true(balls, start[:, i], found, i))
    )
    for i in failures[:3]:
        print(
            f"{roots.name}: a false box about {start[:, i]}, half width {found.half_width[i]}",
            file=sys.stderr,
        )
    count = points.shape[1]
    return Tried(
        count, int(np.sum(found.found)), len(failures), quick / count, slow / max(1, len(proved))
    )


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:
    """A quick certificate over a proof by balls of 128 bits, shares of points without one, and
    false ones.
    """
    rng, false, judged = np.random.default_rng(seed), 0, 0
    chosen = [
        c
        for c in all_cases(seed)
        if c.name in (QUICK if quick else [c.name for c in all_cases(seed)])
    ]
    for case in chosen:
        found = [
            tried(roots, rng, BALLS if quick else None)
            for _ in range(3)
            for roots in roots_of(case, rng)
        ]
        found = found[1:]  # the first one compiles
        if not found:
            continue
        false, judged = (
            false + sum(t.failures for t in found),
            judged + sum(t.certified for t in found),
        )
        ratio = statistics.median(t.quick_s / t.balls_s for t in found if t.balls_s)
        yield Figure(
            f"certificates: {case.name}, quick test over balls", ratio, "processor time a point"
        )
    yield Figure(
        "certificates: false ones",
        false,
        f"of {judged}, of each root a few" if quick else f"of {judged}",
    )


def is_true(balls: BallSystem, point: np.ndarray, found: Enclosures, i: int) -> bool:
    """Whether balls prove that box i holds one root: by Krawczyk's operator on the box itself, and
    else by a smaller box within it and by derivatives on the whole that allow no second root.
    """
    ring, chart = REAL if found.is_real[i] else COMPLEX, chart_of(balls, point)
    if chart is None:
        return False
    centre, half = found.centre[:, i], float(found.half_width[i])
    with precision(BITS):
        exact = [
            ring.number(c.real) if ring.is_real else ring.number(c.real, c.imag)
            for c in centre.tolist()
        ]
        n = len(exact)
        side, most = (
            ring.column([ring.around_zero(half)] * n),
            ring.column([ring.around_zero(0.999 * half)] * n),
        )
        slope = chart.matrix(
            ring, balls.jacobian(ring, [c + ring.around_zero(half) for c in exact])
        )
        inverse = slope.mid().inv(nonstop=True).mid()
        off = (
            ring.matrix(n, n, [int(a == b) for a in range(n) for b in range(n)]) - inverse * slope
        ) * side
        rows = [*balls.rows(ring, exact), *([] if chart.patch is None else [ring.number(0)])]
        if most.contains(off - inverse * ring.column(rows)):
            return True
        if not most.contains(off):
            return False
    inner = enclose(balls, chart, ring, centre.real if ring.is_real else centre, BITS)
    if inner is None:
        return False
    with precision(BITS):
        sides = [x - c for x, c in zip(inner.balls, exact, strict=True)]
        return all(
            upper(part) <= half
            for s in sides
            for part in ((s,) if ring.is_real else (s.real, s.imag))
        )


if __name__ == "__main__":
    sys.exit(main())
