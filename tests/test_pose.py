"""Poses: the group SE(3) and its 4 x 4 matrices."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given

from helpers.laws import axis_turn, frame, is_group, same_pose
from helpers.samples import point, seeds, unit
from symkin import Pose


def pose(rng):
    return Pose(np.array(point(rng)), np.array(unit(rng, 4)))


@given(seeds)
def test_poses_are_a_group(rng):
    """Associativity, identity, inverse."""
    is_group(Pose.__matmul__, Pose.inverse, Pose.identity(), [pose(rng) for _ in range(3)], lambda a, b: same_pose(a, b, 100.0))


@given(seeds)
def test_matrix_is_a_homomorphism(rng):
    """M(a b) = M(a) M(b), M(a^-1) = M(a)^-1, M(1) = I, and M is the frame of position and quaternion."""
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
    """Position and R = product of the elementary turns, moving axes in the order written, fixed ones backwards."""
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
    stack = Pose(np.stack([a.position for a in poses], 1), np.stack([a.quaternion for a in poses], 1))
    points = rng.normal(size=(3, 4))
    for k, a in enumerate(poses):
        assert np.allclose(stack.apply(points)[:, k], a.apply(points[:, k]), atol=1e-12)
        assert np.allclose(stack.matrix[:, :, k], a.matrix, atol=1e-12)
        assert np.allclose((stack @ stack.inverse()).matrix[:, :, k], np.eye(4), atol=1e-11)
