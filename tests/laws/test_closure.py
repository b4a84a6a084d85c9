"""The closure F(q, x, X) = 0 against plain products of displacement matrices."""

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import symkin
from helpers import inside
from helpers.gate import in_gate
from helpers.inside import build_closure, build_problem, multiply, parse, random_values
from helpers.laws import (
    axis_turn,
    ball_turn,
    chain,
    differences,
    displacement,
    evaluated,
    frame,
    limb_gap,
)
from helpers.samples import (
    BENNETT,
    delta,
    four_bar,
    pieper,
    random_coordinate,
    random_mechanism,
    seeds,
    three_rrr,
    unit,
)
from helpers.shipped import TWELVE
from symkin import Joint, Limb, Mechanism, Pose, Rod, RodLimb

# limb by letters (lower case: actuated), the joint at which it is cut, and the rows that remain
CUTS = {
    "rRS": ("S", 3),
    "SrR": ("S", 3),
    "pUS": ("S", 3),
    "rRU": ("U", 4),
    "UrP": ("U", 4),
    "rPC": ("C", 4),
    "hCR": ("C", 4),
    "rRR": ("R", 5),
    "pRP": ("P", 5),
    "PPr": ("P", 5),
    "rpH": (None, 6),
    "rphrpr": (None, 6),
    "SrS": ("SS", 1),
    "rSPS": ("SS", 1),
    "SS": ("SS", 1),
    # the link before the third ball is a body: one distance to the second, the third's three rows
    "SRSrS": ("SSS", 4),
}
SAMPLES = {name: (lambda name=name: symkin.load(name)) for name in symkin.shipped_names()}
SAMPLES |= {
    "delta": delta,
    "pieper": pieper,
    "four_bar": lambda: four_bar()[0],
    "bennett": lambda: parse(BENNETT),
    "three_rrr": three_rrr,
    "three_rrr planar": lambda: three_rrr("planar"),
}


def variables(closure, named):
    """The vector of a closure's variables from named values."""
    return np.concatenate([np.atleast_1d(named[c.name]) for c in closure.coordinates])


def forward_configuration(rng, mechanism):
    """Random values of all joints of a one-limb mechanism, those of the cut joint too, and the pose
    where they lead, of the link before the last joint too.
    """
    joints = mechanism.limbs[0].joints
    named = {c.name: random_coordinate(rng, c) for j in joints for c in j.coordinates}
    closure = build_closure(mechanism)
    at = closure.slices
    carried = {"pose": joints, f"limb0.{len(joints) - 1}": joints[:-1]}
    for name, before in carried.items():
        if f"{name}.x" not in at:
            continue
        origin = [closure.reference[at[f"{name}.{k}"]][0] for k in "xyz"]
        reference = frame(origin, closure.reference[at[f"{name}.quaternion"]])
        pose = Pose.from_matrix(chain(before, named) @ reference)
        named |= dict(zip((f"{name}.x", f"{name}.y", f"{name}.z"), pose.position, strict=True))
        named[f"{name}.quaternion"] = pose.quaternion
    return named


# --- where the closure vanishes, and where not ----------------------------------------------------


@pytest.mark.parametrize("name", SAMPLES)
def test_the_reference_closes(name):
    """Rows and errors vanish at the reference configuration; a rod of its own `length` is the only
    exception.
    """
    closure = build_closure(SAMPLES[name]())
    rows, errors = evaluated(closure, closure.reference)
    assert np.max(np.abs(rows)) < 1e-13
    assert np.max(np.abs(errors)) < 1e-12


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds)
def test_the_reference_of_any_mechanism_closes(rng):
    """The same for limbs of every joint type, several at once."""
    closure = build_closure(random_mechanism(rng, rng.permutation([*CUTS, "SPS", "SPS"])[:5]))
    rows, errors = evaluated(closure, closure.reference)
    assert np.max(np.abs(rows)) < 1e-13
    assert np.max(np.abs(errors)) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("kinds", CUTS)
