"""Forms of a pose and its tilt and torsion, against plain matrices of turns."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from helpers.inside import (
    HomogeneousPose,
    StudyPose,
    UnitPose,
    multiply,
    quaternion_from_matrix,
    rotation_conditions,
    tilt_and_torsion,
)
from helpers.laws import axis_turn, ball_turn

Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def numbers(value):
    return np.asarray(ca.DM(value)).ravel()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("form", ["study", "homogeneous", "unit"])
def test_forms_move_points_and_measure_distances(form, seed):
    """With e of any length: points, directions and squared distances, times N = e.e, as the
    rotation of e / |e| and the position have them."""
    rng = np.random.default_rng(seed)
    e, position, m, other = 1.7 * rng.normal(size=4), *rng.normal(size=(3, 3))
    if form == "unit":
        e /= np.linalg.norm(e)
    weight, turn = e @ e, ball_turn(e / np.linalg.norm(e))
    dual = 0.5 * np.asarray(multiply(np.array([0.0, *position]), e))
    q, p, g, point = (ca.SX(ca.DM(v)) for v in (e, position, dual, m))
    pose = {"study": StudyPose(q, g), "homogeneous": HomogeneousPose(p, q), "unit": UnitPose(p, q)}[
        form
    ]
    there = position + turn @ m
    np.testing.assert_allclose(numbers(pose.weight), weight)
    np.testing.assert_allclose(numbers(pose.point(point)), weight * there, atol=1e-12)
    np.testing.assert_allclose(numbers(pose.direction(point)), weight * turn @ m, atol=1e-12)
    squared = numbers(pose.squared_distance(point, ca.SX(ca.DM(other))))
    np.testing.assert_allclose(squared, weight * np.sum((there - other) ** 2), rtol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_tilt_and_torsion_are_three_turns(seed):
    """Rz(azimuth) Ry(tilt) Rz(torsion - azimuth) has them; rows and checks of each alone and of all
    vanish there."""
    rng = np.random.default_rng(seed)
    azimuth, tilt, torsion = rng.uniform(-3, 3), rng.uniform(0.1, 3.0), rng.uniform(-3, 3)
    turn = axis_turn(Z, azimuth) @ axis_turn(Y, tilt) @ axis_turn(Z, torsion - azimuth)
    q = np.asarray(quaternion_from_matrix(turn))
    np.testing.assert_allclose(
        np.exp(1j * np.array(tilt_and_torsion(q))),
        np.exp([1j * azimuth, 1j * tilt, 1j * torsion]),
        atol=1e-9,
    )
    given = {"azimuth": azimuth, "tilt": tilt, "torsion": torsion}
    for names in (["azimuth"], ["tilt"], ["torsion"], ["azimuth", "tilt"], list(given)):
        rows, checks = rotation_conditions(
            ca.SX(ca.DM(q)), {name: ca.SX(given[name]) for name in names}
        )
        assert np.max(np.abs(numbers(ca.vertcat(*rows, *checks)))) < 1e-12
        for name in names:
            off = {n: ca.SX(given[n] + (0.3 if n == name else 0.0)) for n in names}
            rows, checks = rotation_conditions(ca.SX(ca.DM(q)), off)
            assert min(np.max(np.abs(numbers(ca.vertcat(*part)))) for part in (rows, checks)) > 1e-3
    # the other half plane: its row vanishes, its check does not
    rows, checks = rotation_conditions(ca.SX(ca.DM(q)), {"azimuth": ca.SX(azimuth + np.pi)})
    assert np.max(np.abs(numbers(ca.vertcat(*rows)))) < 1e-12
    assert np.max(np.abs(numbers(ca.vertcat(*checks)))) > 1e-2
