"""Limbs: rods, chains, and every description that cannot be right."""

import math

import numpy as np
import pytest
from hypothesis import given

from helpers.laws import refused_in_one_line
from helpers.samples import point, random_joint, seeds
from symkin import Joint, Limb, LinkRod, Pose, Rod, RodLimb


@given(seeds)
def test_limbs_are_values(rng):
    """Lists and tuples make equal limbs with equal hashes."""
    joints = [random_joint(rng, kind, f"j{k}") for k, kind in enumerate("RPHCUS")]
    start, end = point(rng), point(rng)
    one, other = (
        Limb("l", joints, [Rod(start, end)]),
        Limb("l", tuple(joints), (Rod(list(start), list(end)),)),
    )
    assert one == other
    assert hash(one) == hash(other)
    assert RodLimb("l", start, end) == RodLimb("l", list(start), list(end))
    assert hash(RodLimb("l", start, end)) == hash(RodLimb("l", list(start), list(end)))


def test_type_spells_the_joints():
    """The type is the joints' letters from base to platform; rods are counted behind."""
    revolute, ball = Joint("r", "R", axis=(0, 0, 1)), Joint("s", "S")
    assert Limb("l", [revolute, ball]).type == "RS"
    rods = Limb("l", [revolute], [Rod((0, 0, 0), (1, 0, 0)), Rod((0, 1, 0), (1, 1, 0))]).type
    assert rods.startswith("R")
    assert "2" in rods


@pytest.mark.parametrize("kind", ["SPS", "UPS", "SPU"])
def test_a_rod_limb_has_one_actuated_length(kind):
    """Its coordinate is named as the limb, and its least value makes a rod of length zero: offset +
    value = 0.
    """
    limb = RodLimb("leg", (0, 0, 0), (0, 0, 1), offset=3.0, limits=[1, 2], type=kind)
    (bar,) = limb.bars(Pose(np.array([0.0, 0.0, 9.0]), np.array([1.0, 0.0, 0.0, 0.0])))
    c = bar.coordinate
    assert (c.name, c.kind, c.role, c.reference, c.limits) == (
        "leg",
        "length",
        "actuated",
        (7.0,),
        (1.0, 2.0),
    )
    assert c.least + limb.offset == 0.0


@given(seeds)
def test_rods_of_every_kind_are_bars(rng):
    """A leg, a rod at a limb's end and a rod between links have the same ends, and coordinates that
    are their lengths there.
    """
    start, end, origin = point(rng), point(rng), point(rng)
    pose = Pose(np.array(origin), np.array([1.0, 0.0, 0.0, 0.0]))
    away = tuple(e - o for e, o in zip(end, origin, strict=True))
    (leg,) = RodLimb("leg", start, away, offset=2.0).bars(pose)
    limb = Limb("limb", [random_joint(rng, "R", "r")], [Rod(start, away)])
    between = LinkRod("leg", ["base", "foot"], start, end, actuated=True, offset=2.0).bar
    for bar in (leg, *limb.bars(pose), between):
        assert bar.places[0] == pytest.approx(start)
        assert bar.places[1] == pytest.approx(end)
    for bar in (leg, between):
        assert bar.coordinate.reference[0] + bar.offset == pytest.approx(math.dist(start, end))
    assert RodLimb("leg", start, away).joints == ()


BAD = {
    "type": (
        lambda: RodLimb("leg", (0, 0, 0), (0, 0, 1), type="RPS"),
        ["'leg'", "'RPS'", "SPS, UPS, SPU"],
    ),
    "base": (lambda: RodLimb("leg", (0, 0), (0, 0, 1)), ["'leg'", "base", "[0, 0]", "three"]),
    "platform": (lambda: RodLimb("leg", (0, 0, 0), "abc"), ["'leg'", "platform", "'a'", "number"]),
    "offset": (
        lambda: RodLimb("leg", (0, 0, 0), (0, 0, 1), math.nan),
        ["'leg'", "offset", "nan", "finite"],
    ),
    "limits": (
        lambda: RodLimb("leg", (0, 0, 0), (0, 0, 1), limits=(2, 1)),
        ["'leg'", "limits", "[2.0, 1.0]"],
    ),
    "no joints": (lambda: Limb("arm", []), ["'arm'", "no joint"]),
    "rod from": (lambda: Rod((0, math.inf, 0), (0, 0, 0)), ["rod", "from", "inf"]),
    "rod platform": (lambda: Rod((0, 0, 0), (0, 0)), ["rod", "platform", "three"]),
    "rod length negative": (
        lambda: Rod((0, 0, 0), (0, 0, 1), -2.0),
        ["rod", "length", "-2.0", "positive"],
    ),
    "rod length zero": (
        lambda: Rod((0, 0, 0), (0, 0, 1), 0.0),
        ["rod", "length", "0.0", "positive"],
    ),
    "rod length NaN": (lambda: Rod((0, 0, 0), (0, 0, 1), math.nan), ["rod", "length", "nan"]),
}


@pytest.mark.parametrize(
    "between",
    [
        [],
        [Joint("r", "R", (2.0, 3.0, 4.0), (0, 0, 5))],
        [Joint("u", "U", (2.0, 3.0, -1.0), (1, 0, 0), (0, 1, 0))],
    ],
)
def test_balls_that_nothing_parts_are_refused(between):
    """Two spherical joints at one centre, with joints between that leave it at rest, keep a
    distance that is always zero.
    """
    centre = (2.0, 3.0, -1.0)
    first, last = Joint("s1", "S", centre), Joint("s2", "S", centre)
    arm = Joint("r0", "R", (0, 0, 0), (0, 0, 1), actuated=True)
    refused_in_one_line(
        lambda: Limb("l", [arm, first, *between, last]), ["'l'", "'s1'", "'s2'", "one point"]
    )
    parting = Joint("p", "P", centre, (1, 0, 0))
    assert Limb("l", [arm, first, parting, last]).type == "RSPS"
    assert Limb("l", [arm, first, Joint("s2", "S", (2.0, 3.0, 0.0))]).type == "RSS"


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_names_offender_value_and_choice(case):
    """MechanismError in one line."""
    refused_in_one_line(*BAD[case])
