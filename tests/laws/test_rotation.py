"""Rotations: every chart against the group SO(3)."""

import itertools
import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.gate import in_gate
from helpers.inside import rotation as rot
from helpers.laws import axis_turn, ball_turn, is_group, is_rotation
from helpers.samples import seeds, unit

SEQUENCES = [
    "".join(s) for s in itertools.product("xyz", repeat=3) if s[0] != s[1] and s[1] != s[2]
]
SEQUENCES += [s.upper() for s in SEQUENCES]
SOME = SEQUENCES[::3]
"""Of two and of three axes, even and odd, about fixed and about moving axes."""
CHARTS = {
    "matrix": (rot.matrix_from_quaternion, rot.quaternion_from_matrix),
    "rotation vector": (rot.rotation_vector_from_quaternion, rot.quaternion_from_rotation_vector),
}


def quaternion(rng):
    return np.array(unit(rng, 4))


def same(a, b, tolerance=1e-12):
    return np.max(np.abs(ball_turn(a) - ball_turn(b))) < tolerance


@given(seeds)
def test_unit_quaternions_are_a_group(rng):
    """(ab)c = a(bc), 1a = a = a1, a a* = 1 = a* a."""
    one = np.array([1.0, 0, 0, 0])
    is_group(
        rot.multiply,
        rot.conjugate,
        one,
        [quaternion(rng) for _ in range(3)],
        lambda a, b: np.allclose(a, b, atol=1e-14),
    )


@given(seeds)
def test_matrix_is_a_homomorphism_to_rotations(rng):
    """R(ab) = R(a) R(b), R(a*) = R(a)^T, R in SO(3), and it is the map v -> a v a*."""
    a, b, v = quaternion(rng), quaternion(rng), rng.normal(size=3)
    r = rot.matrix_from_quaternion(a)
    assert is_rotation(r)
    assert np.allclose(r, ball_turn(a), atol=1e-14)
    assert np.allclose(
        rot.matrix_from_quaternion(rot.multiply(a, b)),
        r @ rot.matrix_from_quaternion(b),
        atol=1e-14,
    )
    assert np.allclose(rot.matrix_from_quaternion(rot.conjugate(a)), r.T, atol=1e-14)
    assert np.allclose(rot.rotate(a, v), r @ v, atol=1e-13)


@given(seeds, st.floats(-20, 20))
def test_axis_angle_is_rodrigues(rng, angle):
    """R(axis, t) = I + sin t K + (1 - cos t) K^2, and turns about one axis add."""
    axis = np.array(unit(rng))
    q = rot.quaternion_from_axis_angle(axis, angle)
    assert np.allclose(rot.matrix_from_quaternion(q), axis_turn(axis, angle), atol=1e-12)
    assert same(
        rot.multiply(q, rot.quaternion_from_axis_angle(axis, 0.7)),
        rot.quaternion_from_axis_angle(axis, angle + 0.7),
    )


@pytest.mark.parametrize("chart", CHARTS)
@given(rng=seeds)
def test_charts_go_there_and_back(chart, rng):
    """from(to(q)) is the rotation of q, for q and for -q."""
    to, back = CHARTS[chart]
    q = quaternion(rng)
    assert same(back(to(q)), q, 1e-10)
    assert same(back(to(-q)), q, 1e-10)


@given(seeds)
def test_rotation_vector_is_axis_times_angle(rng):
    """exp(t axis) turns by t about the axis; log gives the short way, |r| <= pi."""
    axis, angle = np.array(unit(rng)), rng.uniform(0, math.pi)
    assert same(
        rot.quaternion_from_rotation_vector(angle * axis),
        rot.quaternion_from_axis_angle(axis, angle),
    )
    assert np.allclose(
        rot.rotation_vector_from_quaternion(rot.quaternion_from_axis_angle(axis, angle)),
        angle * axis,
        atol=1e-12,
    )
    assert np.linalg.norm(rot.rotation_vector_from_quaternion(quaternion(rng))) <= math.pi + 1e-12


