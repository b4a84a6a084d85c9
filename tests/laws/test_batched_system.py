"""One system at many points: the same numbers as one by one, and as NumPy's own decompositions."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.inside import (
    Coordinate,
    Mapped,
    System,
    Writing,
    build_problem,
    conditions,
    extreme_singular_values,
    independent_rows,
    least_squares_steps,
    levenberg_marquardt,
    most_independent,
    null_space,
    row_space,
    shared_library,
    singular_values,
)
from helpers.samples import five_bar, three_rrr

RNG = np.random.default_rng(3)


@pytest.mark.parametrize("count", [0, 1, 2, 63, 64, 65, 200, 255, 256, 257])
def test_a_mapped_function_is_the_function(count):
    """At any number of points, arguments of each point or of all."""
    x, k = ca.SX.sym("x", 3), ca.SX.sym("k", 2)
    mapped = Mapped.of([x, k], [ca.vertcat(x * k[0], k[1]), ca.jacobian(ca.sin(x) * k[1], x)])
    points, known = RNG.normal(size=(count, 3)), RNG.normal(size=(count, 2))
    for each in (known, RNG.normal(size=2)):
        first, second = mapped(points, each)
        assert first.shape == (count, 4, 1)
        assert second.shape == (count, 3, 3)
        for i in range(count):
            a, b = mapped.function(points[i], each[i] if each.ndim == 2 else each)
            assert np.array_equal(np.asarray(a), first[i])
            assert np.array_equal(np.asarray(b), second[i])


@pytest.mark.parametrize("known", [(256, 1), (255, 2), (1, 2), (1,), (256, 3)])
def test_compiled_code_reads_no_more_than_its_arguments(known):
    """Arguments of another length, or of other points, are refused, not read beyond their end."""
    x, k = ca.SX.sym("x", 3), ca.SX.sym("k", 2)
    mapped = Mapped.of([x, k], [x * k[0] + k[1]])
    if shared_library() is None:
        pytest.skip("there is no C compiler here")
    with pytest.raises(ValueError, match="an argument of shape"):
        mapped(np.ones((256, 3)), np.ones(known))


def test_compiled_operations_are_those_of_casadi(monkeypatch):
    """Every operation at numbers of all kinds, digit for digit, with a compiler and without."""
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    both = [x + y, x - y, x * y, x / y, ca.fmax(x, y), ca.atan2(x, y)]
    one = [x**2, -x, 2 * x, 1 / x, ca.sin(x), ca.cos(x), ca.sqrt(x), ca.fabs(x)]
    mapped = Mapped.of([x, y], [ca.vertcat(*both, *one, 3.7)])
    special = [0.0, -0.0, 1e-310, 1e308, np.inf, -np.inf, np.nan]
    points = np.concatenate([special, RNG.normal(size=219), 1e5 * RNG.normal(size=30)])
    compiled = mapped(points[:, None], np.roll(points, 3)[:, None])[0]
    monkeypatch.setenv("SYMKIN_ENGINE", "numpy")
    assert shared_library() is None
    plain = mapped(points[:, None], np.roll(points, 3)[:, None])[0]
    assert np.array_equal(compiled, plain, equal_nan=True)


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (2, 5), (4, 4), (10, 7), (8, 12)])
def test_extremes_of_many_are_those_of_their_singular_values(shape):
    """Simple ones, equal ones, nearly equal ones, nearly none; each the same in other company; of
    what is zero or not finite nothing.
    """
    n, least = 600, min(shape)
    left, sizes, right = np.linalg.svd(RNG.normal(size=(n, *shape)), full_matrices=False)
    sizes[:100] = sizes[:100, :1]
    sizes[100:200, 1:] = sizes[100:200, 1:2]
    sizes[200:300] = sizes[200:300, :1] * (1 + 1e-9 * RNG.random((100, least)))
    sizes[300:400, -1] *= 10.0 ** RNG.uniform(-12, 0, 100)
    whole = (left * sizes[:, None]) @ right
    whole[400:403, 0, 0] = 0.0, np.nan, np.inf
    whole[403] = 0.0
    found, sizes = extreme_singular_values(whole), singular_values(whole)
    np.testing.assert_allclose(found[:, 0], sizes[:, 0], rtol=1e-13)
    np.testing.assert_allclose(found[:, 1], sizes[:, -1], rtol=1e-9, atol=1e-15)
    assert not found[[401, 402, 403]].any()
    assert np.array_equal(extreme_singular_values(whole[7:107]), found[7:107])


@pytest.mark.parametrize("held", [0, 1, 40])
def test_a_nearly_empty_result_is_whole(held):
    """Of large results with few entries, or none, the others are zeros, at every point."""
    x = ca.SX.sym("x", 40)
    rows = ca.vertcat(ca.SX(0, 1), *(ca.sin(x[k]) * x[(k + 7) % 40] for k in range(held)))
    jacobian = ca.vertcat(ca.jacobian(rows, x), ca.SX(40 - held, 40))
    points = RNG.normal(size=(5, 40))
    (found,) = Mapped.of([x], [jacobian])(points)
    direct = ca.Function("direct", [x], [ca.densify(jacobian)])
    assert found.shape == (5, 40, 40)
    for point, one in zip(points, found, strict=True):
        np.testing.assert_allclose(one, np.asarray(direct(point)), rtol=1e-14)


def test_a_search_ends_at_the_bottom_of_a_minimum():
    """Rows (x - 1, x + 1) of one angle, whose least squares at 0 leave both: Gauss and Newton's
    steps are exact there, so that no patience is needed to see that nothing shrinks any more.
    """
    x, angle = ca.SX.sym("x"), Coordinate("x", "angle", "passive")
    rows = ca.vertcat(x - 1, x + 1)
    system = System((angle,), x, ca.SX(0, 1), rows, rows, 1.0)
    starts = np.array([[0.7], [-2.0]])
    ended = levenberg_marquardt(system, starts, np.zeros(0), max_iterations=300, patience=200)
    assert ended.iterations < 20
    np.testing.assert_allclose(ended.points, 0.0, atol=1e-8)
    assert not ended.converged.any()


@pytest.mark.parametrize(("rows", "columns"), [(5, 5), (8, 5), (4, 6)])
def test_least_squares_steps(rows, columns):
    """Square, tall and wide matrices, regular and singular ones side by side, as NumPy's least
    squares one by one.
    """
    jacobians, values = RNG.normal(size=(7, rows, columns)), RNG.normal(size=(7, rows))
    jacobians[2, :, 1] = jacobians[2, :, 0]
    jacobians[4] = 0.0
    steps = least_squares_steps(jacobians, values)
    for j, f, step in zip(jacobians, values, steps, strict=True):
        np.testing.assert_allclose(step, np.linalg.lstsq(j, -f, rcond=1e-13)[0], atol=1e-10)


def test_conditions_and_singular_values():
    """As NumPy's; infinite where a matrix is singular or not finite."""
    matrices = RNG.normal(size=(5, 6, 4))
    matrices[3, :, 2] = 0.0
    matrices[4, 0, 0] = np.nan
    found = conditions(matrices)
    np.testing.assert_allclose(found[:3], [np.linalg.cond(m) for m in matrices[:3]])
    assert np.isinf(found[3:]).all()
    np.testing.assert_allclose(
        singular_values(matrices[0]), np.linalg.svd(matrices[0], compute_uv=False)
    )
    assert conditions(np.zeros((2, 0, 0))).tolist() == [1.0, 1.0]


