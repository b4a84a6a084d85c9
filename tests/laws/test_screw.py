"""Screws: exponentials, the adjoint map and reciprocity."""

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.inside import exponential, move_screw, reciprocal_product, reciprocal_system
from helpers.inside import screw as sc
from helpers.laws import act, axis_turn, displacement, frame, same_pose
from helpers.samples import point, seeds, unit
from symkin import Pose

values = st.floats(-6, 6) | st.sampled_from([0.0, 1e-12, 1e-7, 1e-5, 1.1e-5, 1e-4, math.pi])


def hat(s):
    """The 4 x 4 matrix of a twist (w; v)."""
    return np.array(
        [[0, -s[2], s[1], s[3]], [s[2], 0, -s[0], s[4]], [-s[1], s[0], 0, s[5]], [0, 0, 0, 0]]
    )


def matrix_exponential(a):
    """Power series after halving 20 times, then 20 squarings."""
    a = a / 2**20
    term, total = np.eye(4), np.eye(4)
    for k in range(1, 8):
        term = term @ a / k
        total = total + term
    for _ in range(20):
        total = total @ total
    return total


def random_screw(rng):
    return np.concatenate([rng.normal(size=3), rng.normal(size=3)])


@given(seeds, values, st.floats(-5, 5))
def test_exponential_of_a_joint_is_its_turn_and_slide(rng, value, pitch):
    """R and H: turn about the axis through the point, advancing pitch / 2 pi per radian; P: slide
    along the axis.
    """
    c, a = np.array(point(rng, 2.0)), np.array(unit(rng))
    turned = displacement(axis_turn(a, value), c, pitch * value / (2 * math.pi) * a)
    assert np.allclose(
        exponential(sc.revolute_screw(c, a, pitch), value).matrix, turned, atol=1e-10
    )
    slid = displacement(np.eye(3), c, value * a)
    assert np.allclose(exponential(sc.prismatic_screw(a), value).matrix, slid, atol=1e-13)


@given(seeds, st.floats(-2, 2))
def test_exponential_is_the_matrix_exponential(rng, value):
    """exp(value [s]) of the 4 x 4 twist matrix, for any screw."""
    s = random_screw(rng)
    assert np.allclose(exponential(s, value).matrix, matrix_exponential(value * hat(s)), atol=1e-8)


@given(seeds, values, values)
def test_exponential_adds(rng, a, b):
    """exp(a s) exp(b s) = exp((a + b) s), and exp(0) = 1."""
    s = random_screw(rng)
    s[:3] /= np.linalg.norm(s[:3])
    assert same_pose(exponential(s, a) @ exponential(s, b), exponential(s, a + b), 10.0, 1e-10)
    assert np.array_equal(exponential(s, 0.0).matrix, np.eye(4))


@given(seeds)
def test_exponential_is_smooth_where_the_series_takes_over(rng):
    """Both branches agree about |s| value = 1e-5 to the distance between the two values."""
    s = sc.revolute_screw(np.array(point(rng, 2.0)), np.array(unit(rng)))
    below, above = exponential(s, 1e-5 * (1 - 1e-7)), exponential(s, 1e-5 * (1 + 1e-7))
    assert np.max(np.abs(below.matrix - above.matrix)) < 1e-11


@given(seeds, values)
def test_adjoint_moves_the_screw_with_its_axis(rng, value):
    """Ad_g of a revolute's screw is that of the moved point and axis; g exp(s) g^-1 = exp(Ad_g s);
    Ad_gh = Ad_g Ad_h.
    """
    g, h = (Pose(np.array(point(rng, 2.0)), np.array(unit(rng, 4))) for _ in range(2))
    c, a = np.array(point(rng, 2.0)), np.array(unit(rng))
    s = sc.revolute_screw(c, a, 0.5)
    m = frame(g.position, g.quaternion)
    assert np.allclose(
        move_screw(g, s), sc.revolute_screw(act(m, c), m[:3, :3] @ a, 0.5), atol=1e-12
    )
    assert same_pose(
        g @ exponential(s, value) @ g.inverse(),
        exponential(move_screw(g, s), value),
        1.0,
        1e-10,
    )
    assert np.allclose(move_screw(g @ h, s), move_screw(g, move_screw(h, s)), atol=1e-11)


