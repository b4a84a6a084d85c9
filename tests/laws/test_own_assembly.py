"""Mobility is that of the assembly that a file describes: families of known mobility, branches that
meet, and steps that lead away.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import symkin

# the families and their independent judge are those of the campaign
from campaigns.mobility_families import FAMILIES, Machine, drawn, wrong
from helpers.gate import in_gate
from helpers.inside import (
    assembly_of,
    build_closure,
    closed_configurations,
    describe,
    file_digits,
    least_squares_from,
    must_agree,
    own_component,
    parse,
    rank_to_digits,
    whole_system,
)
from symkin import InputError, Joint, Limb, LinkJoint, Mechanism

Z = (0.0, 0.0, 1.0)


@pytest.mark.parametrize("index", in_gate([0, 1], [0]))
@pytest.mark.parametrize("family", [make.__name__ for make in FAMILIES])
def test_mobility_is_that_of_theory_whatever_the_seed(family: str, index: int) -> None:
    """Parallel cranks, Bricard's loops and octahedra, equal rods, and their rigid siblings; with
    random and with round numbers.
    """
    machine, placed = drawn(index, 7, family)
    assert wrong(placed.text(), machine, 2) == []


def three_cranks(*, last: float = 60.0) -> str:
    """A lift of round numbers, whose cross-wise assembly least squares from far off finds; the last
    crank of another length.
    """
    pivots = np.array([[0.0, 0.0, 0.0], [150.0, 50.0, 0.0], [140.0, 40.0, 0.0]])
    joints = []
    for k, (pivot, arm) in enumerate(zip(pivots, (60.0, 60.0, last), strict=True)):
        joints += [
            ("base", f"c{k}", pivot, np.array(Z)),
            (f"c{k}", "plate", pivot - [arm, 0.0, 0.0], np.array(Z)),
        ]
    return Machine("cranks", 1, tuple(joints)).text()


def test_a_lift_is_not_refused() -> None:
    """Cranks of a platform turn alike: each by what the first is given."""
    machine = parse(three_cranks())
    (mode,) = symkin.modes(machine, given={"j0": 0.5})
    assert [mode.joints[name] for name in ("j2", "j4")] == pytest.approx([0.5, 0.5])
    assert symkin.jacobian(machine, of=["j4"], by=["j0"]).at(mode) == pytest.approx(1.0)
    assert symkin.solve(machine, given={"j0": 0.2}).status == "ok"


def test_a_rigid_sibling_is_called_shaky() -> None:
    """A third crank of another length lets the lift begin to move and stops it at second order."""
    found = symkin.mobility(parse(three_cranks(last=75.0)))
    assert (found.mobility, found.infinitesimal, found.freedoms - found.rank.value) == (0, 1, 1)
    assert any("no motion leads away from the reference" in warning for warning in found.warnings)
    assert "mobility = 4 - 3 - 1 of first order alone = 0" in describe(found.closure.mechanism)
    assert found.to_dict()["generic"]["mobility"] == 0


def test_other_assemblies_are_told_apart_from_branches() -> None:
    """The cross-wise assembly of a lift is rigid and does not meet the one that turns: it is told
    as another assembly, if at all.
    """
    machine = parse(three_cranks())
    found = symkin.mobility(machine)
    assert found.mobility == 1
    assert found.other_ranks == ()
    assert set(found.ranks_apart) <= {4}
    assert not any("branches meet" in warning for warning in found.warnings)


def four_bar(*across: float) -> Mechanism:
    """Pivots and pins on one line: base, crank pin, coupler pin, base."""
    a, b, c, d = ((x, 0.0, 0.0) for x in across)
    left = Limb("left", [Joint("crank", "R", a, Z, actuated=True), Joint("pin", "R", b, Z)])
    return Mechanism(
        "flat",
        [left, Limb("right", [Joint("rocker", "R", d, Z), Joint("top", "R", c, Z)])],
        platform_position=b,
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_folded_parallelogram_moves(seed: int) -> None:
    """Two branches of one mobility meet at a flat reference: as parallelogram and crossed."""
    found = symkin.mobility(four_bar(0.0, 1.0, 4.0, 3.0), seed=seed)
    assert (found.mobility, found.infinitesimal, found.other_ranks) == (1, 0, ())
    assert found.reference_rank is not None
    assert found.reference_rank.value < found.rank.value


@pytest.mark.parametrize("seed", range(3))
def test_a_stretched_chain_is_rigid(seed: int) -> None:
    """Crank, coupler and rocker as long together as the base: nothing moves, in whatever direction
    first order would let it.
    """
    found = symkin.mobility(four_bar(0.0, 1.0, 2.5, 4.0), seed=seed)
    assert found.mobility == 0
    assert found.infinitesimal == found.freedoms - found.rank.value > 0


@pytest.mark.parametrize(
    "name", ["four_bar", "bennett", "zhao2000_links", "delta", "jansen_leg", "ur5e"]
)
def test_configurations_are_closed_apart_and_of_one_rank(name: str) -> None:
    """Walks end at closed configurations off the reference, no two alike; the rank is the same at
    all of them.
    """
    closure = build_closure(symkin.load(name))
    system, points = whole_system(closure), np.array(closed_configurations(closure, 5))
    size = closure.characteristic_length
    assert system.residuals(points, np.zeros(0)).max() < 1e-10 * size
    away = np.linalg.norm(
        system.difference(np.tile(closure.reference, (len(points), 1)), points), axis=1
    )
    assert away.min() > 0.01 * size
    assert len(np.unique(points.round(9), axis=0)) == len(points) > 12
    values = np.linalg.svd(system.linearise(points, np.zeros(0))[1], compute_uv=False)
    assert set((values > 1e-8 * values[:, :1]).sum(axis=1)) <= {
        own_component(assembly_of(closure), 5).rank.value
    }  # type: ignore[union-attr]


def two_legs(quarter: float) -> str:
    """Two five-bars between coaxial motors, the knees universal joints with parallel second axes,
    one beside the other; `quarter` turns the motors' axes off their forward direction.
    """
    forward, across = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    joints = []
    for leg, middle in (("a", 300.0), ("b", -300.0)):
        for k, side in enumerate((-1.0, 1.0)):
            crank, cross, shank = (f"{leg}{part}{k}" for part in ("crank", "cross", "shank"))
            axis = np.array([side * np.cos(quarter), np.sin(quarter), 0.0])
            knee = np.array([middle + 95.0 * side, 131.0 - 9.0 * k, -18.5])
            joints += [
                ("base", crank, np.array([middle, 155.0 - 55.0 * k, -18.5]), axis),
                (crank, cross, knee, across),
                (cross, shank, knee, forward),
            ]
        joints.append((f"{leg}shank0", f"{leg}shank1", np.array([middle, 126.5, -183.0]), across))
    return Machine("two_legs", 4, tuple(joints)).text()


@pytest.mark.parametrize(
    "quarter", in_gate([np.pi / 2, 1.57075, 1.5708, 1.5707], [np.pi / 2, 1.57075])
)
def test_mobility_to_digits_is_that_of_exact_numbers_whatever_the_seed(quarter: float) -> None:
    """A five-bar has two freedoms and a redundant constraint, wherever it goes, and three freedoms
    of first order at the reference, where the knees' second axes are parallel. Motors whose axes
    are off by the digits of a quarter turn close nowhere else exactly.
    """
    machine = parse(two_legs(quarter))
    for seed in range(3):
        found = symkin.mobility(machine, seed=seed)
        assert (found.mobility, found.redundant, found.infinitesimal) == (4, 2, 0)
        assert found.reference_rank is not None
        assert found.freedoms - found.reference_rank.value == 6
        assert (found.digits is not None) == (quarter != np.pi / 2)
    if found.digits is not None:
        assert "at the reference, which is singular, it is 6" in found.warnings[0]
        assert found.to_dict()["generic"]["mobility"] == found.to_dict()["to_digits"]["mobility"]
        closure = found.closure
        system, rank = whole_system(closure), found.reference_rank.value
        for seed in range(5):
            ends = least_squares_from(system, closure.reference, seed)
            digits = rank_to_digits(system, ends, rank)
            assert digits is not None
            assert found.freedoms - digits.rank == 4


def test_a_result_says_each_note_once() -> None:
    """Whatever steps of a verb add, in the order in which it is said first."""
    (mode,) = symkin.modes(parse(three_cranks()), given={"j0": 0.5})
    assert replace(mode, notes=("first", "second", "first")).notes == ("first", "second")


def test_difference_is_the_inverse_of_move() -> None:
    """move(z, difference(z, there)) = there, of lengths, angles and rotations."""
    rng = np.random.default_rng(3)
    system = whole_system(build_closure(symkin.load("zhao2000_links")))
    z = system.move(
        np.tile(build_closure(symkin.load("zhao2000_links")).reference, (5, 1)),
        rng.normal(size=(5, system.freedom)),
    )
    step = rng.normal(size=(5, system.freedom))
    np.testing.assert_allclose(system.difference(z, system.move(z, step)), step, atol=1e-11)


def test_ranks_of_which_none_is_frequent_are_not_clear() -> None:
    """Five configurations of five ranks: the middle one is told, and that it is not clear."""
    jacobians = np.array([np.diag([1.0] * k + [0.0] * (5 - k)) for k in range(1, 6)])
    assert file_digits._generic(jacobians, np.full(5, 1e-6)) == (3, False)
    alike = jacobians[[4, 4, 3, 0, 1]]
    assert file_digits._generic(alike, np.full(5, 1e-6)) == (5, True)


def carried_taut() -> Mechanism:
    """A stretched four-bar, which first order would let move twice, on a crank that turns."""
    pins = [("a", 100, "crank", "l1"), ("b", 200, "l1", "l2"), ("c", 250, "l2", "l3")]
    crank = [("q", 0, "base", "crank"), ("q2", 0, "crank", "base")]
    joints = [
        LinkJoint(Joint(name, "R", (x, 0.0, 0.0), Z), links)
        for name, x, *links in (*crank, *pins, ("d", 400, "l3", "crank"))
    ]
    return Mechanism("taut", link_joints=joints)


def test_what_no_motion_follows_is_not_said_to_be_free() -> None:
    """One value decides the only motion, and the configuration is listed; it has no rates."""
    machine = carried_taut()
    assert symkin.mobility(machine).infinitesimal == 2
    (mode,) = symkin.modes(machine, given={"q": 0.3}, starts=60)
    assert [mode.joints[n] for n in ("q2", "a", "b", "c", "d")] == pytest.approx(
        [-0.3, 0.0, 0.0, 0.0, 0.0], abs=1e-6
    )
    with pytest.raises(InputError, match=r"leaves taut 1 freedom, .* give 1 more, for example q"):
        symkin.modes(machine, given={"b": 0.0})
    with pytest.raises(InputError, match="2 freedoms of first order, which no motion follows"):
        symkin.jacobian(machine, of=["b"], by=["q"])


def test_a_rigid_machine_of_first_order_freedoms_is_listed() -> None:
    """Its one configuration, whether nothing is given or what first order leaves."""
    machine = four_bar(0.0, 1.0, 2.5, 4.0)
    for given in ({}, {"crank": 0.0}):
        (mode,) = symkin.modes(machine, given=given, starts=60, method="multistart")
        assert mode.joints["pin"] == pytest.approx(0.0, abs=1e-6)


def kite(motion: str = "planar") -> Mechanism:
    """Crank and base lie on each other: rocker and coupler turn about both their ends and the crank
    stands.
    """
    joints = [
        Joint("crank", "R", (0.0, 0.0, 0.0), Z, actuated=True),
        Joint("pin", "R", (1.0, 0.0, 0.0), Z),
        Joint("rocker", "R", (1.0, 0.0, 0.0), Z),
        Joint("top", "R", (1.0, 0.6, 0.0), Z),
    ]
    return Mechanism(
        "kite",
        [Limb("left", joints[:2]), Limb("right", joints[2:])],
        platform_position=(1.0, 0.6, 0.0),
        angle_unit="deg",
        motion=motion,
    )


@pytest.mark.parametrize("motion", in_gate(["planar", "spatial"], ["planar"]))
def test_what_is_free_about_the_reference_alone_is_searched(motion: str, tmp_path: Path) -> None:
    """Rocker and coupler of a kite meet at two points at other angles of the crank than the
    reference's, by `modes` as in a sweep.
    """
    folded = kite(motion)
    found = symkin.modes(folded, joints=[20.0])
    assert (len(found), found.completeness) == (2, "proved")
    half = np.array([np.cos(np.radians(20.0)) + 1.0, np.sin(np.radians(20.0))]) / 2.0
    places = np.array([mode.pose.position[:2] for mode in found])
    assert np.mean(places, axis=0) == pytest.approx(half)
    assert any("about the reference" in note for note in found.notes)
    # one value has no other to agree with
    assert (
        must_agree(folded) == "about the reference the actuated joints cannot all move on their own"
    )
    swept = symkin.sweep(folded, {"crank": [1e-5, 20.0]}, tmp_path, workers=0)
    assert swept.points_by_count == {2: 2}


def test_what_moves_in_another_motion_may_be_given() -> None:
    """A four-bar whose hinge c also spreads a kite, folded at the reference: the four-bar stands
    still there and the kite turns. Elsewhere both move: each turn of c leaves the four-bar, which
    is a triangle then, two places, and the kite two. A triangle's hinge never moves.
    """
    places = {
        "a": (("base", "p"), (0.0, 0.0, 0.0)),
        "b": (("p", "q"), (0.3, 1.2, 0.0)),
        "c": (("q", "r"), (2.0, 1.5, 0.0)),
        "d": (("base", "r"), (2.2, 0.1, 0.0)),
        "e": (("r", "s"), (1.4, 2.4, 0.0)),
        "f": (("s", "t"), (2.1, 2.9, 0.0)),
        "g": (("q", "t"), (1.4, 2.4, 0.0)),
    }
    joints = [
        LinkJoint(Joint(name, "R", point, Z), links) for name, (links, point) in places.items()
    ]
    machine = Mechanism("two_motions", link_joints=joints)
    for angle in (20.0, 1e-9):
        found = symkin.modes(machine, given={"c": angle})
        assert (len(found), found.completeness, found.complex_count) == (4, "proved", 4)
        assert not any("double" in note for mode in found for note in mode.notes)
    found = symkin.modes(machine, given={"c": 20.0})
    near = symkin.solve(machine, given={"c": 20.0}, start=found[0].values)
    assert (near.status, near.notes) == ("ok", ())
    assert symkin.track(machine, given={"c": [20.0, 20.5]}, start=found[0], samples=3).reached
    still = [*joints[:2], LinkJoint(joints[2].joint, ("q", "base")), joints[3]]
    triangle = Mechanism("triangle", link_joints=still)
    for verb, turn in ((symkin.modes, 20.0), (symkin.solve, 0.0), (symkin.track, [0.0, 20.0])):
        with pytest.raises(InputError, match="no motion about the reference moves a; leave it out"):
            verb(triangle, given={"a": turn})


def test_a_regular_start_is_followed_whatever_is_free_about_the_reference() -> None:
    """A kite's modes at other angles of the crank are followed to where it is folded; there no
    mode is isolated.
    """
    folded = kite()
    there = symkin.track(folded, joints=[[20.0], [40.0]], samples=3)
    assert (there.reached, there.certified) == (True, True)
    back = symkin.track(folded, joints=[[20.0], [0.0]], samples=3)
    assert back.stop is not None
    assert (back.stop.kind, back.stop.row, back.stop.u) == ("bifurcation", 1, 1.0)
    # of one that is isolated it is not said that it is one of a set
    assert not any("one of a set" in n for n in symkin.solve(folded, joints=[20.0]).notes)
    assert any("one of a set" in n for n in symkin.solve(folded, joints=[0.0]).notes)
    with pytest.raises(InputError, match="no isolated mode to stay on"):
        symkin.track(folded, joints=[[0.0], [20.0]])


@pytest.mark.parametrize("apart", [1.0, 1e-2, 1e-5, 1e-9, 1e-12])
def test_a_kite_has_two_modes_however_nearly_it_is_folded(apart: float) -> None:
    """Circles of equal radii 0.6 about ends a apart, a the crank's angle, meet square to the way
    between these: the rocker stands at 90 - a / 3 and -90 + 4 a / 3, in first order.
    """
    found = symkin.modes(kite(), joints=[apart])
    assert found.completeness == "proved"
    assert sorted(mode.joints["rocker"] for mode in found) == pytest.approx(
        [4.0 * apart / 3.0 - 90.0, 90.0 - apart / 3.0], abs=1e-13 + 1e-3 * apart
    )
    # nothing that is said contradicts two proved modes
    assert not any("double" in note or "multiple" in note for mode in found for note in mode.notes)
    assert all("where there are any" in note for note in found.notes if "not isolated" in note)


@pytest.mark.parametrize("apart", [1e-9, 1e-12, 0.0])
def test_what_rounding_hides_is_not_said_of_the_machine(apart: float) -> None:
    """A kite that is unfolded at the reference and folded but for so many degrees: what is said of
    multiple solutions and of sets is said as far as rounding tells.
    """
    cos, sin = np.cos(0.7), np.sin(0.7)
    middle, across = np.array([1.0 + cos, sin]) / 2.0, np.array([-sin, cos - 1.0])
    top = middle - across / np.hypot(*across) * np.sqrt(0.36 - across @ across / 4.0)
    places = {"crank": (0, 0), "pin": (cos, sin), "top": tuple(top), "rocker": (1, 0)}
    links = ["base", "k", "c", "r", "base"]
    joints = [
        LinkJoint(Joint(name, "R", (*place, 0.0), Z, actuated=name == "crank"), pair)
        for (name, place), pair in zip(places.items(), pairwise(links), strict=True)
    ]
    unfolded = Mechanism("kite", link_joints=joints, angle_unit="deg")
    found = symkin.modes(unfolded, joints=[apart - np.degrees(0.7)])
    assert found.completeness != "proved" or len(found) == 2
    said = [*found.notes, *(note for mode in found for note in mode.notes)]
    strong = [n for n in said if n.startswith("double") or "not isolated" in n]
    assert strong or found.completeness == "proved"
    assert all("rounding" in note for note in strong)
