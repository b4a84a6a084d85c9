"""The same machine turned as a whole, in another unit of length, with its parts in another order,
has the same modes; formulas list as many as paths do.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import symkin
from helpers.gate import each_once, in_gate
from helpers.inside import (
    build_problem,
    displaced,
    group_paths,
    group_solver,
    is_linear,
    scaled,
    structure_groups,
)
from helpers.moved_mechanisms import reordered, scaled_values
from helpers.samples import delta

TURN = symkin.Pose.from_euler([0.0, 0.0, 0.0], [0.3, 0.5, 0.7])
NAMES = ("four_bar", "pantograph_five_bar", "slider_crank", "watt_six_bar")


def loops(*rows: tuple[str, str, str, str, list[int], list[int]]) -> symkin.Mechanism:
    joints = [symkin.LinkJoint(symkin.Joint(n, kind, p, a), [f, t]) for n, kind, f, t, p, a in rows]
    return symkin.Mechanism(
        "loops", link_joints=joints, length_unit="m", angle_unit="deg", platform_link=None
    )


def spherical() -> symkin.Mechanism:
    """Two spherical loops with axes at right angles; all joints at 0 close exactly."""
    return loops(
        ("j0", "R", "base", "k1", [0, 0, 2], [0, 0, -1]),
        ("j1", "R", "k1", "k2", [-1, 0, -1], [1, 0, 1]),
        ("j2", "R", "k2", "k3", [-1, -1, 2], [1, 1, -2]),
        ("j3", "R", "k3", "base", [0, -2, 0], [0, -1, 0]),
        ("p0", "R", "k3", "p1", [0, 1, 1], [0, 1, 1]),
        ("p1", "R", "p1", "p2", [0, 0, 1], [0, 0, 1]),
        ("p2", "R", "p2", "base", [1, 0, 0], [1, 0, 0]),
    )


def one_point() -> symkin.Mechanism:
    """Two spherical loops that share a link."""
    rows = [
        ("j0", "base", "k1", [-1, 1, -2]),
        ("j1", "k1", "k2", [1, 1, 1]),
        ("j2", "k2", "k3", [-1, 1, 0]),
    ]
    rows += [
        ("j3", "k3", "base", [-1, -1, 1]),
        ("p0", "k1", "p1", [1, 1, 1]),
        ("p1", "p1", "p2", [1, -1, 0]),
    ]
    rows += [("p2", "p2", "base", [1, 0, 0])]
    return loops(*((name, "R", a, b, v, v) for name, a, b, v in rows))


def told(found: symkin.Modes) -> tuple[int, int | None, str]:
    return len(found), found.complex_count, found.completeness


def at_home(name: str) -> tuple[symkin.Mechanism, dict[str, float]]:
    mechanism = spherical() if name == "spherical" else symkin.load(name)
    if name == "spherical":
        return mechanism, {"p1": 60.0}
    at = {
        c.name: mechanism.angle_out(c.reference[0]) if c.is_angular else c.reference[0]
        for c in mechanism.actuated
    }
    return mechanism, {name: value + 0.01 for name, value in at.items()}


TWINS = [(1.0, True), (1e-8, False), (1e-8, True), (1e6, True)]
"""Factors of size, and whether the machine is turned in space."""


@pytest.mark.parametrize(
    ("name", "twin"),
    in_gate(
        itertools.product([*NAMES, "spherical"], TWINS),
        list(zip(["four_bar", "watt_six_bar", "slider_crank", "spherical"], TWINS, strict=True)),
    ),
)
def test_a_twin_has_the_modes_at_home(name: str, twin: tuple[float, bool]) -> None:
    factor, turned = twin
    mechanism, values = at_home(name)
    home = symkin.modes(mechanism, given=values)
    twin = reordered(scaled(displaced(mechanism, TURN) if turned else mechanism, factor), 1)
    other = symkin.modes(twin, given=scaled_values(mechanism, values, factor))
    assert told(other) == told(home)
    angles = [c.name for c in mechanism.coordinates if c.is_angular]
    ours, theirs = (
        np.radians([[mode.joints[n] for n in angles] for mode in found]) for found in (home, other)
    )
    apart = np.max(np.abs(np.angle(np.exp(1j * (ours[:, None] - theirs[None])))), axis=2)
    assert np.all(np.min(apart, axis=1) < 1e-6)


@pytest.mark.parametrize("factor", in_gate([1e-8, 1e6], [1e-8]))
def test_a_delta_of_any_size_has_its_modes(factor: float) -> None:
    home, twin = delta(), scaled(delta(), factor)
    motors = [0.1, 0.2, 0.3]
    found = symkin.modes(home, joints=motors)
    assert told(symkin.modes(twin, joints=motors)) == told(found)
    pose = found[0].pose
    moved = symkin.Pose(factor * np.array(pose.position), pose.quaternion)
    assert told(symkin.modes(twin, pose=moved)) == told(symkin.modes(home, pose=pose))


@pytest.mark.parametrize("value", [0.0, 10.0, -25.0, 60.0, 120.0])
def test_both_values_of_a_choice_are_looked_at(value: float) -> None:
    """sin p2 is 1 on one branch whatever p1 is, and not on the other: a formula that has seen the
    first alone loses modes.
    """
    formulas = symkin.modes(spherical(), given={"p1": value})
    paths = symkin.modes(spherical(), given={"p1": value}, method="continuation")
    assert len(formulas) == len(paths) == (2 if abs(value) < 50.0 else 4)


@pytest.mark.parametrize("factor", in_gate([1e-6, 1e-5, 1.0, 1e5], [1e-6]))
def test_lengths_do_not_decide_how_far_angles_are_sampled(factor: float) -> None:
    """Of the four sets of angles two each are one turn of a ball, which three of the axes are."""
    found = symkin.modes(scaled(one_point(), factor), given={"p0": 0.0})
    assert (len(found), found.completeness) == (2, "proved")


def test_a_linkage_of_micrometres_has_formulas() -> None:
    third = float(np.sqrt(3.0)) / 2.0
    rows = [
        ("j0", "R", "base", "k1", [0, 3e-5, 0], [0, 0, 1]),
        ("j1", "P", "k1", "k2", [0, 0, 0], [0, 1, 0]),
        ("j2", "R", "k2", "k3", [0, 0, 0], [0, 0, 1]),
        ("j3", "P", "base", "k3", [0, 0, 0], [third, 0.5, 0]),
        ("j4", "R", "k3", "k4", [2e-5, 2e-5, 0], [0, 0, 1]),
        ("j5", "R", "k4", "k5", [1e-5, 2e-5, 0], [0, 0, 1]),
        ("j6", "R", "base", "k5", [1e-5, 0, 0], [0, 0, 1]),
    ]
    for factor in (1e-3, 1e8):
        assert len(symkin.modes(scaled(loops(*rows), factor), given={"j3": 0.0})) == 4


@pytest.mark.parametrize(("name", "turned"), each_once(NAMES, [True, False]))
def test_formulas_are_used_where_paths_find_as_many(name: str, turned: bool) -> None:
    """A turned planar block has a row more than it needs, which cancels to rounding."""
    mechanism = displaced(symkin.load(name), TURN) if turned else symkin.load(name)
    problem = build_problem(mechanism, "given", tuple(c.name for c in mechanism.actuated))
    for group in itertools.filterfalse(is_linear, structure_groups(problem)):
        solver, paths = group_solver(group), group_paths(group)
        assert paths is not None
        assert solver is not None
        assert (solver.engine, solver.most_roots) == ("closed form", paths.most_roots)


def test_structure_groups_do_not_depend_on_the_unit_of_length() -> None:
    """A slide that is nearly along x moves a point up by a hundredth of its stroke: in any unit
    that is no zero.
    """
    slope = [float(np.cos(0.0129)), float(np.sin(0.0129)), 0.0]
    z = [0, 0, 1]
    rows = [
        ("j1", "R", "base", "link1", [-15, -3, 0], z),
        ("j2", "R", "link1", "link2", [2, 0, 0], z),
        ("j3", "P", "link2", "link3", [-15, -25, 0], [-0.97, 0.245, 0]),
        ("j4", "R", "link3", "base", [23, 8, 0], z),
        ("j5", "P", "link2", "link4", [14, -20, 0], slope),
        ("j6", "R", "link4", "link5", [9, -24, 0], z),
        ("j7", "R", "link5", "link6", [14, -26, 0], z),
        ("j8", "R", "link6", "link3", [6, 24, 0], z),
    ]

    def groups(factor: float) -> list[list[str]]:
        problem = build_problem(scaled(loops(*rows), factor), "given", ("j7", "j2"))
        return [[c.name for c in group.system.unknowns] for group in structure_groups(problem)]

    assert groups(1e-6) == groups(1.0) == groups(1e6)
