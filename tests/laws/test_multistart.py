"""All modes by varied starts: published counts and closed forms, merging laws, and what is said
when there are none.
"""

import json
import math
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    Sample,
    build_closure,
    build_problem,
    distinct,
    features,
    merge,
    parse,
    random_values,
    read_given,
)
from helpers.laws import (
    all_distinct,
    ball_turn,
    closes,
    frame,
    matched,
    same_angle,
    same_modes,
    same_pose,
    solution_coordinates,
)
from helpers.samples import (
    BENNETT,
    DELTA,
    RRR_BASE,
    RRR_LINKS,
    RRR_PLATFORM,
    circles,
    delta,
    delta_directions,
    five_bar,
    four_bar,
    hexapod,
    parallel_rrr,
    pieper,
    random_mechanism,
    seeds,
    three_rrr,
)
from helpers.shipped import LIMBS
from symkin import InputError, Joint, Limb, LinkJoint, Mechanism, Pose

sampled = partial(symkin.modes, method="multistart")

KEYS = {
    "mechanism",
    "problem",
    "given",
    "length_unit",
    "angle_unit",
    "modes",
    "poses",
    "complex_count",
    "completeness",
    "unresolved_paths",
    "smallest_residual",
    "method",
    "seed",
    "elapsed_s",
}
MODE_KEYS = {
    "pose",
    "joints",
    "residual",
    "condition",
    "certified",
    "radius",
    "within_limits",
    "notes",
}


def check(mechanism, modes, said="sampled"):
    """Every mode closes by plain matrices, no two are the same, and the hits are counted among the
    starts.
    """
    assert all(closes(mechanism, mode) for mode in modes)
    assert all_distinct(modes, mechanism.characteristic_length)
    assert modes.completeness == said
    if len(modes):
        assert all(mode.hits >= 1 for mode in modes)
        assert modes.smallest_residual is None
    assert modes.poses <= len(modes)
    return modes


def positions_match(modes, expected, tolerance):
    return matched(
        list(modes), list(expected), lambda m, e: np.allclose(m.position, e, atol=tolerance)
    )


# --- published mechanisms -------------------------------------------------------------------------


def test_zhang2009_has_the_papers_modes():
    """Table 2 of Zhang 2009: two poses (x, y, z; Rx Ry Rz, deg) and their mirrors in the base
    plane.
    """
    mechanism = symkin.load("zhang2009")
    upper = [
        (119.030, 88.011, 71.936, 10.001, 20.990, 14.992),
        (91.608, 100.062, 42.934, 7.371, 35.260, 15.558),
    ]
    expected = [(x, y, s * z, s * a, s * b, c) for x, y, z, a, b, c in upper for s in (1, -1)]
    poses = [Pose.from_euler(e[:3], np.radians(e[3:]), "XYZ") for e in expected]
    modes = check(mechanism, sampled(mechanism))
    assert same_modes(modes, poses, mechanism.characteristic_length, 1e-4)
    assert sum(mode.hits for mode in modes) <= modes.starts


def test_planar_base_and_platform_mirror_the_modes():
    """With base and platform joints each in a plane, (x, y, -z; w, -qx, -qy, qz) is a mode with
    each mode.
    """
    for name in ("zhang2009", "ren2008"):
        mechanism = symkin.load(name)
        modes = check(mechanism, sampled(mechanism))
        mirror = [Pose(m.position * [1, 1, -1], m.quaternion * [1, -1, -1, 1]) for m in modes]
        assert len(modes) > 0
        assert same_modes(modes, mirror, mechanism.characteristic_length)


def test_zhao2000_has_the_papers_modes():
    """Table 1, row 2 of Zhao 2000: (x, y, +-z; angle about z)."""
    mechanism = symkin.load("zhao2000")
    rows = [(4.946, 5.009, 104.964, 5.021), (14.613, 14.799, 103.124, 165.013)]
    poses = [
        Pose.from_euler((x, y, s * z), np.radians([0, 0, g]), "XYZ")
        for x, y, z, g in rows
        for s in (1, -1)
    ]
    modes = check(mechanism, sampled(mechanism))
    assert same_modes(modes, poses, mechanism.characteristic_length, 1e-4)


