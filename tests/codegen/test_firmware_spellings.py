"""C of a machine however it is written: it costs the same, answers in the frames of the
description, and its answers are those of the description's own rows.
"""

from __future__ import annotations

import ctypes
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import samples
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from helpers.inside import Options, limbs_of, lowered_limbs
from helpers.moved_mechanisms import as_revolutes
from helpers.spelled_code import Goals, answered, border_of, operations
from helpers.spellings import MACHINES, named, spellings
from symkin import Joint, Limb, LinkJoint, Mechanism, Pose

pytestmark = pytest.mark.slow

PLANAR = ("five-bar", "3-RRR", "3-RPR", "slider-crank")
SPELLED = ("limbs, motion", "graph, motion", "limbs", "graph", "limbs, point", "MJCF", "URDF")
TURNED = ("limbs, turned", "graph, turned", "limbs, turned about z")
COSTS = [
    ("3-RRR", ("limbs, motion", "graph, turned about z", "limbs, reference")),
    ("delta", ("limbs, motion", "graph, turned", "URDF")),
    ("ankle", ("limbs", "limbs, turned", "MJCF", "graph, reference")),
    ("Agile Eye", ("limbs, motion", "graph, turned", "URDF", "limbs, reference")),
    ("3-RPS", ("limbs", "limbs, 1e+06")),
    *((name, (*SPELLED, *TURNED, "graph, reference", "limbs, 1e-08")) for name in PLANAR),
    ("Tricept", ("limbs", "limbs, turned", "graph, turned", "limbs, reference")),
    ("6-RUS", ("limbs", "limbs, reference")),
    ("3-RUU", ("limbs, motion", "graph, turned", "limbs, 1e-08")),
]


@pytest.mark.parametrize(("name", "names"), in_gate(COSTS, COSTS[:5]))
def test_all_spellings_cost_the_same(tmp_path, name, names) -> None:
    """A turned machine costs the turn at the border more."""
    machine = MACHINES[name]()
    spelled = named(list(spellings(machine, tmp_path)), names)
    assert len(spelled) == len(names)
    wanted = operations(spelled[0].mechanism)
    for other in spelled[1:]:
        found = operations(other.mechanism)
        assert found.keys() == wanted.keys()
        border = {k: border_of(k, machine) if other.is_turned else 0 for k in wanted}
        assert all(found[k] <= 1.05 * wanted[k] + border[k] for k in wanted), other.name


def test_a_turned_arm_costs_the_turn_more(tmp_path) -> None:
    """At the border alone."""
    machine = MACHINES["UR arm"]()
    plain, turned = named(list(spellings(machine, tmp_path)), ["joints", "limbs, turned"])
    wanted, found = operations(plain.mechanism), operations(turned.mechanism)
    assert found.keys() == wanted.keys()
    assert all(found[k] <= wanted[k] + border_of(k, machine) for k in wanted)


def test_a_universal_joint_may_be_two_revolutes() -> None:
    hexapod = samples.rus(6)
    assert operations(as_revolutes(hexapod)) == operations(hexapod)


@pytest.mark.parametrize("name", in_gate(["3-RRR", "delta", "Tricept"], ["3-RRR"]))
def test_what_processors_make_of_last_digits_costs_nothing(name) -> None:
    """Points off by roundings, as sines and products of other processors are."""
    machine = MACHINES[name]().home
    wanted, rng = operations(machine), np.random.default_rng(0)
    assert all(operations(_shaken(machine, rng)) == wanted for _ in range(3))


def _shaken(machine: Mechanism, rng: np.random.Generator) -> Mechanism:
    """The machine with two roundings at most on each coordinate of a joint's point."""

    def shaken(joint: Joint) -> Joint:
        off = rng.integers(-2, 3, 3) * np.finfo(float).eps
        return replace(joint, point=(np.array(joint.point) * (1.0 + off)).tolist())

    limbs = [
        replace(limb, joints=[shaken(j) for j in limb.joints]) if limb.joints else limb
        for limb in machine.limbs
    ]
    return replace(machine, limbs=limbs)


@pytest.mark.parametrize("name", in_gate(["UR arm", "Agile Eye", "delta", "ankle"], ["UR arm"]))
def test_a_turned_machine_answers_as_the_plain_one(tmp_path, name) -> None:
    """As many goals are OK in both directions, and no answer is off the machine."""
    tools.compiler("gcc")
    machine = MACHINES[name]()
    spelled = list(spellings(machine, tmp_path))
    [turned] = named(spelled, ["limbs, turned"])
    goals = Goals.of(machine, spelled[0], 12)
    plain, found = answered(goals, spelled[0]), answered(goals, turned)
    assert found == plain
    assert not found.wrong


