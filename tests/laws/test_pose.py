"""Poses: the group SE(3) and its 4 x 4 matrices."""

import re

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from helpers.gate import each_once
from helpers.laws import axis_turn, frame, is_group, same_pose
from helpers.samples import point, seeds, unit
from symkin import InputError, Pose


def pose(rng):
    return Pose(np.array(point(rng)), np.array(unit(rng, 4)))


@given(seeds)
def test_poses_are_a_group(rng):
    """Associativity, identity, inverse."""
    is_group(
        Pose.__matmul__,
        Pose.inverse,
        Pose.identity(),
        [pose(rng) for _ in range(3)],
        lambda a, b: same_pose(a, b, 100.0),
    )


@given(seeds)
def test_matrix_is_a_homomorphism(rng):
    """M(a b) = M(a) M(b), M(a^-1) = M(a)^-1, M(1) = I, and M is the frame of position and
    quaternion.
    """
    a, b = pose(rng), pose(rng)
    assert np.allclose(a.matrix, frame(a.position, a.quaternion), atol=1e-12)
    assert np.allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-11)
    assert np.allclose(a.inverse().matrix, np.linalg.inv(a.matrix), atol=1e-11)
    assert np.array_equal(Pose.identity().matrix, np.eye(4))


@given(seeds)
def test_a_pose_acts_on_points_and_directions(rng):
    """apply is R x + p, turn is R x, and (a b)(x) = a(b(x))."""
    a, b, x = pose(rng), pose(rng), rng.normal(size=3)
    assert np.allclose(a.apply(x), (a.matrix @ [*x, 1])[:3], atol=1e-12)
    assert np.allclose(a.turn(x), a.rotation @ x, atol=1e-12)
    assert np.allclose((a @ b).apply(x), a.apply(b.apply(x)), atol=1e-11)


@given(seeds)
def test_from_matrix_is_the_inverse_of_matrix(rng):
    """from_matrix(M(a)) = a, with w >= 0."""
    a = pose(rng)
    back = Pose.from_matrix(a.matrix)
    assert same_pose(back, a, 100.0, 1e-12)
    assert back.quaternion[0] >= 0


@pytest.mark.parametrize(("sequence", "order"), [("xyz", (2, 1, 0)), ("XYZ", (0, 1, 2))])
@given(rng=seeds)
def test_from_euler(sequence, order, rng):
    """Position and R = product of the elementary turns, moving axes in the order written, fixed
    ones backwards.
    """
    position, angles = point(rng), rng.uniform(-3, 3, 3)
    r = np.eye(3)
    for k in order:
        r = r @ axis_turn(np.eye(3)[k], angles[k])
    made = Pose.from_euler(position, angles, sequence)
    assert np.allclose(made.rotation, r, atol=1e-13)
    assert np.array_equal(made.position, position)


@given(seeds)
def test_symbols_evaluate_to_the_same_numbers(rng):
    """A composed, inverted CasADi pose is NumPy's."""
    p, q, r, s = (ca.SX.sym(n, k) for n, k in (("p", 3), ("q", 4), ("r", 3), ("s", 4)))
    function = ca.Function("f", [p, q, r, s], [(Pose(p, q) @ Pose(r, s).inverse()).matrix])
    a, b = pose(rng), pose(rng)
    numbers = np.array(function(a.position, a.quaternion, b.position, b.quaternion))
    assert np.allclose(numbers, (a @ b.inverse()).matrix, atol=1e-11)


@given(seeds)
def test_a_stack_of_poses_is_element_by_element(rng):
    """Positions (3, N) and quaternions (4, N) act column by column."""
    poses = [pose(rng) for _ in range(4)]
    stack = Pose(
        np.stack([a.position for a in poses], 1), np.stack([a.quaternion for a in poses], 1)
    )
    points = rng.normal(size=(3, 4))
    for k, a in enumerate(poses):
        assert np.allclose(stack.apply(points)[:, k], a.apply(points[:, k]), atol=1e-12)
        assert np.allclose(stack.matrix[:, :, k], a.matrix, atol=1e-12)
        assert np.allclose((stack @ stack.inverse()).matrix[:, :, k], np.eye(4), atol=1e-11)


# --- poses from what users have -------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sequence", "unit"),
    each_once(["xyz", "zyx", "zxz", "XYZ", "ZYX", "ZYZ", "YXZ"], ["rad", "deg"]),
)
@given(rng=seeds)
def test_euler_angles_are_those_of_scipy(sequence, unit, rng):
    """R is SciPy's: small letters about fixed axes, capitals about moving ones, in either unit."""
    angles, place = rng.uniform(-3, 3, 3), point(rng)
    expected = Rotation.from_euler(sequence, angles).as_matrix()
    made = Pose.from_euler(
        place, np.degrees(angles) if unit == "deg" else angles, sequence, angle_unit=unit
    )
    assert np.allclose(made.matrix[:3, :3], expected, atol=1e-13)
    assert np.array_equal(made.position, place)