@given(seeds)
def test_reciprocal_product_is_power_and_does_not_depend_on_the_frame(rng):
    """f . v + m . w of a force through a point and a twist: the force times the point's velocity;
    invariant under Ad.
    """
    twist, force, at = random_screw(rng), rng.normal(size=3), rng.normal(size=3)
    wrench = np.concatenate([force, np.cross(at, force)])
    velocity = twist[3:] + np.cross(twist[:3], at)
    power = reciprocal_product(twist, wrench)
    assert math.isclose(power, force @ velocity, rel_tol=1e-10, abs_tol=1e-10)
    g = Pose(rng.normal(size=3), np.array(unit(rng, 4)))
    assert math.isclose(
        reciprocal_product(move_screw(g, twist), move_screw(g, wrench)),
        power,
        abs_tol=1e-10,
    )
    assert math.isclose(reciprocal_product(wrench, twist), power, abs_tol=1e-12)


@given(seeds, st.integers(0, 6), st.integers(0, 2), st.sampled_from([1.0, 100.0]))
def test_reciprocal_systems_are_complements(rng, count, repeats, size):
    """Every product vanishes, the dimensions sum to 6, and reciprocal twice is the system
    itself.
    """
    screws = rng.normal(size=(count, 6)) * [1, 1, 1, size, size, size]
    if count:
        screws = np.vstack([screws, rng.normal(size=(repeats, count)) @ screws])
    screws = screws.reshape(-1, 6)
    other = reciprocal_system(screws, size)
    assert len(other) == 6 - count
    for s in screws:
        for w in other:
            assert abs(reciprocal_product(s, w)) < 1e-8 * np.linalg.norm(s) * np.linalg.norm(w) * 10
    again = reciprocal_system(other, size)
    assert len(again) == count
    assert (
        np.linalg.matrix_rank(np.vstack([screws, again]) / [1, 1, 1, size, size, size], tol=1e-6)
        == count
    )


def test_reciprocal_system_of_a_spherical_joint():
    """Three turns through a point: the forces through it, and nothing else (Ball 1900)."""
    c = np.array([1.0, 2.0, 3.0])
    system = reciprocal_system(np.array([sc.revolute_screw(c, a) for a in np.eye(3)]))
    assert len(system) == 3
    assert all(np.allclose(w[3:], np.cross(c, w[:3]), atol=1e-12) for w in system)


@given(seeds, st.integers(0, 5))
def test_tidy_rows_keep_the_row_space(rng, count):
    """Echelon form: same space, unit rows."""
    rows = rng.normal(size=(count, 6))
    tidy = sc.tidy_rows(rows)
    assert tidy.shape == rows.shape
    assert np.linalg.matrix_rank(np.vstack([rows, tidy]), tol=1e-7) == count
    assert np.allclose(np.linalg.norm(tidy, axis=1), 1)


@pytest.mark.slow
@given(seeds, values)
def test_symbols_evaluate_to_the_same_numbers(rng, value):
    """The CasADi exponential gives NumPy's, at small angles too, and its derivative there is the
    screw.
    """
    s, v = ca.SX.sym("s", 6), ca.SX.sym("v")
    made = exponential(s, v)
    function = ca.Function("f", [s, v], [made.matrix, ca.jacobian(ca.vec(made.matrix), v)])
    numbers = random_screw(rng)
    matrix, _ = function(numbers, value)
    assert np.allclose(np.array(matrix), exponential(numbers, value).matrix, atol=1e-11)
    _, slope = function(numbers, 0.0)
    assert np.allclose(np.array(slope).reshape(4, 4, order="F"), hat(numbers), atol=1e-12)


@given(seeds)
def test_a_stack_is_element_by_element(rng):
    """Screws (6, N) and values (N,) act column by column."""
    screws, v = rng.normal(size=(6, 4)), np.array([0.0, 1e-7, 0.5, -2.0])
    whole = exponential(screws, v).matrix
    for k in range(4):
        assert np.allclose(whole[:, :, k], exponential(screws[:, k], v[k]).matrix, atol=1e-13)
