"""Mobility, rank and reciprocal screws follow from the closure, whatever Gruebler and Kutzbach
count.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import moved_points
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from helpers.inside import (
    Rank,
    as_graph,
    build_closure,
    describe,
    fewer_rows,
    generic,
    loops_at,
    prismatic_screw,
    reciprocal_product,
    reciprocal_system,
    revolute_screw,
    scaled,
)
from helpers.random_graphs import random_graph
from helpers.samples import delta, three_rrr
from helpers.shipped import TWELVE
from oracle.body_constraints import redundant_rows
from symkin import Joint, Limb, Mechanism


def four_bar(x: float = 4.0, z: float = 0.0) -> Mechanism:
    """Crank 1, coupler, rocker 3, base `x`; axes along z, except the last one, which leans by
    `z`.
    """
    axis, lean = (0, 0, 1), (0, z, 1)
    left = Limb(
        "left",
        [Joint("crank", "R", (0, 0, 0), axis, actuated=True), Joint("a", "R", (0, 1, 0), axis)],
    )
    right = Limb("right", [Joint("rocker", "R", (x, 0, 0), lean), Joint("b", "R", (3, 3, 0), axis)])
    return Mechanism("four_bar", [left, right], platform_position=(1, 2, 0))


def bennett(twist: float = 30.0, other: float = 60.0, length: float = 2.0) -> Mechanism:
    """Bennett's four-bar: opposite links equal, a / sin(alpha) = b / sin(beta), by DH transforms
    (Bennett 1903).
    """
    b = length * math.sin(math.radians(other)) / math.sin(math.radians(twist))
    alpha, beta = math.radians(twist), math.radians(other)
    theta1 = math.radians(100.0)
    half = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2) / math.tan(theta1 / 2)
    theta2 = 2 * math.atan(half)

    def dh(theta: float, a: float, twist_: float) -> np.ndarray:
        ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(twist_), math.sin(twist_)
        return np.array(
            [
                [ct, -st * ca, st * sa, a * ct],
                [st, ct * ca, -ct * sa, a * st],
                [0, sa, ca, 0],
                [0, 0, 0, 1],
            ]
        )

    frames = [np.eye(4)]
    for theta, a, t in (
        (theta1, length, alpha),
        (theta2, b, beta),
        (-theta1, length, alpha),
        (-theta2, b, beta),
    ):
        frames.append(frames[-1] @ dh(theta, a, t))
    assert np.allclose(frames[4], np.eye(4), atol=1e-9), "the loop closes at the reference"
    joints = [
        Joint(f"j{k}", "R", frames[k][:3, 3], frames[k][:3, 2], actuated=k == 0) for k in range(4)
    ]
    platform = tuple(frames[1][:3, 3])
    return Mechanism(
        "bennett",
        [Limb("one", joints[:2]), Limb("two", [joints[3], joints[2]])],
        platform_position=platform,
    )


@pytest.mark.parametrize(
    ("mechanism", "mobility", "redundant", "gruebler"),
    [
        (four_bar(), 1, 3, -2),
        (bennett(), 1, 3, -2),
        (symkin.load("zhao2000_links"), 4, 1, 4),
        (symkin.load("zhao2000"), 4, 4, 1),
        (symkin.load("zhang2009"), 6, 0, 12),
        (symkin.load("ren2008"), 6, 0, 6),
        (symkin.load("gluon_6l3"), 6, 0, 6),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_mobility_of_known_mechanisms(
    mechanism: Mechanism, mobility: int, redundant: int, gruebler: int
) -> None:
    """Full-cycle mobility: planar four-bar and Bennett 1 (overconstrained by 3), 3-TRT+SPS 4 with
    one redundant couple (Zhao 2000), platforms of six SPS or UPS limbs 6.
    """
    found = symkin.mobility(mechanism)
    assert (found.mobility, found.redundant, found.gruebler) == (mobility, redundant, gruebler)


def agile_eye() -> Mechanism:
    """Three limbs of three revolutes whose axes meet at the origin, square to each other at the
    reference.
    """
    x, y, z = np.eye(3)
    limbs = []
    for k, (a, b, c) in enumerate([(x, y, -z), (y, z, -x), (z, x, -y)]):
        axes = {"m": a, "e": b, "p": c}
        limbs.append(
            Limb(
                f"l{k}",
                [Joint(f"{n}{k}", "R", 60 * v, v, actuated=n == "m") for n, v in axes.items()],
            )
        )
    return Mechanism("agile", limbs)


@pytest.mark.parametrize(
    ("mechanism", "motion", "redundant"),
    [
        pytest.param(agile_eye(), "spherical", 6, marks=pytest.mark.long),
        pytest.param(three_rrr(), "planar", 6, marks=pytest.mark.long),
        (delta(), "translation", 0),
        (symkin.load("zhao2000"), "schoenflies", 4),
        (four_bar(), "planar", 3),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_redundant_constraints_are_those_of_the_machine(
    mechanism: Mechanism, motion: str, redundant: int
) -> None:
    """6 loops and rods less their rank, by hand: whether its motion is declared or not, as limbs
    and as a graph, and to `close`.
    """
    spatial = replace(mechanism, motion="spatial")
    for form in (replace(mechanism, motion=motion), spatial, as_graph(spatial)):
        found = symkin.mobility(form)
        shown, closed = found.to_dict(), symkin.close(form)
        told = [
            found.redundant,
            shown["redundant"],
            shown["generic"]["redundant"],
            closed.redundant,
        ]
        told.append(closed.to_dict()["generic"]["redundant"])
        assert told == [redundant] * 5
        assert f"redundant constraints: {redundant}" in describe(form)
    assert symkin.mobility(spatial).implied_rows == redundant


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_redundant_constraints_are_those_of_free_bodies(name: str) -> None:
    """At the reference, by what joints and rods forbid of links as free bodies."""
    mechanism = symkin.load(name)
    found = symkin.mobility(mechanism)
    assert found.to_dict()["redundant"] == redundant_rows(replace(mechanism, motion="spatial"))


@pytest.mark.parametrize("name", ["four_bar", "sarrus", "double_wishbone", "five_link_suspension"])
@pytest.mark.parametrize("away", [1e2, 1e6])
def test_redundant_constraints_wherever_the_base_frame_is(name: str, away: float) -> None:
    """By loops, each and together, of a machine that stands many times its size from the origin of
    the base frame.
    """
    mechanism = symkin.load(name)
    far = np.array([1.0, 0.7, -0.4]) * away * mechanism.characteristic_length
    joints = [
        replace(e, joint=replace(e.joint, point=e.joint.point + far)) for e in mechanism.link_joints
    ]
    rods = [replace(rod, start=rod.start + far, end=rod.end + far) for rod in mechanism.link_rods]
    moved = replace(mechanism, link_joints=joints, link_rods=rods, link_points=())
    closures = [build_closure(m) for m in (mechanism, moved)]
    together = [symkin.mobility(m).redundant_at_reference for m in (mechanism, moved)]
    single = [
        [loop.redundant for loop in loops_at(closure, closure.reference)] for closure in closures
    ]
    assert together[0] == together[1]
    assert single[0] == single[1]


@pytest.mark.parametrize("seed", in_gate(range(15), range(8)))
def test_redundant_constraints_of_random_graphs_are_those_of_free_bodies(seed: int) -> None:
    """By the rows of the closure, couplings included, wherever loops are cut."""
    mechanism = random_graph(seed)
    assert symkin.mobility(mechanism).redundant_at_reference == redundant_rows(mechanism)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "expected"),
    [
        (three_rrr(), ("planar", 0)),
        (four_bar(), ("planar", 0)),
        (bennett(), None),
        pytest.param(symkin.load("zhao2000_links"), None, marks=pytest.mark.long),
        (symkin.load("zhang2009"), None),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_a_declared_motion_that_removes_redundant_rows_is_named(mechanism, expected) -> None:
    """Planar linkages with their motion left out: `show` names it. Nothing is named where the
    platform keeps fewer freedoms than the group leaves, or rows stay redundant in it.
    """
    spatial = replace(mechanism, motion="spatial")
    assert fewer_rows(symkin.mobility(spatial)) == expected
    text = describe(spatial)
    assert f'motion = "{expected[0]}"' in text if expected else "in [platform]" not in text


def test_a_motion_that_is_declared_is_not_named_again() -> None:
    assert fewer_rows(symkin.mobility(replace(three_rrr(), motion="planar"))) is None


def test_a_bennett_linkage_off_its_condition_is_rigid() -> None:
    """With one axis leaning, the four-bar closes at the reference only: mobility 0 there, rank
    full.
    """
    assert symkin.mobility(four_bar(z=0.3)).mobility == 0


@pytest.mark.parametrize("name", ["zhao2000", "zhao2000_links", "yao2020"])
def test_limb_wrenches_are_reciprocal_to_joint_screws(name: str) -> None:
    """The closure's constraint wrenches of a limb span the screws reciprocal to all of its joints'
    twists.
    """
    mechanism = symkin.load(name)
    found = symkin.mobility(mechanism)
    assert found.at_reference
    for limb, screws in zip(mechanism.limbs, found.limbs, strict=True):
        if not isinstance(limb, Limb):
            continue
        twists = np.array([_screw(joint) for joint in limb.joints])
        expected = reciprocal_system(twists, mechanism.characteristic_length)
        assert screws.constraints.shape == expected.shape
        for wrench in screws.constraints:
            assert (
                max(abs(reciprocal_product(twist, wrench)) for twist in twists)
                < 1e-9 * mechanism.characteristic_length
            )


@pytest.mark.parametrize("size", [1e-8, 1e6])
@pytest.mark.parametrize("form", ["limbs", "graph"])
def test_what_a_platform_takes_and_has_left_is_that_of_any_size(form: str, size: float) -> None:
    """Unit couples beside unit forces are neither nothing nor all there is."""
    home = moved_points.three_rpr()
    found = symkin.mobility(scaled(graph_twin(home) if form == "graph" else home, size))
    assert len(found.platform_constraints) == len(found.platform_twists) == 3
    for twist in found.platform_twists:
        for wrench in found.platform_constraints:
            assert abs(reciprocal_product(twist, wrench)) < 1e-9 * size


def _screw(joint: Joint) -> np.ndarray:
    axis = np.array(joint.axis)
    return (
        prismatic_screw(axis) if joint.type == "P" else revolute_screw(np.array(joint.point), axis)
    )


def test_the_couples_of_the_trt_limbs() -> None:
    """Each TRT limb exerts one horizontal couple normal to its revolutes; three couples have rank 2
    (Zhao 2000).
    """
    found = symkin.mobility(symkin.load("zhao2000_links"))
    directions = [(1, 0), (-0.5, math.sqrt(3) / 2), (-0.5, -math.sqrt(3) / 2)]
    for screws, (x, y) in zip(found.limbs[:3], directions, strict=True):
        (couple,) = screws.constraints
        np.testing.assert_allclose(couple[[0, 1, 2, 5]], 0.0, atol=1e-9)
        assert abs(couple[3] * x + couple[4] * y) < 1e-9
    assert len(found.platform_constraints) == 2


@pytest.mark.parametrize(
    "name", [name for name in symkin.shipped_names() if symkin.load(name).platform_link is not None]
)
def test_platform_twists_and_constraints_make_six(name: str) -> None:
    """A screw system and its reciprocal one have dimensions that add up to six, and do no work on
    each other.
    """
    found = symkin.mobility(symkin.load(name))
    assert len(found.platform_constraints) + len(found.platform_twists) == 6
    for wrench in found.platform_constraints:
        for twist in found.platform_twists:
            assert (
                abs(reciprocal_product(twist, wrench)) < 1e-8 * found.closure.characteristic_length
            )


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_loops_of_every_mechanism(name: str) -> None:
    """Joints - links + 1 loops are independent, of limbs as of graphs; none has more redundant rows
    by itself than its own.
    """
    found = symkin.mobility(symkin.load(name))
    told = found.to_dict()
    assert len(told["each_loop"]) == told["loops"] == told["joints"] - told["links"] + 1
    assert all(0 <= loop.rank <= loop.rows <= 6 for loop in found.loops)


def test_limbs_that_cannot_close_say_by_how_much() -> None:
    """A delta's platform does not turn, so that the two rods of a limb are equal vectors: of
    lengths that differ by 200 one is wrong by 100 at least.
    """
    machine = delta()
    first, second = machine.limbs[0].rods
    uneven = [replace(first, length=120.0), replace(second, length=320.0)]
    apart = replace(machine, limbs=[replace(machine.limbs[0], rods=uneven), *machine.limbs[1:]])
    found = symkin.mobility(apart)
    assert not found.closed
    assert found.misfit is not None
    assert 100.0 <= found.misfit.length < 200.0
    assert "limb1" in found.misfit.loop
    assert "no configuration closes the loops" in describe(apart)
    assert found.to_dict()["misfit"] == found.misfit.length


def test_rank_counts_singular_values() -> None:
    """Rank 2 with a clear gap and a share of a half; an empty matrix has rank 0; a doubtful gap is
    measured.
    """
    assert Rank.of(np.diag([1.0, 0.5, 1e-12])) == Rank(2, 0.5 / 1e-12, least=0.5)
    assert Rank.of(np.zeros((0, 3))).value == 0
    assert Rank.of(np.diag([1.0, 1e-7, 1e-9])).gap == pytest.approx(100.0)


def test_the_generic_rank_is_met_off_singular_places() -> None:
    """A planar arm of two revolutes has rank 2 but where it is straight, in whatever order the
    places come; where a place that should be singular is found to the root of rounding only, its
    rank is too large and not the generic one.
    """

    def arm(first: float, elbow: float) -> Rank:
        slopes = [np.array([-math.sin(a), math.cos(a)]) for a in (first, first + elbow)]
        return Rank.of(np.column_stack([slopes[0] + slopes[1], slopes[1]]))

    straight, bent = [arm(0.3, 0.0), arm(1.1, math.pi)], [arm(0.3, 1.0), arm(2.0, -0.7)]
    assert ([rank.value for rank in straight], [rank.value for rank in bent]) == ([1, 1], [2, 2])
    for ranks in (straight + bent, bent + straight, [straight[0], bent[0], straight[1]]):
        assert ranks[generic(ranks)].value == 2
    found = [Rank.of(np.diag([1.0, 1e-7])), Rank.of(np.diag([1.0, 0.0]))]
    assert [rank.value for rank in found] == [2, 1]
    assert generic(found) == generic(found[::-1]) + 1 == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [name for name in symkin.shipped_names() if not symkin.load(name).is_graph]
)
def test_show_prints_what_is_promised(name: str) -> None:
    """`show` names limbs, equations, unknowns, rank, mobility, redundant constraints and reciprocal
    screws.
    """
    text = describe(symkin.load(name))
    for word in (
        "Limbs",
        "equations",
        "unknowns",
        "rank",
        "mobility",
        "redundant constraints",
        "Reciprocal screws",
    ):
        assert word in text


def test_show_warns_when_inputs_are_not_the_mobility() -> None:
    """Fewer actuated joints than the mobility: a warning names both numbers."""
    joints = [
        Joint("a", "R", (0, 0, 0), (0, 0, 1), actuated=True),
        Joint("b", "R", (1, 0, 0), (0, 0, 1)),
    ]
    text = describe(
        Mechanism(
            "open_chain",
            [Limb("only", [*joints, Joint("c", "R", (2, 0, 0), (0, 0, 1))])],
            (2, 0, 0),
        )
    )
    assert "1 actuated joint for a mobility of 3" in text


def four_ruu(motion: str) -> Mechanism:
    """Four limbs R U U about a vertical axis, knees and ankles turned by 10 degrees: four couples
    about horizontal axes, of rank two.
    """
    limbs = []
    for k in range(4):
        t = math.radians(45 + 90 * k)
        out, side = np.array([math.cos(t), math.sin(t), 0.0]), (-math.sin(t), math.cos(t), 0.0)
        ankle = (80 * math.cos(t + math.radians(10)), 80 * math.sin(t + math.radians(10)), -300.0)
        joints = [
            Joint(f"motor{k}", "R", tuple(200 * out), side, actuated=True),
            Joint(f"knee{k}", "U", tuple(330 * out), side, axis2=(0.0, 0.0, 1.0)),
            Joint(f"ankle{k}", "U", ankle, (0.0, 0.0, 1.0), axis2=side),
        ]
        limbs.append(Limb(f"limb{k}", joints))
    return Mechanism("ruu4", limbs, platform_position=(0.0, 0.0, -300.0), motion=motion)


def test_branches_that_meet_at_the_reference_are_told():
    """With the turn about z free, translations (three freedoms) and a screw-like motion (one) meet
    at the reference; with translations declared there is one branch alone.
    """
    told = symkin.mobility(four_ruu("schoenflies"))
    assert {told.mobility, *(told.freedoms - rank for rank in told.other_ranks)} == {1, 3}
    assert any("branches meet near the reference" in warning for warning in told.warnings)
    alone = symkin.mobility(four_ruu("translation"))
    assert (alone.mobility, alone.other_ranks) == (3, ())
    assert not any("branches" in warning for warning in alone.warnings)


@pytest.mark.parametrize(
    "name", ["zhao2000_links", "delta", "jansen_leg", "bricard", "goldberg", "zhang2009"]
)
def test_one_branch_is_not_called_two(name):
    assert symkin.mobility(symkin.load(name)).other_ranks == ()
