"""Two assembly modes that merge: are all modes found as a platform comes near a type 2 singularity?

Notation: legs L(X) of a pose X = (p, R); J = dL/dtwist, rows (u_i; R a_i x u_i) with u_i the unit
vectors along the legs; type 2 where det J = 0. Along a line of poses the sign of det J changes, at
X* say; there J v = 0 and n J = 0. With twists of unit length (lengths over the size) the legs
beside X* are, to second order,

    n (L(X* moved by d v) - L*) = c d^2 / 2,

so that L* + s n d^2 |c| / 2 belongs to two modes about 2 d apart for s = sign(c), and to a complex
pair for s = -sign(c). The study walks d from 1e-1 to 1e-10 on both sides. What double precision can
tell ends near d = 1e-8, where d^2 is the rounding of the legs: below, a double root, flagged as
such, or no root is the honest answer.

For each d: modes found, merging ones among them (within 10 d of X*, at least 1e-3), how far apart
these are, residual, condition, what is flagged or unresolved. The platform is a general 6-6 from
random numbers.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import symkin
from symkin import Modes, Solution
from symkin.spatial.rotation import quaternion_from_rotation_vector

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, new_figure, options_parser
from studies.shared.words import certified

DISTANCES = tuple(10.0**-k for k in range(1, 11))
SEED = 1


# --- the platform ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Platform:
    """Base points b and platform points a, (6, 3) each; `size` is the mechanism's."""

    base: np.ndarray
    points: np.ndarray

    @staticmethod
    def random(rng: np.random.Generator) -> Platform:
        return Platform(rng.normal(size=(6, 3)), 0.7 * rng.normal(size=(6, 3)))

    def mechanism(self) -> symkin.Mechanism:
        limbs = [
            symkin.RodLimb(f"leg{i}", b, a)
            for i, (b, a) in enumerate(zip(self.base, self.points, strict=True), start=1)
        ]
        return symkin.Mechanism("hexapod", limbs, platform_position=(0, 0, 1.5))

    def legs(self, pose: symkin.Pose) -> np.ndarray:
        return np.linalg.norm(self._vectors(pose), axis=1)

    def _vectors(self, pose: symkin.Pose) -> np.ndarray:
        return np.asarray(pose.position) + self.points @ np.asarray(pose.rotation).T - self.base

    def jacobian(self, pose: symkin.Pose, size: float) -> np.ndarray:
        """Leg rates over (velocity; size times angular velocity)."""
        along = self._vectors(pose)
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        arms = self.points @ np.asarray(pose.rotation).T
        return np.hstack([along, np.cross(arms, along) / size])


def moved(pose: symkin.Pose, twist: np.ndarray, size: float) -> symkin.Pose:
    """The pose after velocity twist[:3] and size times angular velocity twist[3:] for unit time."""
    turn = symkin.Pose(np.zeros(3), np.asarray(quaternion_from_rotation_vector(twist[3:] / size)))
    quaternion = (turn @ symkin.Pose(np.zeros(3), pose.quaternion)).quaternion
    return symkin.Pose(np.asarray(pose.position) + twist[:3], quaternion)


@dataclass(frozen=True, eq=False)
class Singularity:
    """A pose X* with det J = 0: its legs, v with J v = 0, n with n J = 0 (unit length), and the
    curvature c times the size.
    """

    pose: symkin.Pose
    legs: np.ndarray
    v: np.ndarray
    n: np.ndarray
    c: float
    size: float

    def legs_beside(self, d: float, side: int) -> np.ndarray:
        """Legs of two modes about 2 d size apart (side 1) or of a complex pair (side -1)."""
        return np.asarray(self.legs + side * self.n * self.c * self.size * d * d / 2)


