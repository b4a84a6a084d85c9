"""Singularities against closed forms."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import symkin
from helpers.inside import build_closure, reciprocal_product, variables_of, whole_system
from helpers.laws import act, assert_wrenches_do_no_work, joint_displacement
from helpers.samples import (
    DELTA,
    circles,
    delta,
    delta_directions,
    five_bar,
    four_bar,
    hexagons,
    hexapod,
    pieper,
    planar_pose,
    three_rps,
)
from symkin import InputError, Joint, Limb, Mechanism, Singularity, SolveError, singularity

Z = (0.0, 0.0, 1.0)


# --- closed forms ---------------------------------------------------------------------------------


def test_four_bar_toggle() -> None:
    """Coupler and rocker in one line: ground^2 + crank^2 - 2 ground crank cos q = (coupler +
    rocker)^2 has no solution for a crank that turns fully; with a long crank it has one, type 2,
    and the coupler then turns about the crank pin.
    """
    ground, crank, coupler, rocker = 100.0, 90.0, 60.0, 50.0
    at = math.acos((ground**2 + crank**2 - (coupler + rocker) ** 2) / (2 * ground * crank))
    b = np.array([crank * math.cos(at), crank * math.sin(at)])
    d = np.array([ground, 0.0])
    c = b + (d - b) * coupler / (coupler + rocker)

    def turning(name: str, p: np.ndarray, actuated: bool = False, zero: float = 0.0) -> Joint:
        return Joint(name, "R", (*p, 0.0), Z, actuated=actuated, zero=zero)

    limbs = [
        Limb("left", [turning("crank", np.zeros(2), True, at), turning("b", b)]),
        Limb("right", [turning("d", d), turning("c", c)]),
    ]
    found = singularity(
        Mechanism("toggle", limbs, platform_position=(*b, 0.0)), pose=planar_pose(*b), start=[at]
    )
    assert found.kinds == ("type 2",)
    assert found.conditions == ("RO", "II")
    assert found.distances["type 2"] < 1e-9
    (twist,) = found.twists
    assert twist.name == "rotation"
    assert np.allclose(twist.point, [*b, 0.0], atol=1e-6)
    assert np.allclose(twist.direction, Z)


def test_a_regular_four_bar_has_the_lever_of_its_closed_form() -> None:
    """|twist| / crank rate of the coupler: by the loop's velocity equation in the plane."""
    mechanism, (ground, crank, coupler, rocker) = four_bar()
    found = singularity(mechanism)
    q = math.radians(60)
    b = crank * np.array([math.cos(q), math.sin(q)])
    c = circles(b, coupler, np.array([ground, 0.0]), rocker)[0]
    # (w_crank J b + w (c - b)') . (c - d) = 0 with J the quarter turn
    arm = c - np.array([ground, 0.0])
    turned = np.array([-b[1], b[0]])
    omega = -(turned @ arm) / (np.array([-(c - b)[1], (c - b)[0]]) @ arm)
    expected = math.hypot(crank / mechanism.characteristic_length, omega)
    assert found.kinds == ()
    assert found.manipulability == pytest.approx(expected, rel=1e-9)
    assert found.inverse_manipulability == pytest.approx(1 / expected, rel=1e-9)


def test_five_bar_type_1() -> None:
    """The right limb stretched (crank 60 + coupler 80 in one line): the force along it is borne
    without the cranks, and only that crank moves with the platform (the left coupler) at rest.
    """
    along = np.array([math.cos(math.radians(130)), math.sin(math.radians(130))])
    tip = np.array([100.0, 0.0]) + 140.0 * along
    elbow = circles(np.zeros(2), 60.0, tip, 80.0)[0]
    found = singularity(
        five_bar(), pose=planar_pose(*tip, _coupler_turn(tip, elbow)), start=[100.0, 130.0]
    )
    assert found.kinds == ("type 1",)
    assert found.conditions == ("RI", "IO")
    assert found.distances["type 1"] < 1e-6 < 0.1 < found.distances["type 2"]
    assert found.inputs == ({"q2": 1.0},)
    assert len(found.wrenches) == 5, "a coupler of two freedoms always bears four, here one more"
    line = np.array([*along, 0.0, *np.cross([100.0, 0.0, 0.0], [*along, 0.0])])
    span = np.array([w.vector for w in found.wrenches])
    assert np.linalg.norm(line - np.linalg.lstsq(span.T, line, rcond=None)[0] @ span) < 1e-4
    assert_wrenches_do_no_work(found)


