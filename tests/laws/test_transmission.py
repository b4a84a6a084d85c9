"""Laws of transmissions: both ways are inverse to each other, power is the same on both sides,
derivatives are those of differences, torques and rates fill their polytopes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import mpmath
import numpy as np
import pytest

import symkin
from helpers.closed_leg import Dynamics, g1_maps, of_mujoco, of_pinocchio, worst
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.inside import between_planes, zonotope
from helpers.samples import exechon
from helpers.transmissions import G1, G1_RANGES, MODELS, linear, regular_motors, robot, transmission

MACHINES = (
    "geared",
    "redundant",
    "four_bar",
    "ankle",
    "g1",
    "five_bar",
    "six_bar",
    "digit_knee",
    "digit_ankle",
)
QUICK = ["geared", "redundant", "four_bar", "g1", "five_bar"]


@pytest.mark.parametrize("name", in_gate(MACHINES, QUICK))
def test_power_is_the_same_on_both_sides(name: str) -> None:
    """tau_m . m' = tau_j . j' for any joint torques and rates, each mapped by its own matrix."""
    found = transmission(name)
    states = found.states(regular_motors(found, 40))
    rng = np.random.default_rng(1)
    rates = rng.normal(size=(len(states.w), len(found.joints)))
    torques = rng.normal(size=(len(states.w), len(found.motors)))
    motor_rates = np.einsum("nai,ni->na", states.inverse_jacobian, rates)
    back = np.einsum("nia,na->ni", states.jacobian, motor_rates)
    joint_torques = np.einsum("nai,na->ni", states.inverse_jacobian, torques)
    power = np.sum(torques * motor_rates, axis=1)
    sizes = np.sum(np.abs(torques * motor_rates), axis=1)
    assert np.abs(power - np.sum(joint_torques * back, axis=1)).max() < 1e-12 * sizes.max()


def test_linear_transmission_of_two_motors() -> None:
    """The second motor carries the first: tau_j1 = tau_a1 + tau_a2, tau_j2 = tau_a2."""
    found = transmission("geared")
    assert np.allclose(found.joint_torques([2.0, 5.0]), [7.0, 5.0], atol=1e-14)
    assert np.allclose(found.torques([7.0, 5.0]), [2.0, 5.0], atol=1e-14)
    assert np.abs(found.second([0.3, 0.2])).max() < 1e-14


@pytest.mark.parametrize("name", in_gate(MACHINES, QUICK))
def test_there_and_back(name: str) -> None:
    """motors -> joints -> motors is the identity over the range, and J G = 1."""
    found = transmission(name)
    states = found.survey.states
    rows = np.random.default_rng(2).choice(len(states.w), min(60, len(states.w)), replace=False)
    units = [
        [1.0 if c.is_angular else 1.0 / found.linkage.size for c in found.linkage.coordinates_of(n)]
        for n in (found.motors, found.joints)
    ]
    turn = found.linkage.mechanism.angle_out(1.0)
    motors = found.states(motors=_out(found, states.motors[rows], found.motors, turn))
    joints = found.states(joints=_out(found, states.joints[rows], found.joints, turn))
    assert np.abs((motors.joints - states.joints[rows]) * units[1]).max() < 1e-12
    assert np.abs((joints.motors - states.motors[rows]) * units[0]).max() < 1e-12
    one = states.jacobian @ states.inverse_jacobian
    assert np.abs(one - np.eye(len(found.joints))).max() < 1e-9


def test_a_solution_is_polished_in_weak_directions() -> None:
    """Motors come back to rounding where rows that count as closed are far from the solution: a
    goal that lost four digits.
    """
    found = transmission("digit_knee")
    goal = np.array([0.44869279, 0.37683937])
    assert np.abs(found.motors_of(found.joints_of(goal)) - goal).max() < 1e-13


def test_springs_are_named_among_the_motors() -> None:
    """A gripper with springs is a map of its motor and springs, and the sentence says so."""
    gripper = symkin.load(MODELS / "mjcf" / "robotiq_2f85.xml")
    with pytest.raises(symkin.InputError, match="springs are named among the motors"):
        symkin.transmission(gripper)
    motors = ["left_driver_joint", "left_spring_link_joint", "right_spring_link_joint"]
    joints = ["left_follower_joint", "right_follower_joint", "right_driver_joint"]
    found = symkin.transmission(gripper, motors, joints)
    goals = 0.2 * np.random.default_rng(0).uniform(0.0, 1.0, (20, 3))
    assert np.abs(found.motors_of(found.joints_of(goals)) - goals).max() < 1e-12


def test_a_start_leaves_a_reference_where_joints_are_locked() -> None:
    """At Kangaroo's zero the slide and the knee stand still while the thigh swings, so that neither
    may be given there; from values of a bent leg on the slide turns the knee.
    """
    knee = transmission("kangaroo")
    bent = knee.joints_of(knee.motors_of([1.0, 0.2]))
    assert np.abs(bent - [1.0, 0.2]).max() < 1e-12
    assert 0.1 < abs(knee.inverse_jacobian(joints=[1.0, 0.2])[0, 0]) < 1.0


def _out(found: symkin.Transmission, values: np.ndarray, names: tuple, turn: float) -> np.ndarray:  # type: ignore[type-arg]
    kinds = [turn if c.is_angular else 1.0 for c in found.linkage.coordinates_of(names)]
    return values * np.array(kinds)


# --- the ankle of a humanoid, by its two rods alone -----------------------------------------------


class Rods:
    """The G1's ankle written from the numbers of its file: two distances."""

    def __init__(self) -> None:
        mpmath.mp.dps = 50
        self.cranks = (
            ("0.15087", "0.013", "0.016529", "-0.0039746"),
            ("0.21587", "0.0175", "-0.016359", "-0.0046245"),
        )
        self.feet = ("0.015", "-0.015")
        zero = [mpmath.mpf(0)] * 2
        self.lengths = [self.distance(k, zero, zero) for k in range(2)]

    def distance(self, k: int, motors: list, joints: list) -> mpmath.mpf:  # type: ignore[type-arg]
        """The squared length of a rod."""
        height, x, y, z = map(mpmath.mpf, self.cranks[k])
        c, s = mpmath.cos(motors[k]), mpmath.sin(motors[k])
        crank = (mpmath.mpf("0.022") + x, c * y - s * z, height + s * y + c * z)
        px, py, pz = mpmath.mpf("0.022"), mpmath.mpf(self.feet[k]), mpmath.mpf("0.0079999")
        c, s = mpmath.cos(joints[1]), mpmath.sin(joints[1])
        y, z = c * py - s * pz, s * py + c * pz - mpmath.mpf("0.017558")
        c, s = mpmath.cos(joints[0]), mpmath.sin(joints[0])
        foot = (c * px + s * z, y, -s * px + c * z)
        return sum(((a - b) ** 2 for a, b in zip(crank, foot, strict=True)), mpmath.mpf(0))

    def joints(self, motors: list, near: np.ndarray) -> list:  # type: ignore[type-arg]
        rows = [
            lambda *j, k=k: self.distance(k, motors, list(j)) - self.lengths[k] for k in range(2)
        ]
        return list(mpmath.findroot(rows, [mpmath.mpf(float(v)) for v in near], tol=1e-80))