@settings(max_examples=4)
@given(rng=seeds)
def test_forward_kinematics_closes(kinds, rng):
    """Rows and errors vanish at the pose that any joint values lead to, and only the cut joint's
    values are not needed.
    """
    mechanism = random_mechanism(rng, [kinds])
    closure = build_closure(mechanism)
    named = forward_configuration(rng, mechanism)
    rows, errors = evaluated(closure, variables(closure, named))
    assert np.max(np.abs(rows)) < 1e-12
    assert np.max(np.abs(errors)) < 1e-11
    held = {c.name for c in closure.coordinates}
    missing = "".join(
        j.type for j in mechanism.limbs[0].joints if j.coordinates[0].name not in held
    )
    assert missing == (CUTS[kinds][0] or "")


@pytest.mark.slow
@pytest.mark.parametrize("kinds", in_gate(list(CUTS)[:-1], list(CUTS)[:-1:2]))
@settings(max_examples=8)
@given(rng=seeds)
def test_elsewhere_the_closure_does_not_vanish(kinds, rng):
    """At a random pose, and a small step away, rows and errors see the gap that plain matrices
    measure.
    """
    mechanism = random_mechanism(rng, [kinds])
    closure = build_closure(mechanism)
    named = forward_configuration(rng, mechanism)
    for step in (1e-4, 1.0):
        pushed = dict(named)
        for k in "xyz":
            pushed[f"pose.{k}"] = named[
                f"pose.{k}"
            ] + step * closure.characteristic_length * rng.uniform(0.1, 1.0)
        turn = inside.quaternion_from_rotation_vector(step * rng.uniform(0.3, 1.0, 3))
        pushed["pose.quaternion"] = inside.multiply(turn, named["pose.quaternion"])
        rows, errors = evaluated(closure, variables(closure, pushed))
        known = {c.name: pushed[c.name] for c in closure.coordinates}
        platform = frame([pushed[f"pose.{k}"] for k in "xyz"], pushed["pose.quaternion"])
        gap = (
            limb_gap(mechanism, mechanism.limbs[0], platform, known) / closure.characteristic_length
        )
        assert np.max(np.abs(rows)) > 1e-7
        assert 0.01 * min(gap, gap * closure.characteristic_length) < np.max(np.abs(errors))
        assert np.max(np.abs(errors)) > 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("kind", "RP")
@settings(max_examples=12)
@given(rng=seeds)
def test_half_turns_are_no_spurious_roots(kind, rng):
    """A half turn about a random direction is no displacement of a revolute or a slide: rows and
    errors see it.
    """
    mechanism = random_mechanism(rng, [f"r{kind}"])
    closure = build_closure(mechanism)
    named = forward_configuration(rng, mechanism)
    half = displacement(axis_turn(symkin_direction(rng), math.pi), [0.0, 0.0, 0.0])
    there = frame([named[f"pose.{k}"] for k in "xyz"], named["pose.quaternion"])
    pose = Pose.from_matrix(there @ half)
    rows, errors = evaluated(
        closure, variables(closure, named | {"pose.quaternion": pose.quaternion})
    )
    assert np.max(np.abs(rows)) > 1e-3
    assert np.max(np.abs(errors)) > 1e-3