def test_zhao2000_links_reach_two_of_the_poses():
    """Limbs reach 2 x 70 mm: of the line model's four poses the two near the base's axis remain,
    with two elbows in each of three limbs: 2 x 2^3 configurations.
    """
    mechanism = symkin.load("zhao2000_links")
    modes = check(mechanism, sampled(mechanism))
    assert len(modes) == 16
    assert modes.poses == 2
    line = list(sampled(symkin.load("zhao2000")))
    assert all(
        any(same_pose(mode, other, mechanism.characteristic_length, 1e-6) for other in line)
        for mode in modes
    )
    assert all(mode.joints["op"] == pytest.approx(105.2) for mode in modes)


def test_gluon_has_exactly_the_tutorials_two_solutions():
    """The pose of 15 degrees at each joint: (15, 15, 15, 15, 15, 15) and (15, 30, -15, 30, 15,
    15).
    """
    arm = symkin.load("gluon_6l3")
    pose = symkin.solve(arm, joints=[15.0] * 6).solution.pose
    modes = check(arm, sampled(arm, pose=pose))
    expected = [(15, 15, 15, 15, 15, 15), (15, 30, -15, 30, 15, 15)]
    assert matched(list(modes), expected, lambda m, e: np.allclose(m.actuated, e, atol=1e-6))


def test_yao2020_has_the_papers_solutions():
    """The worked example of Yao 2020: four real solutions (theta1..theta5 deg; L6 mm)."""
    expected = [
        (-35.5964, 2.7296, 22.5391, 7.7660, 62.2486, -51.5743),
        (144.4036, 177.2704, -157.4609, 7.7660, 62.2486, -51.5743),
        (-89.735, 16.6451, 4.5028, 7.766, 117.7514, -407.5519),
        (90.265, 163.3549, -175.4972, 7.766, 117.7514, -407.5519),
    ]
    arm = symkin.load("yao2020")
    modes = check(arm, sampled(arm))
    assert modes.poses == 1
    assert matched(list(modes), expected, lambda m, e: np.allclose(m.actuated, e, atol=2e-4))


def test_roots_many_turns_away_are_the_same_roots():
    """A root whose angles carry whole turns, up to 1e8 of them, is the root without them, and is
    not lost although a sine of 1e8 turns has lost half of its digits.
    """
    arm = symkin.load("yao2020")
    found = symkin.modes(arm)
    problem = build_problem(arm, "inverse")
    known = read_given(arm, None, None).values
    roots = np.array([[mode.values[c.name] for c in problem.system.unknowns] for mode in found])
    turns = np.random.default_rng(0).integers(-(10**8), 10**8, roots.shape) * [
        c.kind == "angle" for c in problem.system.unknowns
    ]
    far = distinct(problem.system, np.vstack([roots + 2 * np.pi * turns, roots]), known, 8)
    assert len(far.points) == len(roots) == 4
    assert far.hits.tolist() == [2] * 4


def test_a_wrist_partitioned_arm_has_eight_solutions():
    """Pieper 1968: shoulder, elbow and wrist, two each; each leads to the pose, and the wrist flips
    by (q4 + 180, -q5, q6 + 180).
    """
    arm = pieper()
    q = [0.3, 0.5, -0.4, 0.7, 0.9, -0.2]
    pose = symkin.solve(arm, joints=q).solution.pose
    modes = check(arm, sampled(arm, pose=pose))
    assert len(modes) == 8
    assert any(
        all(same_angle(a, b, 1e-7) for a, b in zip(mode.actuated_values, q, strict=True))
        for mode in modes
    )
    for mode in modes:
        assert same_pose(
            symkin.solve(arm, joints=mode.actuated_values).solution, pose, arm.characteristic_length
        )
        a, b, c, d, e, f = mode.actuated_values
        flipped = (a, b, c, d + math.pi, -e, f + math.pi)
        assert any(
            all(same_angle(x, y, 1e-6) for x, y in zip(o.actuated, flipped, strict=True))
            for o in modes
        )


# --- closed forms: overconstrained linkages with motion undeclared --------------------------------


@pytest.mark.parametrize("degrees", [10.0, 60.0, 100.0, 179.0, -45.0])
def test_four_bar_modes_are_the_circles_intersections(degrees):
    """B on the crank's circle; C where the circles of coupler about B and rocker about D meet: two
    modes, or none.
    """
    mechanism, (ground, crank, coupler, rocker) = four_bar()
    q = math.radians(degrees)
    b = crank * np.array([math.cos(q), math.sin(q)])
    found = check(mechanism, sampled(mechanism, joints=[q], starts=300))
    expected = circles(b, coupler, np.array([ground, 0.0]), rocker)
    tips = [mode.position + mode.rotation @ [coupler, 0, 0] for mode in found]
    assert matched(tips, expected, lambda f, e: np.allclose(f, [*e, 0.0], atol=1e-7))
    assert all(np.allclose(mode.position, [*b, 0.0], atol=1e-9) for mode in found)