def test_a_null_space_is_one():
    """Orthonormal rows that the matrix takes to zero, as many as its rank leaves."""
    matrix = RNG.normal(size=(3, 2)) @ RNG.normal(size=(2, 5))
    null = null_space(matrix, 1e-9)
    assert null.shape == (3, 5)
    np.testing.assert_allclose(null @ null.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(matrix @ null.T, 0.0, atol=1e-12)


def test_independent_rows_span_all():
    """As many as the rank, of the same row space; rows of an earlier group go before later ones."""
    matrix = RNG.normal(size=(9, 3)) @ RNG.normal(size=(3, 6))
    span = row_space(matrix, 1e-9)
    for groups in (None, range(9), [[7, 8], range(7)]):
        chosen = independent_rows(matrix, 1e-9, groups=groups)
        assert len(chosen) == 3
        ours = row_space(matrix[chosen], 1e-9)
        np.testing.assert_allclose(ours.T @ ours, span.T @ span, atol=1e-9)
    assert {7, 8} < {*independent_rows(matrix, 1e-9, groups=[[7, 8], range(7)])}


def test_independent_rows_of_a_stack():
    """Each matrix's as it has them alone; together, the same rows, independent in all of them."""
    matrices = RNG.normal(size=(4, 7, 3)) @ RNG.normal(size=(4, 3, 5))
    matrices[2] = matrices[2, [0] * 7]
    matrices = np.concatenate([matrices, np.full((1, 7, 5), np.nan)])
    taken = most_independent(matrices, 5)
    alone = [sorted(independent_rows(m, 1e-9)) for m in matrices[:4]]
    assert [np.flatnonzero(t).tolist() for t in taken[:4]] == alone
    assert taken.sum(axis=1).tolist() == [3, 3, 1, 3, 0]
    same = most_independent(matrices[[0, 1, 3]], 3, together=True)
    assert (same == same[0]).all()
    assert all(np.linalg.matrix_rank(m[same[0]]) == 3 for m in matrices[[0, 1, 3]])


@pytest.mark.parametrize(
    "mechanism", [symkin.load("zhang2009"), five_bar(), three_rrr("planar")], ids=lambda m: m.name
)
def test_many_points_are_each_alone(mechanism):
    """Rows, Jacobians, errors, conditions and polished points of many points with known values of
    their own.
    """
    problem = build_problem(mechanism, "direct")
    system = problem.system
    reference = problem.closure.reference
    z = np.tile(problem.select_values(reference, system.unknowns), (6, 1))
    z = system.move(z, 0.05 * system.characteristic_length * RNG.normal(size=(6, system.freedom)))
    known = problem.select_values(reference, problem.known_coordinates) * (
        1 + 0.01 * RNG.normal(size=(6, len(mechanism.actuated)))
    )
    rows, jacobians = system.linearise(z, known)
    polished = system.polish_many(z, known)
    for i in range(6):
        f, j = system.linearise_one(z[i], known[i])
        np.testing.assert_allclose(rows[i], f, atol=1e-12 * system.characteristic_length)
        np.testing.assert_allclose(jacobians[i], j, atol=1e-12)
        assert system.residuals(z, known)[i] == pytest.approx(system.residual(z[i], known[i]))
        assert system.conditions(z, known)[i] == pytest.approx(system.condition(z[i], known[i]))
        np.testing.assert_allclose(
            polished.points[i],
            system.polish(z[i], known[i], 8),
            atol=1e-9 * system.characteristic_length,
        )


def test_the_standard_writing():
    """Angles within half a turn or in their limits, quaternions with w >= 0, the same rotation;
    written twice, it stays.
    """
    closure = build_problem(symkin.load("zhang2009"), "direct").closure
    values = np.tile(closure.reference, (4, 1))
    place = closure.slices["pose.quaternion"]
    values[:, place] = RNG.normal(size=(4, 4))
    once = Writing.of(closure.coordinates, closure.slices).standard(values)
    q = once[:, place]
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0)
    assert (q[:, 0] >= 0).all()
    np.testing.assert_allclose(
        Writing.of(closure.coordinates, closure.slices).standard(once), once, atol=1e-15
    )
    arm = build_problem(five_bar(), "direct").closure
    angles = [arm.slices[c.name].start for c in arm.coordinates if c.kind == "angle"]
    turned = np.tile(arm.reference, (2, 1))
    turned[:, angles] += 2 * np.pi * np.array([[3.0], [-2.0]])
    np.testing.assert_allclose(
        Writing.of(arm.coordinates, arm.slices).standard(turned)[:, angles],
        np.tile(arm.reference[angles], (2, 1)),
    )


