"""Krawczyk's test in double precision for all points at once: what it shows is true by balls and by
known roots; what is no regular root is never shown.
"""

from __future__ import annotations

from itertools import product

import casadi as ca
import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

import certificates
from helpers import inside
from helpers.certificates import certify, knowns_of_one, of_instance
from helpers.gate import in_gate
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    Enclosures,
    Knowns,
    certify_batch,
    enclose_all,
    in_phase,
    shared_library,
)
from helpers.known_roots import case
from helpers.samples import seeds

KNOWN_CASES = ["dietmaier", "zhang2009", "yao2020", "gluon_6l3"]


def system_of_rows(rows, width: int = 1, known: int = 0, kind: str = "length") -> AlgebraicSystem:
    """Rows in some unknowns, as functions of z and k."""
    z, k = ca.SX.sym("z", width), ca.SX.sym("k", known)
    unknowns = tuple(Coordinate(f"x{i}", kind, "passive") for i in range(width))
    return AlgebraicSystem(1.0, unknowns, z, k, ca.vertcat(*rows(z, k)), ())


def tried(
    system: AlgebraicSystem,
    points: np.ndarray,
    known: np.ndarray | None = None,
    *,
    real: bool = True,
) -> Enclosures:
    """The test at points (width, n) of one instance, or, with known values (n, .), of as many."""
    n = points.shape[1]
    knowns = Knowns.exact(np.zeros((1, 0)) if known is None else known)
    instance = np.zeros(n, dtype=int) if known is None else np.arange(n)
    return enclose_all(system, points.astype(complex), np.full(n, real), knowns, instance)


@pytest.fixture
def engine():
    """The test is one of compiled code."""
    if shared_library() is None:
        pytest.skip("no C compiler")


def holds(found: Enclosures, i: int, root: np.ndarray) -> bool:
    apart = found.centre[:, i] - root
    return bool(np.max(np.maximum(np.abs(apart.real), np.abs(apart.imag))) <= found.half_width[i])


# --- what is shown is true ------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["squares", "angles", "rays"])
def test_boxes_of_nearly_double_roots_are_true_by_balls(engine, name):
    """The short form of `benchmarks/certificates.py` on systems whose roots nearly meet."""
    rng = np.random.default_rng(3)
    counts = np.sum(
        [certificates.count_failures(certificates.nearly_double(name, rng), rng) for _ in range(4)],
        axis=0,
    )
    assert counts[1] > 20
    assert counts[2] == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(KNOWN_CASES, ["gluon_6l3", "yao2020", "zhang2009"]))
def test_boxes_of_mechanisms_are_true_by_balls(engine, name):
    """The same on roots of mechanisms; a point off by less than 1e-10 is certified."""
    _, system, k, z = case(name)
    rng = np.random.default_rng(0)
    roots = certificates.Roots(name, system, knowns_of_one(k), z[:, ::4])
    certified, failures = certificates.count_failures(roots, rng)[1:]
    assert certified > 20 * roots.z.shape[1]
    assert failures == 0


@settings(max_examples=30, deadline=None)
@given(seeds, st.integers(1, 4), st.sampled_from([1e-9, 1e-5, 1e-2, 1.0]), st.booleans())
def test_each_box_holds_one_of_the_known_roots(rng, width, gap, curved):
    """Rows that are random combinations of (z_i - a_i)(z_i - a_i - gap): 2^n roots; every box holds
    one of them.
    """
    a, mixing = rng.integers(-3, 4, width).astype(float), rng.normal(size=(width, width))

    def rows(z, _):
        factors = [
            (z[i] - a[i]) * (z[i] - a[i] - gap) * (1 + curved * z[i - 1] ** 2) for i in range(width)
        ]
        return ca.vertsplit(ca.mtimes(ca.DM(mixing), ca.vertcat(*factors)))

    roots = np.array(list(product(*[(x, x + gap) for x in a]))).T
    points = np.repeat(roots, 6, axis=1)
    size = rng.choice([1e-16, 1e-12, 1e-8, 0.3 * gap, 0.5 * gap], points.shape[1]) * (
        np.arange(points.shape[1]) % 6 > 0
    )
    points = points + size * rng.normal(size=points.shape)
    found = tried(system_of_rows(rows, width), points)
    for i in np.flatnonzero(found.found).tolist():
        held = [holds(found, i, root) for root in roots.T]
        # the second root, a + gap, is a rounded number: the box may hold the exact one alone
        assert sum(held) <= 1
        assert any(
            np.max(np.abs(found.centre[:, i] - root)) <= found.half_width[i] + 1e-15
            for root in roots.T
        )
    assert found.found[::6].any() or gap < 1e-2 or shared_library() is None


