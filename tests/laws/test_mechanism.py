"""Mechanisms: layout only, frozen, hashable, printable; size; checks."""

import math
import os
import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given

import symkin
from helpers.laws import act, frame, refused_in_one_line
from helpers.samples import delta, pieper, point, random_mechanism, seeds, unit
from symkin import (
    DHTable,
    Example,
    Joint,
    Limb,
    LinkJoint,
    Mechanism,
    MechanismError,
    Rod,
    RodLimb,
    mobility,
)

LIMBS = ["rRS", "SPS", "pU", "hC", "SPS"]
LEG = RodLimb("leg", (0, 0, 0), (0, 0, 1))
TURN = Joint("turn", "R", axis=(0, 0, 1))


@given(seeds)
def test_a_mechanism_is_a_frozen_value(rng):
    """Equal layouts are equal, hash alike and print alike; no field can be set."""
    one = random_mechanism(rng, LIMBS)
    again = Mechanism(**vars_of(one))
    assert one == again
    assert hash(one) == hash(again)
    assert str(one) == str(again)
    with pytest.raises(FrozenInstanceError):
        one.name = "other"
    assert replace(one, name="other") != one


def test_a_mechanism_is_a_key_in_another_process():
    """Where texts have other hashes."""
    machine = delta()
    hash(machine)
    look = (
        "import pickle, sys; from dataclasses import replace; "
        "one = pickle.load(sys.stdin.buffer); print(hash(one) == hash(replace(one)))"
    )
    told = [
        subprocess.run(
            [sys.executable, "-c", look],
            input=pickle.dumps(machine),
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout.split()
        for seed in ("1", "2")
    ]
    assert told == [[b"True"]] * 2


def vars_of(mechanism):
    return {name: getattr(mechanism, name) for name in mechanism.__dataclass_fields__}


@given(seeds)
def test_text_names_mechanism_and_limbs(rng):
    """str holds the name, every limb and its type, and the units."""
    mechanism = random_mechanism(rng, LIMBS)
    for fragment in [
        "sample",
        "mm",
        "rad",
        *(limb.name for limb in mechanism.limbs),
        *(limb.type for limb in mechanism.limbs),
    ]:
        assert fragment in str(mechanism)


@pytest.mark.parametrize("name", symkin.shipped_names())
def test_actuated_coordinates_stand_in_file_order(name):
    """Limb after limb, joint after joint, rod after rod, actuated ones only."""
    mechanism = symkin.load(name)
    order = []
    for limb in mechanism.limbs:
        order += (
            [limb.name]
            if isinstance(limb, RodLimb)
            else [j.name for j in limb.joints if j.actuated]
        )
    order += [
        c.name
        for entry in mechanism.link_joints
        if entry.joint.actuated
        for c in entry.joint.coordinates
    ]
    order += [rod.name for rod in mechanism.link_rods if rod.actuated]
    assert [c.name for c in mechanism.actuated] == order


# --- size -----------------------------------------------------------------------------------------


@given(seeds)
def test_size_is_the_largest_distance_between_joint_points(rng):
    """Rod ends on the platform are taken at the reference pose."""
    mechanism = random_mechanism(rng, LIMBS)
    reference = frame(mechanism.platform_position, mechanism.platform_quaternion)
    points = [np.array(j.point) for _, j in mechanism.joints]
    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            points += [np.array(limb.base), act(reference, limb.platform)]
    assert math.isclose(
        mechanism.characteristic_length,
        max(np.linalg.norm(a - b) for a, b in combinations(points, 2)),
        rel_tol=1e-12,
    )


@pytest.mark.slow
@given(seeds)
def test_size_scales_and_does_not_turn(rng):
    """Twice the lengths: twice the size."""
    ends = [(np.array(point(rng)), np.array(point(rng))) for _ in range(4)]
    sizes = [
        Mechanism(
            "m", [RodLimb(f"l{k}", s * b, s * p) for k, (b, p) in enumerate(ends)]
        ).characteristic_length
        for s in (1.0, 2.0)
    ]
    assert math.isclose(sizes[1], 2 * sizes[0], rel_tol=1e-12)
    q = unit(rng, 4)
    r = frame((0, 0, 0), q)
    turned = Mechanism(
        "m",
        [RodLimb(f"l{k}", act(r, b), p) for k, (b, p) in enumerate(ends)],
        platform_quaternion=q,
    )
    assert math.isclose(turned.characteristic_length, sizes[0], rel_tol=1e-9)


def test_size_of_coinciding_points_is_positive():
    """All joints in one point: the distance to the platform, or 1."""
    limb = Limb("l", [TURN])
    assert Mechanism("m", [limb], platform_position=(3, 4, 0)).characteristic_length == 5.0
    assert Mechanism("m", [limb]).characteristic_length == 1.0


def test_points_that_differ_by_rounding_are_one_point():
    """A spherical five-bar whose axes meet but for rounding was 1e-16 across, and its rounding a
    share of that: it had no freedom.
    """
    axes = [(1, 0, 0.1), (0.8, 0.5, 0.4), (0.2, 0.9, 0.8), (-0.5, 0.8, 0.3), (-1, 0.1, 0.2)]
    links = ["base", "a", "b", "c", "d", "base"]
    joints = [
        LinkJoint(Joint(f"j{k}", "R", (0.1, 0.2 + k % 2 * 6e-17, 0.3), axis), links[k : k + 2])
        for k, axis in enumerate(axes)
    ]
    machine = Mechanism("five", link_joints=joints)
    assert math.isclose(machine.characteristic_length, math.sqrt(0.14))  # to the origin
    assert mobility(machine).mobility == 2


@given(seeds)
def test_reference_rod_value_is_distance_less_offset(rng):
    """|t + R a - b| - offset at the reference pose."""
    limb = RodLimb("leg", point(rng), point(rng), offset=float(rng.uniform(-5, 5)))
    mechanism = Mechanism(
        "m", [limb], platform_position=point(rng), platform_quaternion=unit(rng, 4)
    )
    end = act(frame(mechanism.platform_position, mechanism.platform_quaternion), limb.platform)
    assert math.isclose(
        mechanism.actuated[0].reference[0] + limb.offset, np.linalg.norm(end - np.array(limb.base))
    )


# --- units and quaternions ------------------------------------------------------------------------


def test_angle_units_are_inverse():
    """angle_in(angle_out(x)) = x; degrees are 180 / pi radians."""
    for unit_name, factor in (("deg", 180 / math.pi), ("rad", 1.0)):
        mechanism = Mechanism("m", [LEG], angle_unit=unit_name)
        assert math.isclose(mechanism.angle_out(0.3), 0.3 * factor)
        assert math.isclose(mechanism.angle_in(mechanism.angle_out(0.3)), 0.3)


@given(seeds)
def test_a_quaternion_nearly_of_unit_length_is_normalised(rng):
    """Off by less than 1e-2: the same direction, length 1; by more: refused."""
    q = np.array(unit(rng, 4))
    for factor in (0.991, 1.009):
        made = Mechanism("m", [LEG], platform_quaternion=factor * q).platform_quaternion
        assert np.allclose(made, q, atol=1e-14)
    for factor in (0.98, 1.02, 0.0):
        with pytest.raises(MechanismError, match=r"platform\.quaternion.*norm"):
            Mechanism("m", [LEG], platform_quaternion=factor * q)


BAD = {
    "name": (lambda: Mechanism("3-rps", [LEG]), ["name", "'3-rps'", "C identifier"]),
    "empty name": (lambda: Mechanism("", [LEG]), ["name", "''"]),
    "name with umlaut": (lambda: Mechanism("rüssel", [LEG]), ["name", "'rüssel'"]),
    "motion": (
        lambda: Mechanism("m", [LEG], motion="flat"),
        ["motion", "'flat'", "spatial, schoenflies, planar"],
    ),
    "length unit": (
        lambda: Mechanism("m", [LEG], length_unit="inch"),
        ["length_unit", "'inch'", "m, mm"],
    ),
    "angle unit": (
        lambda: Mechanism("m", [LEG], angle_unit="grad"),
        ["angle_unit", "'grad'", "deg, rad"],
    ),
    "no limb": (lambda: Mechanism("m", []), ["no limb"]),
    "two limbs of one name": (lambda: Mechanism("m", [LEG, LEG]), ["limbs", "'leg'"]),
    "two joints of one name": (
        lambda: Mechanism("m", [Limb("a", [TURN]), Limb("b", [TURN])]),
        ["joints", "'turn'"],
    ),
    "joint named as a rod limb": (
        lambda: Mechanism("m", [LEG, Limb("a", [replace(TURN, name="leg")])]),
        ["'leg'", "unique"],
    ),
    "empty joint name": (
        lambda: Mechanism("m", [Limb("a", [replace(TURN, name="")])]),
        ["empty name"],
    ),
    "platform position": (
        lambda: Mechanism("m", [LEG], platform_position=(0, 1)),
        ["platform.position", "three"],
    ),
    "platform quaternion": (
        lambda: Mechanism("m", [LEG], platform_quaternion=(1, 0, 0)),
        ["platform.quaternion", "four"],
    ),
    "NaN quaternion": (
        lambda: Mechanism("m", [LEG], platform_quaternion=(math.nan, 0, 0, 1)),
        ["quaternion", "nan"],
    ),
    "passive joint of an arm": (
        lambda: Mechanism("m", [Limb("m", [TURN])], serial=True),
        ["'turn'", "actuated"],
    ),
    "motion of an arm": (lambda: replace(pieper(), motion="planar"), ["motion", "serial"]),
    "motion of dh": (
        lambda: replace(symkin.load("gluon_6l3"), motion="planar"),
        ["motion", "serial"],
    ),
    "dh convention": (
        lambda: DHTable("craig", []),
        ["dh.convention", "'craig'", "standard, modified"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_names_offender_value_and_choice(case):
    """MechanismError in one line."""
    refused_in_one_line(*BAD[case])


def test_coordinate_names_are_unique():
    """A closure's coordinates are looked up by name: a U joint's 'u.1' must not meet a joint of
    that name, nor 'pose.x'.
    """
    u = Joint("u", "U", axis=(0, 0, 1), axis2=(1, 0, 0))
    for clash in ("u.1", "pose.x"):
        with pytest.raises(MechanismError, match=clash):
            Mechanism(
                "m",
                [Limb("a", [u, replace(TURN, name=clash), Joint("s", "S")])],
                platform_position=(1, 2, 3),
            )


def test_samples_are_what_they_say():
    """The shared samples are parallel or serial as named."""
    assert pieper().serial
    assert [c.name for c in delta().actuated] == ["q1", "q2", "q3"]


def test_an_example_that_cannot_be_taken_is_refused():
    """An example of the wrong count, or one that makes a rod negative, is refused where the
    mechanism is made.
    """
    rod = RodLimb("leg", (0, 0, 0), (0, 0, 1), offset=-1.0)
    with pytest.raises(MechanismError, match="rod of negative length"):
        Mechanism("sample", [rod], example=Example(joints=(0.0,)))
    with pytest.raises(MechanismError, match="2 values given"):
        Mechanism("sample", [rod], example=Example(joints=(3.0, 4.0)))


@pytest.mark.parametrize("key", ["joints", "pose", "start", "given"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_an_example_of_numbers_that_are_none_is_refused(key, value):
    numbers = (("leg", value),) if key == "given" else (0.0, value)
    place = "given.leg" if key == "given" else f"{key}[1]"
    refused_in_one_line(lambda: Example(**{key: numbers}), [f"example.{place}", "not finite"])


def test_a_rod_whose_ends_meet_at_the_reference_is_refused():
    """Its length would be read off the reference, where it is zero."""
    limb = Limb(
        "arm",
        [Joint("r", "R", (0, 0, 0), (0, 1, 0), actuated=True)],
        [Rod((10, 0, 5), (10, 0, -5))],
    )
    refused_in_one_line(lambda: Mechanism("m", [limb], (0, 0, 10)), ["'arm'", "rod 1", "one point"])
    assert Mechanism("m", [limb], (0, 0, 20)).characteristic_length > 0
