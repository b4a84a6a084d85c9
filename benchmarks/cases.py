"""The machines of all figures: problems of `enumeration.py` with the figures that they are held
against, grids and sweeps, starts.

TABLE holds what a prototype of one generic engine took in NumPy, in multiples of T: (many instances
at once, one instance). T was 40 us there. A case without such figures has limits of its own, or
none.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import symkin

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / folder) for folder in ("tests", "")]

REFERENCE_KERNEL = 40e-6
"""T in seconds where the prototype's times were taken."""
TABLE = {
    "five-bar": (1.7, 8.6),
    "3-RRR direct": (5.5, 10.6),
    "3-RRR inverse": (17, 48),
    "3-RPS": (8.6, 6.7),
    "delta, spatial": (19, 103),
    "3-TRT+SPS, links": (430, 407),
    "yao2020": (8, 43),
    "general 6R": (25, 123),
    "gluon_6l3": (7, 51),
}
"""Milliseconds there."""
PATHS = {"numpy": 600.0, "compiled": 30.0}
"""Most that 40 paths of six distances may take, in T."""
GENERAL_6R = {"compiled": 50.0}
"""Most that the 16 of a general 6R may take, in T."""
QUICK = ("zhang2009", "zhao2000", "five-bar", "3-RRR direct", "gluon_6l3", "spherical wrist")
"""Cases that are ready in a moment: their starts are shipped, found quickly, or formulas."""
STARTED = ("zhang2009", "zhao2000", "yao2020")
"""Shipped mechanisms whose examples random starts solve."""
FOLLOWED = "zhang2009"
"""The shipped mechanism whose modes are followed, and swept at random points."""
NAMED: list[tuple[str, dict[str, tuple[float, float]]]] = [
    ("four_bar", {"crank": (0.0, 360.0)}),
    ("four_bar", {"follower": (-90.0, 90.0)}),
    ("jansen_leg", {"crank": (0.0, 360.0)}),
    ("ankle", {"ankle.1": (-40.0, 40.0), "ankle.2": (-40.0, 40.0)}),
    ("ankle", {"upper_motor": (-40.0, 40.0), "lower_motor": (-40.0, 40.0)}),
    ("five_link_suspension", {"rack": (-20.0, 20.0), "z": (290.0, 330.0)}),
]
"""Graphs that are swept, and the ranges of what is given (mm, deg)."""


@dataclass(frozen=True, eq=False)
class Case:
    """A problem: mechanism, kind, number of complex solutions, whether its start is carried with
    the package, and the inputs drawn for it, joints or a pose, as keywords of `symkin.modes`.
    """

    name: str
    mechanism: symkin.Mechanism
    kind: str
    complex_count: int
    draw: Callable[[np.random.Generator], dict[str, object]]
    shipped: bool = False
    six_distances: bool = False

    def table(self) -> tuple[float, float] | None:
        """The prototype's figures in T."""
        figures = TABLE.get(self.name)
        return (
            None
            if figures is None
            else (figures[0] * 1e-3 / REFERENCE_KERNEL, figures[1] * 1e-3 / REFERENCE_KERNEL)
        )

    def limit(self, engine: str) -> float | None:
        """Most that its paths may take, in T."""
        if self.six_distances:
            return PATHS[engine]
        figures = self.table()
        own = GENERAL_6R.get(engine) if self.name == "general 6R" else None
        return own if own is not None else None if figures is None else figures[1]


def all_cases(seed: int) -> list[Case]:
    from helpers.samples import delta, five_bar, pieper, three_rps, three_rrr
    from studies.others.dietmaier1998 import LEGS, platform

    rng = np.random.default_rng(seed)
    dietmaier, planar, spatial = platform(), three_rrr("planar"), replace(delta(), motion="spatial")
    near = [*LEGS]
    return [
        rods("general 6-6", general_platform(rng), 40),
        Case(
            "dietmaier1998",
            dietmaier,
            "direct",
            40,
            lambda r: {"joints": near * (1 + 1e-7 * r.normal(size=6))},
            six_distances=True,
        ),
        rods("zhang2009", symkin.load("zhang2009"), 28, shipped=True),
        rods("ren2008_true", symkin.load("ren2008_true"), 40, shipped=True),
        about_reference("five-bar", five_bar(), 2),
        about_reference("3-RRR direct", planar, 6),
        of_pose("3-RRR inverse", planar, 8),
        about_reference("3-RPS", three_rps(), 16),
        about_reference("delta, spatial", spatial, 40),
        about_example("zhao2000", symkin.load("zhao2000"), 4, shipped=True),
        about_reference("3-TRT+SPS, links", symkin.load("zhao2000_links"), 64, shipped=True),
        of_joints("yao2020", symkin.load("yao2020"), 8, shipped=True),
        of_joints("gluon_6l3", symkin.load("gluon_6l3"), 8, shipped=True),
        of_joints("spherical wrist", pieper(), 8),
        of_joints("general 6R", general_6r(rng), 16),
    ]


