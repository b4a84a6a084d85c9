"""Laws of arms whose nearly parallel axes are described by points far away: the numbers of a
description are not the machine.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.inside import quaternion_from_matrix, universal_arm
from helpers.inside import six_revolute_start as universal_start
from helpers.laws import chain

ROWS = [
    (162.5, 0.0, 90),
    (0.0, -425.0, 0),
    (0.0, -392.2, 0),
    (133.3, 0.0, 90),
    (99.7, 0.0, -90),
    (99.6, 0.0, 0),
]
"""d, a, alpha of an arm with three parallel axes."""


def _lines(off: float, seed: int) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    """Points and axes at zero joint values, axes off by about `off` rad, and the tool's matrix."""
    rng, frame, points, axes = np.random.default_rng(seed), np.eye(4), [], []
    for d, a, alpha in ROWS:
        points.append(frame[:3, 3].copy())
        axis = frame[:3, 2] + (off * rng.normal(size=3) if axes else 0.0)
        axes.append(axis / np.linalg.norm(axis))
        c, s = math.cos(math.radians(alpha)), math.sin(math.radians(alpha))
        frame = frame @ np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, d], [0, 0, 0, 1]])
    return points, axes, frame


def factory_arm(off: float, seed: int, *, far: bool = True) -> symkin.Mechanism:
    """The arm with the points of nearly parallel axes where these come nearest to each other, as
    common normals put them.
    """
    points, axes, tool = _lines(off, seed)
    placed = list(points)
    for i in (1, 2, 3) if far else ():
        gap, u, v = points[i] - points[i - 1 if i > 1 else 2], axes[i], axes[i - 1 if i > 1 else 2]
        slide = np.linalg.lstsq(np.array([u, -v]).T, -gap, rcond=None)[0][0]
        placed[i] = points[i] + slide * u
    joints = [
        symkin.Joint(f"q{i + 1}", "R", tuple(p), tuple(a), actuated=True)
        for i, (p, a) in enumerate(zip(placed, axes, strict=True))
    ]
    return symkin.Mechanism(
        "factory",
        [symkin.Limb("factory", joints)],
        tuple(tool[:3, 3]),
        tuple(quaternion_from_matrix(tool[:3, :3])),
        angle_unit="deg",
        serial=True,
    )


@pytest.mark.parametrize("off", [1e-3, 1e-4, 1e-5])
def test_the_size_is_that_of_the_machine_wherever_points_lie_on_their_axes(off):
    near, far = factory_arm(off, 1, far=False), factory_arm(off, 1)
    assert max(np.linalg.norm(j.point) for _, j in far.joints) > 30 * near.characteristic_length
    assert far.characteristic_length == pytest.approx(near.characteristic_length, rel=0.05)
    for _, joint in far.joints:
        away = far.places[joint.name] - np.array(joint.point)
        assert np.linalg.norm(np.cross(away, joint.axis)) < 1e-7


def test_an_arm_moves_the_same_by_far_points_and_by_near_ones():
    rng = np.random.default_rng(3)
    near, far = factory_arm(1e-4, 2, far=False), factory_arm(1e-4, 2)
    for q in rng.uniform(-170, 170, (5, 6)):
        here = symkin.solve(far, joints=q).solution
        there = chain(
            [j for _, j in near.joints], {f"q{i + 1}": math.radians(v) for i, v in enumerate(q)}
        )
        place = there @ np.append(near.platform_position, 1.0)
        assert np.max(np.abs(here.position - place[:3])) < 1e-6
        back = symkin.solve(far, pose=here.pose, start=q + rng.uniform(-2, 2, 6)).solution
        assert np.max(np.abs((np.array(back.actuated_values) - q + 180) % 360 - 180)) < 1e-6
        assert here.residual < 1e-9 * near.characteristic_length


@pytest.mark.long
@pytest.mark.slow
def test_the_modes_of_a_factory_arm_are_complete_and_certified():
    """They hold the joint values that gave the pose, each is certified, and no path is left."""
    arm = factory_arm(1e-3, 4)
    q = np.array([20.0, -70.0, 80.0, 25.0, 40.0, 30.0])
    found = symkin.modes(arm, pose=symkin.solve(arm, joints=q).solution.pose)
    assert found.completeness in ("proved", "probability one")
    assert found.complex_count == 16
    assert found.unresolved_paths == 0
    assert all(mode.certified for mode in found)
    assert any(np.max(np.abs(np.array(mode.actuated_values) - q)) < 1e-6 for mode in found)


@pytest.mark.slow
def test_the_start_of_a_factory_arm_is_computed_once(monkeypatch):
    """Kept roots with large imaginary parts are accepted when they are read: another process would
    not search again.
    """
    arm = factory_arm(1e-3, 4)
    poses = [
        symkin.solve(arm, joints=q).solution.pose
        for q in ([20.0, -70.0, 80.0, 25.0, 40.0, 30.0], [5.0, -50.0, 60.0, 15.0, 70.0, 3.0])
    ]
    first = symkin.modes(arm, pose=poses[0], method="continuation")

    def searched_again(*_arguments, **_named):
        raise AssertionError("the generic roots were searched again")

    monkeypatch.setattr(inside.start_store, "compute_start", searched_again)
    second = symkin.modes(arm, pose=poses[1], method="continuation")
    assert first.complex_count == second.complex_count == 16


def test_points_of_spherical_and_planar_machines_stay_where_they_are_described():
    for name in ("gluon_6l3", "yao2020", "zhao2000_links"):
        machine = symkin.load(name)
        assert all(np.array_equal(machine.places[j.name], j.point) for _, j in machine.joints)


def test_the_universal_start_of_six_revolute_joints_has_sixteen_different_roots():
    start, system = universal_start(), universal_arm()
    f, _ = system.linearise(start.z, np.repeat(start.k[:, None], 16, axis=1))
    assert np.max(np.abs(f)) < 1e-9
    apart = np.exp(1j * start.z)
    gaps = np.max(np.abs(apart[:, :, None] - apart[:, None, :]), axis=0) + 10 * np.eye(16)
    assert gaps.min() > 1e-3


@pytest.mark.parametrize("seed", range(5))
def test_joints_on_one_line_have_the_size_of_that_line(seed):
    """Points of parallel axes that are one line could all be moved into one; the size is then not
    what rounding leaves of it.
    """
    rng = np.random.default_rng(seed)
    rows = [
        symkin.DHRow(f"q{i}", "R", d=float(d), alpha=float(rng.choice([0.0, math.pi])))
        for i, d in enumerate(rng.uniform(10.0, 90.0, 3))
    ]
    arm = symkin.serial_arm_from_dh("line", symkin.DHTable("standard", rows))
    points = np.array([joint.point for _, joint in arm.joints])
    longest = max(np.linalg.norm(a - b) for a in points for b in points)
    assert arm.characteristic_length == pytest.approx(longest, rel=1e-9)
    assert symkin.mobility(arm).mobility == 3
