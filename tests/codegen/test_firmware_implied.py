"""C of a platform whose joints imply a motion: solved as if that were declared, by formulas, and
honest about its limbs.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import (
    LimbPlatform,
    Options,
    Real,
    build_closure,
    build_problem,
    fit_passive,
    keeps_motion,
    limb_platform,
    limbwise_form,
)
from helpers.moved_points import three_upu

pytestmark = pytest.mark.slow

LINK = 70.0
"""Length (mm) of both links of each limb."""

HOME = np.array([[0.0, 0.0, 100.0, 1.0, 0.0, 0.0, 0.0]])


@pytest.fixture(scope="module")
def links():
    return symkin.load("zhao2000_links")


@pytest.fixture(scope="module")
def declared(asked):
    """The same with its motion declared, as it is generated."""
    return asked.program.kind


@pytest.fixture(scope="module")
def asked(links):
    tools.compiler("gcc")
    return tools.bench_module("asked").Asked(links, Options("double"))


def level_poses(count: int, seed: int = 3) -> np.ndarray:
    """Poses (count, 7) about the reference, turned about the vertical."""
    rng = np.random.default_rng(seed)
    half = 0.5 * rng.uniform(-0.2, 0.2, count)
    zeros = np.zeros(count)
    position = np.array([0.0, 0.0, 100.0]) + rng.uniform(-8, 8, (count, 3))
    return np.column_stack([position, np.cos(half), zeros, zeros, np.sin(half)])


@pytest.mark.long
def test_the_code_is_of_the_implied_motion_and_the_model_that_of_the_file(links, asked):
    program = asked.program
    assert (links.motion, program.kind.mechanism.motion) == ("spatial", "schoenflies")
    assert isinstance(program.kind, LimbPlatform)
    assert program.kind.direct_formulas is not None
    assert links.digest in program.header
    assert "_direct_newton(" not in program.source


@pytest.mark.long
def test_direct_of_inverse_is_the_pose_and_closes_every_row(links, asked):
    """Also the rows that the implied motion makes redundant, those of the platform's tilt."""
    poses = level_poses(40)
    status, joints = asked.back(poses)
    assert not status.any()
    found = asked.answers(joints, np.tile(HOME, (len(poses), 1)))
    assert not found.status.any()
    np.testing.assert_allclose(found.found, poses, atol=1e-8)
    closure, problem = build_closure(links), build_problem(links, "direct")
    told = frozenset(c.name for c in closure.role("actuated", "pose"))
    for pose, q in zip(found.found[:6], joints, strict=False):
        values = closure.reference.copy()
        for c, value in zip(closure.role("actuated"), q, strict=True):
            values[closure.slices[c.name]] = value
        values[closure.slices["pose.x"].start :][:7] = pose
        values = fit_passive(closure, values, told)
        known = problem.select_values(values, problem.known_coordinates)
        assert (
            problem.system.residual(problem.select_values(values, problem.system.unknowns), known)
            < 1e-6
        )


@pytest.mark.long
def test_a_tilted_guess_is_refused(asked):
    tilted = np.array([[0.0, 0.0, 100.0, np.cos(0.05), np.sin(0.05), 0.0, 0.0]])
    _, joints = asked.back(level_poses(1))
    assert asked.answers(joints, tilted).status[0] == tools.bench_module("asked").STATUSES.index(
        "OUT_OF_RANGE"
    )


@pytest.mark.long
def test_lines_on_which_a_limb_is_stretched_are_refused(declared, asked):
    """Where a limb's ends are further apart than its links: by the planes and the rod alone, which
    know nothing of reach, in many points of the line; also where both ends of the line are within
    reach.
    """
    twin = symkin.load("zhao2000")
    platform = LimbPlatform(twin, Options("double"), Real("double", "x"))
    form = platform.direct_formulas.form
    rng, home = np.random.default_rng(8), HOME
    status, begin = asked.back(home)
    assert not status.any()
    goals = begin + rng.uniform(-1, 1, (5000, 4)) * [0.9, 0.9, 0.9, 60.0]
    answers = asked.answers(goals, np.tile(home, (len(goals), 1)))
    signs = form.signs_at(platform.home_values)
    names = [f"{what}{k}" for what in ("radial", "height") for k in (1, 2, 3)]
    asked_for = [form.whole.numbers[name][0].value for name in names]
    squares = [one.value for one in form.discriminants]
    least, at_end = np.full(len(goals), np.inf), np.zeros(len(goals))
    for part in np.linspace(0.0, 1.0, 61):
        at = begin + part * (goals - begin)
        values, square = (form.at(ca.vertcat(*e), signs, at).T for e in (asked_for, squares))
        values = np.where(np.all(square >= 0.0, axis=0), values, np.nan)
        reached = values[:3] ** 2 + values[3:] ** 2
        slack = 4 * LINK**2 - np.max(reached, axis=0)
        least = np.minimum(least, np.where(np.isfinite(slack), slack, -np.inf))
        at_end = slack
    within = least > 1.0
    stretched = (least < -1.0) & np.isfinite(least) & (at_end > 1.0)
    assert within.sum() > 300
    assert stretched.any()
    assert np.sum((least < -1.0) & np.isfinite(least)) > 100
    assert np.mean(answers.status[within] == 0) > 0.9
    assert not np.any(answers.status[least < -1.0] == 0)
    assert declared.mechanism.motion == twin.motion


@pytest.mark.long
def test_lines_on_which_the_couples_lose_rank_are_refused(asked):
    """Half way all three limbs stand in parallel planes, so that their couples are one."""
    home = HOME
    _, begin = asked.back(home)
    middle = np.array([np.pi / 2, 3 * np.pi / 2, 3 * np.pi / 2, begin[0, 3]])
    for beyond in (1.2, 1.6, 2.0):
        goal = begin + beyond * (middle - begin)
        assert asked.answers(goal, home).status[0] != 0