def test_derivatives_are_those_of_fifty_digits() -> None:
    """Joints, Jacobian and second derivatives of the G1's ankle against differences of 50 digits of
    its two rods' lengths.
    """
    found, rods, step = transmission("g1"), Rods(), mpmath.mpf(10) ** -14
    for at in ([0.31, -0.17], [-0.4, 0.52]):
        near = found.joints_of(at)

        def joints(a: int = 0, b: int = 0, at: list = at, near: np.ndarray = near) -> list:  # type: ignore[type-arg]
            moved = [mpmath.mpf(at[0]) + a * step, mpmath.mpf(at[1]) + b * step]
            return rods.joints(moved, near)

        grid = {(a, b): joints(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)}
        first, second = found.jacobian(at), found.second(at)
        for i in range(2):
            f = {key: values[i] for key, values in grid.items()}
            slopes = [(f[1, 0] - f[-1, 0]) / (2 * step), (f[0, 1] - f[0, -1]) / (2 * step)]
            bends = [
                [
                    (f[1, 0] - 2 * f[0, 0] + f[-1, 0]) / step**2,
                    (f[1, 1] - f[1, -1] - f[-1, 1] + f[-1, -1]) / (4 * step**2),
                ],
                [None, (f[0, 1] - 2 * f[0, 0] + f[0, -1]) / step**2],
            ]
            assert abs(near[i] - float(f[0, 0])) < 1e-13
            assert np.abs(first[i] - [float(v) for v in slopes]).max() < 1e-10
            for a, b in ((0, 0), (0, 1), (1, 1)):
                assert abs(second[i, a, b] - float(bends[a][b])) < 1e-10