@pytest.mark.parametrize("joints", [(90.0, 90.0), (100.0, 70.0), (120.0, 10.0), (-30.0, -100.0)])
def test_five_bar_modes_are_the_circles_intersections(joints):
    """P where the circles of 80 about both crank ends meet."""
    mechanism = five_bar()
    tips = [
        np.array([x, 0.0]) + 60 * np.array([math.cos(q), math.sin(q)])
        for x, q in zip((0, 100), np.radians(joints), strict=True)
    ]
    expected = circles(tips[0], 80.0, tips[1], 80.0)
    found = check(mechanism, sampled(mechanism, joints=joints, starts=300))
    assert positions_match(found, [[*e, 0.0] for e in expected], 1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [(0.0, 0.0, 0.0), (0.1, -0.05, 0.08), (0.4, 0.1, -0.3)])
def test_planar_three_rrr_does_not_care_how_its_motion_is_written(steps):
    """Spatial joints without declared motion (9 redundant rows) and the planar closure have the
    same assembly modes: an even number, at most six (Gosselin and Sefrioui 1991), all in the plane.
    """
    free, planar = three_rrr(), three_rrr("planar")
    joints = [c.reference[0] + step for c, step in zip(free.actuated, steps, strict=True)]
    found = check(free, sampled(free, joints=joints))
    assert same_modes(
        found, check(planar, sampled(planar, joints=joints)), free.characteristic_length
    )
    assert len(found) in (2, 4, 6)
    for mode in found:
        assert abs(mode.position[2]) < 1e-7
        assert np.allclose(mode.rotation[:, 2], [0, 0, 1], atol=1e-9)


@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_planar_three_rrr_working_modes_are_elbows(motion):
    """Each limb reaches its platform joint with the elbow on either side: 2^3 working modes, first
    links from circles.
    """
    mechanism = three_rrr(motion)
    turn, shift = 0.1, np.array([3.0, 2.0])
    c, s = math.cos(turn), math.sin(turn)
    choices = []
    for k in range(3):
        angle = math.pi / 2 + 2 * math.pi * k / 3
        direction = np.array([math.cos(angle), math.sin(angle)])
        base, end = (
            RRR_BASE * direction,
            shift + np.array([[c, -s], [s, c]]) @ (RRR_PLATFORM * direction),
        )
        elbows = circles(base, RRR_LINKS[0], end, RRR_LINKS[1])
        choices.append([math.atan2(*(elbow - base)[::-1]) for elbow in elbows])
    pose = [*shift, 0.0, math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)]
    found = sampled(mechanism, pose=pose, starts=300)
    # what starts reach is all where it is as many as two circles have in common
    check(mechanism, found, "proved" if motion == "planar" else "sampled")
    same = lambda m, e: all(same_angle(x, y, 1e-7) for x, y in zip(m.actuated, e, strict=True))  # noqa: E731
    assert matched(list(found), list(product(*choices)), same)
    assert found.poses == 1


@pytest.mark.parametrize("degrees", [-120.0, -40.0, 0.0, 25.0, 100.0, 170.0])
def test_bennett_linkage_moves_by_bennetts_law(degrees):
    """One mode for each crank angle, though Gruebler counts -2; the angles between links at A and B
    keep tan(A/2) tan(B/2) constant (Bennett 1903), the constant taken from the given points.
    """
    mechanism = parse(BENNETT)
    found = check(mechanism, sampled(mechanism, joints=[degrees], starts=300))
    assert len(found) == 1
    points = {j.name: np.array(j.point) for _, j in mechanism.joints}
    moved = frame(found[0].position, found[0].quaternion) @ np.linalg.inv(
        frame(mechanism.platform_position, (1, 0, 0, 0))
    )
    now = points | {k: (moved @ [*points[k], 1.0])[:3] for k in "BC"}
    assert bennett_product(now) == pytest.approx(bennett_product(points), rel=1e-7)


def bennett_product(points):
    def tangent(at, one, other):
        u, v = points[one] - points[at], points[other] - points[at]
        angle = math.atan2(np.linalg.norm(np.cross(u, v)), u @ v)
        return math.tan(angle / 2)

    return tangent("A", "D", "B") * tangent("B", "A", "C")