def find_singularity(platform: Platform, size: float, rng: np.random.Generator) -> Singularity:
    """Bisection of det J along a line between random poses."""
    while True:
        turn = rng.normal(size=4)
        begin = symkin.Pose(rng.normal(size=3) + [0, 0, 1.5], turn / np.linalg.norm(turn))
        line = size * 0.5 * rng.normal(size=6)
        low, high = 0.0, 1.0
        signs = [
            np.sign(np.linalg.det(platform.jacobian(moved(begin, t * line, size), size)))
            for t in (low, high)
        ]
        if signs[0] == signs[1]:
            continue
        for _ in range(60):
            middle = 0.5 * (low + high)
            here = np.sign(
                np.linalg.det(platform.jacobian(moved(begin, middle * line, size), size))
            )
            low, high = (middle, high) if here == signs[0] else (low, middle)
        return _expanded(platform, moved(begin, low * line, size), size)


def _expanded(platform: Platform, pose: symkin.Pose, size: float) -> Singularity:
    left, _, right = np.linalg.svd(platform.jacobian(pose, size))
    n, v, legs, h = left[:, -1], right[-1], platform.legs(pose), 1e-4
    both = [platform.legs(moved(pose, side * h * size * v, size)) for side in (1, -1)]
    c = float(n @ (both[0] + both[1] - 2 * legs)) / (h * h * size)
    return Singularity(pose, legs, v, n, c, size)


# --- the walk -------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Step:
    """All modes of the legs at distance d on one side."""

    d: float
    side: int
    found: Modes
    merging: tuple[Solution, ...]
    apart: float | None

    @staticmethod
    def of(mechanism: symkin.Mechanism, at: Singularity, d: float, side: int) -> Step:
        found = symkin.modes(mechanism, joints=at.legs_beside(d, side))
        away = np.array([distance(at.pose, mode.pose, at.size) for mode in found])
        merging = tuple(found[int(i)] for i in np.flatnonzero(away < max(10 * d, 1e-3)))
        apart = distance(merging[0].pose, merging[1].pose, at.size) if len(merging) == 2 else None
        return Step(d, side, found, merging, apart)

    @property
    def flagged(self) -> int:
        """Modes that carry a note of being singular."""
        return sum(any("singular" in note for note in mode.notes) for mode in self.found)

    @property
    def condition(self) -> float | None:
        return max((mode.condition for mode in self.merging), default=None)

    @property
    def residual(self) -> float:
        return (
            max((mode.residual for mode in self.found), default=0.0)
            / self.found.problem.closure.characteristic_length
        )


def distance(a: symkin.Pose, b: symkin.Pose, size: float) -> float:
    """Length of positions' difference over the size and angle of the turn between, together."""
    shift = np.linalg.norm(np.asarray(a.position) - np.asarray(b.position)) / size
    return float(
        np.hypot(
            shift, np.linalg.norm(np.asarray(a.rotation) - np.asarray(b.rotation)) / np.sqrt(2)
        )
    )


def walk(mechanism: symkin.Mechanism, at: Singularity, side: int) -> list[Step]:
    return [Step.of(mechanism, at, d, side) for d in DISTANCES]


# --- report ---------------------------------------------------------------------------------------


def report_singularity(report: Report, platform: Platform, at: Singularity) -> None:
    singular = np.linalg.svd(platform.jacobian(at.pose, at.size), compute_uv=False)
    report.row(
        "singular values of J at X*: largest, fifth, sixth",
        None,
        [singular[0], singular[4], singular[5]],
    )
    report.row("curvature |c| of the legs, times the size", None, abs(at.c))


def report_walk(report: Report, steps: list[Step]) -> None:
    where = "two modes" if steps[0].side == 1 else "beyond, a complex pair"
    for step in steps:
        what = f"d = {step.d:.0e}, {where}: modes, merging, flagged, certified, unresolved paths"
        numbers = [
            len(step.found),
            len(step.merging),
            step.flagged,
            certified(step.found),
            step.found.unresolved_paths,
        ]
        report.row(what, None, [*numbers, step.found.completeness])
    if steps[0].side == 1:
        for step in steps:
            numbers = [step.apart, step.condition, step.residual]
            report.row(
                f"d = {step.d:.0e}: apart, condition of the merging ones, largest residual over "
                f"the size",
                None,
                numbers,
            )


