"""One solution near a start: inverse and direct problems undo each other, and every failure has its
sentence.
"""

import json
import math
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings

import symkin
from helpers.gate import each_once, in_gate
from helpers.inside import multiply, quaternion_from_rotation_vector
from helpers.laws import chain, closes, frame, same_angle, same_pose
from helpers.samples import (
    delta,
    five_bar,
    four_bar,
    pieper,
    random_joint,
    seeds,
    three_rps,
    three_rrr,
    unit,
)
from helpers.shipped import TWELVE
from symkin import (
    InputError,
    Joint,
    LeastSquares,
    Limb,
    Mechanism,
    MechanismError,
    Newton,
    Pose,
    SolveError,
)

SOLVERS = ["newton", "fast_newton", "ipopt"]
PARALLEL = ["zhang2009", "zhao2000", "zhao2000_links", "ren2008", "ren2008_true"]
SERIAL = ["gluon_6l3", "yao2020"]
KEYS = {
    "mechanism",
    "problem",
    "given",
    "length_unit",
    "angle_unit",
    "solution",
    "status",
    "iterations",
}
SOLUTION_KEYS = {
    "pose",
    "joints",
    "residual",
    "condition",
    "certified",
    "radius",
    "within_limits",
    "notes",
}


def flat(pose):
    return [*map(float, pose.position), *map(float, pose.quaternion)]


def nearby_pose(rng, mechanism, reach=0.05):
    """A random pose near the example's mode, or the reference, in the motion group (of four
    freedoms for zhao2000).
    """
    pose = mechanism.reference_pose
    if mechanism.name == "zhang2009":
        pose = symkin.solve(mechanism).solution.pose
    turn = rng.uniform(-1, 1, 3) * [reach, reach, reach]
    if mechanism.name.startswith("zhao2000"):
        turn[:2] = 0.0
    shift = reach * mechanism.characteristic_length * rng.uniform(-1, 1, 3)
    return Pose(
        pose.position + shift, multiply(quaternion_from_rotation_vector(turn), pose.quaternion)
    )


# --- inverse of direct is the identity ------------------------------------------------------------


@pytest.mark.parametrize("name", PARALLEL)
@settings(max_examples=8)
@given(rng=seeds)
def test_direct_undoes_inverse(name, rng):
    """pose -> joints -> pose for parallel mechanisms, from the pose itself as start and from a step
    beside it.
    """
    mechanism = symkin.load(name)
    pose = nearby_pose(rng, mechanism)
    inverse = symkin.solve(mechanism, pose=pose).solution
    assert same_pose(inverse, pose, mechanism.characteristic_length, 1e-12)
    assert closes(mechanism, inverse)
    direct = symkin.solve(mechanism, joints=inverse.actuated_values, start=pose).solution
    assert closes(mechanism, direct)
    assert same_pose(direct, pose, mechanism.characteristic_length, 1e-7)
    assert direct.actuated_values == pytest.approx(inverse.actuated_values, abs=1e-12)


@pytest.mark.parametrize("name", [*SERIAL, "pieper"])
@settings(max_examples=8)
@given(rng=seeds)
def test_inverse_undoes_direct(name, rng):
    """joints -> pose -> joints for serial arms, from a start a little off."""
    mechanism = pieper() if name == "pieper" else symkin.load(name)
    joints = rng.uniform(0.3, 1.2, 6) * rng.choice([-1, 1], 6)
    joints = [
        mechanism.angle_out(v) if c.is_angular else 50 * v
        for c, v in zip(mechanism.actuated, joints, strict=True)
    ]
    direct = symkin.solve(mechanism, joints=joints).solution
    assert closes(mechanism, direct)
    start = np.array(joints) + mechanism.angle_out(0.01)
    inverse = symkin.solve(mechanism, pose=direct.pose, start=start).solution
    assert closes(mechanism, inverse)
    for c in mechanism.actuated:
        if c.is_angular:
            assert same_angle(inverse.values[c.name], direct.values[c.name], 1e-6)
        else:
            assert inverse.values[c.name] == pytest.approx(direct.values[c.name], abs=1e-5)