# --- closed forms: a delta by rods ----------------------------------------------------------------


def sphere_centres(joints):
    """The rods' pairs meet the platform's origin as one rod from tip less platform radius."""
    d = DELTA
    centres = []
    for k, q in enumerate(joints):
        outward, _ = delta_directions(k)
        tip = (d["base"] + d["arm"] * math.cos(q)) * outward - d["arm"] * math.sin(q) * np.array(
            [0, 0, 1.0]
        )
        centres.append(tip - d["platform"] * outward)
    return centres


def spheres(centres, radius):
    """The two points at `radius` from three centres: on the line through the circumcentre, normal
    to their plane.
    """
    a, b, c = centres
    u, v = b - a, c - a
    n = np.cross(u, v)
    foot = a + ((u @ u) * np.cross(v, n) + (v @ v) * np.cross(n, u)) / (2 * (n @ n))
    height = math.sqrt(radius**2 - (foot - a) @ (foot - a)) / np.linalg.norm(n)
    return [foot + height * n, foot - height * n]


@pytest.mark.parametrize("joints", [(0.0, 0.0, 0.0), (0.1, 0.2, 0.3), (-0.4, 0.3, 0.2)])
def test_delta_modes_are_where_three_spheres_meet(joints):
    """Two assembly modes."""
    centres = sphere_centres(joints)
    expected = spheres(centres, DELTA["rod"])
    assert all(
        np.linalg.norm(e - c) == pytest.approx(DELTA["rod"]) for e in expected for c in centres
    )
    found = check(delta(), sampled(delta(), joints=joints, starts=300))
    assert positions_match(found, expected, 1e-7)
    assert all(np.allclose(mode.rotation, np.eye(3)) for mode in found)


@pytest.mark.parametrize(
    "position", [(0.0, 0.0, -120.0), (10.0, 5.0, -150.0), (-20.0, 12.0, -140.0)]
)
def test_delta_has_eight_working_modes(position):
    """Each arm's tip is where its circle meets a sphere: E cos q + F sin q = G has two roots, 2^3
    in all.
    """
    d, choices = DELTA, []
    for k in range(3):
        outward, _ = delta_directions(k)
        w = np.array(position) + (d["platform"] - d["base"]) * outward
        e, f = 2 * d["arm"] * (w @ outward), -2 * d["arm"] * w[2]
        g = w @ w + d["arm"] ** 2 - d["rod"] ** 2
        middle, spread = math.atan2(f, e), math.acos(g / math.hypot(e, f))
        choices.append([middle - spread, middle + spread])
    found = check(delta(), sampled(delta(), pose=[*position, 1, 0, 0, 0], starts=300))
    same = lambda m, x: all(same_angle(a, b, 1e-7) for a, b in zip(m.actuated, x, strict=True))  # noqa: E731
    assert matched(list(found), list(product(*choices)), same)


# --- laws of the result ---------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMBS)
def test_solve_finds_one_of_the_modes(name):
    """The solution of `solve` is among the modes of the same input."""
    mechanism = symkin.load(name)
    solution = symkin.solve(mechanism).solution
    modes = sampled(mechanism)
    if not modes.problem.is_explicit:
        check(mechanism, modes)
    assert any(same_pose(solution, mode, mechanism.characteristic_length, 1e-6) for mode in modes)


ISOLATED = [
    ["rRS", "rRS", "rRS"],
    ["rUS"] * 6,
    ["hRS", "pRS", "rPS"],
    ["SPS", "SPS", "SPS", "rRS", "SrRP"],
    ["prhU", "rPS"],
    ["rrC", "ppU"],
    ["rhpR", "prC"],
    ["rHS", "rRS", "pRS"],
    ["rprrhr"],
]


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("limbs", ISOLATED, ids="+".join)
@pytest.mark.parametrize("seed", range(2))
def test_the_reference_is_among_the_modes(limbs, seed):
    """Random mechanisms of every joint type: given the reference's joints or pose, the reference is
    a mode, once.
    """
    mechanism = random_mechanism(np.random.default_rng(seed), limbs)
    reference = {c.name: c.reference for c in build_closure(mechanism).coordinates}
    for given_ in ({}, {"pose": mechanism.reference_pose}):
        try:
            found = sampled(mechanism, **given_, starts=400)
        except InputError as error:
            assert "unknowns free" in str(error)  # noqa: PT017 - fewer constraints than freedoms, said so
            continue
        assert len(found) == 1 or all_distinct(found, mechanism.characteristic_length)
        assert all(closes(mechanism, mode) for mode in found)
        assert (
            sum(at_reference(mode, reference, mechanism.characteristic_length) for mode in found)
            == 1
        )


