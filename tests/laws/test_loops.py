"""Lines and loops that are tracked together: each is what it is alone, and what counts as
evidence.
"""

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    Looping,
    around,
    conditions,
    engine,
    fibre,
    within_reach,
)
from helpers.inside import monodromy_orbits as orbits


def power(degree: int) -> AlgebraicSystem:
    """z^degree = k, whose roots a loop around k = 0 turns."""
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    return AlgebraicSystem(1.0, (Coordinate("z", "length", "passive"),), z, k, z**degree - k, ())


def roots_of(degree: int, k: complex) -> np.ndarray:
    return (k ** (1 / degree) * np.exp(2j * np.pi * np.arange(degree) / degree))[None]


def points(rng: np.random.Generator, near: bool) -> tuple[np.ndarray, np.ndarray]:
    return rng.normal(size=1) + 1j * rng.normal(size=1), rng.normal(size=1) + 1j * rng.normal(
        size=1
    )


@pytest.mark.parametrize("own", ["numpy", ""])
def test_lines_together_are_lines_alone(own, monkeypatch):
    """Each with roots of its own number, one with none."""
    monkeypatch.setenv("SYMKIN_ENGINE", own)
    system, rng = power(4), np.random.default_rng(0)
    lines = [(rng.normal(size=1) + 1j, rng.normal(size=1) - 2j) for _ in range(5)]
    roots = [
        roots_of(4, begin[0])[:, :count]
        for (begin, _), count in zip(lines, (4, 0, 1, 3, 4), strict=True)
    ]
    together = engine.track_lines(system, roots, lines)
    for z, (begin, end), found in zip(roots, lines, together, strict=True):
        alone = engine.track(system, z, begin, end)
        assert found.z.shape == z.shape
        assert found.arrived.all()
        assert np.array_equal(found.tries, alone.tries)
        np.testing.assert_allclose(found.z, alone.z, atol=1e-12)


def test_loops_end_where_they_begin():
    """Around k = 0 each root becomes the next; beside it, none moves."""
    degree, k0 = 5, np.array([1.0 + 0j])
    corners = np.exp(2j * np.pi * np.arange(1, 3) / 3)
    about, beside = [k0, *corners[:, None], k0], [k0, k0 + 0.1, k0 + 0.1j, k0]
    turned, kept = around(power(degree), roots_of(degree, 1.0), [about, beside])
    assert turned.arrived.all()
    assert kept.arrived.all()
    np.testing.assert_allclose(
        turned.z, roots_of(degree, 1.0) * np.exp(2j * np.pi / degree), atol=1e-9
    )
    np.testing.assert_allclose(kept.z, roots_of(degree, 1.0), atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("degree", in_gate([1, 2, 7, 12], [1, 12]))
def test_all_roots_are_found_from_one(degree):
    """The roots of z^n = k, none twice, all connected."""
    found = fibre(power(degree), points, np.random.default_rng(degree), 0, 1, Looping())
    assert found is not None
    assert found.z.shape[1] == degree
    np.testing.assert_allclose(found.z**degree, np.full((1, degree), found.k[0]), atol=1e-9)
    assert not found.orbits.any()
    assert degree == 1 or found.evidence >= 6.0
    assert not orbits(
        power(degree), found.z, found.k, lambda: 2.0 * points(np.random.default_rng(1), True)[0]
    ).any()


def test_orbits_that_few_loops_connect_are_one():
    """z1^2 = k1, z2^2 = k2: loops about k1 = 0 move every root, and only the thirteenth goes about
    k2 = 0 too and connects the two pairs; that all roots move is no evidence that the pairs are two
    operation modes.
    """
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k", 2)
    unknowns = tuple(Coordinate(name, "length", "passive") for name in ("z1", "z2"))
    system = AlgebraicSystem(1.0, unknowns, z, k, z**2 - k, ())
    about = iter(
        np.exp(2j * np.pi * corner / 3) * np.array([1.0, 1.0 if loop == 12 else 0.0])
        + [0.0, loop != 12]
        for loop in range(200)
        for corner in (1, 2)
    )
    roots = np.array([[1, 1, -1, -1], [1, -1, 1, -1]], dtype=complex)
    assert not orbits(system, roots, np.ones(2, dtype=complex), lambda: next(about)).any()


def test_a_bound_ends_the_search():
    """As soon as it is reached, whatever the evidence."""
    found = fibre(power(6), points, np.random.default_rng(0), 0, 1, Looping(bound=6, needed=1e9))
    assert found is not None
    assert found.z.shape[1] == 6


def test_angles_of_a_loop_stay_within_reach():
    """A turn each way and a little into the complex; small ways and lengths are left alone."""
    rng = np.random.default_rng(0)
    way = 40.0 * (rng.normal(size=6) + 1j * rng.normal(size=6))
    angles = np.array([True, False] * 3)
    kept = within_reach(way, angles)
    assert np.array_equal(kept[~angles], way[~angles])
    assert np.all(np.abs(kept[angles].real) <= 2 * np.pi)
    assert np.all(np.abs(kept[angles].imag) <= 2.0)
    np.testing.assert_allclose(within_reach(1e-3 * way, angles), 1e-3 * way, rtol=1e-3)
    assert np.array_equal(within_reach(way, None), way)


@pytest.mark.parametrize("shape", [(9, 9), (11, 9), (5, 8)])
def test_conditions_are_ratios_of_singular_values(shape):
    """From 1 to 1e13, to the digits that rounding leaves; infinite for a matrix without full rank
    or with entries not finite.
    """
    rng = np.random.default_rng(0)
    wanted, small = 10.0 ** np.arange(0, 14), min(shape)
    matrices = []
    for condition in wanted:
        left, right = (np.linalg.qr(rng.normal(size=(n, n)))[0] for n in shape)
        matrices.append(
            left[:, :small] @ np.diag(np.geomspace(condition, 1.0, small)) @ right[:small]
        )
    found = conditions(np.array([*matrices, np.zeros(shape), np.full(shape, np.nan)]))
    np.testing.assert_allclose(found[:-2], wanted, rtol=1e-2)
    np.testing.assert_allclose(found[:5], wanted[:5], rtol=1e-10)
    assert np.isinf(found[-2:]).all()


def test_a_loop_of_too_many_joints_is_refused_at_once():
    """Each verb says which loop, and how many joints it may have."""
    count = 1000
    angles = 2 * np.pi * np.arange(count) / count
    links = ["base", *(f"link{k}" for k in range(1, count))]
    joints = [
        symkin.LinkJoint(
            symkin.Joint(f"q{k}", "R", (np.cos(a), np.sin(a), 0.0), (0, 0, 1), actuated=k > 2),
            (links[k], links[(k + 1) % count]),
        )
        for k, a in enumerate(angles)
    ]
    ring = symkin.Mechanism("ring", link_joints=joints)
    for verb in (symkin.modes, symkin.mobility, symkin.solve):
        with pytest.raises(symkin.MechanismError, match="has 1000 joints; allowed: 250"):
            verb(ring)