def test_a_box_holds_for_all_known_values_in_their_discs(engine):
    """z^2 = k for k within 1e-9 of 2: the box holds the roots for both ends."""
    system = system_of_rows(lambda z, k: [z[0] ** 2 - k[0]], known=1)
    found = enclose_all(
        system,
        np.array([[np.sqrt(2) + 0j]]),
        np.array([True]),
        knowns_of_one([arb(2.0, 1e-9)]),
        np.zeros(1, dtype=int),
    )
    assert found.found[0]
    assert all(holds(found, 0, np.array([np.sqrt(2 + side)])) for side in (-1e-9, 0, 1e-9))
    assert found.half_width[0] < 1e-9


# --- what is not true is not shown ----------------------------------------------------------------


@given(st.integers(2, 4), st.sampled_from([0.0, 1e-200, 1e-20, 1e-9, 1e-6]), st.booleans())
def test_multiple_roots_are_not_shown(order, off, real):
    """z^n = 0, and (z0 z1, z0 + z1) at zero: no box, wherever the point is; none of z^2 + 1e-30
    either, in real numbers.
    """
    point = np.array([[off]])
    assert not tried(system_of_rows(lambda z, _: [z[0] ** order]), point, real=real).found.any()
    double = system_of_rows(lambda z, _: [z[0] * z[1], z[0] + z[1]], 2)
    assert not tried(double, np.full((2, 1), off), real=real).found.any()
    assert not tried(system_of_rows(lambda z, _: [z[0] ** 2 + 1e-30]), point).found.any()
    assert not tried(
        system_of_rows(lambda z, _: [ca.sin(z[0]) - 1], kind="angle"), np.pi / 2 + point, real=real
    ).found.any()


@pytest.mark.parametrize("name", ["dietmaier", "yao2020"])
def test_points_beside_roots_have_no_box_that_is_near(engine, name):
    """A point 1e-3 away either has no box or one about the true root, away from the point."""
    _, system, k, z = case(name)
    given_points = in_phase(system, z + 1e-3 * np.random.default_rng(0).normal(size=z.shape))
    found = enclose_all(
        system,
        given_points,
        np.zeros(z.shape[1], dtype=bool),
        knowns_of_one(k),
        np.zeros(z.shape[1], dtype=int),
    )
    away = np.max(np.abs(found.centre - given_points), axis=0)
    assert np.all(away[found.found] > 1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e308])
def test_missing_numbers_show_nothing(engine, bad):
    """Points or known values that are no numbers have no box, and spoil none beside them."""
    _, system, k, z = case("zhang2009")
    start = in_phase(system, z)
    spoiled = start.copy()
    spoiled[2, 5] = bad
    near = np.max(np.abs(start.imag), axis=0) < 1e-7
    found, clean = (
        enclose_all(system, p, near, knowns_of_one(k), np.zeros(z.shape[1], dtype=int))
        for p in (spoiled, start)
    )
    others = np.arange(z.shape[1]) != 5
    assert not found.found[5]
    assert np.array_equal(found.half_width[others], clean.half_width[others])
    values = np.repeat(np.asarray(k).real[None], 2, axis=0)
    values[1, 3] = bad
    found = enclose_all(system, start[:, [0, 0]], near[[0, 0]], Knowns.exact(values), np.arange(2))
    assert found.found.tolist() == [True, False]
    assert not certify(system, z, values[1]).certified.any()


@pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e-150, 1e-12, 1e12, 1e150, 1e300])
def test_rows_of_any_scale(engine, scale):
    """c (z - 1)(z - 2) = 0: a box is true at every scale of the row, and there is one where squares
    neither under- nor overflow.
    """
    system = system_of_rows(lambda z, k: [k[0] * (z[0] - 1) * (z[0] - 2)], known=1)
    found = tried(system, np.array([[1.0, 2.0 + 1e-12, 1.5]]), np.full((3, 1), scale))
    assert not found.found[2]
    for i in np.flatnonzero(found.found).tolist():
        assert [holds(found, i, np.array([root])) for root in (1.0, 2.0)] == [i == 0, i == 1]
    assert found.found[:2].all() or not 1e-100 < scale < 1e100