def at_reference(mode, reference, size):
    if not same_pose(mode, mode.mechanism.reference_pose, size, 1e-6):
        return False
    kinds = {c.name: c.kind for c in solution_coordinates(mode)}
    numbers = [n for n in mode.values if kinds[n] in ("angle", "length", "turns")]
    return all(
        same_angle(mode.values[n], reference[n][0], 1e-5)
        if kinds[n] == "angle"
        else abs(mode.values[n] - reference[n][0]) < 1e-5 * size
        for n in numbers
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["zhang2009", "zhao2000", "yao2020"])
def test_a_seed_decides_the_result(name):
    """The same seed, the same JSON but for the time; another seed, the same modes."""
    mechanism = symkin.load(name)
    first, again, other = (sampled(mechanism, seed=s) for s in (3, 3, 4))
    drop = lambda r: {k: v for k, v in r.to_dict().items() if k != "elapsed_s"}  # noqa: E731
    assert json.dumps(drop(first)) == json.dumps(drop(again))
    assert first.seed == 3
    assert len(first) == len(other)
    for a, b in zip(first, other, strict=True):
        assert same_pose(a, b, mechanism.characteristic_length, 1e-6)
        assert a.hits != b.hits or len(first) < 3


@pytest.mark.parametrize("solver", ["newton", "fast_newton", "ipopt"])
def test_other_solvers_find_no_other_modes(solver):
    """Starts one by one with a solver of `solve`: a part of the batched solver's modes, each once,
    none strange.
    """
    mechanism = symkin.load("zhao2000")
    every = sampled(mechanism)
    found = check(mechanism, sampled(mechanism, solver=solver, starts=25))
    assert len(found) > 0
    assert all(
        any(same_pose(mode, other, mechanism.characteristic_length, 1e-6) for other in every)
        for mode in found
    )
    assert sum(mode.hits for mode in found) <= 25


@pytest.mark.slow
@pytest.mark.parametrize("starts", [1, 2, 127, 129])
def test_any_count_of_starts(starts):
    """Few starts find a part of the modes, never more; hits sum to no more than the starts."""
    mechanism = symkin.load("zhang2009")
    modes = check(mechanism, sampled(mechanism, starts=starts))
    assert modes.starts == starts
    assert sum(mode.hits for mode in modes) <= starts
    every = sampled(mechanism)
    assert all(
        any(same_pose(mode, other, mechanism.characteristic_length, 1e-6) for other in every)
        for mode in modes
    )


@pytest.mark.parametrize(
    "options", [{"starts": 0}, {"starts": -5}, {"seed": -1}, {"solver": "bfgs"}]
)
def test_bad_options_are_refused(options):
    """InputError names the option and its value."""
    (key, value), *_ = options.items()
    with pytest.raises(InputError, match=f"{key} = {value!r}"):
        sampled(symkin.load("zhang2009"), **options)


def test_progress_is_told():
    """(finished, in all), not decreasing, never above all."""
    seen = []
    sampled(
        symkin.load("zhang2009"), starts=50, progress=lambda done, total: seen.append((done, total))
    )
    assert seen
    assert all(total == 50 for _, total in seen)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_angles_are_moved_into_limits():
    """Angles are in (-180, 180], moved by whole turns into `limits` where possible; within_limits
    is judged then.
    """
    text = BENNETT.replace(
        "actuated = true", "actuated = true\nzero = 300.0\nlimits = [200.0, 500.0]"
    )
    mechanism = parse(text)
    pose = symkin.solve(mechanism, joints=[310.0]).solution.pose
    (mode,) = sampled(mechanism, pose=pose, starts=50)
    assert mode.joints["A"] == pytest.approx(310.0)
    assert mode.within_limits is True
    outside = symkin.solve(mechanism, joints=[170.0]).solution
    (mode,) = sampled(mechanism, pose=outside.pose, starts=50)
    assert mode.joints["A"] == pytest.approx(170.0)
    assert mode.within_limits is False