@given(
    seeds,
    st.sampled_from(
        [
            0.0,
            1e-300,
            1e-12,
            1e-9,
            1e-8,
            1e-6,
            1.99e-6,
            2.01e-6,
            1e-5,
            0.99e-4,
            1e-4,
            3e-4,
            1e-3,
            1e-2,
        ]
    ),
)
def test_rotation_vector_is_regular_at_zero(rng, angle):
    """Where the series and the closed form meet, both agree with the sine, relatively."""
    axis = np.array(unit(rng))
    q = rot.quaternion_from_rotation_vector(angle * axis)
    assert np.allclose(q[1:], math.sin(angle / 2) * axis, rtol=1e-14, atol=0)
    assert np.allclose(rot.rotation_vector_from_quaternion(q), angle * axis, rtol=1e-14, atol=0)
    assert abs(np.linalg.norm(q) - 1) < 1e-15


@given(seeds, st.sampled_from([0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3]))
def test_charts_are_regular_near_half_turns(rng, less):
    """At pi - less every division of the matrix's quaternion is well conditioned, and log does not
    lose digits.
    """
    for axis in (np.array(unit(rng)), *np.eye(3)):
        q = rot.quaternion_from_axis_angle(axis, math.pi - less)
        r = axis_turn(axis, math.pi - less)
        assert same(rot.quaternion_from_matrix(r), q, 1e-14)
        vector = rot.rotation_vector_from_quaternion(q)
        assert abs(np.linalg.norm(vector) - (math.pi - less)) < 1e-14
        assert np.allclose(
            axis_turn(vector / np.linalg.norm(vector), np.linalg.norm(vector)), r, atol=1e-13
        )


def test_derivative_of_the_rotation_vector_at_zero_is_half_the_identity():
    """d(x, y, z)/dr = I/2 and dw/dr = 0 at r = 0, also symbolically: no NaN from the branch that is
    not taken.
    """
    r, q = ca.SX.sym("r", 3), ca.SX.sym("q", 4)
    exp = ca.Function("exp", [r], [ca.jacobian(rot.quaternion_from_rotation_vector(r), r)])
    log = ca.Function("log", [q], [ca.jacobian(rot.rotation_vector_from_quaternion(q), q)])
    assert np.allclose(
        np.array(exp([0, 0, 0])), np.vstack([np.zeros(3), np.eye(3) / 2]), atol=1e-15
    )
    assert np.allclose(np.array(log([1, 0, 0, 0]))[:, 1:], 2 * np.eye(3), atol=1e-15)