def couples_of_upu(position: np.ndarray) -> np.ndarray:
    """The determinant of the couples of `three_upu` at positions (n, 3), by its geometry: each
    limb's is across its outer axis, the tangent, in the plane of that and its leg.
    """
    legs, tangents = [], []
    for k in range(3):
        t = 2 * np.pi * k / 3
        out, tangent = np.array([np.cos(t), np.sin(t), 0.0]), np.array([-np.sin(t), np.cos(t), 0.0])
        legs.append(position + 80 * out - 200 * out)
        tangents.append(tangent)
    couples = [
        leg - np.outer(leg @ tangent, tangent) for leg, tangent in zip(legs, tangents, strict=True)
    ]
    return np.linalg.det(np.stack(couples, axis=1))


def legs_of_upu(places: np.ndarray) -> np.ndarray:
    """The legs' lengths (n, 3) of `three_upu` at positions."""
    turns = 2 * np.pi * np.arange(3) / 3
    out = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(3)])
    return np.linalg.norm(places[:, None] - 120 * out, axis=2)


@pytest.mark.long
def test_couples_that_no_divisor_watches_are_watched_themselves():
    """The couples of a 3-UPU lose rank where its spheres do not: their volume is a guard, here
    compared with that by geometry.
    """
    made = limb_platform(three_upu(), Options("double"), Real("double", "x"))
    assert (made.mechanism.motion, made.direct_formulas is not None) == ("translation", True)
    form = made.direct_formulas.form
    (reach,) = form.reaches
    # the volume is this times the root of the spheres' discriminant, which has a guard of its own
    square = form.of_values(form.discriminants[0].value)
    guard = ca.Function("guard", [form.values], [reach.value, square])
    places = np.array([0.0, 0.0, 300.0]) + np.random.default_rng(4).uniform(-250, 250, (30, 3))
    own = []
    for place in places:
        value, square = guard(legs_of_upu(place[None]).ravel())
        own.append(float(value) * float(square) ** 0.5)
    np.testing.assert_allclose(
        np.array(own) / own[0], couples_of_upu(places) / couples_of_upu(places[:1]), rtol=1e-7
    )


@pytest.mark.parametrize("real", in_gate(["double", "float"], ["double"]))
def test_lines_of_a_3_upu_on_which_couples_lose_rank_are_refused(real):
    """Goals are the legs' lengths at positions beyond the surface on which the couples depend on
    one another, and on this side.
    """
    tools.compiler("gcc")
    asked = tools.bench_module("asked").Asked(three_upu(), Options(real))
    rng, home = np.random.default_rng(6), np.array([[0.0, 0.0, 300.0, 1.0, 0.0, 0.0, 0.0]])
    places = home[0, :3] + rng.uniform(-1, 1, (3000, 3)) * [200.0, 200.0, 290.0]
    poses = np.column_stack([places, np.tile(home[0, 3:], (len(places), 1))])
    status, joints = asked.back(poses)
    assert not status.any()
    answers = asked.answers(joints, np.tile(home, (len(places), 1)))
    beyond = couples_of_upu(places) * couples_of_upu(home[:, :3]) < 0.0
    ok = answers.status == 0
    assert beyond.sum() > 100
    assert not np.any(
        np.abs(answers.found[ok & beyond, :3] - places[ok & beyond]).max(axis=1, initial=0.0) < 1.0
    )
    reached = couples_of_upu(answers.found[ok, :3])
    assert np.all(reached * couples_of_upu(home[:, :3]) > 0.0)
    assert np.mean(ok[~beyond]) > 0.3


@pytest.mark.long
def test_volumes_are_compared_with_divisors(declared):
    """The couples of the three limbs are watched; without the divisors they are not."""
    found = declared.direct_formulas
    assert keeps_motion(declared, found)
    form = replace(found.form, divisors=found.form.divisors[:0])
    assert not keeps_motion(declared, replace(found, form=form))


def test_a_struct_of_geometry_keeps_the_described_motion(links):
    made = limb_platform(links, Options("double", geometry="struct"), Real("double", "x"))
    assert made.mechanism.motion == "spatial"


@pytest.mark.long
def test_formulas_limb_by_limb_hold_in_every_direction_of_a_limb(declared):
    """No plane of a limb is special, as one along an axis would be if rows were divided by a
    cosine.
    """
    samples, limbs = declared.samples, [block.system for block in declared._closure_blocks]
    whole = limbwise_form(declared.direct, limbs, samples)
    assert whole is not None
    assert [reach.name for reach in whole.reaches] == ["elbow1", "elbow2", "elbow3"]
    home = declared.direct.reference_known
    system = declared.direct.system
    found = ca.vertcat(*(whole.whole.numbers[c.name][0].value for c in system.unknowns))
    squares = ca.vertcat(*(one.value for one in whole.discriminants))
    for angle in (0.0, 0.5 * np.pi, np.pi):
        turned = home.copy()
        turned[0] = angle
        real = [
            signs
            for signs in product((1.0, -1.0), repeat=5)
            if np.all(whole.at(squares, signs, turned[None]) >= 0.0)
        ]
        for signs in real:
            at = whole.at(found, signs, turned[None])
            assert system.residual(at[0], turned) <= 1e-9 * system.characteristic_length
        assert len(real) > 0 or angle != 0.5 * np.pi
        assert np.isfinite(whole.at(squares, np.ones(5), turned[None])).all()