@pytest.mark.parametrize("name", LIMBS)
def test_json_has_the_contract_keys(name):
    """Contract 3: these keys at least, for result and mode; no NaN; angles in (-180, 180]."""
    result = sampled(symkin.load(name), starts=300).to_dict()
    assert result.keys() >= KEYS
    assert result["completeness"] in ("proved", "probability one", "incomplete", "sampled")
    assert json.loads(json.dumps(result, allow_nan=False)) == result
    for mode in result["modes"]:
        assert mode.keys() >= MODE_KEYS
        assert mode["pose"].keys() >= {"position", "quaternion", "matrix"}
        assert mode["pose"]["quaternion"][0] >= 0
        assert np.allclose(
            mode["pose"]["matrix"], ball_turn(mode["pose"]["quaternion"]), atol=1e-12
        )


def test_a_pose_that_closes_without_joint_coordinates_is_one_mode():
    """A rigid rod between two balls has no coordinate: a pose at its length is one mode, any other
    none.
    """
    rod = Mechanism(
        "rod",
        [Limb("l", [Joint("a", "S"), Joint("b", "S", (3.0, 4.0, 0.0))])],
        platform_position=(3.0, 4.0, 0.0),
    )
    assert len(sampled(rod, pose=[0.0, 0.0, 5.0, 1, 0, 0, 0])) == 1
    assert len(sampled(rod, pose=[0.0, 0.0, 6.0, 1, 0, 0, 0])) == 0


def test_forward_kinematics_of_an_arm_is_one_mode():
    """A function of its joints: one pose, proved."""
    result = sampled(symkin.load("gluon_6l3"), joints=[10, 20, 30, 40, 50, 60])
    assert (len(result), result.poses, result.completeness) == (1, 1, "proved")


# --- nothing to find ------------------------------------------------------------------------------

EMPTY = {
    "leg too long": (lambda: symkin.load("zhang2009"), {"joints": [100.0] * 5 + [5000.0]}),
    "rod too short": (lambda: symkin.load("zhao2000"), {"joints": [81.6, 202.8, 330.6, 0.1]}),
    "limb out of reach": (three_rrr, {"pose": [90.0, 90.0, 0.0, 1, 0, 0, 0]}),
    "arm out of reach": (lambda: symkin.load("gluon_6l3"), {"pose": [5000.0, 0, 0, 1, 0, 0, 0]}),
    "cranks too far apart": (five_bar, {"joints": [180.0, 0.0]}),
    "platform tilted": (
        lambda: symkin.load("zhao2000_links"),
        {"pose": [0, 0, 100, math.cos(0.1), math.sin(0.1), 0, 0]},
    ),
}


@pytest.mark.parametrize("case", EMPTY)
def test_without_a_solution_the_smallest_residual_is_told(case):
    """No modes, a positive smallest_residual, still sampled; the text says so."""
    make, given_ = EMPTY[case]
    result = check(make(), sampled(make(), **given_, starts=300))
    assert len(result) == result.poses == 0
    assert not result.positive_dimensional
    assert result.smallest_residual > 1e-3
    assert "no real solution" in str(result)
    assert json.loads(json.dumps(result.to_dict(), allow_nan=False))["modes"] == []


def test_the_smallest_residual_of_a_five_bar_that_cannot_close():
    """Crank ends 220 apart and two couplers of 80 leave 60: in a best fit an error of a third to
    all of it remains.
    """
    result = sampled(five_bar(), joints=[180.0, 0.0], starts=300)
    assert 220 - 160 >= result.smallest_residual >= (220 - 160) / 3 - 1e-6


# --- self-motions ---------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_parallel_links_move_freely_beside_isolated_modes(motion):
    """Second links of 40 parallel, elbows' triangle (circle of 50) equal to the platform's: a
    circle of solutions, named as such, and two isolated modes turned about the centre by 2
    asin(40 / 2 / 50).
    """
    mechanism = parallel_rrr(motion)
    result = check(mechanism, sampled(mechanism))
    assert result.positive_dimensional
    assert any("positive-dimensional" in note for note in result.notes)
    turn = 2 * math.asin(0.4)
    expected = [
        Pose(np.zeros(3), np.array([math.cos(s * turn / 2), 0, 0, math.sin(s * turn / 2)]))
        for s in (1, -1)
    ]
    assert same_modes(result, expected, mechanism.characteristic_length)


def test_a_singular_wrist_turns_freely_beside_isolated_modes():
    """Axes 4 and 6 in line: a set of solutions, q4 + q6 given; the isolated modes have q5 off zero,
    and close.
    """
    arm = pieper()
    result = check(arm, sampled(arm, pose=[90, 0, 220, 1, 0, 0, 0]))
    assert result.positive_dimensional
    assert all(abs(math.sin(mode.values["q5"])) > 1e-3 for mode in result)
    assert all(mode.condition < 1e6 for mode in result)