@pytest.fixture(scope="module", params=in_gate(PLANAR, ["3-RRR"]))
def asked(request, tmp_path_factory):
    """The C of a machine that is a graph and stands turned in space."""
    tools.compiler("gcc")
    machine = MACHINES[request.param]()
    [turned] = named(list(spellings(machine, tmp_path_factory.mktemp("files"))), ["graph, turned"])
    return tools.bench_module("asked").Asked(turned.mechanism, Options("double"))


def about_home(mechanism: Mechanism, count: int) -> np.ndarray:
    rng, size = np.random.default_rng(5), mechanism.characteristic_length
    home = np.array([c.reference[0] for c in mechanism.actuated])
    scale = np.array([0.1 if c.is_angular else 0.01 * size for c in mechanism.actuated])
    return home + scale * rng.uniform(-1, 1, (count, len(home)))


def home_pose(mechanism: Mechanism) -> np.ndarray:
    pose = mechanism.reference_pose
    return np.array([*pose.position, *pose.quaternion])


def in_units(mechanism: Mechanism, values: np.ndarray) -> dict[str, float]:
    return {
        c.name: mechanism.angle_out(v) if c.is_angular else v
        for c, v in zip(mechanism.actuated, values.tolist(), strict=True)
    }


def found_poses(asked, joints: np.ndarray) -> np.ndarray:
    answers = asked.answers(joints, np.tile(home_pose(asked.mechanism), (len(joints), 1)))
    assert not answers.status.any()
    return answers.found


def test_answers_are_those_of_the_description(asked) -> None:
    machine = asked.mechanism
    joints = about_home(machine, 12)
    poses = found_poses(asked, joints)
    status, back = asked.back(poses)
    assert not status.any()
    np.testing.assert_allclose(back, joints, atol=1e-9 * machine.characteristic_length)
    for given, row in zip(joints[:4], poses, strict=False):
        pose = Pose(row[:3], row[3:])
        own = symkin.solve(machine, joints=in_units(machine, given), start=pose).solution
        size = machine.characteristic_length
        assert np.linalg.norm(own.pose.position - pose.position) < 1e-9 * size
        assert abs(own.pose.quaternion @ pose.quaternion) > 1 - 1e-15


def test_rates_are_those_of_differences(asked) -> None:
    """J times the twist of a step of the joints is that step; and back."""
    machine, step = asked.mechanism, 1e-6
    joints = about_home(machine, 4)
    ways = np.random.default_rng(7).uniform(-1, 1, joints.shape)
    ways *= [1.0 if c.is_angular else machine.characteristic_length for c in machine.actuated]
    before, after = (found_poses(asked, joints + s * step * ways) for s in (-1.0, 1.0))
    middle = found_poses(asked, joints)
    for way, a, b, row in zip(ways, before, after, middle, strict=True):
        change = Pose(b[:3], b[3:]) @ Pose(a[:3], a[3:]).inverse()
        twist = np.concatenate([b[:3] - a[:3], 2.0 * change.quaternion[1:]]) / (2 * step)
        assert np.abs(called(asked, "rates", row, twist, len(way)) - way).max() < 1e-5 * max(
            1.0, np.abs(way).max()
        )
        assert (
            np.abs(called(asked, "twist", row, way, 6) - twist).max() < 1e-5 * np.abs(twist).max()
        )


def called(asked, name: str, pose: np.ndarray, given: np.ndarray, count: int) -> np.ndarray:
    """What a function of rates gives at a pose."""
    arrays = [np.array(v, dtype=float) for v in (pose, given, np.zeros(count))]
    function = getattr(asked._library, f"{asked.mechanism.name}_{name}")
    assert function(*(ctypes.c_void_p(v.ctypes.data) for v in arrays)) == 0
    return arrays[2]


def test_a_pose_off_the_plane_is_refused(asked) -> None:
    statuses = tools.bench_module("asked").STATUSES
    home, machine = home_pose(asked.mechanism), asked.mechanism
    normal = np.array(next(j.axis for j in machine.all_joints if j.type == "R"))
    off = home.copy()
    off[:3] += 0.01 * machine.characteristic_length * normal
    tilted = Pose.from_rotation_vector(np.zeros(3), 0.01 * np.cross(normal, [1.0, 0.0, 0.0]))
    turned = np.concatenate([home[:3], (tilted @ machine.reference_pose).quaternion])
    no_number = home.copy()
    no_number[4] = np.nan
    status, _ = asked.back(np.array([off, turned, no_number]))
    assert [statuses[k] for k in status] == ["OUT_OF_RANGE", "OUT_OF_RANGE", "NONFINITE"]


