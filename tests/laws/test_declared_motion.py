"""A motion that is declared of a platform which joints carry: its coordinates are told where the
platform has it, and it is said where not.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import parse
from symkin import shipped_names

ARM = """format = 1
name = "arm"
length_unit = "mm"
angle_unit = "deg"
[platform]
link = "arm"
motion = "{motion}"
position = [1, 0, 0]
[[joint]]
name = "a"
type = "R"
links = ["base", "arm"]
point = [0, 0, 0]
axis = {axis}
actuated = true
"""
FOUR_BAR = """format = 1
name = "four"
length_unit = "mm"
angle_unit = "deg"
[platform]
link = "coupler"
motion = "{motion}"
""" + "".join(
    f"[[joint]]\nname = '{name}'\ntype = 'R'\nlinks = ['{first}', '{second}']\n"
    f"point = [{x}, {y}, 0]\naxis = [0, 0, 1]\n{more}"
    for name, first, second, x, y, more in (
        ("a", "base", "crank", 0, 0, "actuated = true\n"),
        ("b", "crank", "coupler", 0, 50, ""),
        ("c", "coupler", "rocker", 100, 80, ""),
        ("d", "base", "rocker", 120, 0, ""),
    )
)
THREE_LIMBS = """format = 1
name = "limbs"
length_unit = "mm"
angle_unit = "deg"
[platform]
position = [0, 0, 0]
motion = "{motion}"
""" + "".join(
    f"[[limb]]\nname = '{name}'\n"
    + "".join(
        f"[[limb.joint]]\nname = '{name}{k}'\ntype = 'R'\npoint = [{x}, {y}, 0]\naxis = [0, 0, 1]\n"
        f"actuated = {str(k == 1).lower()}\n"
        for k, (x, y) in enumerate(points, start=1)
    )
    for name, points in (
        ("a", ((-200, -100), (-150, -10), (-50, -20))),
        ("b", ((200, -100), (150, 10), (50, -20))),
        ("c", ((0, 250), (90, 150), (0, 50))),
    )
)
TOLD = "the platform's motion is declared {motion}"


def arm(motion: str, axis: str = "[0, 0, 1]") -> symkin.Mechanism:
    return parse(ARM.format(motion=motion, axis=axis))


@pytest.mark.parametrize("motion", ["planar", "schoenflies"])
@pytest.mark.parametrize("angle", [0.0, 10.0, -170.0, 180.0])
def test_the_angle_of_a_carried_platform_is_that_of_its_joint(motion: str, angle: float) -> None:
    """One hinge carries it, so that its pose is no unknown of the closure."""
    mechanism = arm(motion)
    for result in (
        symkin.modes(mechanism, joints=[angle]),
        symkin.solve(mechanism, joints=[angle]),
    ):
        assert "gamma [deg]" in repr(result)
        assert "declared" not in repr(result)
    solution = symkin.solve(mechanism, joints=[angle]).solution
    assert solution is not None
    np.testing.assert_allclose(
        math.remainder(math.degrees(solution.gamma) - angle, 360.0), 0.0, atol=1e-12
    )
    np.testing.assert_allclose(
        solution.position,
        [math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0],
        atol=1e-12,
    )


@pytest.mark.parametrize(
    "motion",
    in_gate(["planar", "schoenflies", "translation", "spherical"], ["planar", "spherical"]),
)
def test_poses_of_a_loops_link_are_those_of_the_spatial_declaration(motion: str) -> None:
    """A declaration changes what is shown of a carried platform, and no pose; one that does not
    hold is named, and nothing is hidden.
    """
    free, declared = (
        symkin.modes(parse(FOUR_BAR.format(motion=m)), joints=[95.0]) for m in ("spatial", motion)
    )
    assert len(free) == len(declared) == 2
    for one, other in zip(free, declared, strict=True):
        np.testing.assert_allclose(other.position, one.position, atol=1e-9)
        np.testing.assert_allclose(abs(other.quaternion @ one.quaternion), 1.0, atol=1e-12)
    holds = motion in ("planar", "schoenflies")
    account = str(symkin.mobility(parse(FOUR_BAR.format(motion=motion))))
    assert (TOLD.format(motion=motion) in str(declared)) == (not holds)
    assert (TOLD.format(motion=motion) in account) == (not holds)
    assert ("qw" in str(declared)) == (not holds)


@pytest.mark.parametrize("axis", ["[0, 0, 1]", "[1, 0, 0]", "[1, 2, 3]"])
@pytest.mark.parametrize("motion", ["planar", "schoenflies", "translation", "spherical"])
def test_a_hinge_has_a_motion_if_its_axis_allows(motion: str, axis: str) -> None:
    """Turning about z is planar and Schoenflies; no turn is a translation; the platform's point is
    off the axis, so none is spherical but for one along the x axis through it.
    """
    holds = (motion in ("planar", "schoenflies") and axis == "[0, 0, 1]") or (
        motion == "spherical" and axis == "[1, 0, 0]"
    )
    mechanism = arm(motion, axis)
    assert (TOLD.format(motion=motion) in str(symkin.mobility(mechanism))) == (not holds)
    assert (TOLD.format(motion=motion) in str(symkin.solve(mechanism, joints=[20.0]))) == (
        not holds
    )


@pytest.mark.parametrize("motion", ["planar", "translation"])
def test_limbs_that_leave_more_than_the_declared_motion_are_named(motion: str) -> None:
    """Three limbs of parallel hinges turn the platform."""
    told = [
        w
        for w in symkin.mobility(parse(THREE_LIMBS.format(motion=motion))).warnings
        if TOLD.format(motion=motion) in w
    ]
    assert len(told) == (motion == "translation")
    assert all("(0, 0, 1, 0, 0, 0)" in warning for warning in told)


@pytest.mark.slow
def test_shipped_mechanisms_have_the_motion_that_they_declare() -> None:
    for name in shipped_names():
        mechanism = symkin.load(name)
        if mechanism.motion != "spatial":
            assert "declared" not in str(symkin.mobility(mechanism)), name


@pytest.mark.parametrize("motion", ["spatial", "planar", "schoenflies"])
def test_a_limb_of_driven_joints_alone_places_its_platform(motion):
    """A planar 2R arm written as a limb: x = cos q1 + cos(q1 + q2), y alike, turned by q1 + q2."""
    joints = [symkin.Joint(f"q{k + 1}", "R", (k, 0, 0), (0, 0, 1), actuated=True) for k in range(2)]
    arm = symkin.Mechanism("arm", [symkin.Limb("a", joints)], (2, 0, 0), motion=motion)
    (mode,) = symkin.modes(arm, joints=[0.3, 0.4])
    assert mode.certified
    turned = np.exp(0.3j) + np.exp(0.7j)
    np.testing.assert_allclose(mode.position, [turned.real, turned.imag, 0.0], atol=1e-12)
    np.testing.assert_allclose(
        mode.quaternion, [math.cos(0.35), 0.0, 0.0, math.sin(0.35)], atol=1e-12
    )