@pytest.mark.slow
@pytest.mark.parametrize("shape", in_gate(range(4), [0]))
@pytest.mark.parametrize("length", [100.0, 150.0])
def test_a_hexapod_of_equal_parallel_legs_moves_freely(shape, length):
    """Base and platform equal, all legs of one length: the platform translates on a sphere. The set
    is named, in seconds, and no point of the sphere (rotation 1, |t| = length) is called a mode.
    """
    ends = np.random.default_rng(shape).uniform(-100, 100, (6, 3))
    mechanism = hexapod(ends, ends)
    result = sampled(mechanism, joints=[length] * 6, starts=500)
    check(mechanism, result)
    assert result.positive_dimensional
    assert not any(np.allclose(mode.rotation, np.eye(3), atol=1e-4) for mode in result)


@pytest.mark.slow
@pytest.mark.parametrize(
    "given_",
    [
        {"joints": [150.0] * 6},
        {"seed": 1},
        pytest.param({"seed": 2}, marks=pytest.mark.long),
        pytest.param({"seed": 5}, marks=pytest.mark.long),
    ],
)
def test_degenerate_roots_end_in_a_result(given_):
    """On such a sphere the Jacobian loses three ranks: every count of starts and seed ends in a
    result, not an error.
    """
    ends = np.random.default_rng(3).uniform(-100, 100, (6, 3))
    assert sampled(hexapod(ends, ends), **given_).positive_dimensional


def test_three_rods_leave_the_platform_free_and_that_is_said():
    """Three distances on six freedoms: no isolated mode, and the count of free unknowns is
    named.
    """
    ring = [(100 * math.cos(t), 100 * math.sin(t), 0.0) for t in (0.0, 2.0, 4.0)]
    result = sampled(hexapod(ring, ring))
    assert (len(result), result.positive_dimensional) == (0, True)
    assert any("3 of 6 unknowns free" in note for note in result.notes)
    solution = symkin.solve(hexapod(ring, ring), joints=[110.0, 100.0, 105.0]).solution
    assert closes(hexapod(ring, ring), solution)


# --- merging --------------------------------------------------------------------------------------


@given(seeds)
def test_features_are_equal_where_configurations_are(rng):
    """Whole turns of angles and signs of quaternions change no feature; other steps, and turns of a
    screw joint, do.
    """
    problem = build_problem(MIXED, "direct")
    system = problem.system
    z = problem.select_values(
        random_values(problem.closure.coordinates, system.characteristic_length, rng),
        system.unknowns,
    )
    same, other = z.copy(), z.copy()
    c, place = list(zip(system.unknowns, system.slices, strict=True))[
        rng.integers(len(system.unknowns))
    ]
    step = {
        "quaternion": lambda v: -v,
        "angle": lambda v: v + 2 * math.pi * rng.integers(-2, 3),
    }.get(c.kind, lambda v: v)
    same[place] = step(z[place])
    step = {
        "quaternion": lambda v: v[[1, 0, 3, 2]] * [-1, 1, 1, -1],
        "turns": lambda v: v + 2 * math.pi,
    }
    other[place] = step.get(c.kind, lambda v: v + 0.01)(z[place])
    rows = features(system, np.array([z, same, other])) / system.characteristic_length
    assert np.allclose(rows[0], rows[1], atol=1e-12)
    assert np.max(np.abs(rows[0] - rows[2])) > 1e-5


MIXED = random_mechanism(np.random.default_rng(0), ["rRS", "rSRU", "SPS", "PUr", "hRC", "rHC"])


@given(seeds, st.integers(1, 6), st.integers(1, 40))
def test_merging_finds_the_clusters(rng, kinds, count):
    """Points scattered by less than the tolerance about far centres: one representative for each
    centre that occurs, and labels that agree with the centres.
    """
    centres = np.arange(kinds)[:, None] * 10.0 + rng.uniform(-1, 1, (kinds, 3))
    chosen = rng.integers(kinds, size=count)
    points = centres[chosen] + rng.uniform(-1e-7, 1e-7, (count, 3))
    first, labels = merge(points, 1e-6)
    assert len(first) == len(set(chosen))
    assert np.array_equal(chosen[first][labels], chosen)
    assert set(labels) == set(range(len(first)))