@settings(max_examples=8)
@given(seeds)
def test_forward_kinematics_is_the_product_of_exponentials(rng):
    """A serial arm of R, P and H joints: symkin's pose is the product of 4 x 4 matrices, in one
    step.
    """
    joints = [
        random_joint(rng, k, f"q{i}", actuated=True)
        for i, k in enumerate(rng.choice(list("RPH"), 4))
    ]
    arm = Mechanism(
        "arm",
        [Limb("arm", joints)],
        serial=True,
        platform_position=(1, 2, 3),
        platform_quaternion=unit(rng, 4),
    )
    q = rng.uniform(-3, 3, 4)
    result = symkin.solve(arm, joints=q)
    values = {f"q{i}": v for i, v in enumerate(q)}
    expected = chain(joints, values) @ frame(arm.platform_position, arm.platform_quaternion)
    assert np.allclose(
        frame(result.solution.position, result.solution.quaternion), expected, atol=1e-10
    )
    assert result.iterations == 0


@pytest.mark.slow
@pytest.mark.parametrize("count", in_gate([3, 4, 5, 7, 8], [3, 7]))
@settings(max_examples=3)
@given(rng=seeds)
def test_arms_of_any_count_are_solved_near_a_start(count, rng):
    """Fewer than six joints: all rows hold at a pose in reach, and a pose beside it has no
    solution; more than six: one of many solutions, for all solvers.
    """
    joints = [random_joint(rng, "R", f"q{i}", actuated=True) for i in range(count)]
    arm = Mechanism("arm", [Limb("arm", joints)], serial=True, platform_position=(30.0, 20.0, 10.0))
    q = np.array([j.zero for j in joints]) + rng.uniform(-1, 1, count)
    pose = symkin.solve(arm, joints=q).solution.pose
    for solver in SOLVERS:
        found = symkin.solve(
            arm, pose=pose, start=q + 0.01 * rng.uniform(-1, 1, count), solver=solver
        ).solution
        assert closes(arm, found)
        assert same_pose(found, pose, arm.characteristic_length)
    if count < 6:
        beside = Pose(
            pose.position,
            multiply(quaternion_from_rotation_vector(np.array([0.2, -0.3, 0.4])), pose.quaternion),
        )
        result = symkin.solve(arm, pose=beside, start=q, check=False)
        assert result.solution is None
        assert result.smallest_residual > 1e-6 * arm.characteristic_length


@pytest.mark.parametrize("count", [7, 8])
def test_modes_of_a_redundant_arm_are_refused_with_the_reason(count):
    """More joints than the pose has freedoms: no isolated modes; the message says so and points to
    solve.
    """
    rng = np.random.default_rng(count)
    joints = [random_joint(rng, "R", f"q{i}", actuated=True) for i in range(count)]
    arm = Mechanism("arm", [Limb("arm", joints)], serial=True, platform_position=(30.0, 20.0, 10.0))
    with pytest.raises(InputError, match="no isolated") as error:
        symkin.modes(arm, pose=[30.0, 20.0, 10.0, 1, 0, 0, 0])
    assert f"{count - 6} of {count}" in str(error.value)
    assert "solve" in str(error.value)


# --- solvers and iterations -----------------------------------------------------------------------

CASES = {
    "zhang2009": lambda: (symkin.load("zhang2009"), {"start": [0, 0, 100, 1, 0, 0, 0]}),
    "zhao2000": lambda: (symkin.load("zhao2000"), {}),
    "zhao2000_links": lambda: (symkin.load("zhao2000_links"), {}),
    "ren2008": lambda: (symkin.load("ren2008"), {"joints": [0.16, 0.15, 0.14, 0.15, 0.16, 0.15]}),
    "yao2020": lambda: (symkin.load("yao2020"), {}),
    "gluon": lambda: (
        symkin.load("gluon_6l3"),
        {"pose": gluon_pose(), "start": [20, 10, 20, 10, 20, 10]},
    ),
    "delta": lambda: (delta(), {"joints": [0.1, 0.2, 0.3]}),
    "three_rrr": lambda: (three_rrr(), {"joints": rrr_joints()}),
    "four_bar": lambda: (four_bar()[0], {"joints": [1.2]}),
    "five_bar": lambda: (five_bar(), {"joints": [100.0, 80.0]}),
}


def rrr_joints():
    return [
        c.reference[0] + step
        for c, step in zip(three_rrr().actuated, (0.1, -0.05, 0.08), strict=True)
    ]


def gluon_pose():
    return symkin.solve(symkin.load("gluon_6l3"), joints=[15.0] * 6).solution.pose


