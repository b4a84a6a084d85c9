"""A spatial file whose poses must satisfy conditions is told which motion, declared, gives the
complete list.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import implied_motion
from helpers.samples import delta, four_bar, readme_five_bar, three_rps, three_rrr
from symkin import Joint, Limb, Mechanism


def three_upu() -> Mechanism:
    """Tsai's 3-UPU: in each limb the outer axes of the universal joints are parallel, and so are
    the inner ones.
    """
    limbs = []
    for k, angle in enumerate(np.radians([0, 120, 240]), start=1):
        r, t = (
            np.array([math.cos(angle), math.sin(angle), 0.0]),
            (-math.sin(angle), math.cos(angle), 0.0),
        )
        foot, head = 200 * r, 80 * r + [0, 0, 300.0]
        along = (head - foot) / np.linalg.norm(head - foot)
        inner = tuple(np.cross(t, along))
        joints = [
            Joint(f"u{k}", "U", tuple(foot), axis=t, axis2=inner),
            Joint(f"p{k}", "P", tuple(foot), axis=tuple(along), actuated=True),
            Joint(f"v{k}", "U", tuple(head), axis=inner, axis2=t),
        ]
        limbs.append(Limb(f"limb{k}", joints))
    return Mechanism("three_upu", limbs, platform_position=(0.0, 0.0, 300.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "motion"),
    [
        (three_upu(), "translation"),
        (three_rrr(), "planar"),
        (replace(delta(), motion="spatial"), "translation"),
        (readme_five_bar(), None),
        (four_bar()[0], None),
        (three_rps(), None),
        (symkin.load("zhang2009"), None),
        (three_rrr("planar"), None),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_the_motion_is_the_one_that_leaves_every_coordinate_free(mechanism, motion) -> None:
    """Platforms that move in a whole group of motions have one; those whose coordinates are tied
    have none.
    """
    assert implied_motion(mechanism) == motion


@pytest.mark.long
@pytest.mark.slow
def test_declared_the_named_motion_gives_the_complete_list() -> None:
    """Where the inverse problem is sampled, a note names the motion, with which the same pose's
    list is complete.
    """
    mechanism, pose = three_rrr(), [5.0, 3.0, 0.0, 1, 0, 0, 0]
    found = symkin.modes(mechanism, pose=pose)
    declared = symkin.modes(replace(mechanism, motion="planar"), pose=pose)
    assert declared.completeness in ("proved", "probability one")
    assert len(declared) == len(found) == 8
    named = [note for note in found.notes if "motion = 'planar' in [platform]" in note]
    assert bool(named) == (found.completeness == "sampled")


@pytest.mark.slow
@pytest.mark.parametrize(
    "given",
    in_gate(
        [{"pose": [80.0, 20.0, 0.0, 1.0, 0.0, 0.0, 0.0]}, {"given": {"x": 80.0, "y": 20.0}}],
        [{"pose": [80.0, 20.0, 0.0, 1.0, 0.0, 0.0, 0.0]}],
    ),
)
def test_a_motion_around_that_of_the_platform_is_told(given) -> None:
    """The five-bar's platform has two freedoms of a planar motion's three. No crank's end, on a
    circle of radius 100, is 150 from a point that is 21 from the circle's centre, so that there is
    no solution; declared planar, the list says so with its ground.
    """
    mechanism = readme_five_bar("spatial")
    found = symkin.modes(mechanism, **given)
    declared = symkin.modes(replace(mechanism, motion="planar"), **given)
    assert not found
    assert not declared
    assert declared.completeness == "probability one"
    named = [note for note in found.notes if "motion = 'planar' in [platform]" in note]
    assert bool(named) == (found.completeness == "sampled")


@pytest.mark.slow
def test_complete_lists_are_not_told_of_a_motion() -> None:
    """Formulas list all solutions of a pose that the five-bar takes, and nothing is to be
    declared.
    """
    mechanism = readme_five_bar("spatial")
    found = symkin.modes(mechanism, pose=symkin.solve(mechanism, joints=[10, -10]).solution.pose)
    assert not [note for note in found.notes if "in [platform]" in note]