def test_limits_keep_joints_as_they_are() -> None:
    """Two revolutes of which one is limited stay two, and a guide with a limit stays a limb."""
    free = as_revolutes(samples.rus(6))
    limb = free.limbs[0]
    limited = [replace(j, limits=(-1.0, 1.0)) if not j.actuated else j for j in limb.joints[:2]]
    stays = replace(limb, joints=[*limited, *limb.joints[2:]])
    machine = lowered_limbs(replace(free, limbs=[stays, *free.limbs[1:]])).machine
    assert [len(one.joints) for one in machine.limbs] == [4, 3, 3, 3, 3, 3]
    guide = guided((-90.0, 90.0))
    assert len(lowered_limbs(guide).machine.limbs) == 4
    assert len(lowered_limbs(guided(None)).machine.limbs) == 3


def guided(limits) -> Mechanism:
    """A 3-RRR whose platform a table of two slides and a pivot holds in the plane."""
    rrr = samples.three_rrr("spatial")
    slides = [
        Joint("px", "P", (0, 0, 0), (1, 0, 0), limits=limits),
        Joint("py", "P", (0, 0, 0), (0, 1, 0)),
    ]
    table = Limb("table", [*slides, Joint("turn", "R", (0, 0, 0), samples.Z)])
    return replace(rrr, limbs=[*rrr.limbs, table])


def graph_of(name: str) -> Mechanism:
    return graph_twin(replace(MACHINES[name]().home, motion="spatial"))


def test_limbs_that_tell_no_direction_on_the_base_stay_as_they_are() -> None:
    """A spherical joint at the base's origin has neither an axis nor a place off it."""
    ball = [Joint("s", "S", point=(0.0, 0.0, 0.0))]
    slide = [Joint("p", "P", point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), actuated=True)]
    limb = Limb("carried", [*ball, *slide, Joint("e", "S", point=(10.0, 0.0, 300.0))])
    legs = symkin.load("zhang2009").limbs[1:]
    machine = Mechanism("ball", [limb, *legs], platform_position=(0.0, 0.0, 300.0))
    assert lowered_limbs(machine).frames is None


def test_the_frame_of_many_limbs_is_found_in_little_memory() -> None:
    """Twenty limbs on 60 directions have 1,800 normals of two, each with 60 directions across."""
    rng = np.random.default_rng(1)
    limbs = []
    for k in range(20):
        base, platform, axis = rng.normal(size=(3, 3))
        axis2 = np.cross(axis, platform - base)
        joints = [
            Joint(f"u{k}", "U", point=base, axis=axis, axis2=axis2),
            Joint(f"p{k}", "P", point=base, axis=platform - base, actuated=True),
            Joint(f"s{k}", "S", point=platform),
        ]
        limbs.append(Limb(f"leg{k}", joints))
    tracemalloc.start()
    try:
        assert lowered_limbs(Mechanism("many", limbs)).frames is None
        assert tracemalloc.get_traced_memory()[1] < 1e8
    finally:
        tracemalloc.stop()


def test_a_graph_that_is_no_limbs_stays_one() -> None:
    """Limbs hold no bridge between two of them, and no coupling."""
    five_bar = graph_of("five-bar")
    assert not limbs_of(five_bar)[0].is_graph
    links = [five_bar.link_joints[0].links[1], "platform"]
    bridge = LinkJoint(Joint("bridge", "S", (1.0, 2.0, 3.0)), links)
    bridged = replace(five_bar, link_joints=[*five_bar.link_joints, bridge])
    assert limbs_of(bridged)[0] is bridged
    coupled = symkin.Coupling("elbow1", {"elbow2": 1.0})
    geared = replace(five_bar, couplings=[coupled])
    assert limbs_of(geared)[0] is geared


def test_joints_written_from_the_platform_are_turned_over() -> None:
    graph = graph_of("3-RPR")
    turned = [
        LinkJoint(replace(e.joint, axis=[-c for c in e.joint.axis]), e.links[::-1]) if k % 2 else e
        for k, e in enumerate(graph.link_joints)
    ]
    turned, _ = limbs_of(replace(graph, link_joints=turned))
    assert turned.limbs == limbs_of(graph)[0].limbs