@pytest.mark.parametrize("case", CASES)
def test_solvers_agree(case):
    """newton, fast_newton and ipopt reach the same configuration from the same start;
    overconstrained ones too.
    """
    mechanism, given_ = CASES[case]()
    results = [symkin.solve(mechanism, **given_, solver=solver) for solver in SOLVERS]
    for result in results:
        assert result.status == "ok"
        assert closes(mechanism, result.solution)
        assert same_pose(
            result.solution, results[0].solution, mechanism.characteristic_length, 1e-6
        )
        assert result.solution.actuated_values == pytest.approx(
            results[0].solution.actuated_values, rel=1e-6, abs=1e-5
        )


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("case", CASES)
def test_history_is_the_iteration(case, solver):
    """One entry more than iterations, the last residual about zero and none before it smaller by
    more than rounding.
    """
    mechanism, given_ = CASES[case]()
    result = symkin.solve(mechanism, **given_, solver=solver)
    left = [step.residual for step in result.history]
    assert result.iterations == len(left) - 1 > 0
    assert left[-1] <= 1e-6 * mechanism.characteristic_length
    assert left[-1] <= min(left) + 1e-9 * mechanism.characteristic_length
    assert left[-1] < left[-2] or left[-2] < 1e-9 * mechanism.characteristic_length
    assert same_pose(
        result.history[-1].pose, result.solution, mechanism.characteristic_length, 1e-5
    )


def test_newton_is_quadratic():
    """Near the solution each residual is about the square of the one before: over the size,
    r[k+1] < 10^3 r[k]^2.
    """
    mechanism = symkin.load("zhang2009")
    left = (
        np.array([step.residual for step in symkin.solve(mechanism).history])
        / mechanism.characteristic_length
    )
    pairs = [(a, b) for a, b in pairwise(left) if 1e-7 < a < 1e-3]
    assert pairs
    assert all(b < 1e3 * a**2 for a, b in pairs)


def test_history_begins_at_the_start():
    """The first iterate is the pose given as start."""
    start = [10.0, -20.0, 90.0, *quaternion_from_rotation_vector(np.array([0.1, 0.2, 0.3]))]
    for solver in SOLVERS:
        first = (
            symkin.solve(symkin.load("zhang2009"), start=start, solver=solver, check=False)
            .history[0]
            .pose
        )
        assert same_pose(first, Pose(np.array(start[:3]), np.array(start[3:])), 100.0, 1e-12)


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000", "ren2008"])
def test_a_start_at_a_mode_stays_there(name):
    """Started at each assembly mode, Newton returns that mode, not another."""
    mechanism = symkin.load(name)
    for mode in symkin.modes(mechanism):
        again = symkin.solve(mechanism, joints=mode.actuated_values, start=mode.pose)
        assert same_pose(again.solution, mode, mechanism.characteristic_length, 1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "joints"),
    [(three_rps(), 1.02), (three_rrr("planar"), 1.0)],
    ids=["3-RPS", "3-RRR"],
)
def test_the_pose_of_every_mode_leads_back_to_it(mechanism, joints):
    """Limbs on other branches than the reference's too: a leg that has turned over, an elbow on the
    other side. A start at another mode is noted only if another one is reached.
    """
    values = np.array(
        [joints * c.reference[0] + 0.01 * k for k, c in enumerate(mechanism.actuated)]
    )
    found = symkin.modes(mechanism, joints=values)
    assert len(found) >= 2
    for mode in found:
        again = symkin.solve(mechanism, joints=values, start=mode.pose)
        assert same_pose(again.solution, mode, mechanism.characteristic_length, 1e-7)
        assert not again.notes


def test_a_start_that_leads_far_away_is_noted():
    """No mode lies near a pose upside down and far off; the result says how far it went."""
    mechanism = symkin.load("zhang2009")
    found = symkin.solve(mechanism, start=[0, 0, 900, 1, 0, 0, 0])
    assert any("mm" in note and "configuration that it led to" in note for note in found.notes)


def test_a_start_of_joints_chooses_the_working_mode():
    """yao2020: from each of its modes, turned by a degree, the inverse problem returns that
    mode.
    """
    mechanism = symkin.load("yao2020")
    for mode in symkin.modes(mechanism):
        again = symkin.solve(
            mechanism, pose=mode.pose, start=np.array(mode.actuated_values) + 1.0
        ).solution
        assert np.allclose(again.actuated_values, mode.actuated_values, atol=1e-5)


