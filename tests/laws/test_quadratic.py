"""Closures made of quadratics: the form is the rows, the series solves them, and paths end where
the general tracker's do.
"""

from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given

import symkin
from helpers.inside import (
    AlgebraicSystem,
    QuadraticForm,
    algebraic_systems,
    build_problem,
    distance_data,
    known_values,
    line_of,
    quadratic,
    quadratic_form,
    tracker,
    universal_start,
    universal_system,
)
from helpers.inside import track_quadratic as track
from helpers.samples import delta, hexapod, seeds


def gauss(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.normal(size=shape) + 1j * rng.normal(size=shape)


@lru_cache
def systems() -> dict[str, AlgebraicSystem]:
    """Six rods (a ray, lengths and points known); one rod (a length unknown, its pose known); a
    delta that only translates (redundant rows, angles known); a delta by rods in space (a ray,
    angles known).
    """
    free_delta = replace(delta(), motion="spatial", name="delta_spatial")
    problems = {
        "six rods": build_problem(symkin.load("zhang2009"), "direct"),
        "one rod": build_problem(symkin.load("zhang2009"), "inverse"),
        "delta": build_problem(delta(), "direct"),
        "delta in space": build_problem(free_delta, "direct"),
    }
    return {name: algebraic_systems(problem)[0] for name, problem in problems.items()}


def form_of(system: AlgebraicSystem) -> QuadraticForm:
    form = quadratic_form(system)
    assert form is not None
    return form


def lifted(form: QuadraticForm, z: np.ndarray) -> np.ndarray:
    """x = (z, 1) where the form has the constant 1."""
    return np.concatenate([z.T, np.ones((z.shape[1], form.width - form.unknowns))], axis=1)


NAMES = ["six rods", "one rod", "delta", "delta in space"]


# --- the form -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@given(rng=seeds)
def test_the_form_is_the_rows(name, rng):
    """x^T A(k) x = F(z, k) at any complex point."""
    system = systems()[name]
    form = form_of(system)
    z, k = gauss(rng, system.width, 5), gauss(rng, int(system.k.shape[0]), 5)
    a = form.matrices[: form.rows] + np.tensordot(form.at(k), form.matrices[form.rows :], 1)
    x = lifted(form, z)
    rows = np.einsum("na,nrab,nb->nr", x, a, x)
    expected, _ = system.linearise(z, k)
    np.testing.assert_allclose(
        rows, expected, atol=1e-11 * np.max(np.abs(a)) * np.max(np.abs(x)) ** 2
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@given(rng=seeds)
def test_a_line_is_the_form_along_it(name, rng):
    """2 B x and 2 V x with the weights at s give x^T A(k(s)) x, for known values that are lengths,
    points and angles.
    """
    system = systems()[name]
    form = form_of(system)
    begin, end = gauss(rng, 2, int(system.k.shape[0]))
    line = line_of(form, begin, end, 8)
    s, z = rng.uniform(size=5), gauss(rng, system.width, 5)
    x, images = lifted(form, z), line.apply(lifted(form, z))
    values = 0.5 * np.einsum("nrw,nw->nr", images, x)
    u = line.weights(s)[:, :, 0]
    rows = values[:, : form.rows] + np.einsum("nrq,nq->nr", u, values[:, form.rows :])
    expected, _ = system.linearise(z, begin[:, None] + s * (end - begin)[:, None])
    scale = np.max(np.abs(values)) * max(1.0, np.max(np.abs(u), initial=0.0))
    np.testing.assert_allclose(rows, expected, atol=1e-10 * scale)


@given(rng=seeds)
def test_weights_come_with_their_taylor_series(rng):
    """sum_c u_c(s) t^c = u_0(s + t): the weights of six rods are polynomials along a line."""
    form = form_of(universal_system())
    line = line_of(form, *gauss(rng, 2, 42), 8)
    s, t = rng.uniform(size=4), rng.uniform(-0.3, 0.3, 4)
    powers = t[:, None] ** np.arange(line.terms + 1)
    there = np.einsum("nrcq,nc->nrq", line.weights(s), powers)
    np.testing.assert_allclose(
        there, line.weights(s + t)[:, :, 0], atol=1e-11 * np.max(np.abs(there))
    )


def test_only_what_moves_is_kept_along_a_line():
    """With fixed points the lengths enter six rods' rows as L^2 |e|^2 alone: one moving quadratic
    form of degree 2.
    """
    form = form_of(universal_system())
    begin = gauss(np.random.default_rng(0), 42)
    end = begin.copy()
    end[::7] += 1.0
    assert line_of(form, begin, end, 8).moving == 1
    assert line_of(form, begin, begin + 1.0, 8).moving > 1
    assert form.degree == 2


@pytest.mark.parametrize("name", ["zhao2000_links", "gluon_6l3"])
def test_other_closures_have_no_form(name):
    """Rows that hold unknown angles are no quadratics."""
    problem = build_problem(symkin.load(name), "direct" if name == "zhao2000_links" else "inverse")
    assert quadratic_form(algebraic_systems(problem)[0]) is None


def test_fewer_rows_than_unknowns_have_no_form():
    """A set of positive dimension has no paths of points."""
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k")
    assert quadratic_form(AlgebraicSystem(1.0, (), z, k, z[0] * z[1] - k, ())) is None


# --- the series -----------------------------------------------------------------------------------


def rods_at(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots of six rods at complex known values, and where the lengths are to go."""
    start = universal_start()
    end = start.k.copy()
    end[::7] += 0.5 * gauss(rng, 6)
    return start.z, start.k, end


@given(rng=seeds)
def test_the_series_meets_the_rows_to_its_order(rng):
    """The rows at s + t of the series with p terms are of order t^(p + 1): a half of t leaves 2^-9
    of them.
    """
    z, begin, end = rods_at(rng)
    line = line_of(form_of(universal_system()), begin, end, 8)
    x = universal_system().normalise(z).T
    terms = quadratic._series(line, x, np.zeros(len(x)))
    left = []
    for t in (0.02, 0.01):
        powers = t ** np.arange(8, -1, -1)
        point = np.einsum("npw,p->nw", terms, powers)
        u = line.weights(np.full(len(x), t))[:, :, 0]
        left.append(np.max(np.abs(quadratic._rows(line, line.apply(point), point, u)), axis=(1, 2)))
    seen = left[1] > 1e-13
    assert np.all(left[1][seen] / left[0][seen] < 2.0**-8)
    assert np.all(left[1][~seen] < 1e-12)


@given(rng=seeds)
def test_a_common_denominator_is_found(rng):
    """A vector of cubics over one cubic is summed exactly, also farther than its poles, where its
    series diverges.
    """
    poles = rng.uniform(0.8, 1.2, 3) * np.exp(
        1j * np.pi * (np.array([1, 3, 5]) / 3 + rng.uniform(-0.2, 0.2, 3))
    )
    q = np.poly(poles)[::-1] / np.prod(-poles)
    numerator = gauss(rng, 6, 4)
    series = np.zeros((6, 9), dtype=complex)
    for p in range(9):
        series[:, p] = numerator[:, p] if p < 4 else 0.0
        series[:, p] -= sum(q[j] * series[:, p - j] for j in range(1, min(p, 3) + 1))
    h = 1.3
    exact = (numerator @ h ** np.arange(4)) / (q @ h ** np.arange(4))
    summed = quadratic._sum(series.T[::-1][None], np.array([h]))[0]
    np.testing.assert_allclose(summed, exact, rtol=1e-7)


# --- paths ----------------------------------------------------------------------------------------


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


def test_ends_are_those_of_the_general_tracker():
    """Both trackers follow each path of a random platform to the same root."""
    system, rng = universal_system(), np.random.default_rng(3)
    for _ in range(3):
        z, begin, end = rods_at(rng)
        ours = track(system, form_of(system), z, begin, end)
        others = tracker.track(system, z, begin, end, tracker.TrackSettings(tolerance=1e-4))
        assert ours.arrived.all()
        assert others.arrived.all()
        check_roots(system, ours, end)
        np.testing.assert_allclose(system.features(ours.z), system.features(others.z), atol=1e-8)


@pytest.mark.slow
@given(rng=seeds)
def test_a_path_back_ends_where_it_began(rng):
    """Tracking along a line and back is the identity, root by root."""
    system = universal_system()
    z, begin, end = rods_at(rng)
    there = track(system, form_of(system), z, begin, end)
    back = track(system, form_of(system), there.z[:, there.arrived], end, begin)
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
    rng = np.random.default_rng(8)
    for _ in range(12):
        data = rng.uniform(-1, 1, (6, 7)).astype(complex)
        data[:, 0] = 1.0 + 0.5 * gauss(rng, 6) + 0.3j
        own = track(
            system,
            form_of(system),
            start.z,
            start.k,
            data.ravel(),
            tracker.TrackSettings(tolerance=1e-5),
        )
        real = data.real.copy()
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.linalg.det(turn)
        real[:, 0] = np.linalg.norm(
            rng.normal(size=3) + real[:, 4:] @ turn.T - real[:, 1:4], axis=1
        )
        ends = track(system, form_of(system), own.z, data.ravel(), real.ravel())
        for tracked, k in ((own, data.ravel()), (ends, real.ravel())):
            assert tracked.arrived.all()
            check_roots(system, tracked, k)
            f = system.features(tracked.z)
            assert np.min(np.max(np.abs(f[:, None] - f[None]), axis=2) + np.eye(40)) > 1e-7


def test_angles_move_the_coefficients():
    """A delta by rods in space, whose arms' angles move the base points: both trackers agree on the
    way from complex angles, where its roots are those of six distances, to real ones.
    """
    mechanism = replace(delta(), motion="spatial", name="delta_spatial")
    problem = build_problem(mechanism, "direct")
    (system,) = algebraic_systems(problem)
    angles = np.array([0.3 + 0.5j, -0.2 + 0.4j, 0.1 - 0.6j])
    start, rods = universal_start(), universal_system()
    data = distance_data(problem)(angles)
    scaled = track(
        rods, form_of(rods), start.z, start.k, data, tracker.TrackSettings(tolerance=1e-5)
    )
    assert scaled.arrived.all()
    z, _ = tracker.newton(system, scaled.z, known_values(problem, angles))
    end = known_values(problem, np.array([0.2, 0.1, -0.15]))
    ours = track(system, form_of(system), z, known_values(problem, angles), end)
    others = tracker.track(
        system, z, known_values(problem, angles), end, tracker.TrackSettings(tolerance=1e-5)
    )
    assert form_of(system).degree is None
    assert ours.arrived.all()
    check_roots(system, ours, end)
    np.testing.assert_allclose(system.features(ours.z), system.features(others.z), atol=1e-7)


def test_redundant_rows_are_solved_together():
    """A translating delta has two equal rows a limb: both of its poses are tracked on all six
    rows.
    """
    problem = build_problem(delta(), "direct")
    (system,) = algebraic_systems(problem)
    here = known_values(problem, np.zeros(3))
    up = np.array([0.0, 0.0, -np.sqrt(220.0**2 - 180.0**2)]) / system.characteristic_length
    z = np.array([up, -up]).T
    end = np.array([0.3, -0.2, 0.1]) + 0j
    tracked = track(system, form_of(system), z, here, end)
    assert tracked.arrived.all()
    check_roots(system, tracked, end)
    assert system.count > system.width


def test_rows_that_contradict_each_other_have_no_end():
    """x^2 = k_1 and x^2 = k_2 with k_1 /= k_2: a least-squares point is no root."""
    z, k = ca.SX.sym("z", 1), ca.SX.sym("k", 2)
    system = AlgebraicSystem(1.0, (), z, k, z**2 - k, ())
    good = track(
        system, form_of(system), np.array([[1.0 + 0j]]), np.array([1.0, 1.0]), np.array([4.0, 4.0])
    )
    bad = track(
        system, form_of(system), np.array([[1.0 + 0j]]), np.array([1.0, 1.0]), np.array([4.0, 9.0])
    )
    assert good.arrived.all()
    np.testing.assert_allclose(good.z, 2.0, atol=1e-12)
    assert not bad.arrived.any()


def test_a_double_root_is_not_an_end():
    """x^2 = k from k = 1 + i to 0: both paths come close, neither arrives."""
    z, k = ca.SX.sym("z", 1), ca.SX.sym("k", 1)
    system = AlgebraicSystem(1.0, (), z, k, z**2 - k, ())
    root = np.sqrt(1.0 + 1.0j)
    tracked = track(
        system, form_of(system), np.array([[root, -root]]), np.array([1.0 + 1.0j]), np.array([0.0])
    )
    assert not tracked.arrived.any()
    assert np.all(tracked.s > 1.0 - 1e-4)
    assert np.all(np.abs(tracked.z) < 0.05)


def test_paths_with_lines_of_their_own_are_tracked_too():
    """Known values (known, n): each path follows its own line, as in the general tracker."""
    system, rng = universal_system(), np.random.default_rng(4)
    z, begin, end = rods_at(rng)
    ends = np.repeat(end[:, None], 2, axis=1)
    ends[::7, 1] += 0.1
    ours = track(system, form_of(system), z[:, :2], np.repeat(begin[:, None], 2, axis=1), ends)
    one = track(system, form_of(system), z[:, 1:2], begin, ends[:, 1])
    assert ours.arrived.all()
    np.testing.assert_allclose(system.features(ours.z[:, 1:]), system.features(one.z), atol=1e-9)


def test_no_paths_and_no_way_to_go():
    """No paths end nowhere; a path from k to k ends where it is."""
    system = universal_system()
    z, begin, end = rods_at(np.random.default_rng(0))
    assert track(system, form_of(system), z[:, :0], begin, end).z.shape == (8, 0)
    still = track(system, form_of(system), z, begin, begin)
    assert still.arrived.all()
    np.testing.assert_allclose(system.features(still.z), system.features(z), atol=1e-9)


def test_hexapods_of_one_shape_share_one_form():
    """The form belongs to the system of six distances, not to a machine."""
    platforms = [hexapod(np.eye(6, 3) * 50 + i, np.eye(6, 3) * 30 + 2 * i) for i in (1, 2)]
    forms = {
        id(quadratic_form(algebraic_systems(build_problem(m, "direct"))[0])) for m in platforms
    }
    assert len(forms) == 1