def test_angles_are_written_within_their_limits():
    """By the fewest whole turns that bring them there; those inside stay, those that no turns bring
    in are within half a turn.
    """
    limits = [(-1.0, 2.0), (4.0, 9.0), (-12.0, -11.0), (-20.0, 20.0), (3.0, 3.2)]
    coordinates = [
        Coordinate(f"q{k}", "angle", "passive", limits=pair) for k, pair in enumerate(limits)
    ]
    places = {c.name: slice(k, k + 1) for k, c in enumerate(coordinates)}
    values = RNG.uniform(-30, 30, (500, len(limits)))
    for k, column in enumerate(Writing.of(coordinates, places).standard(values).T):
        low, high = limits[k]
        start = np.remainder(values[:, k] + np.pi, 2 * np.pi) - np.pi
        others = start[:, None] + 2 * np.pi * np.arange(-6, 7)
        inside = (others >= low) & (others <= high)
        nearest = np.argmin(np.where(inside, np.abs(others - start[:, None]), np.inf), axis=1)
        expected = np.where(inside.any(axis=1), others[np.arange(500), nearest], start)
        np.testing.assert_allclose(column, expected, atol=1e-9)


def test_lengths_are_written_above_their_least():
    """A rod of offset d has the coordinate r = length - d: length and -length are one
    configuration, r and 2 least - r, least = -d.
    """
    rod = Coordinate("r", "length", "actuated", least=-3.0)
    length = RNG.uniform(-10, 10, (200, 1))
    np.testing.assert_allclose(
        Writing.of([rod], {"r": slice(0, 1)}).standard(length - 3.0),
        np.abs(length) - 3.0,
        atol=1e-12,
    )