@pytest.mark.parametrize("engine", [of_mujoco, of_pinocchio])
def test_a_closed_leg_moves_as_others_say(engine: Callable[..., Dynamics]) -> None:
    """Motions, accelerations, the motors' inertia at the foot and the motors' torques of an ankle
    whose rods have masses are those of MuJoCo and of Pinocchio on the null space of its
    constraints.
    """
    for package in ("mujoco", "pinocchio"):
        pytest.importorskip(package)
    assert (worst(engine, g1_maps(), 5, seed=0) < 1e-8).all()


def test_bias_is_the_rate_of_the_inertia() -> None:
    """The energy j' M j' / 2 changes by the power of b j' j' as long as joints do not accelerate:
    j'_i b_ijk j'_j j'_k = d/dt (j' M j') / 2.
    """
    found = transmission("ankle")
    here, rng, step = found.joints_of([4.0, 3.0]), np.random.default_rng(3), 1e-4
    inertias = [0.2, 0.3]
    bias = found.bias(joints=here, of_motors=inertias)
    for _ in range(3):
        rate = rng.normal(size=2)
        ends = [
            found.inertia(joints=here + sign * step * np.degrees(rate), of_motors=inertias)
            for sign in (-1, 1)
        ]
        change = rate @ (ends[1] - ends[0]) @ rate / (2.0 * step)
        power = np.einsum("i,ijk,j,k->", rate, bias, rate, rate)
        assert abs(power - 0.5 * change) < 1e-6 * abs(power)


# --- branches -------------------------------------------------------------------------------------


def test_the_mode_is_that_of_a_proved_track() -> None:
    """Joints are those that a track with proof reaches; what no straight line reaches is NaN."""
    found = transmission("g1")
    goals = np.random.default_rng(4).uniform(-1.3, 1.3, (8, 2))
    joints = found.joints_of(goals, check=False)
    for goal, mine in zip(goals, joints, strict=True):
        path = {name: [0.0, float(v)] for name, v in zip(found.motors, goal, strict=True)}
        way = symkin.track(found.linkage.mechanism, given=path, limits=False, name_modes=False)
        if way.reached:
            there = [way.end.solution.joints[name] for name in found.joints]
            assert np.abs(mine - there).max() < 1e-9
        else:
            assert np.isnan(mine).all()


def test_what_is_not_reached_is_told() -> None:
    """Beyond the reach: a sentence with the values, the share and the direction lost; in a batch
    NaN where it is asked for; standing still is always reached.
    """
    found = transmission("four_bar")
    with pytest.raises(symkin.SolveError, match=r"follower = 200.*crank moves|not reached"):
        found.motors_of([200.0])
    some = found.motors_of([[200.0], found.joints_of([60.0])], check=False)
    assert np.isnan(some[0]).all()
    assert abs(some[1, 0] - 60.0) < 1e-9
    for name in QUICK:
        here = transmission(name).states()
        assert np.abs(here.w - transmission(name).linkage.reference).max() == 0.0


