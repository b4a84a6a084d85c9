"""Plans: rank-one formulas against plain matrices, workspaces and wedges kept, planned postures
against random ones.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import get_args

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.built_machines import random_postures
from helpers.gate import in_gate
from helpers.inside import (
    NO_GROUP,
    Candidates,
    Criterion,
    ExchangeSearch,
    Noise,
    PlannedReadings,
    System,
    Workspace,
    build_closure,
    group_numbers,
    pose_slopes,
    random_configurations,
    simulate_readings,
)
from helpers.samples import delta, five_bar, three_rps
from symkin import InputError, Measurements, Pose, calibrate, plan_measurements

NOMINAL, TRUE = symkin.load("ren2008"), symkin.load("ren2008_true")
CRITERIA = get_args(Criterion)
NOISE = Noise(lengths=2e-6 / math.sqrt(12), group=math.radians(0.001) / math.sqrt(12), uniform=True)


def exchange(criterion, seed=0):
    rng = np.random.default_rng(seed)
    rows, group = rng.normal(size=(30, 2, 6)), rng.normal(size=(30, 2, 2))
    half = rng.normal(size=(6, 9))
    candidates = Candidates(rows, group, np.arange(30) % 3)
    return ExchangeSearch(candidates, 3, criterion, half @ half.T, 1e-2)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_gains_are_differences_of_the_criterion(criterion):
    """The gain of adding a candidate, and C after adding or removing one, are those of the inverse
    computed anew.
    """
    choice = exchange(criterion)
    chosen = list(range(9))
    c = choice.covariance(chosen)
    gains = choice.gains(c, np.arange(30))
    for k in (10, 17, 29):
        more = choice.covariance([*chosen, k])
        assert gains[k] == pytest.approx(choice.value(c) - choice.value(more), rel=1e-8, abs=1e-10)
        np.testing.assert_allclose(choice.updated(c, k), more, atol=1e-10)
        np.testing.assert_allclose(choice.without(more, [*chosen, k], 9), c, atol=1e-10)


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("precision", [1.0, 1e4, 1e8, 1e9, 1e12])
def test_readings_of_any_precision_are_judged(criterion, precision):
    """Candidates that each tell two parameters of six, beside a weak prior: three of different
    kinds are needed. To take out the only one that tells something leaves the prior, not rounding.
    """
    rng = np.random.default_rng(3)
    rows = np.zeros((30, 2, 6))
    for k in range(30):
        rows[k][:, 2 * (k % 3) : 2 * (k % 3) + 2] = np.linalg.qr(rng.normal(size=(2, 2)))[0]
    choice = ExchangeSearch(
        Candidates(precision * rows, np.zeros((30, 2, 2)), np.full(30, -1)),
        0,
        criterion,
        np.eye(6),
        1e-4,
    )
    for begun in ([0, 3, 6], [2, 1, 4], choice.greedy(3, {-1})):
        assert {k % 3 for k in choice.improve(begun, {-1})} == {0, 1, 2}
    c = choice.covariance([0, 1])
    np.testing.assert_allclose(np.linalg.eigvalsh(c)[-2:], 1e4, rtol=1e-6)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_a_greedy_choice_begins_with_what_is_kept(criterion):
    """Kept candidates stay, and each allowed wedge has one at least."""
    choice = exchange(criterion, 7)
    kept = [4, 7, 10]  # all on wedge 1
    chosen = choice.greedy(8, {0, 1}, kept)
    assert chosen[:3] == kept
    assert len(set(chosen)) == 8
    assert {k % 3 for k in chosen} == {0, 1}


@pytest.mark.parametrize("criterion", CRITERIA)
def test_exchange_ends_where_no_single_exchange_helps(criterion):
    """Improving never makes the criterion worse, and at its end no candidate in place of a chosen
    one makes it better.
    """
    choice = exchange(criterion, 5)
    allowed = {0, 1, 2}
    begun = choice.greedy(9, allowed)
    chosen = choice.improve(begun, allowed, passes=50)
    best = choice.value(choice.covariance(chosen))
    assert best <= choice.value(choice.covariance(begun)) + 1e-12
    assert len(set(chosen)) == 9
    for place in range(9):
        for k in set(range(30)) - set(chosen):
            other = choice.value(choice.covariance(chosen[:place] + [k] + chosen[place + 1 :]))
            assert other >= best - 1e-5 * abs(best)


@pytest.mark.parametrize(
    ("mechanism", "held"),
    [
        (NOMINAL, True),
        (three_rps(), True),
        (delta(), False),
        (symkin.load("gluon_6l3"), True),
        (symkin.load("zhao2000_links"), False),
    ],
    ids=["ren2008", "three_rps", "delta", "gluon_6l3", "zhao2000_links"],
)
def test_drawn_postures_close_within_limits_at_their_inclination(mechanism, held):
    """Postures close on all constraints, keep limits, and in a group R^T e_z is one vector."""
    rng = np.random.default_rng(2)
    workspace = Workspace.about(mechanism)
    wanted = np.repeat(workspace.inclinations(3, rng), 4, axis=0)
    made = workspace.draw(wanted, rng, held=held)
    closure = build_closure(mechanism)
    system = System(
        closure.coordinates,
        closure.variables,
        ca.SX(0, 1),
        closure.bound(closure.rows),
        closure.bound(closure.errors),
        closure.characteristic_length,
    )
    for values in made.values:
        assert system.residual(values, np.zeros(0)) < 1e-9 * mechanism.characteristic_length
    for c in closure.coordinates:
        if c.limits is not None and c.kind == "length":
            column = made.values[:, closure.slices[c.name].start]
            assert np.all((column >= c.limits[0]) & (column <= c.limits[1]))
    if held:
        ups = np.array(
            [Pose(row[:3], row[3:]).inverse().turn(np.array([0.0, 0.0, 1.0])) for row in made.poses]
        ).reshape(3, 4, 3)
        assert np.abs(ups - ups[:, :1]).max() < 1e-12


@pytest.mark.slow
def test_inclinations_that_a_platform_cannot_take_are_refused():
    """A platform that stays level has no posture at a tilt."""
    rng = np.random.default_rng(0)
    workspace = Workspace.about(delta())
    with pytest.raises(InputError, match="inclinations that the platform can take"):
        workspace.draw(np.array([[0.2, 0.1]]), rng)


def test_pose_slopes_are_differences_of_the_direct_problem():
    """dX/dp at held joints against a central difference of the direct problem of two neighbouring
    geometries.
    """
    from helpers.inside import with_parameters

    rng = np.random.default_rng(1)
    workspace = Workspace.about(NOMINAL)
    made = workspace.draw(workspace.inclinations(1, rng), rng, held=False)
    name, step = "leg3.base.x", 1e-5
    slopes, _ = pose_slopes(NOMINAL, made, [name])
    value = dict(
        zip(
            build_closure(NOMINAL).parameter_names,
            build_closure(NOMINAL).parameter_values,
            strict=True,
        )
    )[name]
    start = [*made.poses[0]]
    ends = [
        symkin.solve(
            with_parameters(NOMINAL, {name: value + s * step}), joints=made.joints[0], start=start
        ).solution.pose
        for s in (1, -1)
    ]
    np.testing.assert_allclose(
        slopes[0, :3, 0], (ends[0].position - ends[1].position) / (2 * step), atol=1e-6
    )


def test_predicted_deviations_are_those_of_a_fit():
    """The information of a plan's rows is the inverse of the covariance that a maximum-likelihood
    fit reports, held frames.
    """
    from helpers.inside import joint_frames, less_inclinations

    rng = np.random.default_rng(3)
    groups = group_numbers(40, 10)
    made = random_configurations(Workspace.about(NOMINAL), groups, Noise(), rng)
    quiet = simulate_readings(NOMINAL, made, groups, (), Noise(), rng)
    exact = symkin.Measurements(
        quiet.joints, groups=groups, joint_sigma=NOISE.joints(NOMINAL), group_sigma=NOISE.group
    )
    fit = calibrate(
        NOMINAL,
        exact,
        fixed=joint_frames(NOMINAL, ("leg1", "leg2", "leg6"), ("leg1", "leg2")),
        residual="maximum likelihood",
        outliers="ignore",
    )
    names = fit.problem.names
    slopes = PlannedReadings(NOMINAL, (), NOISE, names).slopes(made, grouped=True)
    rows = less_inclinations(Candidates(*slopes, groups), 10)
    covariance = np.linalg.inv(rows.T @ rows)
    sigmas = np.array([p.sigma for p in fit.parameters if not p.held])
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), sigmas, rtol=1e-3)


@pytest.fixture(scope="module")
def plan_24():
    workspace = Workspace.about(NOMINAL, [0.25, 0.25, 0.15], margin=0.02)
    return plan_measurements(workspace, 24, NOISE, groups=3, seed=1)


@pytest.mark.slow
def test_a_plan_keeps_its_workspace_and_wedges(plan_24):
    """24 postures in at most 3 groups at the wedges offered, within box, turn and stroke."""
    workspace = Workspace.about(NOMINAL, [0.25, 0.25, 0.15], margin=0.02)
    assert len(plan_24.groups) == 24
    assert len(plan_24.wedges) <= 3
    away = np.abs(workspace._middles(plan_24.configurations))
    assert np.all(away <= workspace.half * (1 + 1e-9))
    low, high = NOMINAL.limbs[0].limits
    assert np.all(
        (plan_24.configurations.joints >= low + 0.02 * (high - low))
        & (plan_24.configurations.joints <= high - 0.02 * (high - low))
    )
    for row, group in zip(plan_24.configurations.poses, plan_24.groups, strict=True):
        angles = inside.euler_from_quaternion(row[3:], "xyz")
        np.testing.assert_allclose(angles[:2], plan_24.wedges[group], atol=1e-9)
        assert abs(angles[2]) <= math.radians(20) + 1e-9


@pytest.mark.slow
def test_the_same_seed_gives_the_same_plan():
    """A plan is a function of its seed."""
    workspace, wedges = Workspace.about(NOMINAL), np.radians([[0.0, 0.0], [15.0, -15.0]])
    one, two = (
        plan_measurements(workspace, 10, NOISE, groups=2, wedges=wedges, seed=1) for _ in range(2)
    )
    assert np.array_equal(one.configurations.joints, two.configurations.joints)
    assert one.accuracy.worst_position == two.accuracy.worst_position


@pytest.mark.slow
def test_24_planned_postures_are_predicted_to_reach_the_accuracy(plan_24):
    """0.1 mm and 0.01 deg, largest of 200 poses in 95 % of calibrations, aligned frames; random
    postures miss both.
    """
    assert plan_24.accuracy.rank == 32
    assert plan_24.accuracy.worst_position < 1e-4
    assert math.degrees(plan_24.accuracy.worst_angle) < 0.01
    assert plan_24.random.worst_position > 1e-4


@pytest.mark.slow
def test_groups_of_a_platform_that_cannot_lean_stand_level():
    """A delta translates: by default its only wedge is level, and no other is tried."""
    noise = Noise(angles=1e-4, position=0.01, group=1e-5)
    plan = plan_measurements(symkin.load("delta"), 10, noise, readings=["position"])
    assert plan.wedges.tolist() == [[0.0, 0.0]]
    assert plan.groups.tolist() == [0] * 10


def test_plans_without_groups_use_readings():
    """With poses read, every parameter of an arm by DH that poses tell is observable, and a plan
    beats random postures.
    """
    arm = symkin.load("gluon_6l3")
    plan = plan_measurements(
        Workspace.about(arm),
        12,
        Noise(angles=1e-5, position=0.05, orientation=1e-4),
        groups=0,
        readings=("pose",),
        seed=2,
    )
    assert np.all(plan.groups == NO_GROUP)
    assert plan.accuracy.position < plan.random.position


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        ({"groups": 20}, "20 groups for 24 postures"),
        ({"criterion": "E"}, "allowed: D, A, I"),
        ({"groups": 0}, "nothing is read"),
        ({"readings": ("colour",)}, "colour"),
    ],
)
def test_plans_that_cannot_be_are_refused(options, fragment):
    """Counts, criteria and readings that cannot be are refused in one sentence."""
    with pytest.raises(InputError, match=fragment):
        plan_measurements(Workspace.about(NOMINAL), 24, NOISE, **options)


@pytest.mark.parametrize("count", in_gate([5, 20], [5]))
def test_a_plan_counts_what_a_fit_counts(count):
    """The rank of a plan is that of a fit of readings taken there, that of all candidates what many
    postures tell: redundant loops hold combinations of parameters in both.
    """
    machine, noise = delta(), Noise(position=0.02)
    plan = plan_measurements(machine, count, noise, groups=0, readings=["position"])
    for made, rank in (
        (plan.configurations, plan.accuracy.rank),
        (random_postures(machine, machine, 80, np.random.default_rng(0)), plan.observable),
    ):
        rng, groups = np.random.default_rng(0), np.full(len(made), NO_GROUP)
        read = simulate_readings(machine, made, groups, ("position",), noise, rng)
        assert calibrate(machine, read).rank == rank


def test_what_a_fit_refuses_is_neither_simulated_nor_planned():
    """A five-bar with one motor of two: readings, plan and fit are refused in the same sentence."""
    limbs = [
        replace(limb, joints=[replace(j, actuated=j.actuated and k == 0) for j in limb.joints])
        for k, limb in enumerate(five_bar().limbs)
    ]
    mechanism = replace(five_bar(), limbs=limbs, motion="planar")
    rng, groups = np.random.default_rng(0), group_numbers(10, 0)
    noise = Noise(angles=1e-4, position=1e-4, orientation=1e-4)
    made = random_configurations(Workspace.about(mechanism), groups, noise, rng)
    read = Measurements(made.joints, position=made.poses[:, :3], orientation=made.poses[:, 3:])
    for refused in (
        lambda: simulate_readings(mechanism, made, groups, ("pose",), noise, rng),
        lambda: plan_measurements(mechanism, 5, noise, groups=0, readings=["pose"]),
        lambda: calibrate(mechanism, read),
    ):
        with pytest.raises(InputError, match="do not determine the pose"):
            refused()