@settings(max_examples=10)
@given(seeds)
def test_ipopt_keeps_the_limits(rng):
    """Whatever ipopt returns for limited joints is within them; without a solution there it says
    so.
    """
    joints = [
        Joint(j.name, "R", j.point, j.axis, actuated=True, limits=(-1.5, 1.5))
        for _, j in pieper().joints
    ]
    arm = Mechanism("arm", [Limb("arm", joints)], serial=True, platform_position=(90.0, 0.0, 220.0))
    inside = rng.uniform(-1.3, 1.3, 6)
    pose = symkin.solve(arm, joints=inside).solution.pose
    result = symkin.solve(
        arm, pose=pose, start=rng.uniform(-1.5, 1.5, 6), solver="ipopt", check=False
    )
    for step in result.history[1:]:
        assert np.all(np.abs(step.values[:6]) <= 1.5 + 1e-6)
    if result.solution is not None:
        assert result.solution.within_limits
        assert closes(arm, result.solution)


def test_within_limits_says_yes_no_or_nothing():
    """ren2008 has rod limits 0 to 0.55 m: true inside, false outside; zhang2009 has none: null."""
    ren = symkin.load("ren2008")
    x, y, _ = ren.platform_position
    assert symkin.solve(ren, pose=[x, y, 1.4, 1, 0, 0, 0]).solution.within_limits is True
    assert symkin.solve(ren, pose=[x, y, 2.5, 1, 0, 0, 0]).solution.within_limits is False
    assert symkin.solve(symkin.load("zhang2009")).solution.within_limits is None


# --- statuses -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Fixed:
    """A solver that answers with its start moved by one number, whatever the problem."""

    step: float
    name: str = "fixed"

    def iterate(self, _problem, start, _known):
        return [start, start + self.step]


FAILURES = {
    "infeasible": (lambda: symkin.load("zhang2009"), {"joints": [100.0] * 5 + [5000.0]}, "reach"),
    "max_iterations": (
        lambda: symkin.load("zhang2009"),
        {"start": [30, 20, 90, 1, 0, 0, 0], "solver": Newton(max_iterations=1)},
        "modes",
    ),
    "singular": (
        lambda: symkin.load("zhang2009"),
        {"start": [0, 0, 0, 1, 0, 0, 0], "solver": Fixed(0.3)},
        "singular",
    ),
    "nonfinite": (lambda: symkin.load("zhang2009"), {"solver": Fixed(math.nan)}, "NaN"),
}


@pytest.mark.parametrize("status", FAILURES)
def test_a_failure_has_its_status_and_a_remedy(status):
    """SolveError by default, holding the result and its notes; returned on request; the message has
    status, count, what to do.
    """
    make, given_, remedy = FAILURES[status]
    result = symkin.solve(make(), **given_, check=False)
    assert result.status == status
    assert result.solution is None
    assert result.smallest_residual > 0
    assert status in result.message
    assert remedy in result.message
    assert ":" in result.message
    with pytest.raises(SolveError) as error:
        symkin.solve(make(), **given_)
    assert error.value.result.status == status
    assert str(error.value) == "; ".join([result.message, *result.notes])


@pytest.mark.parametrize(
    ("step", "names"),
    in_gate(
        [(-50.0, TWELVE), *product([-50.0, 0.3, 1e3, 1e6], [symkin.shipped_names()])],
        [(-50.0, TWELVE)],
    ),
    ids=lambda value: str(value) if isinstance(value, float) else f"{len(value)}",
)
def test_the_driver_believes_no_solver(step, names):
    """An answer that does not close the loops is never called a solution: it is verified on all
    rows.
    """
    for name in names:
        mechanism = symkin.load(name)
        result = symkin.solve(mechanism, solver=Fixed(step), check=False)
        assert (result.status == "ok") == (result.solution is not None)
        if result.solution is not None:
            assert mechanism.is_graph or closes(mechanism, result.solution)
            assert result.solution.residual < 1e-9 * mechanism.characteristic_length


