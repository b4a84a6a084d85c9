"""Generated control loops of arms: damped steps through singularities, joint rates of twists and
back, feed.
"""

from __future__ import annotations

import ctypes
import subprocess
from functools import lru_cache

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import joint_types
from helpers.gate import in_gate
from helpers.inside import Options, SerialArm, build_program, multiply

OK, NONFINITE, OUT_OF_RANGE = 0, 3, 4
ARMS = {
    "ur5e": lambda: symkin.load("ur5e"),
    "scara": lambda: symkin.load("scara"),
    "yao2020": lambda: symkin.load("yao2020"),
    "five": joint_types.five_joints,
    "seven": joint_types.seven_joints,
    "eight": joint_types.eight_joints,
}
TYPES = {"double": ctypes.c_double, "float": ctypes.c_float}
WRIST_PASSES = (
    np.array([0.3, -1.2, 1.4, -1.0, 0.5, 0.2]),
    np.array([0.5, -1.4, 1.2, -0.8, -0.5, 0.6]),
)
"""Joint values of a six-joint arm with three parallel axes on both sides of a straight wrist (its
fifth joint at zero).
"""


class Code:
    """The compiled C of an arm."""

    def __init__(self, arm: symkin.Mechanism, real: str, folder) -> None:
        tools.write_code(arm, folder, Options(real))
        compiler = tools.compiler("gcc")
        subprocess.run(
            [compiler, "-O1", "-shared", "-fPIC", f"{arm.name}.c", "-o", "code.so", "-lm"],
            cwd=folder,
            check=True,
        )
        self.name, self.type, self.count = arm.name, TYPES[real], len(arm.actuated)
        self.library = ctypes.CDLL(str(folder / "code.so"))
        kind = build_program(arm, Options(real)).kind
        assert isinstance(kind, SerialArm)
        self.arm, self.size = kind, arm.characteristic_length
        number = self.type

        class Info(ctypes.Structure):
            _fields_ = [
                ("iterations", ctypes.c_uint8),
                ("residual", number),
                ("step", number),
                ("min_pivot", number),
                ("joint", ctypes.c_uint8),
            ]

        self.info = Info()

    def numbers(self, values):
        return (self.type * len(values))(*(float(v) for v in values))

    def call(self, function: str, *arguments) -> int:
        return int(getattr(self.library, f"{self.name}_{function}")(*arguments))

    def tracked(self, pose: np.ndarray, joints) -> int:
        """One step; `joints` moves in place."""
        return self.call("track", self.numbers(pose), joints, ctypes.byref(self.info))

    def rates(self, joints, twist) -> tuple[int, np.ndarray]:
        out = self.numbers(np.zeros(self.count))
        status = self.call(
            "rates", self.numbers(joints), self.numbers(twist), out, ctypes.byref(self.info)
        )
        return status, np.array(out[:])


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    return lru_cache(
        lambda name, real: Code(ARMS[name](), real, tmp_path_factory.mktemp(f"{name}_{real}"))
    )


def _error(code: Code, joints, pose: np.ndarray) -> float:
    """How far a tool pose is: position, and the turn between times the size."""
    found = code.arm.forward_at(np.array(joints[:]))
    turn = 2 * np.arccos(
        min(
            1.0,
            abs(float(found[3:] @ pose[3:]) / np.linalg.norm(pose[3:]) / np.linalg.norm(found[3:])),
        )
    )
    return float(np.hypot(np.linalg.norm(found[:3] - pose[:3]), code.size * turn))


