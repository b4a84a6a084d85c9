"""Joints: coordinates, freedoms, and every description that cannot be right."""

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.inside import JOINT_FORMS, JOINT_TYPES
from helpers.samples import random_joint, seeds
from oracle.product_of_exponentials import displacement
from symkin import Joint, MechanismError

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
_STEP = 1e-6
NAMES = {"R": [""], "P": [""], "H": [""], "C": [".angle", ".slide"], "U": [".1", ".2"], "S": [""]}


@pytest.mark.slow
@pytest.mark.parametrize("kind", JOINT_TYPES)
@given(rng=seeds)
def test_coordinates_carry_the_freedom(kind, rng):
    """The coordinates' freedoms sum to the joint's: 1 for R, P and H, 2 for C and U, 3 for S; names
    as documented.
    """
    joint = random_joint(rng, kind, "j")
    assert sum(c.freedom for c in joint.coordinates) == joint.freedom == JOINT_FORMS[kind].freedom
    assert [c.name for c in joint.coordinates] == ["j" + suffix for suffix in NAMES[kind]]
    assert all(len(c.reference) == c.width for c in joint.coordinates)
    if joint.freedom == 1:
        assert joint.coordinates[0].reference == (joint.zero,)


@given(seeds, st.sampled_from(JOINT_TYPES))
def test_screws_are_the_velocities_of_displacements(rng, kind):
    """The twist of each freedom is the derivative of the joint's displacement at the reference, by
    differences of matrix exponentials.
    """
    joint = random_joint(rng, kind, "j")
    axes = [np.array(axis) for axis in (joint.axis, joint.axis2) if axis is not None]
    screws = joint.form.screws(np.array(joint.point), axes, joint.pitch)
    rest = {c.name: c.reference if c.width == 4 else c.reference[0] for c in joint.coordinates}
    steps = [
        {c.name: (1.0, *(0.5 * _STEP * row))} if c.width == 4 else {c.name: rest[c.name] + _STEP}
        for c in joint.coordinates
        for row in np.eye(3)[: c.freedom]
    ]
    for screw, step in zip(screws, steps, strict=True):
        twist = (displacement(joint, rest | step) - np.eye(4)) / _STEP
        velocity = [twist[2, 1], twist[0, 2], twist[1, 0], *twist[:3, 3]]
        np.testing.assert_allclose(velocity, screw, atol=1e-4 * max(1.0, np.abs(screw).max()))


@given(st.tuples(*[st.floats(-1e3, 1e3)] * 3).filter(lambda v: math.hypot(*v) > 1e-3))
def test_axes_are_normalised_and_stay_so(axis):
    """|axis| = 1, the direction stays, and normalising again changes no bit (files come back
    equal).
    """
    once = Joint("j", "R", axis=axis).axis
    assert math.isclose(math.hypot(*once), 1.0, rel_tol=1e-15)
    assert all(
        math.isclose(a * math.hypot(*axis), b, rel_tol=1e-12, abs_tol=1e-12)
        for a, b in zip(once, axis, strict=True)
    )
    assert Joint("j", "R", axis=once).axis == once


@given(seeds, st.sampled_from(JOINT_TYPES))
def test_a_joint_is_a_frozen_value(rng, kind):
    """Equal descriptions are equal and hash alike, lists or tuples; no field can be set."""
    joint = random_joint(rng, kind, "j")
    fields = {k: list(v) if isinstance(v, tuple) else v for k, v in vars(joint).items()}
    again = Joint(**fields)
    assert again == joint
    assert hash(again) == hash(joint)
    with pytest.raises(FrozenInstanceError):
        joint.name = "other"


BAD = {
    "unknown type": ({"type": "Q"}, ["'Q'", "R, P, H, C, U, S"]),
    "zero axis": ({"axis": [0, 0, 0]}, ["axis", "[0.0, 0.0, 0.0]", "direction"]),
    "no axis": ({"axis": None}, ["axis", "missing", "R"]),
    "axis of two numbers": ({"axis": [0, 1]}, ["axis", "[0, 1]", "three"]),
    "axis is no list": ({"axis": 3}, ["axis", "3", "three"]),
    "point is text": ({"point": ["a", 0, 0]}, ["point", "'a'", "number"]),
    "NaN point": ({"point": [math.nan, 0, 0]}, ["point", "nan", "finite"]),
    "infinite axis": ({"axis": [math.inf, 0, 0]}, ["axis", "inf", "finite"]),
    "axis of a ball": ({"type": "S", "axis": X}, ["axis", "S"]),
    "axis2 of a revolute": ({"axis2": X}, ["axis2", "R"]),
    "universal without axis2": ({"type": "U"}, ["axis2", "missing", "U"]),
    "universal with parallel axes": ({"type": "U", "axis2": [0, 0, -2]}, ["axis2", "parallel"]),
    "actuated ball": (
        {"type": "S", "axis": None, "actuated": True},
        ["actuated", "R, P, H, C and U", "S"],
    ),
    "actuated weld": (
        {"type": "weld", "axis": None, "actuated": True},
        ["actuated", "R, P, H, C and U", "weld"],
    ),
    "zero of a cylinder": ({"type": "C", "zero": 1.0}, ["zero", "R, P, H"]),
    "limits of a cylinder": ({"type": "C", "limits": [0, 1]}, ["limits", "R, P, H"]),
    "pitch of a revolute": ({"pitch": 2.0}, ["pitch", "H", "R"]),
    "infinite pitch": ({"type": "H", "pitch": math.inf}, ["pitch", "inf"]),
    "NaN zero": ({"zero": math.nan}, ["zero", "nan"]),
    "limits reversed": ({"limits": [2.0, 1.0]}, ["limits", "[2.0, 1.0]", "low < high"]),
    "limits empty": ({"limits": [1.0, 1.0]}, ["limits", "[1.0, 1.0]", "low < high"]),
    "limits of three": ({"limits": [1.0, 2.0, 3.0]}, ["limits", "[1.0, 2.0, 3.0]"]),
    "limits NaN": ({"limits": [math.nan, 1.0]}, ["limits", "nan"]),
    "limits no list": ({"limits": 3.0}, ["limits", "3.0"]),
}


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_names_offender_value_and_choice(case):
    """MechanismError in one line: which joint, which key, its value, what is allowed."""
    change, fragments = BAD[case]
    with pytest.raises(MechanismError) as error:
        Joint(**({"name": "j", "type": "R", "axis": Z} | change))
    for fragment in [*fragments, "'j'"]:
        assert fragment in str(error.value)
    assert "\n" not in str(error.value)
