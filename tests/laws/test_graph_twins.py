"""Limbs, arms and rods said as graphs of links are the same machines: the same modes, poses and
inverse solutions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from symkin import Mechanism, RodLimb

MACHINES = {
    "planar 3-RRR": lambda: samples.three_rrr("planar"),
    "planar 3-RRR in space": samples.three_rrr,
    "five-bar": lambda: samples.readme_five_bar("planar"),
    "four-bar": lambda: samples.bars(100.0, 40.0, 120.0, 90.0),
    "delta": samples.delta,
    "3-RPS": samples.three_rps,
    "hexapod": samples.hexagons,
    "arm": samples.pieper,
    "zhao2000": lambda: symkin.load("zhao2000"),
    "zhao2000_links": lambda: symkin.load("zhao2000_links"),
    "yao2020": lambda: symkin.load("yao2020"),
}


def same(a: symkin.Modes, b: symkin.Modes) -> None:
    """The same configurations, in any order, of actuated joints and poses."""
    size = a.problem.mechanism.characteristic_length
    names = [c.name for c in a.problem.mechanism.actuated]
    rows = []
    for found in (a, b):
        table = []
        for mode in found:
            turns = [
                np.radians(mode.joints[n])
                if found.problem.mechanism.angle_unit == "deg"
                else mode.joints[n]
                for n in names
            ]
            kinds = {c.name: c.kind for c in found.problem.mechanism.actuated}
            values = [
                mode.joints[n] / size if kinds[n] == "length" else v
                for n, v in zip(names, turns, strict=True)
            ]
            angular = [
                np.exp(1j * v) if kinds[n] != "length" else v
                for n, v in zip(names, values, strict=True)
            ]
            table.append(
                np.concatenate(
                    [mode.position / size, np.asarray(mode.pose.rotation).ravel(), angular]
                )
            )
        rows.append(np.array(table))
    first, second = rows
    assert len(first) == len(second)
    for row in first:
        assert np.min(np.max(np.abs(second - row), axis=1)) < 1e-6


@pytest.mark.parametrize(
    "name", in_gate(sorted(MACHINES), ["five-bar", "delta", "zhao2000", "arm"])
)
def test_a_graph_has_the_modes_of_its_limbs(name):
    """Direct problem beside the reference."""
    limbs = MACHINES[name]()
    twin = graph_twin(limbs)
    assert twin.is_graph
    values = [c.reference[0] for c in limbs.actuated]
    joints = [
        limbs.angle_out(v + 0.02) if c.is_angular else v + 0.01 * limbs.characteristic_length
        for v, c in zip(values, limbs.actuated, strict=True)
    ]
    a, b = symkin.modes(limbs, joints=joints), symkin.modes(twin, joints=joints)
    same(a, b)
    assert a.complex_count == b.complex_count
    assert b.completeness in ("proved", "probability one")


@pytest.mark.parametrize("name", in_gate(sorted(MACHINES), ["3-RPS", "five-bar", "four-bar"]))
def test_a_graph_has_the_inverse_solutions_of_its_limbs(name):
    """Inverse problem at the pose of a direct one."""
    limbs = MACHINES[name]()
    twin = graph_twin(limbs)
    pose = symkin.solve(
        limbs,
        joints=[
            limbs.angle_out(c.reference[0]) if c.is_angular else c.reference[0]
            for c in limbs.actuated
        ],
    )
    where = pose.solution.pose
    same(symkin.modes(limbs, pose=where), symkin.modes(twin, pose=where))


def test_a_theorem_holds_for_a_graph_as_for_limbs():
    """Each leg of a platform has one length at a given pose, sign apart: proved in both spellings.
    Its 28 poses are fewer than the theorem's 40, and nothing is proved of them.
    """
    limbs = symkin.load("zhang2009")
    twin = graph_twin(limbs)
    where = symkin.solve(limbs, joints=limbs.example.joints).solution.pose
    a, b = symkin.modes(limbs, pose=where), symkin.modes(twin, pose=where)
    same(a, b)
    assert [a.completeness, b.completeness] == ["proved", "proved"]
    assert {len(a), *(mode.certified for mode in (*a, *b))} == {1}
    among = symkin.modes(twin, joints=limbs.example.joints)
    assert (among.completeness, among.complex_count) == ("probability one", 28)


@pytest.mark.parametrize("longer", [0.0, 50.0])
def test_forty_poses_are_proved_of_a_graph_as_of_limbs(longer):
    """Six rods between random points: 40 certified poses over the complex numbers are all that
    there are, in both spellings; so is it proved that rods far too long for each other have none.
    """
    rng = np.random.default_rng(3)
    legs = [RodLimb(f"leg{i}", samples.unit(rng), samples.unit(rng)) for i in range(6)]
    limbs = Mechanism("general", legs, platform_position=(0.1, 0.2, 1.5))
    joints = [c.reference[0] + 1e-3 * i for i, c in enumerate(limbs.actuated)]
    joints[2] += longer
    a, b = (symkin.modes(x, joints=joints) for x in (limbs, graph_twin(limbs)))
    same(a, b)
    assert [a.completeness, b.completeness] == ["proved", "proved"]
    assert [a.complex_count, b.complex_count] == [40, 40]
    assert all(mode.certified for mode in (*a, *b))
    assert bool(len(a)) == (longer == 0.0)
    assert any("six points at given distances" in note for note in b.notes)


@pytest.mark.parametrize(
    "name", in_gate(sorted(MACHINES), ["delta", "five-bar", "four-bar", "hexapod", "zhao2000"])
)
def test_a_graph_has_the_mobility_of_its_limbs(name):
    limbs = MACHINES[name]()
    assert symkin.mobility(limbs).mobility == symkin.mobility(graph_twin(limbs)).mobility


def test_a_spherical_motion_is_that_of_axes_that_meet():
    """A wrist moves the same with its motion declared and without."""
    declared = symkin.load("spherical_wrist")
    assert declared.motion == "spherical"
    motors = {"motor1": 10.0, "motor2": -5.0, "motor3": 15.0}
    for machine in (declared, replace(declared, motion="spatial")):
        found = symkin.solve(machine, given=motors).solution
        wanted = symkin.solve(declared, given=motors).solution
        np.testing.assert_allclose(found.rotation, wanted.rotation, atol=1e-9)
        assert found.joints == pytest.approx(wanted.joints, abs=1e-7)
        back = symkin.solve(declared, pose=found.pose, start=found.joints).solution
        assert {n: back.joints[n] for n in motors} == pytest.approx(motors, abs=1e-6)
    assert symkin.mobility(declared).mobility == symkin.mobility(machine).mobility == 3


@pytest.mark.long
def test_a_spherical_motion_may_be_declared():
    """Of a wrist whose axes meet: the same modes from motors, and from a whole pose all that each
    limb allows, two each.
    """
    declared = symkin.load("spherical_wrist")
    assert declared.motion == "spherical"
    free = replace(declared, motion="spatial")
    motors = {"motor1": 10.0, "motor2": -5.0, "motor3": 15.0}
    same(symkin.modes(declared, given=motors), symkin.modes(free, given=motors))
    found = symkin.modes(declared, pose=[0, 0, 0, 0.99, 0.05, -0.1, 0.07])
    assert (len(found), found.completeness) == (8, "proved")