def symkin_direction(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


@pytest.mark.slow
@given(seeds)
def test_rods_keep_their_length(rng):
    """A limb with rods: each row vanishes exactly where the rod's end distance is its length, given
    or as it stands.
    """
    start, end = rng.uniform(-50, 50, 3), rng.uniform(-50, 50, 3)
    for length in (None, 70.0):
        limb = Limb(
            "l",
            [Joint("q", "R", (1, 2, 3), (0, 0.6, 0.8), actuated=True)],
            [Rod(tuple(start), tuple(end), length)],
        )
        mechanism = Mechanism("m", [limb], platform_position=(10.0, 20.0, 30.0))
        closure = build_closure(mechanism)
        q, quaternion = float(rng.uniform(-3, 3)), np.array(rng.normal(size=4))
        quaternion /= np.linalg.norm(quaternion)
        tip = (chain(limb.joints, {"q": q}) @ [*start, 1.0])[:3]
        rod = length or float(np.linalg.norm(start - end - [10.0, 20.0, 30.0]))
        position = tip + rod * symkin_direction(rng) - ball_turn(quaternion) @ end
        rows, errors = evaluated(closure, np.array([q, *position, *quaternion]))
        assert np.max(np.abs(rows)) < 1e-12
        assert np.max(np.abs(errors)) < 1e-12
        rows, errors = evaluated(
            closure, np.array([q, *(position + 0.1 * (position - tip)), *quaternion])
        )
        assert np.max(np.abs(rows)) > 1e-4
        assert np.max(np.abs(errors)) > 1e-4


# --- counts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("kinds", CUTS)
@given(rng=seeds)
@settings(max_examples=2)
def test_the_cut_leaves_what_its_joint_constrains(kinds, rng):
    """S 3, U and C 4, R and P 5, none 6, two S ends 1; sources name the limb."""
    closure = build_closure(random_mechanism(rng, [kinds]))
    assert closure.rows.shape == (CUTS[kinds][1], 1)
    assert [source.limb for source in closure.row_sources] == ["limb0"] * CUTS[kinds][1]


@pytest.mark.parametrize("kinds", in_gate(list(CUTS)[:-2], list(CUTS)[:-2:2]))
@given(rng=seeds)
@settings(max_examples=4)
def test_each_row_takes_a_freedom_of_the_platform(kinds, rng):
    """At a closed configuration of one limb, its joints held but the cut one, the rows'
    differential in the pose has full rank: 6 less the cut joint's freedom. (Not of balls alone,
    and not of three, whose rows hold a body within the limb.)
    """
    mechanism = random_mechanism(rng, [kinds])
    problem = build_problem(mechanism, "direct" if mechanism.actuated else "given", held=())
    values = variables(problem.closure, forward_configuration(rng, mechanism))
    z, known = (
        problem.select_values(values, problem.system.unknowns),
        problem.select_values(values, problem.known_coordinates),
    )
    _, jacobian = problem.system.linearise_one(z, known)
    assert np.linalg.matrix_rank(jacobian[:, -6:], tol=1e-6) == CUTS[kinds][1]


@settings(max_examples=10)
@given(seeds)
def test_rows_of_limbs_add(rng):
    """Several limbs: the rows of each; a rod limb has one."""
    limbs = [str(k) for k in rng.permutation([*CUTS, "SPS"])[:4]]
    closure = build_closure(random_mechanism(rng, limbs))
    assert closure.rows.shape[0] == sum(1 if kinds == "SPS" else CUTS[kinds][1] for kinds in limbs)
    assert len(closure.row_sources) == closure.rows.shape[0]


@pytest.mark.slow
@given(seeds)
@settings(max_examples=10)
def test_coordinates_stand_actuated_passive_pose(rng):
    """The order of variables, their slices, and no coordinate twice."""
    mechanism = random_mechanism(rng, ["hRS", "SPS", "PrU", "SSp"])
    closure = build_closure(mechanism)
    roles = [c.role for c in closure.coordinates]
    assert roles == sorted(roles, key=["actuated", "passive", "pose"].index)
    assert [c.name for c in closure.role("actuated")] == [c.name for c in mechanism.actuated]
    assert len({c.name for c in closure.coordinates}) == len(closure.coordinates)
    stops = [place.stop for place in closure.slices.values()]
    assert stops == list(np.cumsum([c.width for c in closure.coordinates]))
    assert closure.variables.shape[0] == stops[-1]


# --- symmetries -----------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds)
def test_quaternion_signs_and_whole_turns_do_not_matter(rng):
    """|F| and the errors are even in each quaternion and periodic in each angle (not in a helical
    joint's).
    """
    closure = build_closure(random_mechanism(rng, ["rRS", "rSRU", "SPS", "PUr", "hRC"]))
    values = random_values(closure.coordinates, closure.characteristic_length, rng)
    rows, errors = evaluated(closure, values)
    for c in closure.coordinates:
        moved = values.copy()
        place = closure.slices[c.name]
        if c.kind == "quaternion":
            moved[place] *= -1
        elif c.kind == "angle":
            moved[place] += 2 * math.pi * rng.integers(-2, 3)
        elif c.kind == "turns":
            moved[place] += 2 * math.pi
        else:
            continue
        there, seen = evaluated(closure, moved)
        if c.kind == "turns":
            assert np.max(np.abs(errors - seen)) > 1e-6
        else:
            assert np.allclose(np.abs(rows), np.abs(there), atol=1e-11)
            assert np.allclose(errors, seen, atol=1e-11)


# --- derivatives ----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["direct", "inverse"])
@settings(max_examples=6)
@given(rng=seeds)
def test_jacobian_is_the_differential_of_the_rows(kind, rng):
    """dF/dd in the tangent space against central differences through `move`, quaternions
    included.
    """
    problem = build_problem(random_mechanism(rng, [*rng.permutation(list(CUTS))[:4], "SPS"]), kind)
    system = problem.system
    values = random_values(problem.closure.coordinates, problem.closure.characteristic_length, rng)
    z, known = (
        problem.select_values(values, system.unknowns),
        problem.select_values(values, problem.known_coordinates),
    )
    _, jacobian = system.linearise_one(z, known)

    def rows(step):
        return system.linearise_one(system.move(z[None], step[None])[0], known)[0]

    expected = differences(rows, system.freedom, 1e-5 * system.characteristic_length)
    assert np.allclose(jacobian, expected, atol=1e-7 * max(1.0, np.max(np.abs(jacobian))))


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
@pytest.mark.parametrize("kind", ["direct", "inverse"])
def test_a_step_adds_numbers_and_turns_quaternions(name, kind):
    """`move` of stacks of every length: lengths add d, angles d / size, quaternions become (1, d /
    2 size) q, normalised.
    """
    system = build_problem(symkin.load(name), kind).system
    rng = np.random.default_rng(17)
    for count in (1, 5, 300):
        z, step = (
            rng.normal(size=(count, system.width)),
            system.characteristic_length * rng.normal(size=(count, system.freedom)),
        )
        expected, column = z.copy(), 0
        for c, place in zip(system.unknowns, system.slices, strict=True):
            part = step[:, column : column + c.freedom]
            if c.kind == "quaternion":
                turns = np.hstack([np.ones((count, 1)), part / (2 * system.characteristic_length)])
                moved = np.array(
                    [multiply(turn, q) for turn, q in zip(turns, z[:, place], strict=True)]
                )
                expected[:, place] = moved / np.linalg.norm(moved, axis=1, keepdims=True)
            else:
                expected[:, place] += part / system.characteristic_length if c.is_angular else part
            column += c.freedom
        np.testing.assert_allclose(system.move(z, step), expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_batched_rows_are_those_of_each_point(name):
    """`linearise` of a stack, longer than one mapped call, gives what `linearise_one` gives for
    each point.
    """
    problem = build_problem(symkin.load(name), "inverse")
    rng = np.random.default_rng(0)
    values = np.array(
        [
            random_values(problem.closure.coordinates, problem.closure.characteristic_length, rng)
            for _ in range(131)
        ]
    )
    known = problem.select_values(values[0], problem.known_coordinates)
    points = np.array([problem.select_values(v, problem.system.unknowns) for v in values])
    rows, jacobians = problem.system.linearise(points, known)
    for k in (0, 1, 127, 128, 130):
        one, jacobian = problem.system.linearise_one(points[k], known)
        assert np.allclose(rows[k], one, rtol=1e-12, atol=1e-12)
        assert np.allclose(jacobians[k], jacobian, rtol=1e-12, atol=1e-12)


# --- parameters -----------------------------------------------------------------------------------


def test_parameter_names_are_key_paths():
    """leg1.base.x, leg1.offset, trt1.theta1.point.z, dh.3.a: the place in the file."""
    names = {n: build_closure(symkin.load(n)).parameter_names for n in symkin.shipped_names()}
    assert {"leg1.base.x", "leg6.platform.z", "leg3.offset"} <= set(names["zhang2009"])
    assert {"trt1.theta1.point.z", "trt2.theta2.zero", "trt3.radial3.axis.x", "op.base.y"} <= set(
        names["zhao2000"]
    )
    assert {"dh.3.a", "dh.1.theta", "dh.6.alpha"} <= set(names["gluon_6l3"])
    assert {"theta4.point.x", "L6.axis.x", "tool.position.z"} <= set(names["yao2020"])
    assert "limb1.rod2.length" in build_closure(delta()).parameter_names


@pytest.mark.parametrize("name", ["ren2008", "ren2008_true"])
def test_ren2008_has_the_papers_42_parameters(name):
    """Six limbs of two points and a length offset, 6 (3 + 3 + 1) = 42 (Ren 2008)."""
    closure = build_closure(symkin.load(name))
    assert len(closure.parameter_names) == 42
    ends = [f"{end}.{k}" for end in ("base", "platform") for k in "xyz"]
    assert set(closure.parameter_names) == {
        f"leg{i}.{key}" for i in range(1, 7) for key in [*ends, "offset"]
    }


@pytest.mark.parametrize("name", SAMPLES)
def test_parameters_are_the_geometry(name):
    """Names are unique, values finite; the rows with the values bound contain coordinates only, and
    do not change.
    """
    closure = build_closure(SAMPLES[name]())
    assert (
        len(set(closure.parameter_names))
        == len(closure.parameter_names)
        == len(closure.parameter_values)
    )
    assert np.all(np.isfinite(closure.parameter_values))
    values = random_values(
        closure.coordinates, closure.characteristic_length, np.random.default_rng(1)
    )
    free = ca.Function("free", [closure.variables, closure.parameters], [closure.rows])
    assert np.allclose(
        np.array(free(values, closure.parameter_values)).ravel() / closure.characteristic_length,
        evaluated(closure, values)[0],
        atol=1e-12,
    )


@given(seeds)
@settings(max_examples=20)
def test_a_parameter_is_the_number_in_the_file(rng):
    """Moving leg1.base.x in the closure equals moving it in the mechanism."""
    ends = rng.uniform(-100, 100, (3, 2, 3))
    legs = [
        RodLimb(f"leg{k}", tuple(b), tuple(p), float(k)) for k, (b, p) in enumerate(ends, start=1)
    ]
    mechanism = Mechanism("m", legs, platform_position=(1.0, 2.0, 3.0))
    closure = build_closure(mechanism)
    k = closure.parameter_names.index("leg1.base.x")
    moved = closure.parameter_values.copy()
    moved[k] += 7.0
    legs[0] = RodLimb("leg1", tuple(ends[0, 0] + [7.0, 0, 0]), tuple(ends[0, 1]), 1.0)
    other = build_closure(Mechanism("m", legs, platform_position=(1.0, 2.0, 3.0)))
    values = random_values(closure.coordinates, closure.characteristic_length, rng)
    free = ca.Function("free", [closure.variables, closure.parameters], [closure.rows])
    assert np.allclose(
        np.array(free(values, moved)).ravel(),
        evaluated(other, values)[0]
        * other.characteristic_length
        * other.characteristic_length
        / closure.characteristic_length,
        atol=1e-9,
    )


# --- restricted motions ---------------------------------------------------------------------------

MOTIONS = {
    "spatial": ["pose.x", "pose.y", "pose.z", "pose.quaternion"],
    "schoenflies": ["pose.x", "pose.y", "pose.z", "pose.gamma"],
    "planar": ["pose.x", "pose.y", "pose.gamma"],
    "translation": ["pose.x", "pose.y", "pose.z"],
    "spherical": ["pose.quaternion"],
}


@pytest.mark.parametrize("motion", MOTIONS)
@settings(max_examples=10)
@given(rng=seeds)
def test_a_restricted_pose_stays_in_its_group(motion, rng):
    """The pose has the coordinates stated, the reference among its values, and moves only in the
    group from there.
    """
    mechanism = random_mechanism(rng, ["SPS", "rRS"], motion=motion)
    closure = build_closure(mechanism)
    assert [c.name for c in closure.role("pose")] == MOTIONS[motion]
    values = random_values(closure.coordinates, closure.characteristic_length, rng)
    function = ca.Function("pose", [closure.variables], [closure.bound(closure.pose.matrix)])
    reference = frame(mechanism.platform_position, mechanism.platform_quaternion)
    assert np.allclose(np.array(function(closure.reference)), reference, atol=1e-12)
    moved = np.array(function(values))
    turn, shift = moved[:3, :3] @ reference[:3, :3].T, moved[:3, 3] - reference[:3, 3]
    if motion in ("schoenflies", "planar"):
        assert np.allclose(turn @ [0, 0, 1], [0, 0, 1], atol=1e-12)
    if motion == "translation":
        assert np.allclose(turn, np.eye(3), atol=1e-12)
    if motion == "planar":
        assert abs(shift[2]) < 1e-12
    if motion == "spherical":
        assert np.allclose(shift, 0, atol=1e-12)


def spherical_rrr():
    """Three limbs of three revolutes through the origin."""
    rng = np.random.default_rng(5)
    limbs = []
    for k in range(3):
        axes = [tuple(symkin_direction(rng)) for _ in range(3)]
        joints = [Joint(f"j{k}{i}", "R", axis=a, actuated=i == 0) for i, a in enumerate(axes)]
        limbs.append(Limb(f"limb{k}", joints))
    return Mechanism("spherical", limbs, motion="spherical")


@pytest.mark.parametrize(
    ("make", "rows"),
    [
        (lambda: three_rrr("planar"), 3 * 2),
        (spherical_rrr, 3 * 2),
        (lambda: symkin.load("zhao2000"), 3 * 3 + 1),
        (delta, 6),
    ],
    ids=["planar", "spherical", "schoenflies", "translation"],
)
def test_rows_that_vanish_in_the_group_are_dropped(make, rows):
    """Planar: a revolute's point in the plane; spherical: its axis; Schoenflies: its point; each
    row left can be nonzero.
    """
    closure = build_closure(make())
    assert closure.rows.shape[0] == rows == len(closure.row_sources)
    rng = np.random.default_rng(0)
    samples = [
        evaluated(closure, random_values(closure.coordinates, closure.characteristic_length, rng))[
            0
        ]
        for _ in range(4)
    ]
    assert np.all(np.max(np.abs(samples), axis=0) > 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("motion", in_gate(MOTIONS, ["planar", "spatial", "spherical"]))
@settings(max_examples=10)
@given(
    rng=seeds, kinds=st.lists(st.sampled_from("RPCU"), min_size=1, max_size=4), zeros=st.booleans()
)
@example(rng=np.random.default_rng(0), kinds=["P", "R", "P"], zeros=True)
def test_rows_and_checks_hold_no_symbol_but_the_coordinates_once_bound(motion, rng, kinds, zeros):
    """Also where a parameter cancels in the rows, but not in the checks: a slide's axis, a hinge
    about z under a restricted pose.
    """
    joints = []
    for k, kind in enumerate(kinds):
        axis = np.eye(3)[rng.integers(3)] if zeros else symkin_direction(rng)
        other = {"axis2": tuple(np.roll(axis, 1))} if kind == "U" else {}
        joints.append(Joint(f"j{k}", kind, tuple(rng.normal(size=3)), tuple(axis), **other))
    limbs = [Limb("limb", joints), RodLimb("leg", (1, 2, 3), (0, 0, 1))]
    closure = build_closure(Mechanism("any", limbs, (0.0, 1.0, 2.0), unit(rng, 4), motion=motion))
    ca.Function(
        "bound", [closure.variables], [closure.bound(closure.rows), closure.bound(closure.errors)]
    )


def test_problems_of_a_mechanism_share_its_closure_however_many_others_came_between():
    """Symbols of a closure that is built anew are others: problems must not hold one that the rest
    has forgotten.
    """
    limb = Limb("limb", [Joint("q", "R", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), actuated=True)])
    first = Mechanism("first", [limb], (100.0, 0.0, 0.0))
    build_problem(first, "inverse")
    for k in range(140):
        build_problem(first, "direct")
        build_problem(Mechanism(f"other{k}", [limb], (101.0 + k, 0.0, 0.0)), "inverse")
    assert build_problem(first, "direct").closure is build_problem(first, "inverse").closure
