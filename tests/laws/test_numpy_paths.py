"""Paths without a compiler: NumPy follows them on all rows, and they end at roots or say that they
do not.
"""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given

from helpers.inside import (
    AlgebraicSystem,
    build_problem,
    known_values,
    system_of,
    tracker,
    universal_start,
    universal_system,
)
from helpers.samples import delta, seeds


def gauss(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.normal(size=shape) + 1j * rng.normal(size=shape)


def rods_at(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots of six rods at complex known values, and where the lengths are to go."""
    start = universal_start()
    end = start.k.copy()
    end[::7] += 0.5 * gauss(rng, 6)
    return start.z, start.k, end


def check_roots(system: AlgebraicSystem, tracked: tracker.Tracked, k: np.ndarray) -> None:
    """Arrived paths end at roots, at rays of unit length."""
    z = tracked.z[:, tracked.arrived]
    rows, _ = system.linearise(
        z, np.repeat(np.asarray(k, dtype=complex)[:, None], z.shape[1], axis=1)
    )
    assert np.max(np.abs(rows), initial=0.0) < 1e-11
    if system.projective:
        np.testing.assert_allclose(
            np.linalg.norm(z[list(system.projective)], axis=0), 1.0, atol=1e-12
        )


@pytest.mark.slow
@given(rng=seeds)
def test_a_path_back_ends_where_it_began(rng):
    """Tracking along a line and back is the identity, root by root."""
    system, settings = universal_system(), tracker.TrackSettings(tolerance=1e-4)
    z, begin, end = rods_at(rng)
    there = tracker.track(system, z, begin, end, settings)
    check_roots(system, there, end)
    back = tracker.track(system, there.z[:, there.arrived], end, begin, settings)
    same = np.flatnonzero(there.arrived)[back.arrived]
    assert len(same) >= len(there.arrived) - 1
    np.testing.assert_allclose(
        system.features(back.z[:, back.arrived]), system.features(z[:, same]), atol=1e-8
    )


@pytest.mark.slow
def test_random_platforms_lose_no_root():
    """Random real geometries: 40 distinct roots at complex lengths, and 40 at the lengths of random
    real poses.
    """
    system, start = universal_system(), universal_start()
    rng, settings = np.random.default_rng(8), tracker.TrackSettings(tolerance=1e-5)
    for _ in range(4):
        data = rng.uniform(-1, 1, (6, 7)).astype(complex)
        data[:, 0] = 1.0 + 0.5 * gauss(rng, 6) + 0.3j
        own = tracker.track(system, start.z, start.k, data.ravel(), settings)
        real = data.real.copy()
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.linalg.det(turn)
        real[:, 0] = np.linalg.norm(
            rng.normal(size=3) + real[:, 4:] @ turn.T - real[:, 1:4], axis=1
        )
        ends = tracker.track(system, own.z, data.ravel(), real.ravel(), settings)
        for tracked, k in ((own, data.ravel()), (ends, real.ravel())):
            assert tracked.arrived.all()
            check_roots(system, tracked, k)
            f = system.features(tracked.z)
            assert np.min(np.max(np.abs(f[:, None] - f[None]), axis=2) + np.eye(40)) > 1e-7


def test_redundant_rows_are_solved_together():
    """A translating delta has two equal rows a limb: both of its poses are tracked on all six
    rows.
    """
    problem = build_problem(delta(), "direct")
    system = system_of(problem)
    here = known_values(problem, np.zeros(3))
    up = np.array([0.0, 0.0, -np.sqrt(220.0**2 - 180.0**2)]) / system.characteristic_length
    end = np.array([0.3, -0.2, 0.1]) + 0j
    tracked = tracker.track(system, np.array([up, -up]).T, here, end)
    assert tracked.arrived.all()
    check_roots(system, tracked, end)
    assert system.count > system.width


def test_rows_that_contradict_each_other_have_no_end():
    """x^2 = k_1 and x^2 = k_2 with k_1 /= k_2: a least-squares point is no root."""
    z, k = ca.SX.sym("z", 1), ca.SX.sym("k", 2)
    system = AlgebraicSystem(1.0, (), z, k, z**2 - k, ())
    one = np.array([[1.0 + 0j]])
    good = tracker.track(system, one, np.array([1.0, 1.0]), np.array([4.0, 4.0]))
    bad = tracker.track(system, one, np.array([1.0, 1.0]), np.array([4.0, 9.0]))
    assert good.arrived.all()
    np.testing.assert_allclose(good.z, 2.0, atol=1e-12)
    assert not bad.arrived.any()


def test_a_double_root_is_not_an_end():
    """x^2 = k from k = 1 + i to 0: both paths come close, neither arrives."""
    z, k = ca.SX.sym("z", 1), ca.SX.sym("k", 1)
    system = AlgebraicSystem(1.0, (), z, k, z**2 - k, ())
    root = np.sqrt(1.0 + 1.0j)
    tracked = tracker.track(
        system, np.array([[root, -root]]), np.array([1.0 + 1.0j]), np.array([0.0])
    )
    assert not tracked.arrived.any()
    assert np.all(tracked.s > 1.0 - 1e-4)
    assert np.all(np.abs(tracked.z) < 0.05)


def test_no_paths_and_no_way_to_go():
    """No paths end nowhere; a path from k to k ends where it is."""
    system = universal_system()
    z, begin, _ = rods_at(np.random.default_rng(0))
    assert tracker.track(system, z[:, :0], begin, begin).z.shape == (8, 0)
    still = tracker.track(system, z, begin, begin)
    assert still.arrived.all()
    np.testing.assert_allclose(system.features(still.z), system.features(z), atol=1e-9)