def _coupler_turn(tip: np.ndarray, elbow: np.ndarray) -> float:
    """How far the left coupler from `elbow` to `tip` is turned from the reference, where it begins
    at (0, 60).
    """
    home = circles(np.array([0.0, 60.0]), 80.0, np.array([100.0, 60.0]), 80.0)[0] - [0.0, 60.0]
    return math.atan2(*(tip - elbow)[::-1]) - math.atan2(*home[::-1])


def test_five_bar_type_2() -> None:
    """Couplers in one line: elbows 160 apart; the tip moves across the line with the cranks held,
    the left coupler about its elbow.
    """
    half = math.asin((160.0 - 100.0) / 2 / 60.0)
    b1 = np.array([-30.0, 60.0 * math.cos(half)])
    tip = np.array([50.0, b1[1]])
    found = singularity(
        five_bar(), pose=planar_pose(*tip, _coupler_turn(tip, b1)), start=[120.0, 60.0]
    )
    assert found.kinds == ("type 2",)
    (twist,) = found.twists
    assert twist.name == "rotation"
    assert np.allclose(twist.point, [*b1, 0.0], atol=1e-5)
    assert str(twist).startswith("rotation about the axis through (")
    assert math.isinf(found.manipulability)
    assert found.inverse_manipulability == 0.0


@pytest.mark.parametrize("sign", [1, -1])
def test_hexagons_turned_by_a_right_angle(sign: int) -> None:
    """Type 2 at gamma = +-90 degrees on the axis (Fichter 1986): L_i^2 = r_a^2 + r_b^2 + h^2 - 2
    r_a r_b cos(gamma +- 20), whose rates by gamma are equal there, so that h h' + r_a r_b cos(20)
    sin(gamma) gamma' = 0 keeps all lengths: a screw about z.
    """
    found = singularity(hexagons(), pose=[0, 0, 120, math.sqrt(0.5), 0, 0, sign * math.sqrt(0.5)])
    assert found.kinds == ("type 2",)
    assert found.conditions == ("RO", "II")
    assert found.distances["type 2"] < 1e-9
    (twist,) = found.twists
    assert twist.name == "screw"
    assert np.allclose(twist.direction, Z)
    assert np.allclose(twist.point, 0, atol=1e-6)
    assert twist.pitch == pytest.approx(
        -sign * 200 * 120 * math.cos(math.radians(20)) / 120, rel=1e-9
    )
    assert "screw of pitch" in str(found)


def test_similar_hexagons_are_singular_everywhere() -> None:
    """Similar platform and base are architecturally singular (Ma and Angeles 1992): six legs, five
    independent ones; a configuration is then judged against that rank.
    """
    angles = np.radians([10, 110, 130, 230, 250, 350])
    base = 200 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(6)])
    found = singularity(hexapod([tuple(b) for b in base], [tuple(0.6 * b) for b in base], 120.0))
    assert found.generic.twist == 5
    assert any("not actuated" in note or "independent" in note for note in found.notes)


@pytest.mark.slow
def test_delta_type_1() -> None:
    """Arm and rods in one plane normal to the arm's motion: r . (axis x arm) = 0; here arm 1
    stretched level.
    """
    d = DELTA
    outward, _ = delta_directions(0)
    reach = d["base"] + d["arm"] - d["platform"]
    tilt = math.radians(-40)
    direction = math.cos(tilt) * outward + np.array([0, 0, math.sin(tilt)])
    p = (d["base"] - d["platform"]) * outward + (d["arm"] + d["rod"]) * direction
    other = singularity(delta(), pose=[0, 0, -math.sqrt(d["rod"] ** 2 - reach**2), 1, 0, 0, 0])
    assert not other.is_singular
    levers = []
    for k in range(3):
        out, tangent = delta_directions(k)
        rod = reach * out + [0, 0, math.sqrt(d["rod"] ** 2 - reach**2)]
        lever = abs(rod @ (d["arm"] * np.cross(tangent, out))) / delta().characteristic_length
        levers.append(lever / math.hypot(lever, d["rod"]))
    assert other.distances["type 1"] == pytest.approx(min(levers), rel=1e-9)
    with pytest.raises(SolveError):
        singularity(delta(), pose=[*(1.01 * p), 1, 0, 0, 0])