# --- polytopes ------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(1, 1), (3, 1), (2, 2), (3, 2), (5, 2), (3, 3), (5, 3), (5, 4)])
def test_zonotope_is_the_hull_of_all_corners(shape: tuple[int, int]) -> None:
    """In every direction the vertices reach as far as the corners of the box, and each is extreme
    in some direction.
    """
    rng = np.random.default_rng(5)
    generators, middle = rng.normal(size=shape), rng.normal(size=shape[1])
    if shape == (5, 3):
        generators[3:] = generators[0] + generators[1], generators[0]  # several in one plane
    vertices = zonotope(generators, middle)
    corners = middle + np.array(list(product((-1.0, 1.0), repeat=shape[0]))) @ generators
    ways = rng.normal(size=(4000, shape[1]))
    assert np.allclose((vertices @ ways.T).max(axis=0), (corners @ ways.T).max(axis=0), atol=1e-12)
    if shape == (5, 3):
        assert len(set((vertices @ ways.T).argmax(axis=0).tolist())) == len(vertices)
    else:
        # m generators in general position in R^n: T. Zaslavsky, Memoirs AMS 154, 1975
        m, n = shape
        assert len(vertices) == 2 * sum(math.comb(m - 1, i) for i in range(n))


@pytest.mark.parametrize("name", ["g1", "redundant"])
def test_polytopes_hold_what_motors_can_do(name: str) -> None:
    """No torques of motors within limits leave the torque polytope, its vertices are reached; rates
    are in the speed polytope exactly where those of the motors are within limits.
    """
    found, rng = transmission(name), np.random.default_rng(6)
    motors = regular_motors(found, 1, seed=7)[0]
    limits = 1.0 + np.arange(len(found.motors))
    torques, speeds = (
        found.polytope(motors, kind=kind, limits=limits) for kind in ("torque", "speed")
    )
    some = rng.uniform(-limits, limits, (10_000, len(limits)))
    some[:64] = np.sign(some[:64]) * limits
    mapped = found.joint_torques(some, np.broadcast_to(motors, some.shape))
    ways = rng.normal(size=(200, len(found.joints)))
    reach = (torques @ ways.T).max(axis=0)
    assert np.all(mapped @ ways.T <= reach + 1e-9)
    assert np.allclose((mapped[:64] @ ways.T).max(axis=0), reach, rtol=1e-9)
    g = found.inverse_jacobian(motors)
    shares = np.abs(speeds @ g.T) / limits
    assert shares.max() < 1.0 + 1e-9
    assert np.all(np.sum(shares > 1.0 - 1e-9, axis=1) >= len(found.joints))


def test_speed_polytope_of_three_planes() -> None:
    """A square with two opposite corners cut by a third motor has six vertices."""
    normals = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    vertices = between_planes(normals, np.full(3, -1.0) * [1, 1, 1.5], np.array([1, 1, 1.5]))
    assert len(vertices) == 6
    assert {tuple(np.round(v, 12)) for v in vertices} >= {(1.0, 0.5), (0.5, 1.0), (-1.0, 1.0)}


def test_redundant_motors_share_the_least_torques() -> None:
    """Of all motor torques that hold a joint torque the shortest are told, and it is said."""
    found = transmission("redundant")
    wanted = np.array([3.0, -2.0])
    told = found.torques(wanted)
    g = found.inverse_jacobian()
    assert np.allclose(g.T @ told, wanted, atol=1e-12)
    assert np.allclose(told, np.linalg.pinv(g.T) @ wanted, atol=1e-12)
    assert any("3 motors drive 2 joints" in note for note in found.notes)
    with pytest.raises(symkin.SolveError, match="do not agree"):
        found.joints_of([0.1, 0.1, 0.3])


# --- the range ------------------------------------------------------------------------------------


def test_the_range_ends_at_limits_and_torques_on_polygons() -> None:
    """A limit of the file ends a joint's range; the least torque alone is where the joint's axis
    leaves the polygon of torques there.
    """
    found = transmission("g1")
    survey = found.survey
    low, high = survey.ends[0]
    assert abs(low.value + 0.87267) < 1e-9
    assert abs(high.value - 0.5236) < 1e-9
    assert low.by == "the limit of pitch_joint"
    small = survey.smallest(0)
    vertices = found.polytope(joints=list(small.at))
    edges = zip(vertices, np.roll(vertices, -1, axis=0), strict=True)
    crossings = [a[0] - a[1] * (b[0] - a[0]) / (b[1] - a[1]) for a, b in edges if a[1] * b[1] < 0.0]
    assert abs(min(map(abs, crossings)) - small.value) < 1e-9
    assert small.value <= survey.alone[:, 0].min()


