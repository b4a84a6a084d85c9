"""Roots far from real ones: they are reached with more bits, those at infinity are not."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    build_problem,
    far_roots,
    known_root,
    system_of,
)
from helpers.samples import delta
from helpers.spellings import MACHINES, named, spellings

BEGIN = np.array([1.3 + 0.4j, 0.7 - 0.2j])


def system() -> AlgebraicSystem:
    """k0 cos z + k1 sin z = 1, a quadratic in exp(i z)."""
    z, k = ca.SX.sym("z"), ca.SX.sym("k", 2)
    row = k[0] * ca.cos(z) + k[1] * ca.sin(z) - 1
    return AlgebraicSystem(1.0, (Coordinate("z", "angle", "passive"),), z, k, row, ())


def roots(k: np.ndarray) -> np.ndarray:
    """Both, by the quadratic, where exp(i z) does not vanish."""
    turns = np.roots([(k[0] - 1j * k[1]) / 2, -1, (k[0] + 1j * k[1]) / 2])
    return np.asarray(-1j * np.log(turns))


@pytest.fixture
def steps(monkeypatch):
    """What has been corrected so far."""
    corrected, told = far_roots._corrected, []
    monkeypatch.setattr(far_roots, "_corrected", lambda *k: told.append(k) or corrected(*k))
    return told


@pytest.mark.parametrize("distance", [1e-3, 1e-6])
def test_far_roots_are_reached(distance, steps):
    """Near k = (1, i) one root lies as far up as log(2 / distance); a path that is smooth at its
    end is not followed through all digits of what is left of it.
    """
    end = np.array([1.0 + distance, 1j])
    came, points = far_roots.carried(system(), roots(BEGIN)[None], BEGIN, end)
    assert came.all()
    assert len(steps) <= 145
    found = sorted(points[0], key=lambda z: z.imag)
    wanted = sorted(roots(end), key=lambda z: z.imag)
    assert found[1].imag == pytest.approx(np.log(2 / distance), rel=0.01)
    np.testing.assert_allclose(np.exp(1j * np.array(found)), np.exp(1j * np.array(wanted)), 1e-8)


def test_a_root_at_infinity_is_left_after_few_steps(steps):
    """At k = (1, i) one path comes to 0, and the other has no end: it is not followed to where
    double precision ends by ever smaller steps.
    """
    came = [
        bool(far_roots.carried(system(), np.array([[z]]), BEGIN, np.array([1.0, 1j]))[0][0])
        for z in roots(BEGIN)
    ]
    assert sorted(came) == [False, True]
    assert len(steps) < 200


def test_more_bits_go_on_from_where_double_precision_leads(steps):
    """Both ways lead to the same roots, and the one that double precision begins takes fewer steps
    with more bits.
    """
    end = np.array([1.001, 1j])
    came, points = far_roots.carried(system(), roots(BEGIN)[None], BEGIN, end)
    whole = len(steps)
    z, near = far_roots.advanced(system(), roots(BEGIN)[None], BEGIN, end)
    assert 0.0 < np.linalg.norm(end - near) < 0.1 * np.linalg.norm(end - BEGIN)
    came_too, points_too = far_roots.carried(system(), z, near, end)
    assert came.all()
    assert came_too.all()
    np.testing.assert_allclose(np.exp(1j * points_too), np.exp(1j * points), 1e-9)
    assert len(steps) - whole < whole


@pytest.mark.parametrize("apart", [1e-3, 2e-3])
def test_shorter_steps_and_conjugates_leave_little_to_follow(apart, steps):
    """Beside two equal joints of a delta, all complex solutions are told without following four
    paths with more bits: two of them are the others' conjugates.
    """
    found = symkin.modes(replace(delta(), motion="spatial"), joints=[0.1, 0.03, 0.1 + apart])
    assert found.complex_count == 40
    assert len(steps) <= 20


def test_far_roots_are_one_by_their_digits():
    """At an imaginary part of 9.5 cosines are 6,700: two writings of one root, 1e-9 apart, have
    cosines that differ by 7e-6, and are one root; those 1e-4 apart are two.
    """
    far = np.array([[0.3 + 9.5j]])
    for apart, same in ((1e-9, True), (1e-4, False), (1e-4j, False)):
        assert (known_root(system(), far, far + apart)[0] == 0) == same
    assert known_root(system(), far, far + 2 * np.pi)[0] == 0


@pytest.mark.parametrize(("share", "far"), [(5e-4, True), (0.1, False)])
def test_a_platform_2000_sizes_away_is_far(share, far):
    """Derivatives there have lost four times the digits of the distance: double precision takes
    such a regular root for one that others surround.
    """
    block = system_of(build_problem(replace(delta(), motion="spatial"), "direct"))
    ray = np.array([share, 0, 0, 0, 0, 0, 0, 1.0]) + 0j
    assert far_roots.are_far(block, ray[:, None])[0] == far


@pytest.mark.long
@pytest.mark.parametrize(
    "joints", [(0.0229, -0.094, -0.0786), (-0.0604, 0.1304, -0.1315), (0.0036, 0.039, 0.0071)]
)
def test_a_free_delta_by_universal_joints_is_complete_near_its_reference(joints):
    """Complex solutions some thousand sizes away are no sets: all 84 x 8 are told."""
    free = replace(MACHINES["3-RUU"]().home, motion="spatial")
    found = symkin.modes(free, joints=list(joints))
    assert (found.complex_count, found.completeness) == (672, "probability one")


@pytest.mark.long
def test_a_free_delta_is_complete_by_the_place_of_its_platform(tmp_path):
    """Without its arms each limb is a row of degree 8 in the platform's quaternion: the rows have
    8^3 solutions.
    """
    machine = MACHINES["delta"]()
    for one in named(list(spellings(machine, tmp_path)), ["limbs", "graph"]):
        found, _ = one.by_name(machine, ("x", "y", "z"))
        assert (len(found), found.complex_count) == (54, 512)
        assert found.completeness == "probability one"
        assert all(mode.certified for mode in found)