def test_delta_type_2() -> None:
    """Rods of all limbs level (in one plane): the platform moves up and down with the arms held;
    arms such that the rods are level have height 100 sin(q) and radius 220 + 40 - 120 = 100
    cos(q) - no: 140 > 100, so arms 180 long are taken.
    """
    mechanism = level_delta()
    found = singularity(mechanism)
    assert found.kinds == ("type 2",)
    (twist,) = found.twists
    assert (twist.name, twist.pitch, twist.point) == ("translation", None, None)
    assert np.allclose(twist.direction, Z)


def level_delta() -> Mechanism:
    """A delta whose rods are level at the reference: base circle 120, arms straight down 50, rods
    inward to a circle of 30.
    """
    limbs = []
    for k in range(3):
        outward, tangent = delta_directions(k)
        pivot, tip = 120 * outward, 120 * outward - np.array([0, 0, 50.0])
        rods = [
            symkin.Rod(tuple(tip + s * 20 * tangent), tuple(30 * outward + s * 20 * tangent))
            for s in (-1, 1)
        ]
        limbs.append(
            Limb(
                f"limb{k + 1}",
                [Joint(f"q{k + 1}", "R", tuple(pivot), tuple(tangent), actuated=True)],
                rods,
            )
        )
    return Mechanism(
        "level_delta", limbs, platform_position=(0.0, 0.0, -50.0), motion="translation"
    )


def three_upu(inclined: float = 40.0) -> Mechanism:
    """SNU 3-UPU: the outer axes of the universal joints meet in the middle of base and platform,
    the inner ones are tangents; limbs lean by `inclined` (Zlatanov, Bonev and Gosselin 2002).
    """
    limbs = []
    for k, angle in enumerate(np.radians([0, 120, 240]), start=1):
        r, t = (math.cos(angle), math.sin(angle), 0.0), (-math.sin(angle), math.cos(angle), 0.0)
        foot, head = 100 * np.array(r), (100 - inclined) * np.array(r) + [0, 0, 200.0]
        along = (head - foot) / np.linalg.norm(head - foot)
        joints = [
            Joint(f"u{k}", "U", tuple(foot), axis=r, axis2=t),
            Joint(f"p{k}", "P", tuple(foot), axis=tuple(along), actuated=True),
            Joint(f"v{k}", "U", tuple(head), axis=t, axis2=r),
        ]
        limbs.append(Limb(f"limb{k}", joints))
    return Mechanism("three_upu", limbs, platform_position=(0, 0, 200.0))


@pytest.mark.slow
def test_three_upu_at_home() -> None:
    """Each limb bears one couple, normal to its universal joints' axes: all three are vertical at
    home, so that the platform has five freedoms, two of them with the actuators held; elsewhere
    three (Zlatanov, Bonev and Gosselin 2002).
    """
    found = singularity(three_upu(), pose=[0, 0, 200, 1, 0, 0, 0])
    assert set(found.kinds) == {"constraint", "increased", "type 2"}
    assert set(found.conditions) == {"IIM", "RO"}
    assert (found.generic.constraints, found.ranks.constraints) == (3, 1)
    assert (found.generic.motions, found.ranks.motions) == (3, 5)
    assert len(found.twists) == 2
    assert found.distances["constraint"] < 1e-12


def test_three_rps_constraint_singularity_is_named() -> None:
    """A 3-RPS whose limbs bear three forces through S parallel to R: forces in the plane of the S
    joints; rank 3 at home.
    """
    found = singularity(three_rps())
    assert found.kinds == ()
    assert found.generic.constraints == 3


# --- arms -----------------------------------------------------------------------------------------


def joint_screws(mechanism: Mechanism, found: Singularity) -> np.ndarray:
    """Twists of the joints of an arm of revolutes at a configuration, by matrices (rows; base
    origin).
    """
    frame, screws = np.eye(4), []
    for _, joint in mechanism.joints:
        point, axis = act(frame, joint.point), frame[:3, :3] @ np.array(joint.axis)
        screws.append(np.concatenate([axis, np.cross(point, axis)]))
        frame = frame @ joint_displacement(joint, [found.solution.values[joint.name]])
    return np.array(screws)