def test_a_singular_end_is_a_dead_centre() -> None:
    """A follower without limits ends where crank and coupler are in line, by the law of cosines:
    crank 40, coupler 101, follower 61 and base 110 mm.
    """
    found = transmission("four_bar")
    ends = found.survey.ends[0]
    assert [end.by for end in ends] == ["a singularity"] * 2
    angles = [math.acos((110**2 + 61**2 - d**2) / (2 * 110 * 61)) for d in (101 - 40, 101 + 40)]
    here = math.acos(11 / 61)
    wanted = sorted(here - angle for angle in angles)
    assert np.allclose([end.value for end in ends], wanted, atol=1e-6)


# --- what cannot be -------------------------------------------------------------------------------

WRONG = [
    ({"motors": ["left_motor_joint"]}, "do not decide the joints.* 2 freedoms, and 1 stays free"),
    ({"motors": ["left_motor_joint", "knee"]}, "no coordinate 'knee'"),
    (
        {"motors": ["left_motor_joint", "right_motor_joint"], "joints": ["pitch_joint"]},
        "pitch_joint is 1 joint, and .* has 2 freedoms; name as many joints as freedoms",
    ),
    (
        {
            "motors": ["left_motor_joint", "right_motor_joint"],
            "torque_limits": [[5.0, -5.0], [1.0, 2.0]],
        },
        "the lower limit comes first",
    ),
    ({"motors": ["left_motor_joint"] * 2}, "stands there twice"),
    ({"ranges": {"pitch": (0.0, 1.0)}}, "pitch_joint"),
    ({"inertia": -1.0}, "numbers from 0"),
]


@pytest.mark.parametrize(("options", "sentence"), WRONG)
def test_mistakes_are_sentences(options: dict, sentence: str) -> None:  # type: ignore[type-arg]
    """Each mistake says what is wrong and what is allowed."""
    with pytest.raises(symkin.InputError, match=sentence):
        symkin.transmission(symkin.load(G1), **options)


def test_joints_that_follow_from_each_other_are_refused() -> None:
    """Two joints geared together do not decide two motors."""
    axes = [
        symkin.LinkJoint(symkin.Joint(n, "R", [0, 0, 0], [0, 0, 1]), ["base", n + "_link"])
        for n in ("a", "b", "c", "d")
    ]
    gears = [symkin.Coupling("d", {"c": 2.0}), symkin.Coupling("b", {"a": 1.0, "c": 1.0})]
    machine = symkin.Mechanism("geared", link_joints=axes, couplings=gears)
    with pytest.raises(symkin.InputError, match="do not decide the motors"):
        symkin.transmission(machine, ["a", "b"], ["c", "d"])


def test_a_singular_reference_is_told_with_its_direction() -> None:
    """A folded parallelogram gains a freedom, and no mode is followed from there."""
    folded = symkin.load(MODELS / "urdf_plus" / "four_bar.urdf")
    with pytest.raises(symkin.InputError, match=r"singular.*--start"):
        symkin.transmission(folded, ["joint1"], ["joint3"])
    found = symkin.transmission(folded, ["joint1"], ["joint3"], start={"joint1": 0.5})
    assert np.isfinite(found.jacobian()).all()


def test_what_is_left_aside_says_why() -> None:
    """Linkages with springs are named with what stays free."""
    with pytest.raises(symkin.InputError, match=r"left-knee do not decide.*left-tarsus"):
        robot("mjcf/cassie.xml")


def test_motors_are_those_that_decide_where_the_mode_begins() -> None:
    """Of four marked motors of an Exechon those are taken that decide its linkage at the reference,
    where a slide and the hinge at its end leave the platform's tilt free.
    """
    limbs = exechon().limbs
    hinged = [replace(j, actuated=True) if j.name == "r1" else j for j in limbs[0].joints]
    machine = replace(exechon(), limbs=[replace(limbs[0], joints=hinged), *limbs[1:]])
    assert set(symkin.transmission(machine).found[0].motors) < {"p1", "r1", "p2", "p3"}