@pytest.mark.parametrize(("solver", "huge"), each_once(SOLVERS, [1e20, 1e100, 1e150]))
def test_huge_values_end_in_a_status(solver, huge):
    """Starts, joints and poses beyond any reach: no warning, no solution that does not close, and
    JSON without Infinity.
    """
    mechanism = symkin.load("zhang2009")
    for given_ in (
        {"start": [huge, 2, 90, 0.8, 0.6, 0, 0]},
        {"joints": [huge] * 6},
        {"pose": [huge, 0, 0, 1, 0, 0, 0]},
    ):
        result = symkin.solve(mechanism, **given_, solver=solver, check=False)
        json.dumps(result.to_dict(), allow_nan=False)
        if result.solution is not None:
            scale = max(
                1.0, max(abs(v) for v in result.solution.position) / mechanism.characteristic_length
            )
            assert result.solution.residual <= 1e-8 * scale * mechanism.characteristic_length


@pytest.mark.parametrize("name", SERIAL)
def test_a_pose_out_of_reach_is_infeasible(name):
    """A tool pose ten times the arm away; the residual left is about the distance missing."""
    mechanism = symkin.load(name)
    far = [10 * mechanism.characteristic_length, 0, 0, 1, 0, 0, 0]
    result = symkin.solve(mechanism, pose=far, check=False)
    if name == "gluon_6l3":
        assert result.status == "infeasible"
        assert result.smallest_residual > mechanism.characteristic_length
    else:
        assert result.solution is not None  # its last joint slides without end
        assert closes(mechanism, result.solution)


def test_an_unreachable_limb_is_infeasible():
    """A pose that one limb of links cannot reach."""
    result = symkin.solve(three_rrr(), pose=[90.0, 90.0, 0.0, 1, 0, 0, 0], check=False)
    assert result.status == "infeasible"
    assert result.smallest_residual > 0


def test_newton_and_least_squares_take_settings():
    """Solver values in place of names; an unknown name is refused with the choice."""
    mechanism = symkin.load("zhang2009")
    for solver in (
        Newton(tolerance=1e-10),
        Newton(method="fast_newton"),
        LeastSquares(max_iterations=100),
    ):
        assert symkin.solve(mechanism, solver=solver).solution is not None
    with pytest.raises(InputError, match=r"solver = 'bfgs' is unknown; allowed: .*newton.*ipopt"):
        symkin.solve(mechanism, solver="bfgs")


# --- what is given --------------------------------------------------------------------------------

NAN, INF = math.nan, math.inf
POSE = [0.0, 0.0, 100.0, 1.0, 0.0, 0.0, 0.0]
BAD = {
    "both": ({"joints": [100.0] * 6, "pose": POSE}, ["both"]),
    "too few joints": ({"joints": [100.0] * 5}, ["joints", "5", "6", "leg1"]),
    "too many joints": ({"joints": [100.0] * 7}, ["joints", "7", "6"]),
    "no joints": ({"joints": []}, ["joints", "0", "6"]),
    "too few of a pose": ({"pose": POSE[:6]}, ["pose", "6", "7", "qw"]),
    "NaN joint": ({"joints": [100.0] * 5 + [NAN]}, ["joints", "value 6", "nan", "finite"]),
    "infinite joint": ({"joints": [INF] + [100.0] * 5}, ["joints", "value 1", "inf", "finite"]),
    "NaN pose": ({"pose": [0, NAN, 0, 1, 0, 0, 0]}, ["pose", "value 2", "nan", "finite"]),
    "text": ({"joints": ["wide"] + [100.0] * 5}, ["joints", "value 1", "'wide'", "number"]),
    "None": ({"joints": [None] + [100.0] * 5}, ["joints", "value 1", "None", "number"]),
    "negative rod": (
        {"joints": [100.0, -3.0] + [100.0] * 4},
        ["joints", "leg2", "-3", "0 and above"],
    ),
    "quaternion norm": ({"pose": [0, 0, 100, 1.02, 0, 0, 0]}, ["pose", "norm", "1.02", "0.01"]),
    "zero quaternion": ({"pose": [0, 0, 100, 0, 0, 0, 0]}, ["pose", "norm", "0.01"]),
    "short start": ({"start": [1.0, 2.0]}, ["start", "2", "7"]),
    "NaN start": ({"start": [NAN, *POSE[1:]]}, ["start", "value 1", "nan"]),
    "start norm": ({"start": [0, 0, 100, 2, 0, 0, 0]}, ["start", "norm 2"]),
    "start of joints": ({"pose": POSE, "start": [100.0] * 5}, ["start", "5", "6"]),
    "start of a negative rod": ({"pose": POSE, "start": [-1.0] * 6}, ["start", "leg1", "-1"]),
    "joints is a number": ({"joints": 3.0}, ["joints", "3.0"]),
    "pose is a number": ({"pose": 3.0}, ["pose", "3.0"]),
    "a pose as the start of joints": ({"pose": POSE, "start": Pose.identity()}, ["start"]),
}