def report_verdict(report: Report, near: list[Step], beyond: list[Step]) -> None:
    pairs = [step.d for step in near if len(step.merging) == 2]
    report.row("smallest d at which both merging modes are found", None, min(pairs, default=None))
    silent = [
        s.d for s in near if len(s.merging) != 2 and not s.flagged and not s.found.unresolved_paths
    ]
    report.row(
        "d at which one or both are lost without a flag or an unresolved path",
        None,
        silent or "none",
    )
    regular = len(near[-1].found) - len(near[-1].merging)
    others = {len(s.found) - len(s.merging) for s in [*near, *beyond] if s.d <= 1e-3}
    report.row(
        "modes elsewhere at the smallest d; at all d up to 1e-3", None, [regular, *sorted(others)]
    )
    false = [
        s.d
        for s in beyond
        if s.merging and not all(any("singular" in note for note in m.notes) for m in s.merging)
    ]
    report.row("d at which a complex pair is called real without a flag", None, false or "none")
    report.row(
        "largest residual over the size, all modes", None, max(s.residual for s in [*near, *beyond])
    )


# --- picture --------------------------------------------------------------------------------------


def draw(near: list[Step], beyond: list[Step]):
    figure = new_figure(15, 5.2)
    figure.suptitle(
        "Two assembly modes merge at a singularity of a 6-6 platform", fontsize=15, weight="bold"
    )
    counts, apart, quality = figure.subplots(1, 3)
    draw_counts(counts, near, beyond)
    d = [s.d for s in near]
    known = [(s.d, s.apart) for s in near if s.apart is not None]
    apart.loglog(d, [2 * x for x in d], "--", color="0.6", lw=1.2, label="2 d")
    apart.loglog(*zip(*known, strict=True), "o", color="#0072b2", ms=7, label="as found")
    apart.set(xlabel="distance d from the singularity", title="Distance of the merging modes")
    shown = [(s.d, s.condition) for s in near if s.condition is not None]
    quality.loglog(
        *zip(*shown, strict=True),
        "o-",
        color="#d55e00",
        lw=1.6,
        label="condition of the merging modes",
    )
    quality.loglog(
        d,
        [max(s.residual, 1e-17) for s in near],
        "s-",
        color="#009e73",
        lw=1.6,
        label="largest residual / size",
    )
    quality.set(
        xlabel="distance d from the singularity", title="Condition and residual", ylim=(1e-18, 1e18)
    )
    for axes in (counts, apart, quality):
        axes.invert_xaxis()
        axes.grid(alpha=0.25)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=9.5)
    return figure


def draw_counts(axes, near: list[Step], beyond: list[Step]) -> None:
    for steps, colour, marker, label in (
        (near, "#0072b2", "o", "two modes there"),
        (beyond, "#cc79a7", "s", "beyond: a complex pair"),
    ):
        axes.semilogx(
            [s.d for s in steps],
            [len(s.found) for s in steps],
            marker + "-",
            color=colour,
            lw=1.8,
            ms=7,
            label=label,
        )
        marked = [s for s in steps if s.flagged or s.found.unresolved_paths]
        axes.semilogx(
            [s.d for s in marked],
            [len(s.found) for s in marked],
            marker,
            ms=14,
            mfc="none",
            mec=colour,
            mew=1.4,
        )
    axes.semilogx(
        [], [], "o", ms=14, mfc="none", mec="0.3", label="flagged singular, or a path unresolved"
    )
    most = max(len(s.found) for s in [*near, *beyond])
    axes.set(
        xlabel="distance d from the singularity",
        title="Real modes found",
        ylim=(0, 1.45 * most + 1),
    )


def main() -> None:
    options = options_parser(__doc__.split("\n\n")[0], SEED).parse_args()
    rng = np.random.default_rng(options.seed)
    platform = Platform.random(rng)
    mechanism = platform.mechanism()
    at = find_singularity(platform, mechanism.characteristic_length, rng)
    report = Report(
        "near_singular",
        "All modes near a type 2 singularity of a general 6-6 platform",
        options.seed,
    )
    report_singularity(report, platform, at)
    near, beyond = (walk(mechanism, at, side) for side in (1, -1))
    report_walk(report, near)
    report_walk(report, beyond)
    report_verdict(report, near, beyond)
    report.finish(draw(near, beyond), options.output)


if __name__ == "__main__":
    main()
