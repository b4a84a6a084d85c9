"""A machine has the same modes, counts, statement and certificates however it is written: modes as
places of its links. The campaign of the same name asks more machines, and what each costs.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    COMPLETENESS,
    Told,
    lowered,
    make_finder,
    problem_of,
    read_given,
)
from helpers.samples import Z, readme_five_bar
from helpers.spellings import MACHINES, lacking, named, spellings
from helpers.sweep_points import tables_of
from symkin import Joint, Limb, LinkJoint, Mechanism

PLANAR = ("limbs, motion", "limbs", "limbs, turned", "graph, turned", "MJCF")
CASES = [
    ("five-bar", "direct", ("limbs, motion", "limbs, turned", "graph, turned", "graph, 1e-08")),
    ("3-RPR", "inverse", ("limbs, motion", "graph, turned", "MJCF")),
    ("Agile Eye", "direct", ("limbs, motion", "limbs", "graph, reordered")),
    ("ankle", "inverse", ("limbs", "limbs, point", "graph, R R for U", "URDF")),
    ("delta", "inverse", ("limbs, motion", "graph, motion", "MJCF")),
    ("Tricept", "inverse", ("limbs", "limbs, turned", "graph, R R for U")),
    ("five-bar", "inverse", PLANAR),
    ("3-RUU", "direct", ("limbs, motion", "graph, point", "URDF")),
    ("3-RUU", "direct", ("limbs", "graph", "graph, R R for U")),
    ("3-RRR", "direct", PLANAR),
    ("3-RRR", "inverse", PLANAR),
    ("3-RPR", "direct", PLANAR),
    ("Agile Eye", "inverse", ("limbs", "limbs, turned", "graph, reference", "URDF")),
    ("ankle", "direct", ("limbs", "limbs, R R for U", "graph", "limbs, 1e+06")),
    ("UR arm", "direct", ("DH", "graph, reordered")),
    ("UR arm", "inverse", ("DH", "limbs, point", "graph", "graph, turned", "MJCF")),
    ("6-UPS", "direct", ("limbs", "limbs, mm", "limbs, point", "graph, reordered")),
]


@pytest.mark.parametrize(("name", "direction", "names"), in_gate(CASES, [*CASES[:6], CASES[14]]))
def test_all_spellings_have_one_answer(tmp_path, name, direction, names) -> None:
    machine = MACHINES[name]()
    spelled = named(list(spellings(machine, tmp_path)), names)
    assert len(spelled) == len(names)
    found = [one.modes(machine, inverse=direction == "inverse") for one in spelled]
    told = {
        (len(f), f.complex_count, f.completeness, f.method, sum(bool(m.certified) for m in f))
        for f in found
    }
    assert len(told) == 1
    places = [one.configurations(machine, f) for one, f in zip(spelled, found, strict=True)]
    assert len(found[0])
    for other in places[1:]:
        for pair in ((places[0], other), (other, places[0])):
            assert not lacking(*pair, (len(found[0]), len(found[0])))


BY_NAME = [
    ("3-RPR", ("p2", "c3", "y"), ("limbs, motion", "limbs", "graph", "graph, axes")),
    ("3-RPR", ("x", "y", "torsion"), ("limbs", "limbs, turned about z", "MJCF")),
    ("five-bar", ("x", "y"), ("limbs", "limbs, turned", "graph, turned")),
    ("slider-crank", ("x",), ("limbs, turned", "graph", "MJCF")),
    ("Tricept", ("cu.1", "cu.2", "cp"), ("limbs, turned", "graph", "graph, turned")),
    ("Agile Eye", ("motor1", "elbow1", "tip1"), ("limbs", "graph, motion", "MJCF")),
    ("3-RRR", ("x", "q1", "torsion"), ("limbs, motion", "limbs, turned", "graph, turned", "URDF")),
    ("3-RPR", ("r1", "c1", "r2"), ("limbs", "limbs, turned", "graph, axes")),
    ("ankle", ("upper_motor", "z"), ("limbs", "graph", "graph, R R for U")),
]

PROVED_BY_NAME = ("slider-crank", "Tricept", "Agile Eye", "five-bar")
"""Machines whose lists above a theorem covers."""


@pytest.mark.parametrize(("name", "given", "names"), in_gate(BY_NAME, BY_NAME[:5]))
def test_values_by_name_have_one_answer_in_all_spellings(tmp_path, name, given, names) -> None:
    """Of passive joints, parts of the pose and mixtures; the configuration that they are taken from
    is among the modes.
    """
    machine = MACHINES[name]()
    told = set()
    for one in named(list(spellings(machine, tmp_path)), names):
        found, known = one.by_name(machine, given)
        certified = sum(bool(mode.certified) for mode in found)
        told.add((len(found), found.complex_count, found.completeness, certified))
        size = one.mechanism.characteristic_length
        away = [
            max(
                np.abs((mode.position - known.position) / size).max(),
                np.abs(mode.rotation - known.rotation).max(),
            )
            for mode in found
        ]
        assert min(away) < 1e-6
    assert len(told) == 1
    if name in PROVED_BY_NAME:
        assert {statement for _, _, statement, _ in told} == {"proved"}


FAR = (
    ("five-bar", (0.9, 0.9), ("crank1", "elbow1")),
    ("Agile Eye", (1.0, -1.2, 0.9), ("elbow1", "motor2", "elbow3")),
)


@pytest.mark.parametrize(
    ("name", "turns", "names"),
    in_gate([*FAR], FAR[:1]),
)
def test_a_far_start_leads_to_one_solution_in_all_frames(tmp_path, name, turns, names) -> None:
    """Values by name of a mode whose motors have turned far (rad): of several solutions `solve`
    finds the same one wherever the machine stands, in any unit, size and order of limbs.
    """
    machine, found = MACHINES[name](), []
    home = machine.home
    pairs = zip(home.actuated, turns, strict=True)
    mode = symkin.modes(home, joints=[home.angle_out(c.reference[0] + q) for c, q in pairs])[-1]
    given = {name: home.angle_in(mode.joints[name]) for name in names}
    for one in spellings(machine, tmp_path):
        if one.name in ("graph, m", "graph, mm"):
            break
        if any(word in one.name for word in ("axes", "reference")):
            continue
        values = {name: one.mechanism.angle_out(value) for name, value in given.items()}
        solution = symkin.solve(one.mechanism, given=values).solution
        assert solution is not None
        found.append(one.configurations(machine, [solution]))
    assert len(found) > 6
    assert all(lacking(found[0], other, (1, 1)) == [] for other in found)


def test_complex_solutions_are_those_of_all_rows(tmp_path) -> None:
    """Rows that the limbs imply of a tilted plane's platform would hold of one turned over, too,
    which closes no limb: 2 signs of each slide are 8, as where the plane is level.
    """
    machine = MACHINES["3-RPR"]()
    [turned] = named(list(spellings(machine, tmp_path)), ["limbs, turned"])
    found, _ = turned.by_name(machine, ("x", "y", "torsion"))
    assert (len(found), found.complex_count) == (8, 8)


@pytest.mark.parametrize("spelling", ["graph, motion", "graph, axes"])
def test_formulas_are_found_whichever_way_axes_point(tmp_path, spelling) -> None:
    """Of angles about opposite axes, or of two sides of a loop, the difference stands in the rows
    as the sum does of others.
    """
    machine = MACHINES["slider-crank"]()
    [told] = named(list(spellings(machine, tmp_path)), [spelling])
    found, _ = told.by_name(machine, ("x",))
    assert (len(found), found.complex_count, found.engine) == (4, 4, "closed form")


OFF = ("limbs, motion", "limbs", "graph", "graph, turned", "MJCF")


@pytest.mark.parametrize(
    "name", in_gate(["five-bar", "3-RPR", "3-RRR", "Agile Eye", "ankle"], ["3-RPR", "ankle"])
)
def test_a_pose_off_the_motion_is_told_so_in_all_spellings(tmp_path, name) -> None:
    """Rounding is taken away, and said; beyond it nothing is found, and how far off it lies. The
    joints leave the motion, or tie the pose, whether or not a file declares it.
    """
    machine = MACHINES[name]()
    size = machine.home.characteristic_length
    for one in named(list(spellings(machine, tmp_path)), OFF):
        exact, near, off = (
            one.modes(machine, inverse=True, off=share) for share in (0.0, 1e-8, 1e-3)
        )
        assert len(near) == len(exact) > 0
        assert near.completeness == exact.completeness
        assert [mode.certified for mode in near] == [mode.certified for mode in exact]
        assert sum("was projected onto" in note for note in near.notes) == 1
        assert not len(off)
        # of a point the largest of three coordinates is told
        assert 0.57e-3 < off.smallest_residual / (size * one.factor) < 1.001e-3


def test_a_tied_pose_of_few_digits_has_its_modes_in_all_spellings(tmp_path) -> None:
    """Joints of the five-bar tie the turn of its platform to the place: a rounded pose is moved to
    the nearest that they can take.
    """
    machine = MACHINES["five-bar"]()
    pose = machine.configuration.pose
    rounded = symkin.Pose(np.round(pose.position, 4), pose.quaternion)
    names = ("limbs, motion", "limbs", "graph, motion", "limbs, point", "graph, turned")
    for one in named(list(spellings(machine, tmp_path)), names):
        found = symkin.modes(one.mechanism, pose=one.told(rounded))
        assert len(found) == 2
        assert sum("was projected onto" in note for note in found.notes) == 1


@pytest.mark.parametrize(
    "spelling", in_gate(["limbs", "graph, turned", "MJCF"], ["limbs", "graph, turned"])
)
def test_a_sweep_finds_the_modes_of_each_point(tmp_path, spelling) -> None:
    """As many as `modes` lists, with the same joints, complete and proved as there; none out of
    reach.
    """
    machine = MACHINES["3-RPR"]()
    [told] = named(list(spellings(machine, tmp_path)), [spelling])
    mechanism = told.mechanism
    names = [c.name for c in mechanism.actuated]
    scale = np.array([[0.0, 0.05, -0.05, 9.0]]) * mechanism.characteristic_length
    values = [machine.values[n] * told.factor for n in names] + scale.T * [[1.0, -0.5, 0.3]]
    inputs = [dict(zip(names, row, strict=True)) for row in values.tolist()]
    problem = problem_of(mechanism, read_given(mechanism, joints=inputs[0]))
    finder = make_finder(problem, starts=100, seed=0, certify=True)
    table = tables_of(finder, [{"joints": one} for one in inputs])
    listed = symkin.modes(mechanism, joints=inputs)
    assert table.count.tolist() == [len(found) for found in listed]
    assert table.count[0] > 0 == table.count[-1]
    assert [COMPLETENESS[k] for k in table.completeness[:-1]] == [
        found.completeness for found in listed[:-1]
    ]
    modes = [mode for found in listed for mode in found]
    assert table.listed.certified.tolist() == [int(mode.certified) for mode in modes]
    size = mechanism.characteristic_length
    assert np.abs(table.listed.position - [m.position for m in modes]).max() < 1e-9 * size
    assert table.listed.residual.max() < 1e-9 * size


def test_the_coordinates_of_the_file_are_told() -> None:
    """Of a universal joint that is written as two revolutes: their names, their zeros and limits;
    what is given keeps its own.
    """
    joints = [
        Joint("drive", "R", (0, 0, 0), (1, 0, 0), actuated=True),
        Joint("a", "R", (0, 0, 2), (0, 1, 0), zero=0.3, limits=(-0.1, 0.1)),
        Joint("b", "R", (0, 0, 5), Z, zero=-0.2),
        Joint("ball", "S", (1, 2, 2)),
        Joint("out", "R", (3, 0, 0), (0, 1, 0)),
    ]
    links = ["base", "one", "two", "three", "four", "base"]
    machine = Mechanism(
        "loop",
        link_joints=[LinkJoint(j, links[k : k + 2]) for k, j in enumerate(joints)],
        platform_link=None,
    )
    assert lowered(machine) is not None
    assert lowered(machine, frozenset({"a"})) is None
    found = symkin.modes(machine, given={"drive": 0.02})
    assert {name for mode in found for name in mode.joints} == {joint.name for joint in joints}
    near = min(found, key=lambda mode: abs(mode.joints["a"] - 0.3))
    assert near.within_limits is False
    assert abs(near.joints["a"] - 0.3) < 0.2
    assert abs(near.joints["b"] + 0.2) < 0.2
    again = symkin.modes(machine, given={"a": near.joints["a"]})
    assert min(abs(mode.joints["drive"] - 0.02) for mode in again) < 1e-9


@pytest.mark.parametrize(
    "joints",
    [
        [((0, 0, 0), Z), ((0, 0, 0), (0, 1, 0)), ((0, 3, 0), (1, 0, 0))],
        [((0, 0, 0), Z), ((0, 0, 0), (0, 1, 0)), ((0, 0, 0), (1, 1, 0))],
        [((0, 0, 0), Z), ((1, 0, 0), Z), ((2, 0, 1), (0, 1, 0))],
    ],
    ids=["a crossing beside another", "not every turn", "skew and parallel"],
)
def test_other_revolutes_stay_as_they_are(joints) -> None:
    """Which two of three crossing axes are one joint would be a choice."""
    limb = Limb("leg", [Joint(f"r{k}", "R", *at) for k, at in enumerate(joints)])
    drive = Limb(
        "drive", [Joint("s", "S", (9, 1, 2)), Joint("p", "P", (0, 0, 1), Z, actuated=True)]
    )
    assert lowered(Mechanism("legs", [limb, drive], platform_position=(1.0, 2.0, 3.0))) is None


@pytest.mark.parametrize("last", [(1.0, 0.0, 0.0), (0.6, 0.0, 0.8)])
def test_three_axes_at_right_angles_are_a_ball(last) -> None:
    """A mode is the turn of its last link: one triple of angles is told of the two that there are,
    with which all rows close.
    """
    ball = [Joint("s", "S", (1, 2, 2))]
    axes = ((0, 0, 1), (0, 1, 0), last)
    three = [
        Joint(f"r{k}", "R", np.add((1, 2, 2), k * np.array(axis)), axis, zero=0.1 * k)
        for k, axis in enumerate(axes)
    ]

    def loop(joints: list[Joint]) -> Mechanism:
        joints = [
            Joint("drive", "R", (0, 0, 0), (1, 0.2, 0), actuated=True),
            Joint("u", "U", (0.3, 1.1, 2), (0, 1, 0), axis2=(0, 0, 1)),
            *joints,
            Joint("out", "R", (3, 0.4, 0), (1, 0.2, 0.3)),
        ]
        links = ["base", *(f"link{k}" for k in range(len(joints) - 1)), "base"]
        pairs = [LinkJoint(j, links[k : k + 2]) for k, j in enumerate(joints)]
        return Mechanism("loop", link_joints=pairs, platform_link=None)

    found, told = (symkin.modes(loop(j), given={"drive": 0.05}) for j in (ball, three))
    assert len(found) == len(told) > 0
    assert (found.complex_count, found.completeness) == (told.complex_count, told.completeness)
    assert all(mode.certified and mode.residual < 1e-12 for mode in told)
    assert all({"r0", "r1", "r2"} <= set(mode.joints) for mode in told)
    assert [note for note in told.notes if note.startswith("r0, r1, r2 turn their link as a ball")]
    outputs = [sorted(mode.joints["out"] for mode in modes) for modes in (found, told)]
    assert np.allclose(*outputs, rtol=0.0, atol=1e-9)


def test_a_mode_whose_rows_contradict_each_other_by_rounding_is_not_certified() -> None:
    """No exact configuration has the pose's digits: those of the central limb of a Tricept tie
    qx qy = qw qz. One combination of its rows alone would have an exact root.
    """
    machine = MACHINES["Tricept"]()
    pose = machine.configuration.pose
    w, x, y, z = (Fraction(float(q)) for q in pose.quaternion)
    assert x * y != w * z
    [mode] = symkin.modes(machine.home, pose=pose)
    assert not mode.certified


def test_a_guide_of_a_motion_is_told_in_its_coordinates() -> None:
    """Passive joints that leave the platform its motion and no other are gone in the machine; they
    read what moves the platform.
    """
    x, y, z = np.eye(3)
    home = replace(readme_five_bar("planar"), example=None)
    for slides in ((x, x + y), (x + y, y)):
        for turn_first in (False, True):
            ways = [Joint(f"s{k}", "P", (0, 0, 0), way, zero=k) for k, way in enumerate(slides)]
            turn = Joint("turn", "R", (3, -2, 0), z, zero=0.25)
            guide = Limb("guide", [turn, *ways] if turn_first else [*ways, turn])
            guided = replace(home, limbs=[*home.limbs, guide], motion="spatial")
            low, given = lowered(guided), read_given(guided, joints=[10.0, -10.0])
            assert [limb.name for limb in low.machine.limbs] == [limb.name for limb in home.limbs]
            plain = symkin.modes(low.machine, joints=[10.0, -10.0])
            values = np.array([mode.variables for mode in plain])
            described = Told(low, problem_of(guided, given), given.values[None])
            told = described.listed(plain.problem.closure, values, np.zeros(2, dtype=int))
            assert len(told) == 2
            assert told.residual.max() < 1e-12 * guided.characteristic_length


COSTS = [
    ("five-bar", "inverse", ("limbs, motion", "limbs", "graph, motion", "graph, turned", "MJCF")),
    ("five-bar", "direct", ("limbs, motion", "limbs", "graph", "graph, turned", "URDF")),
    ("3-RRR", "direct", ("limbs, motion", "limbs", "graph, motion", "graph, turned", "MJCF")),
    ("delta", "inverse", ("limbs, motion", "graph, motion", "limbs, point", "URDF")),
    ("Tricept", "inverse", ("limbs", "graph", "graph, R R for U")),
    ("6-UPS", "inverse", ("limbs", "limbs, point", "graph")),
]


@pytest.mark.parametrize(("name", "direction", "names"), COSTS, ids=lambda value: str(value)[:12])
def test_a_spelling_costs_what_another_costs(tmp_path, name, direction, names) -> None:
    """A warm call of `modes` makes as many calls of Python functions, to a fifth, however the
    machine is written.
    """
    machine = MACHINES[name]()
    calls = {}
    for spelling in named(list(spellings(machine, tmp_path)), names):
        for _ in range(2):
            spelling.modes(machine, inverse=direction == "inverse")
        calls[spelling.name] = _calls(
            lambda one=spelling: one.modes(machine, inverse=direction == "inverse")
        )
    assert max(calls.values()) <= 1.2 * min(calls.values()), calls


def _calls(function: Callable[[], object]) -> int:
    """How many calls of Python functions a call makes."""
    count, before = 0, sys.getprofile()

    def counted(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event == "call"

    sys.setprofile(counted)
    try:
        function()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize("count", [4, 12])
def test_a_train_of_couplings_is_proved_however_long(count) -> None:
    """Whole numbers tell all solutions of a coupling, of few alike and of many."""
    z, links, couplings = (0, 0, 1), [], []
    for k in range(count):
        joint = Joint(f"q{k}", "R", (10.0 * k, 0, 0), z, actuated=k == 0)
        links.append(LinkJoint(joint, ("base" if k == 0 else f"l{k}", f"l{k + 1}")))
        couplings += [symkin.Coupling(f"q{k}", {f"q{k - 1}": 1.0})] if k else []
    train = Mechanism("train", link_joints=links, couplings=couplings, platform_link=f"l{count}")
    found = symkin.modes(train, joints=[1.2])
    assert (len(found), found.completeness, found.complex_count) == (1, "proved", 1)
    assert found[0].joints[f"q{count - 1}"] == pytest.approx(1.2)


def test_a_pose_off_the_plane_has_no_modes() -> None:
    """A motion that geometry tells moves no pose into the plane."""
    machine = readme_five_bar("spatial")
    pose = symkin.solve(machine, joints=[10.0, -10.0]).solution.pose
    near = [*pose.position, *pose.quaternion]
    assert symkin.modes(machine, pose=near)
    near[2] += 5.0
    assert not symkin.modes(machine, pose=near)


@pytest.mark.parametrize("spelling", ["DH", "limbs, turned", "limbs, 1e+06", "graph"])
def test_the_pose_of_an_arm_is_certified(tmp_path, spelling) -> None:
    """As a solution of its closure, whether the pose is an unknown or follows from the links."""
    machine = MACHINES["UR arm"]()
    [arm] = named(list(spellings(machine, tmp_path)), [spelling])
    found = arm.modes(machine, inverse=False)
    assert (len(found), found.completeness, found[0].certified) == (1, "proved", True)
    assert found[0].radius < 1e-9 * arm.mechanism.characteristic_length