@pytest.mark.parametrize("case", BAD)
def test_values_that_do_not_fit_have_their_sentence(case):
    """InputError in one line: what was given, which value, what is allowed; `modes` says the
    same.
    """
    given_, fragments = BAD[case]
    with pytest.raises(InputError) as error:
        symkin.solve(symkin.load("zhang2009"), **given_)
    for fragment in fragments:
        assert fragment in str(error.value)
    assert "\n" not in str(error.value)
    if "start" not in given_:
        with pytest.raises(InputError) as other:
            symkin.modes(symkin.load("zhang2009"), **given_)
        assert str(other.value) == str(error.value)


def test_offset_shifts_the_least_rod_value():
    """ren2008: |rod| = 1.2 + value, so that -1.3 is refused and -1.1 is not."""
    with pytest.raises(InputError, match=r"leg1 = -1\.3 .*-1\.2 and above"):
        symkin.solve(symkin.load("ren2008"), joints=[-1.3] + [0.1] * 5)
    assert (
        symkin.solve(symkin.load("ren2008"), joints=[-1.1] + [0.1] * 5, check=False).status != "ok"
    )


def test_without_input_the_example_is_taken_else_the_reference():
    """given: the example's joints or pose; without one the actuated reference values."""
    for name in ("zhang2009", "zhao2000", "gluon_6l3", "yao2020"):
        mechanism = symkin.load(name)
        echo = symkin.solve(mechanism).given
        if mechanism.example.joints is not None:
            assert echo == {"joints": list(mechanism.example.joints)}
        else:
            assert echo["pose"] == pytest.approx(list(mechanism.example.pose))
    ren = symkin.load("ren2008")
    assert symkin.solve(ren).given["joints"] == pytest.approx(
        [c.reference[0] for c in ren.actuated]
    )
    assert symkin.solve(five_bar()).given["joints"] == pytest.approx([90.0, 90.0])


def test_a_mechanism_without_actuated_joints_needs_a_pose():
    """Nothing to solve without a pose; with one it is an inverse problem."""
    passive = Mechanism(
        "m",
        [Limb("l", [Joint("a", "R", axis=(0, 0, 1)), Joint("b", "S", (1.0, 0, 0))])],
        platform_position=(1, 0, 0),
    )
    with pytest.raises(InputError, match="pose"):
        symkin.solve(passive)
    assert symkin.solve(passive, pose=[0, 1, 0, 1, 0, 0, 0]).solution.values["a"] == pytest.approx(
        math.pi / 2
    )


def test_joints_take_numpy_ints_and_pose_values():
    """Lists, tuples, arrays, integers and Pose objects are the same input."""
    mechanism = symkin.load("zhang2009")
    pose = Pose(np.array([1.0, 2.0, 100.0]), np.array([1.0, 0, 0, 0]))
    expected = symkin.solve(mechanism, pose=pose).solution.actuated_values
    for given_ in (
        [1, 2, 100, 1, 0, 0, 0],
        (1.0, 2.0, 100.0, 1.0, 0, 0, 0),
        np.array([1, 2, 100, -1, 0, 0, 0]),
    ):
        assert symkin.solve(mechanism, pose=given_).solution.actuated_values == pytest.approx(
            expected
        )