@given(st.lists(st.integers(1, 5), max_size=20))
def test_estimates_of_the_unseen(hits):
    """Chao 1984: at least f1^2 / (2 f2) are unseen, none when nothing was hit once; Good 1953: the
    next hit is new with probability f1 / n.
    """
    roots = Sample(np.zeros((len(hits), 1)), np.array(hits, dtype=int), 0.0, 100)
    once, twice = hits.count(1), hits.count(2)
    if twice:
        assert roots.unseen == pytest.approx(once**2 / (2 * twice))
    else:
        assert once * (once - 1) / 2 <= roots.unseen <= once**2 / 2
    assert roots.next_new == (once / sum(hits) if hits else 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("tiny", [0.0, 1e-41, 1e-20])
def test_a_joint_that_only_rounding_makes_matter_is_not_listed_value_by_value(tiny):
    """Two revolutes on one line: only the sum of their angles is determined. Parts of the pose's
    quaternion that are rounding give the rows derivatives of that order, and no value of the first
    angle is a mode of its own.
    """
    joints = [
        Joint("p", "P", (0, 0, 0), (1, 0, 0)),
        Joint("r", "R", (50, 0, 0), (0, 0, 1), actuated=True),
        Joint("s", "R", (50, 0, 0), (0, 0, 1)),
    ]
    mechanism = Mechanism("coaxial", [Limb("limb", joints)], (80.0, 10.0, 0.0))
    quaternion = (math.cos(0.1), 0.0, tiny, math.sin(0.1))
    x, y = math.cos(0.2) * 30 - math.sin(0.2) * 10 + 54.0, math.sin(0.2) * 30 + math.cos(0.2) * 10
    for method in ("multistart", "continuation"):
        found = symkin.modes(mechanism, pose=Pose((x, y, 0.0), quaternion), method=method)
        assert found.positive_dimensional
        assert not found.modes


@pytest.mark.parametrize("method", in_gate(["multistart", "continuation"], ["multistart"]))
def test_screws_are_sampled_over_many_turns(method: str) -> None:
    """The PR2's gripper: its screw of 2 mm a turn makes eleven turns for a finger of 0.3 rad, which
    `solve` follows to.
    """
    gripper = symkin.load(Path(__file__).parents[1] / "data" / "models" / "sdf" / "pr2_gripper.sdf")
    given = {"r_gripper_l_finger_joint": 0.3}
    near = symkin.solve(gripper, given=given).solution
    assert near is not None
    assert abs(near.joints["r_gripper_l_screw_screw_joint"]) > 4 * np.pi
    found = symkin.modes(gripper, given=given, starts=300, method=method)
    assert any(
        np.allclose(list(mode.joints.values()), list(near.joints.values()), atol=1e-6)
        for mode in found
    )


def test_every_turn_of_a_screw_is_listed() -> None:
    """A crank of 0.2 on a slider 0.6 away by a screw of 0.05 a turn: at a given place of both ends
    its length is 0.6 + 0.05 k, measured along the rod to either side, each with two cranks. Few
    starts hit few turns; the others follow from these one by one.
    """
    z, x = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
    rows = [
        ("crank", "R", ("base", "arm"), (0.0, 0.0, 0.0), z),
        ("pin", "R", ("arm", "nut"), (0.0, 0.2, 0.0), z),
        ("turn", "R", ("nut", "screw"), (0.0, 0.2, 0.0), x),
        ("thread", "H", ("screw", "end"), (0.6, 0.2, 0.0), x),
        ("heel", "R", ("end", "slider"), (0.6, 0.2, 0.0), z),
        ("slide", "P", ("base", "slider"), (0.0, 0.0, 0.0), x),
    ]
    joints = [
        LinkJoint(
            Joint(n, kind, p, axis, actuated=n in ("turn", "slide"), pitch=0.05 * (kind == "H")),
            links,
        )
        for n, kind, links, p, axis in rows
    ]
    mechanism = Mechanism("jack", link_joints=joints, length_unit="m", platform_link=None)
    found = symkin.modes(mechanism, given={"turn": 0.3, "slide": 0.01}, starts=200)
    away = math.hypot(0.61, 0.2)
    lengths = (0.6 + 0.05 * k for k in range(-60, 60))
    count = 2 * sum(away - 0.2 < abs(length) < away + 0.2 for length in lengths)
    assert (len(found), found.completeness) == (count, "sampled")
    assert any("turns" in note for note in found.notes)