@pytest.mark.parametrize("motors", [None, ["a"]])
@pytest.mark.parametrize("actuated", [False, True])
def test_a_loop_that_cannot_move_is_not_asked_for_motors(motors, actuated) -> None:  # type: ignore[no-untyped-def]
    """Three hinges of two bars on the base make a triangle."""
    ends = {"a": ["base", "one"], "b": ["base", "two"], "c": ["one", "two"]}
    points = {"a": (0.0, 0.0, 0.0), "b": (100.0, 0.0, 0.0), "c": (30.0, 80.0, 0.0)}
    joints = [
        symkin.LinkJoint(
            symkin.Joint(n, "R", points[n], (0, 0, 1), actuated=actuated and n == "a"), ends[n]
        )
        for n in ends
    ]
    with pytest.raises(symkin.InputError, match="linkage of a, b, c cannot move"):
        symkin.transmission(symkin.Mechanism("frame", link_joints=joints), motors)


def test_found_by_itself() -> None:
    """The ankle of the G1 has its file's motors, and pitch and roll of its foot."""
    found = robot("mjcf/g1_parallel_ankle.xml")
    assert [(t.motors, t.joints) for t in found.values()] == [
        (("left_motor_joint", "right_motor_joint"), ("pitch_joint", "roll_joint"))
    ]


# --- the command ----------------------------------------------------------------------------------


def test_command_writes_the_contract(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Keys of the JSON at a configuration; the table; exit status 2 for a mistake."""
    status, told = run_json(
        capsys, "transmission", "four_bar", "--motors", "crank", "--joints", "follower",
        "--at", "60", "--torque-limits", "10", "--inertia", "0.1", "--speed-limits", "2",
    )  # fmt: skip
    assert status == 0
    assert set(told) >= {
        "motors", "joints", "jacobian", "second", "inverse_jacobian", "reflected_inertia", "bias",
        "torque_polytope", "speed_polytope", "certified", "within_limits", "notes",
    }  # fmt: skip
    assert told["certified"]
    ratio = told["jacobian"][0][0]
    assert np.allclose(np.abs(told["torque_polytope"]), 10.0 / abs(ratio))
    assert np.allclose(np.abs(told["speed_polytope"]), 2.0 * abs(ratio))
    assert abs(told["reflected_inertia"][0][0] - 0.1 / ratio**2) < 1e-12
    status, text, _ = run(
        capsys,
        "transmission",
        G1,
        "--range",
        "roll_joint=-0.26:0.26",
        "--plot",
        tmp_path / "g1.svg",
    )
    assert status == 0
    assert "weakest direction" in text
    assert (tmp_path / "g1.svg").stat().st_size > 0
    status, _, error = run(
        capsys, "transmission", "four_bar", "--motors", "crank", "--torque-limits", "5:-5"
    )
    assert status == 2
    assert "lower limit comes first" in error
    names = ("--motors", "crank", "--joints", "follower")
    status, _, error = run(capsys, "transmission", "four_bar", *names, "--at-joints", "200")
    assert status == 3
    assert "not reached" in error
    status, _, error = run(capsys, "transmission", "four_bar", *names, "--format", "c")
    assert status == 2
    assert "--format c needs -o DIR" in error


def test_linear_helper_refuses_nothing() -> None:
    """A motor of each joint, geared alone, is a transmission too: J is diagonal."""
    found = linear({"a1": {"j1": 3.0}, "a2": {"j2": -2.0, "j1": 0.5}})
    assert np.allclose(found.inverse_jacobian(), [[3.0, 0.0], [0.5, -2.0]], atol=1e-13)


def test_ranges_are_limits() -> None:
    """A told range is kept by the survey."""
    joints = transmission("g1").survey.states.joints
    low, high = G1_RANGES["roll_joint"]
    assert low <= joints[:, 1].min()
    assert joints[:, 1].max() <= high