# --- restricted motions ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "make",
    [lambda: symkin.load("zhao2000"), lambda: three_rrr("planar"), delta],
    ids=["zhao", "rrr", "delta"],
)
def test_a_pose_nearly_on_the_motion_is_projected_with_a_note(make):
    """Tilted by less than 1e-6 rad: solved, and `notes` says so; by more: infeasible; exactly on
    it: no note.
    """
    mechanism = make()
    x, y, z = mechanism.platform_position
    for tilt, status, noted in (
        (0.0, "ok", False),
        (3e-7, "ok", True),
        (3e-6, "infeasible", True),
        (0.3, "infeasible", True),
    ):
        pose = [x, y, z, math.cos(tilt / 2), math.sin(tilt / 2), 0, 0]
        result = symkin.solve(mechanism, pose=pose, check=False)
        assert result.status == status
        assert any(mechanism.motion in note for note in result.notes) == noted
        if status == "ok":
            assert result.solution.quaternion[1] == pytest.approx(0.0, abs=1e-15)
            assert list(result.solution.notes) == list(result.notes)
        else:
            assert result.smallest_residual == pytest.approx(
                tilt * mechanism.characteristic_length, rel=1e-3
            )
            assert len(symkin.modes(mechanism, pose=pose)) == 0


def test_a_planar_pose_off_the_plane_is_infeasible():
    """Out of the plane by a length."""
    for lift, status in ((1e-7, "ok"), (1.0, "infeasible")):
        assert (
            symkin.solve(three_rrr("planar"), pose=[0, 0, lift, 1, 0, 0, 0], check=False).status
            == status
        )


def test_a_start_off_the_motion_is_refused():
    """InputError: the start lies off the motion, by how much."""
    with pytest.raises(InputError, match=r"start.*schoenflies"):
        symkin.solve(symkin.load("zhao2000"), start=[0, 0, 100, math.cos(0.2), math.sin(0.2), 0, 0])


def test_a_pose_that_no_limb_allows_is_infeasible():
    """zhao2000_links keeps its platform level by its limbs alone: a tilted pose has no solution, no
    mode, no crash.
    """
    mechanism = symkin.load("zhao2000_links")
    tilted = [0, 0, 100, math.cos(0.1), math.sin(0.1), 0, 0]
    assert symkin.solve(mechanism, pose=tilted, check=False).status == "infeasible"


# --- JSON -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_json_has_the_contract_keys(name):
    """Contract 3: these keys at least; numbers finite or null; dumps without NaN and loads back
    equal.
    """
    mechanism = symkin.load(name)
    result = symkin.solve(mechanism).to_dict()
    assert result.keys() >= KEYS
    assert result["solution"].keys() >= SOLUTION_KEYS
    assert json.loads(json.dumps(result, allow_nan=False)) == result
    pose = result["solution"]["pose"]
    assert (pose is None) == (mechanism.platform_link is None)
    if pose is not None:
        assert np.allclose(
            pose["matrix"], frame(pose["position"], pose["quaternion"])[:3, :3], atol=1e-12
        )
        assert pose["quaternion"][0] >= 0
    assert {c.name for c in mechanism.actuated} <= result["solution"]["joints"].keys()
    assert not any(key.startswith("pose") for key in result["solution"]["joints"])


@pytest.mark.parametrize("status", FAILURES)
def test_json_of_a_failure(status):
    """solution null, the status, and still no NaN."""
    make, given_, _ = FAILURES[status]
    result = symkin.solve(make(), **given_, check=False).to_dict()
    assert result["solution"] is None
    assert result["status"] == status
    assert json.loads(json.dumps(result, allow_nan=False)) == result


def test_results_print_themselves():
    """str of a result is the table of the command with its pose and closure error, of a solution
    one line with its joints; of a failure the message is a line.
    """
    mechanism = symkin.load("zhang2009")
    found = symkin.solve(mechanism)
    for text, fragments in (
        (str(found), ("zhang2009", "mm", "closure error", "iterations")),
        (str(found.solution), ("residual", "leg6")),
    ):
        for fragment in fragments:
            assert fragment in text
    failed = symkin.solve(mechanism, joints=[100.0] * 5 + [5000.0], check=False)
    assert failed.message in str(failed).splitlines()


def test_same_input_same_result():
    """Two solves give the same bits, also after others in between."""
    mechanism = symkin.load("zhao2000_links")
    first = symkin.solve(mechanism).to_dict()
    symkin.solve(mechanism, joints=[90.0, 210.0, 330.0, 100.0], check=False)
    again = symkin.solve(mechanism).to_dict()
    assert {k: v for k, v in first.items() if k != "elapsed_s"} == {
        k: v for k, v in again.items() if k != "elapsed_s"
    }


def test_errors_are_symkin_errors():
    """One base class for all."""
    assert all(issubclass(e, symkin.SymkinError) for e in (InputError, MechanismError, SolveError))