# --- Euler angles ---------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("sequence", in_gate(SEQUENCES, SOME))
@given(rng=seeds)
def test_euler_angles_are_three_elementary_turns(sequence, rng):
    """'xyz': R = Rz(c) Ry(b) Rx(a); 'XYZ': R = Rx(a) Ry(b) Rz(c); angles come back with the middle
    one in its range.
    """
    angles = rng.uniform(-3, 3, 3)
    turns = [
        axis_turn(np.eye(3)["xyz".index(letter.lower())], a)
        for letter, a in zip(sequence, angles, strict=True)
    ]
    product = (
        turns[0] @ turns[1] @ turns[2] if sequence.isupper() else turns[2] @ turns[1] @ turns[0]
    )
    q = rot.quaternion_from_euler(angles, sequence)
    assert np.allclose(ball_turn(q), product, atol=1e-13)
    back = rot.euler_from_quaternion(q, sequence)
    assert same(rot.quaternion_from_euler(back, sequence), q, 1e-9)
    low, high = (0, math.pi) if sequence[0] == sequence[2] else (-math.pi / 2, math.pi / 2)
    assert low - 1e-9 <= back[1] <= high + 1e-9
    assert np.all(np.abs(back) <= math.pi + 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("sequence", SEQUENCES)
@given(rng=seeds)
def test_euler_angles_in_range_come_back_themselves(sequence, rng):
    """Away from the chart's singularity the angles are unique."""
    middle = rng.uniform(0.1, 3.0) if sequence[0] == sequence[2] else rng.uniform(-1.5, 1.5)
    angles = np.array([rng.uniform(-3, 3), middle, rng.uniform(-3, 3)])
    assert np.allclose(
        rot.euler_from_quaternion(rot.quaternion_from_euler(angles, sequence), sequence),
        angles,
        atol=1e-12,
    )


@pytest.mark.slow
@pytest.mark.parametrize("sequence", in_gate(SEQUENCES, SOME))
@given(rng=seeds)
def test_euler_at_gimbal_lock_still_gives_the_rotation(sequence, rng):
    """Where two axes fall together the angles are not unique, but their rotation is right and
    finite.
    """
    for middle in (0.0, math.pi) if sequence[0] == sequence[2] else (-math.pi / 2, math.pi / 2):
        q = rot.quaternion_from_euler(
            np.array([rng.uniform(-3, 3), middle, rng.uniform(-3, 3)]), sequence
        )
        assert same(
            rot.quaternion_from_euler(rot.euler_from_quaternion(q, sequence), sequence), q, 1e-7
        )


@pytest.mark.slow
@pytest.mark.parametrize("sequence", [s for s in SEQUENCES if s.islower()])
@given(rng=seeds)
def test_fixed_axes_are_moving_axes_backwards(sequence, rng):
    """'xyz' of (a, b, c) about fixed axes is 'ZYX' of (c, b, a) about moving ones."""
    angles = rng.uniform(-3, 3, 3)
    assert same(
        rot.quaternion_from_euler(angles, sequence),
        rot.quaternion_from_euler(angles[::-1], sequence.upper()[::-1]),
    )


@pytest.mark.parametrize("sequence", ["", "xy", "xyzx", "xxy", "xyy", "Xyz", "abc", "xy1", "XYy"])
def test_bad_euler_sequence_is_named(sequence):
    """The message quotes the sequence and says what is allowed."""
    for call in (rot.quaternion_from_euler, rot.euler_from_quaternion):
        with pytest.raises(ValueError, match="three letters") as error:
            call(np.array([1.0, 0, 0, 0]), sequence)
        assert repr(sequence) in str(error.value)


# --- one formula for stacks and symbols -----------------------------------------------------------

FORMULAS = {
    "multiply": (rot.multiply, (4, 4)),
    "conjugate": (rot.conjugate, (4,)),
    "normalized": (rot.normalized, (4,)),
    "rotate": (rot.rotate, (4, 3)),
    "rotation vector": (rot.rotation_vector_from_quaternion, (4,)),
    "from rotation vector": (rot.quaternion_from_rotation_vector, (3,)),
    "matrix": (rot.matrix_from_quaternion, (4,)),
    "to and from matrix": (
        lambda q: rot.quaternion_from_matrix(rot.matrix_from_quaternion(q)),
        (4,),
    ),
    "euler zyx": (lambda q: rot.euler_from_quaternion(q, "zyx"), (4,)),
    "euler ZXZ": (lambda q: rot.euler_from_quaternion(q, "ZXZ"), (4,)),
    "from euler": (lambda a: rot.quaternion_from_euler(a, "YZX"), (3,)),
}


def arguments(rng, widths, count):
    """Stacks (width, count), quaternions of unit length, a few rotation vectors near zero."""
    stacks = [rng.normal(size=(width, count)) for width in widths]
    stacks = [s / np.linalg.norm(s, axis=0) if len(s) == 4 else s for s in stacks]
    for s in stacks:
        if len(s) == 3:
            s[:, 0] *= 1e-6
    return stacks


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMULAS)
@given(rng=seeds)
def test_a_stack_is_element_by_element(name, rng):
    """f of arrays (k, N) holds f of each column."""
    f, widths = FORMULAS[name]
    stacks = arguments(rng, widths, 5)
    whole = f(*stacks)
    for k in range(5):
        assert np.allclose(whole[..., k], f(*(s[:, k] for s in stacks)), rtol=1e-14, atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMULAS)
@given(rng=seeds)
def test_symbols_evaluate_to_the_same_numbers(name, rng):
    """The CasADi expression of a formula gives NumPy's numbers."""
    f, widths = FORMULAS[name]
    symbols = [ca.SX.sym("v", width) for width in widths]
    function = ca.Function("f", symbols, [f(*symbols)])
    values = [s[:, 0] for s in arguments(rng, widths, 1)]
    assert np.allclose(np.squeeze(np.array(function(*values))), f(*values), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("shift", [0.0, 1.0])
def test_one_call_writes_what_the_operations_do(shift):
    """Products of expressions that are written by one call are, operation by operation, those of
    the formula; with structural zeros too.
    """
    q, v = ca.SX.sym("q", 4), ca.vertcat(ca.SX(1, 1), ca.SX.sym("v", 2)) + shift * ca.DM.ones(3, 1)
    for formula, arguments in [(rot.multiply, (q, q[::-1])), (rot.rotate, (q, v))]:
        assert str(formula(*arguments)) == str(formula.__wrapped__(*arguments))