@given(rng=seeds)
def test_rotation_vectors_are_those_of_scipy(rng):
    """R = exp([r]), r in radians or degrees, also where r is next to nothing."""
    r = rng.normal(size=3) * 10.0 ** rng.uniform(-12, 0.3)
    expected = Rotation.from_rotvec(r).as_matrix()
    assert np.allclose(Pose.from_rotation_vector((0, 0, 0), r).rotation, expected, atol=1e-13)
    assert np.allclose(
        Pose.from_rotation_vector((0, 0, 0), np.degrees(r), angle_unit="deg").rotation,
        expected,
        atol=1e-13,
    )


@given(rng=seeds)
def test_quaternions_in_either_order_and_slightly_off_one(rng):
    """R is SciPy's of (x, y, z, w), whichever end w is at; the norm is made 1."""
    q = np.array(unit(rng, 4))
    expected = Rotation.from_quat(np.roll(q, -1)).as_matrix()
    off = q * rng.uniform(0.995, 1.005)
    for made in (
        Pose.from_quaternion([1, 2, 3], off),
        Pose.from_quaternion([1, 2, 3], np.roll(off, -1), order="xyzw"),
    ):
        assert np.allclose(made.rotation, expected, atol=1e-13)
        assert np.isclose(np.linalg.norm(made.quaternion), 1.0, rtol=1e-15)


@given(rng=seeds)
def test_a_rotation_matrix_with_a_position_is_the_transform(rng):
    """from_matrix(R, p) = from_matrix([[R, p], [0, 1]]), from arrays and from nested lists; printed
    digits do no harm.
    """
    a = pose(rng)
    for made in (Pose.from_matrix(a.rotation, a.position), Pose.from_matrix(a.matrix.tolist())):
        assert same_pose(made, a, 100.0, 1e-12)
    assert same_pose(Pose.from_matrix(np.round(a.rotation, 4), a.position), a, 1.0, 1e-3)


def turned(angle: float) -> np.ndarray:
    return np.array(axis_turn(np.array([0.0, 0.0, 1.0]), angle))


def transposed() -> np.ndarray:
    transform = np.eye(4)
    transform[:3, 3] = (1.0, 2.0, 3.0)
    return transform.T


REFUSED = {
    "reflection": (lambda: Pose.from_matrix(turned(0.4)[[1, 0, 2]], (0, 0, 0)), "reflection"),
    "scaled": (lambda: Pose.from_matrix(1.01 * turned(0.4), (0, 0, 0)), "it is no rotation"),
    "sheared": (
        lambda: Pose.from_matrix(turned(0.4) + 0.01 * np.eye(3)[[1, 2, 0]], (0, 0, 0)),
        "it is no rotation",
    ),
    "transposed transform": (lambda: Pose.from_matrix(transposed()), "last row"),
    "no position": (lambda: Pose.from_matrix(turned(0.4)), "shape"),
    "two positions": (lambda: Pose.from_matrix(np.eye(4), (0, 0, 0)), "shape"),
    "NaN": (lambda: Pose.from_matrix(np.full((4, 4), np.nan)), "not finite"),
    "zero quaternion": (lambda: Pose.from_quaternion((0, 0, 0), (0, 0, 0, 0)), "norm 0;"),
    "long quaternion": (lambda: Pose.from_quaternion((0, 0, 0), (1, 1, 0, 0)), "norm 1.41421"),
    "three numbers": (lambda: Pose.from_quaternion((0, 0, 0), (1, 0, 0)), "4 numbers"),
    "order": (
        lambda: Pose.from_quaternion((0, 0, 0), (1, 0, 0, 0), order="w last"),
        "allowed: wxyz, xyzw",
    ),
    "sequence": (
        lambda: Pose.from_euler((0, 0, 0), (0, 0, 0), "xxy"),
        "Euler sequence 'xxy' is unknown",
    ),
    "unit": (
        lambda: Pose.from_euler((0, 0, 0), (0, 0, 0), "xyz", angle_unit="grad"),
        "allowed: deg, rad",
    ),
    "words": (lambda: Pose.from_euler((0, 0, 0), ("a", "b", "c"), "xyz"), "not made of numbers"),
    "infinite": (lambda: Pose.from_rotation_vector((0, 0, 0), (np.inf, 0, 0)), "not finite"),
    "position": (lambda: Pose.from_rotation_vector((0, 0), (0, 0, 0)), "position"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_rotation_is_refused_in_a_sentence(case):
    """InputError names what is wrong and what is allowed."""
    make, told = REFUSED[case]
    with pytest.raises(InputError, match=re.escape(told)):
        make()


def test_symbols_pass_as_before():
    """CasADi angles, rotation vectors and matrices make CasADi poses with the numbers of
    NumPy's.
    """
    x = ca.SX.sym("x", 3)
    euler, vector = (
        Pose.from_euler(ca.SX.zeros(3), x, "ZYX"),
        Pose.from_rotation_vector(ca.SX.zeros(3), x),
    )
    back = Pose.from_matrix(vector.matrix)
    function = ca.Function("f", [x], [euler.matrix, vector.matrix, back.matrix])
    numbers = np.array([0.3, -0.2, 0.5])
    found = [np.asarray(m) for m in function(numbers)]
    assert np.allclose(found[0], Pose.from_euler((0, 0, 0), numbers, "ZYX").matrix, atol=1e-14)
    assert np.allclose(found[1], Pose.from_rotation_vector((0, 0, 0), numbers).matrix, atol=1e-14)
    assert np.allclose(found[2], found[1], atol=1e-14)