@pytest.mark.parametrize(
    ("joints", "moving"),
    [
        ([10, 20, 30, 40, 0, 50], {"q4", "q6"}),
        ([15, 25, 0, 30, 40, 20], {"q2", "q3", "q4"}),
    ],
    ids=["wrist", "elbow"],
)
def test_gluon_wrist_and_elbow(joints: list[float], moving: set[str]) -> None:
    """Three parallel axes 2, 3, 4 in one plane (elbow), axes 4 and 6 parallel (wrist, with 2 and
    3): type 1; joints move with the tool at rest, and the wrench that is borne does no work on any
    joint's twist.
    """
    arm = symkin.load("gluon_6l3")
    found = singularity(arm, joints=joints)
    assert found.kinds == ("type 1",)
    assert "type 2" not in found.distances
    (rates,), (wrench,) = found.inputs, found.wrenches
    assert moving <= set(rates)
    screws = joint_screws(arm, found)
    weights = np.array([rates.get(c.name, 0.0) for c in arm.actuated])
    assert np.abs(weights @ screws).max() < 1e-9 * arm.characteristic_length
    for screw in screws:
        assert abs(reciprocal_product(screw, wrench.vector)) < 1e-9 * arm.characteristic_length


@pytest.mark.slow
def test_gluon_shoulder() -> None:
    """The wrist's centre on axis 1 (a root of a cos-sum in q2 for the other joints given): type
    1.
    """
    arm = symkin.load("gluon_6l3")

    def reach(q2: float) -> float:
        return singularity(arm, joints=[15, q2, 40, 25, 50, 20]).distances["type 1"]

    grid = np.linspace(-180, 180, 721)
    best = grid[int(np.argmin([reach(v) for v in grid[::10]])) * 10]
    step = 5.0
    while step > 1e-12:
        best, step = min((best - step, best, best + step), key=reach), step * 0.6
    assert singularity(arm, joints=[15, best, 40, 25, 50, 20]).kinds == ("type 1",)


def test_pieper_wrist_is_named() -> None:
    """Axes 4 and 6 in line: they turn against each other, and a couple normal to axes 4 and 5 is
    borne.
    """
    found = singularity(pieper(), joints=[0.1, 0.2, 0.3, 0.4, 0.0, 0.5])
    (rates,), (wrench,) = found.inputs, found.wrenches
    assert set(rates) == {"q4", "q6"}
    assert rates["q4"] == pytest.approx(-rates["q6"])
    assert (
        max(abs(reciprocal_product(s, wrench.vector)) for s in joint_screws(pieper(), found))
        < 1e-9 * 200
    )


# --- the border -----------------------------------------------------------------------------------


def test_json_holds_no_infinity() -> None:
    """An infinite manipulability is null, and the object goes through JSON."""
    found = singularity(hexagons(), pose=[0, 0, 120, math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert content["kinds"] == ["type 2"]
    assert content["manipulability"] is None
    assert content["twists"][0]["name"] == "screw"


def test_bad_tolerance_is_refused() -> None:
    """A tolerance outside (0, 0.01) is named with its value."""
    with pytest.raises(InputError, match=r"tolerance = 0\.5"):
        singularity(hexagons(), tolerance=0.5)


def test_an_assembly_whose_limbs_constrain_less_is_not_singular_for_that() -> None:
    """A limb U R S that is locked into one plane near the reference, and not here: the rows of the
    closure are as independent as they are there, so that the platform has not gained a freedom.
    """
    limb = Limb(
        "limb",
        [
            Joint("u", "U", (50, 0, 100), (1, 0, 0), (0, 1, 0)),
            Joint("r", "R", (100, -50, 0), (0, 1, 0)),
            Joint("s", "S", (50, -50, 100)),
        ],
    )
    centre = Limb(
        "centre",
        [
            Joint("a", "R", (50, 100, -50), (1, 0, 0), actuated=True),
            Joint("b", "P", (-50, 50, 0), (0, 0, 1), actuated=True),
            Joint("c", "R", (-100, -100, 100), (0, 1, 0), actuated=True),
        ],
    )
    mechanism = Mechanism("m", [limb, centre], (-50, -100, -100), angle_unit="deg")
    found = symkin.singularity(
        mechanism, joints=[-0.0003193318838098015, 47.870721155946576, 19.238547928492995]
    )
    system = whole_system(build_closure(mechanism))
    _, jacobian = system.linearise_one(
        variables_of(build_closure(mechanism), found.solution), np.zeros(0)
    )
    assert np.linalg.svd(jacobian, compute_uv=False)[-1] > 1e-4
    assert "constraint" not in found.kinds
    assert found.distances.get("constraint", 1.0) > 0.01
