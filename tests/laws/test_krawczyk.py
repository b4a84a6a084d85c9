"""Boxes: each holds exactly one root, whatever the point and the approximate inverse that it was
tried with; boxes of one root are never told apart.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.inside import (
    COMPLEX,
    REAL,
    AlgebraicSystem,
    BallSystem,
    Box,
    Coordinate,
    chart_of,
    distinct_boxes,
    enclose,
    is_pose,
)
from helpers.samples import seeds


def single(row) -> BallSystem:
    """One row in one length z."""
    z = ca.SX.sym("z")
    return BallSystem(
        AlgebraicSystem(
            1.0, (Coordinate("x", "length", "passive"),), z, ca.SX(0, 1), ca.SX(row(z)), ()
        ),
        (),
    )


def tried(
    balls: BallSystem, point: np.ndarray, inverse: np.ndarray | None, *, real: bool = True
) -> Box | None:
    chart = chart_of(balls, point)
    assert chart is not None
    return enclose(balls, chart, REAL if real else COMPLEX, point.astype(complex), 64, inverse)


def holds(box: Box, root: complex) -> bool:
    (centre,) = box.point
    return max(abs((root - centre).real), abs((root - centre).imag)) <= box.radius + box.rounding


@pytest.mark.slow
@settings(max_examples=150)
@given(
    st.floats(-5, -4),
    st.sampled_from([-1.0, 1.0]),
    st.floats(-2, 2),
    st.floats(0.05, 1.5),
    st.booleans(),
    st.booleans(),
)
def test_a_box_holds_exactly_one_root(exponent, sign, ratio, quality, real, cubic):
    """z^2 = c, and (z^2 - c) (1 + z) = 0: a box holds one of the two small roots and not the other;
    no real one is found where c is negative. Points between and beside the roots are tried, by good
    and by poor inverses of the slope.
    """
    root = 10.0**exponent
    c = sign * root**2
    balls = single(lambda z: (z * z - c) * (1 + z * cubic))
    point = np.array([ratio * root])
    slope = 2 * point[0] + cubic * (3 * point[0] ** 2 - c)
    if abs(slope) < 1e-300:
        return
    box = tried(balls, point, np.array([[quality / slope]]), real=real)
    if box is not None:
        roots = [math.sqrt(c), -math.sqrt(c)] if c > 0 else [1j * root, -1j * root]
        assert sum(holds(box, r) for r in roots) == 1
        assert c > 0 or not real


@given(st.floats(-2, 2), st.floats(0.5, 1.5))
def test_any_inverse_gives_a_true_box(point, quality):
    """A poor inverse may fail; where it does not, the box holds the root of z^3 + z = 2 at 1."""
    box = tried(
        single(lambda z: z**3 + z - 2), np.array([1 + 1e-4 * point]), np.array([[quality / 4]])
    )
    assert box is None or holds(box, 1.0)
    assert box is not None or abs(quality - 1) > 0.3


def test_a_root_that_only_a_part_of_the_rows_makes_regular_is_not_proved():
    """x1^2 = 0, x1^3 = 0, x2 = 2 x0, x3 = 0 on rays: regular within x1 = 0, where two rows vanish,
    yet a double root.
    """
    x = ca.SX.sym("x", 4)
    rows = ca.vertcat(x[1] ** 2, x[1] ** 3, x[2] - 2 * x[0], x[3])
    point = np.array([1.0, 0, 2, 0]) / math.sqrt(5)
    for second, regular in ((x[1] ** 2, False), (x[1] * x[0], True)):
        balls = BallSystem(
            AlgebraicSystem(1.0, (), x, ca.SX(0, 1), ca.vertcat(rows[1:], second), (0, 1, 2, 3)), ()
        )
        box = tried(balls, point, None)
        assert (box is not None) == regular
        assert box is None or is_pose(balls.system, box)


@pytest.mark.slow
@given(seeds, st.complex_numbers(min_magnitude=0.1, max_magnitude=10))
def test_multiples_of_a_ray_in_different_patches_are_one(rng, factor):
    """Two linear rows on rays in C^3 have one root: boxes about it and about a multiple of it, each
    in its own patch, are never told apart; boxes of another system's root are.
    """
    x = ca.SX.sym("x", 3)
    a = rng.normal(size=(2, 3))
    balls = BallSystem(
        AlgebraicSystem(1.0, (), x, ca.SX(0, 1), ca.mtimes(ca.DM(a), x), (0, 1, 2)), ()
    )
    ray = np.cross(a[0], a[1]) / np.linalg.norm(np.cross(a[0], a[1]))
    boxes = [tried(balls, point, None, real=False) for point in (ray + 0j, factor * ray)]
    assert all(box is not None for box in boxes)
    found = [box for box in boxes if box is not None]
    assert distinct_boxes(balls.system, found) == [0]
    other = BallSystem(
        AlgebraicSystem(
            1.0, (), x, ca.SX(0, 1), ca.mtimes(ca.DM(a + [[0, 0, 0.5], [0, 0.5, 0]]), x), (0, 1, 2)
        ),
        (),
    )
    away = np.cross(a[0] + [0, 0, 0.5], a[1] + [0, 0.5, 0])
    box = tried(other, away / np.linalg.norm(away) + 0j, None, real=False)
    assert box is not None
    assert distinct_boxes(balls.system, [*found, box]) == [0, 2]