@pytest.mark.parametrize("scale", [5e-324, 1e-310, 1e-20, 1e-9, 1e6, 1e15])
def test_unknowns_of_any_scale(engine, scale):
    """z^2 = c^2 at z = c: the box holds c and not -c."""
    system = system_of_rows(lambda z, k: [z[0] ** 2 - k[0] ** 2], known=1)
    found = tried(system, np.array([[scale, -scale]]), np.full((2, 1), scale))
    for i in np.flatnonzero(found.found).tolist():
        assert [holds(found, i, np.array([root])) for root in (scale, -scale)] == [i == 0, i == 1]
    assert found.found.all() or not 1e-5 < scale < 1e3


# --- batches --------------------------------------------------------------------------------------


def test_a_point_does_not_depend_on_its_neighbours(engine):
    """Boxes of all points together and of each alone are the same, bit for bit."""
    _, system, k, z = case("yao2020")
    start, near = in_phase(system, z), np.zeros(z.shape[1], dtype=bool)
    whole = enclose_all(system, start, near, knowns_of_one(k), np.zeros(z.shape[1], dtype=int))
    for i in range(z.shape[1]):
        alone = enclose_all(
            system, start[:, [i]], near[[i]], knowns_of_one(k), np.zeros(1, dtype=int)
        )
        assert alone.half_width[0] == whole.half_width[i]
        assert np.array_equal(alone.centre[:, 0], whole.centre[:, i])


@pytest.mark.parametrize("name", KNOWN_CASES)
def test_many_instances_are_certified_as_one_by_one(name):
    """Three instances, one of them with a root left out and one with a root twice: counts and boxes
    as of each alone.
    """
    _, system, k, z = case(name)
    sets = [z, z[:, 1:], np.concatenate([z, z[:, :1]], axis=1)]
    instance = np.repeat(np.arange(3), [s.shape[1] for s in sets])
    knowns = Knowns.exact(np.repeat(np.asarray(k)[None], 3, axis=0))
    batch = certify_batch(system, np.concatenate(sets, axis=1), knowns, instance)
    count = z.shape[1]
    assert batch.distinct.tolist() == [count, count - 1, count]
    for j, points in enumerate(sets):
        alone, of = certify(system, points, k), of_instance(batch, j)
        assert np.array_equal(of.certified, alone.certified)
        assert np.array_equal(of.ball, alone.ball)
        assert np.array_equal(of.radius, alone.radius)
        assert np.array_equal(of.real, alone.real)
        assert of.disjoint == alone.disjoint


def test_roots_are_found_within_their_instance():
    """`find` names the root of the point's own instance: another instance's equal root is none."""
    _, system, k, z = case("zhang2009")
    knowns = Knowns.exact(np.repeat(np.asarray(k)[None], 2, axis=0))
    certified = certify(system, z, k)
    real = np.flatnonzero(certified.real == "real")
    points = np.concatenate([z[:, real], z[:, real[1:]]], axis=1)
    batch = certify_batch(system, points, knowns, np.repeat([0, 1], [len(real), len(real) - 1]))
    turned = -2.0 * certified.centre[:, [real[0], real[1], real[0]]]
    index, radius = batch.find(turned, np.array([0, 0, 1]))
    assert index.tolist() == [0, 1, -1]
    assert np.isfinite(radius).tolist() == [True, True, False]


def test_engines_agree():
    """The same points are certified, with boxes that meet; those of balls are no wider."""
    if shared_library() is None:
        pytest.skip("no C compiler")
    for name in KNOWN_CASES:
        _, system, k, z = case(name)
        results = []
        for chosen in ("", "numpy"):
            with pytest.MonkeyPatch.context() as patch:
                patch.setenv("SYMKIN_ENGINE", chosen)
                results.append(certify(system, z, k))
        first, second = results
        assert first.certified.all()
        assert second.certified.all()
        assert np.all(
            np.max(np.abs(first.centre - second.centre), axis=0) <= 2 * (first.ball + second.ball)
        )
        assert np.all(second.ball <= 3.0 * first.ball)


def test_a_radius_without_discs_is_one_by_balls(monkeypatch):
    """Where coordinates have no form over discs, the radius comes from balls: not nothing, and no
    larger than by discs.
    """
    _, system, k, z = case("yao2020")
    by_discs = certify(system, z, k).radius
    monkeypatch.setattr(inside.certificate_coordinates, "_disc_coordinates", lambda _: None)
    by_balls = certify(system, z, k).radius
    assert np.all(by_balls > 0)
    assert np.all(by_balls <= by_discs * (1 + 1e-9))