# --- inputs ---------------------------------------------------------------------------------------


def about_reference(
    name: str, mechanism: symkin.Mechanism, count: int, *, shipped: bool = False
) -> Case:
    """Joints about the reference: angles by 0.15, lengths by a tenth."""

    def draw(rng: np.random.Generator) -> dict[str, object]:
        values = [
            mechanism.angle_out(c.reference[0] + rng.uniform(-0.15, 0.15))
            if c.is_angular
            else c.reference[0] * rng.uniform(0.9, 1.1)
            for c in mechanism.actuated
        ]
        return {"joints": values}

    return Case(name, mechanism, "direct", count, draw, shipped)


def about_example(
    name: str, mechanism: symkin.Mechanism, count: int, *, shipped: bool = False
) -> Case:
    """Joints about those of the mechanism's example, by a hundredth of each."""
    joints = np.asarray(mechanism.example.joints)
    return Case(
        name,
        mechanism,
        "direct",
        count,
        lambda r: {"joints": list(joints * r.uniform(0.99, 1.01, len(joints)))},
        shipped,
    )


def rods(name: str, mechanism: symkin.Mechanism, count: int, *, shipped: bool = False) -> Case:
    """Leg lengths of random poses above the base."""

    def draw(rng: np.random.Generator) -> dict[str, object]:
        return {
            "joints": symkin.solve(
                mechanism, pose=random_pose(mechanism, rng)
            ).solution.actuated_values
        }

    return Case(name, mechanism, "direct", count, draw, shipped, six_distances=True)


def of_joints(name: str, arm: symkin.Mechanism, count: int, *, shipped: bool = False) -> Case:
    """Poses of random joints."""

    def draw(rng: np.random.Generator) -> dict[str, object]:
        values = [
            arm.angle_out(rng.uniform(-3, 3))
            if c.is_angular
            else rng.uniform(-0.3, 0.3) * arm.characteristic_length
            for c in arm.actuated
        ]
        return {"pose": symkin.solve(arm, joints=values).solution.pose}

    return Case(name, arm, "inverse", count, draw, shipped)


def of_pose(name: str, mechanism: symkin.Mechanism, count: int) -> Case:
    """Poses that joints about the reference reach."""
    joints = about_reference(name, mechanism, count)

    def draw(rng: np.random.Generator) -> dict[str, object]:
        return {"pose": symkin.solve(mechanism, **joints.draw(rng)).solution.pose}

    return Case(name, mechanism, "inverse", count, draw)


def random_pose(mechanism: symkin.Mechanism, rng: np.random.Generator) -> symkin.Pose:
    """Up to half the size away from one size above the base, turned by about 0.4."""
    turn = np.array([1.0, 0, 0, 0]) + 0.2 * rng.normal(size=4)
    away = np.array([0, 0, 1.0]) + rng.uniform(-0.5, 0.5, 3)
    return symkin.Pose(mechanism.characteristic_length * away, turn / np.linalg.norm(turn))


@dataclass(frozen=True)
class Grid:
    """A case: its mechanism, half the range of two swept joints, values along each, and most T that
    a point may take.
    """

    mechanism: symkin.Mechanism
    half_range: float
    values: int
    most_t: float


def grids(scale: float) -> list[Grid]:
    """Angles by half a radian, lengths by a tenth of the size."""
    from helpers.samples import five_bar, three_rrr

    five, three = five_bar(), three_rrr("planar")
    cases = [
        Grid(five, five.angle_out(0.5), 300, 0.5),
        Grid(three, three.angle_out(0.5), 150, 3.0),
        *(
            Grid(m, 0.1 * m.characteristic_length, n, 30.0)
            for m, n in ((symkin.load("zhang2009"), 80), (symkin.load("ren2008_true"), 60))
        ),
    ]
    return [replace(case, values=max(4, int(case.values * scale**0.5))) for case in cases]


# --- mechanisms -----------------------------------------------------------------------------------


def general_platform(rng: np.random.Generator) -> symkin.Mechanism:
    legs = [
        symkin.RodLimb(f"leg{i}", rng.normal(size=3), 0.6 * rng.normal(size=3)) for i in range(1, 7)
    ]
    return symkin.Mechanism("general66", legs, platform_position=(0, 0, 1.5))


def general_6r(rng: np.random.Generator) -> symkin.Mechanism:
    axes = [
        symkin.Joint(f"q{i}", "R", rng.normal(size=3), rng.normal(size=3), actuated=True)
        for i in range(1, 7)
    ]
    return symkin.Mechanism(
        "general_6r", [symkin.Limb("arm", axes)], platform_position=rng.normal(size=3), serial=True
    )
