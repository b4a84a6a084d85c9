"""Roots far from real ones: they are reached with more bits, those at infinity are not."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.inside import AlgebraicSystem, Coordinate, far_roots
from helpers.samples import delta

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