def _turned(pose: np.ndarray, angle: float) -> np.ndarray:
    return np.concatenate(
        [
            pose[:3],
            np.asarray(multiply(np.array([np.cos(angle / 2), np.sin(angle / 2), 0, 0]), pose[3:])),
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(TYPES, ["double"]))
@pytest.mark.parametrize("beside", in_gate([0.0, 1e-3, 1e-2, 0.05], [0.0, 1e-2]))
def test_a_loop_passes_a_straight_wrist(real, beside, code):
    """A thousand poses through, or a little beside, the wrist's singularity: every step is OK and
    short, what it says of its error is so, and beyond the singularity the error has gone.
    """
    arm = code("ur5e", real)
    begin, end = WRIST_PASSES
    joints, least = arm.numbers(begin), np.inf
    for t in np.linspace(0.0, 1.0, 1000):
        pose = _turned(arm.arm.forward_at(begin + t * (end - begin)), beside * np.sin(np.pi * t))
        before = np.array(joints[:])
        assert arm.tracked(pose, joints) == OK
        assert np.max(np.abs(np.array(joints[:]) - before)) < 0.1
        measured = _error(arm, joints, pose)
        assert abs(arm.info.residual - measured) < 0.02 * measured + (
            0.02 if real == "float" else 1e-4
        )
        assert measured < 0.03 * arm.size
        least = min(least, float(arm.info.min_pivot))
    assert least < 0.02
    assert _error(arm, joints, pose) < (0.01 if real == "float" else 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(TYPES, ["float"]))
@pytest.mark.parametrize("name", in_gate(ARMS, ["scara"]))
def test_a_loop_follows_its_poses(name, real, code):
    """Poses of a smooth path of joint values: each step is OK, and the tool stays with them."""
    arm = code(name, real)
    q, _ = arm.arm.samples[0]
    p, _ = arm.arm.samples[1]
    joints = arm.numbers(q)
    for t in np.linspace(0.0, 1.0, 800):
        pose = arm.arm.forward_at(q + t * (p - q))
        assert arm.tracked(pose, joints) == OK
        assert _error(arm, joints, pose) < 1e-3 * arm.size
    for _ in range(3):
        assert arm.tracked(pose, joints) == OK
    assert _error(arm, joints, pose) < (4e-6 if real == "float" else 1e-9) * arm.size


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(["ur5e", "seven", "scara"], ["ur5e", "scara"]))
def test_far_and_impossible_poses_bring_no_jump(name, code):
    """A pose out of reach: short steps, the error never grows, and is told."""
    arm = code(name, "double")
    q, pose = arm.arm.samples[2]
    joints, last = arm.numbers(q), np.inf
    far = np.concatenate([pose[:3] + 3 * arm.size * np.array([1.0, 0.5, 0.2]), pose[3:]])
    for _ in range(60):
        before = np.array(joints[:])
        assert arm.tracked(far, joints) == OK
        steps = np.abs(np.array(joints[:]) - before)
        assert (
            np.max(np.where([c.is_angular for c in arm.arm.actuated], steps, steps / arm.size))
            < 0.2001
        )
        assert arm.info.residual <= last * (1 + 1e-9)
        last = float(arm.info.residual)
    assert last > arm.size


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(TYPES, ["float"]))
@pytest.mark.parametrize("name", in_gate(ARMS, ["ur5e", "scara"]))
def test_rates_make_their_twist_and_back(name, real, code):
    """The twist of rates is the tool's, by finite differences; rates of that twist make it again,
    and are no longer.
    """
    arm = code(name, real)
    rng, near = np.random.default_rng(2), 1e-3 if real == "float" else 1e-6
    for q, pose in arm.arm.samples[:12]:
        v = arm.arm.jacobian_at(q) @ rng.uniform(-1, 1, arm.count)
        status, rates = arm.rates(q, v)
        assert status == OK
        assert arm.info.residual < near * (arm.size + np.abs(v).max()) or arm.info.min_pivot < 0.02
        twist = arm.numbers(np.zeros(6))
        assert arm.call("twist", arm.numbers(q), arm.numbers(rates), twist) == OK
        missing = np.array(twist[:]) - v
        missing[3:] *= arm.size
        assert abs(np.linalg.norm(missing) - arm.info.residual) < near * (
            arm.size + np.abs(v).max()
        )
        moved = arm.arm.forward_at(q + 1e-6 * rates)
        np.testing.assert_allclose(
            (moved[:3] - pose[:3]) / 1e-6, twist[:3], atol=20 * near * arm.size
        )


@pytest.mark.slow
@pytest.mark.parametrize("real", TYPES)
def test_rates_at_a_singularity_are_bounded_and_told(real, code):
    """At a straight wrist, twists of unit length over the size: no rate above the damping's, and
    the residual is what is missing.
    """
    arm = code("ur5e", real)
    q, rng = 0.5 * (WRIST_PASSES[0] + WRIST_PASSES[1]), np.random.default_rng(4)
    told = []
    for _ in range(50):
        e = rng.normal(size=6)
        e /= np.linalg.norm(e)
        status, rates = arm.rates(q, e * np.array([arm.size] * 3 + [1.0] * 3))
        assert status == OK
        assert np.all(np.abs(rates) < 60.0)
        told.append(float(arm.info.residual) / arm.size)
    assert max(told) > 0.3
    assert max(told) <= 1.0 + 1e-5


@pytest.mark.slow
def test_feed_keeps_the_limits(code):
    """The largest share of a twist whose rates keep to their limits: one of them is at its limit,
    or the share is 1.
    """
    arm = code("ur5e", "double")
    rng, limits = np.random.default_rng(5), np.full(6, 0.5)
    shares = []
    for q, _ in arm.arm.samples[:12]:
        twist = rng.uniform(-1, 1, 6) * np.array([arm.size] * 3 + [1.0] * 3)
        feed = arm.type(0.0)
        assert (
            arm.call(
                "feed", arm.numbers(q), arm.numbers(twist), arm.numbers(limits), ctypes.byref(feed)
            )
            == OK
        )
        _, rates = arm.rates(q, feed.value * twist)
        assert np.max(np.abs(rates)) <= 0.5 + 1e-9
        assert feed.value == 1.0 or abs(np.max(np.abs(rates)) - 0.5) < 1e-9
        shares.append(feed.value)
    assert min(shares) < 1.0


@pytest.mark.slow
def test_refused_input_leaves_the_joints(code):
    """NaN, joint values out of range, a step beyond a limit: the status says so, and the joint
    values stay.
    """
    arm = code("ur5e", "double")
    q, pose = arm.arm.samples[0]
    joints = arm.numbers(q)
    wrong = pose.copy()
    wrong[1] = np.nan
    assert arm.tracked(wrong, joints) == NONFINITE
    assert list(joints) == list(q)
    beyond = arm.numbers([*q[:5], 1e5])
    assert arm.tracked(pose, beyond) == OUT_OF_RANGE
    assert arm.info.joint == 5
    assert arm.rates(q, np.full(6, np.inf))[0] == NONFINITE
    assert arm.rates(q, np.full(6, 1e300))[0] == OUT_OF_RANGE


@pytest.mark.slow
def test_a_step_out_of_a_limit_is_refused(code):
    """A joint at its limit that would have to leave it: OUT_OF_RANGE, its number, joints
    untouched.
    """
    arm = code("scara", "double")
    _, end = symkin.load("scara").actuated[0].limits
    q = np.array([end - 1e-4, 0.9, 0.2, -30.0])
    pose = arm.arm.forward_at(q + np.array([0.01, 0, 0, 0]))
    values = arm.numbers(q)
    assert arm.tracked(pose, values) == OUT_OF_RANGE
    assert arm.info.joint == 0
    assert list(values) == list(q)
