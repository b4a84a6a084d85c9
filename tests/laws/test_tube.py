"""The proofs of steps: tubes hold one branch of a closed form, and none is proved over a fold."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import (
    ALONE,
    Cubic,
    Interval,
    between,
    build_problem,
    coefficients,
    make_trajectory,
    path_systems,
)
from helpers.laws import same_angle
from helpers.samples import (
    COUPLER,
    CRANK,
    GROUND,
    ROCKER,
    TOGGLE,
    bars,
    rocker_angle,
)


def test_tube_holds_one_branch_and_not_the_other():
    """The closed form's branch lies in the proved tube at every crank angle of the step, the other
    branch outside.
    """
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    problem = build_problem(mechanism, "direct")
    system = path_systems(problem)[0]
    index = [c.name for c in problem.system.unknowns].index("d")
    trajectory = make_trajectory(mechanism, joints=[[1.0], [1.05]])
    interval = Interval(system, coefficients(problem.known_coordinates, *trajectory.samples)[None])
    ends = []
    for angle in (1.0, 1.05):
        mode = next(
            m for m in symkin.modes(mechanism, joints=[angle]) if _on(m.joints["d"], angle, 0)
        )
        ends.append(
            np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns])
            / system.scale
        )
    slopes = [_slope(interval, np.append(z, u)) for z, u in zip(ends, (0.0, 1.0), strict=True)]
    curve = one_cubic(np.append(ends[0], 0.0), slopes[0], np.append(ends[1], 1.0), slopes[1], 1.0)
    tubes = interval.tubes(curve, ALONE)
    assert tubes.proved.all()
    assert tubes.grows.all()
    for u in np.linspace(0, 1, 21):
        own, other = (
            rocker_angle(1.0 + 0.05 * u, k) - rocker_angle(math.pi / 3, 0) for k in (0, 1)
        )
        there = curve.at(u)
        root = system.correct(there, interval.c)[0]
        assert abs(root[0, index] - own) < 1e-9
        assert tubes.hold(u, root, np.zeros(root.shape)).all()
        root[0, index] = other
        assert not tubes.hold(u, root, np.zeros(root.shape)).any()


def one_cubic(a, slope_a, b, slope_b, length) -> Cubic:
    """A single one of several cubics."""
    return Cubic.hermite(a[None], slope_a[None], b[None], slope_b[None], np.array([length]))


def _on(d: float, angle: float, branch: int) -> bool:
    return same_angle(d, rocker_angle(angle, branch) - rocker_angle(math.pi / 3, 0), 1e-6)


def _slope(interval: Interval, y: np.ndarray) -> np.ndarray:
    jacobian = interval.evaluate(y[None], ALONE)[1][0]
    return np.append(-np.linalg.solve(jacobian[:, :-1], jacobian[:, -1]), 1.0)


def test_no_tube_over_a_fold_or_off_the_branch():
    """No tube is proved over crank angles beyond the toggle, nor about a curve that is off the
    branch.
    """
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    problem = build_problem(mechanism, "direct")
    system = path_systems(problem)[0]
    mode = symkin.modes(mechanism, joints=[TOGGLE - 1e-3])[0]
    z = (
        np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns])
        / system.scale
    )
    for end, shift in ((TOGGLE + 1e-3, 0.0), (TOGGLE - 0.99e-3, 0.3)):
        trajectory = make_trajectory(mechanism, joints=[[TOGGLE - 1e-3], [end]])
        interval = Interval(
            system, coefficients(problem.known_coordinates, *trajectory.samples)[None]
        )
        slope = _slope(interval, np.append(z, 0.0))
        a = np.append(z + shift, 0.0)
        tubes = interval.tubes(one_cubic(a, slope, a + slope, slope, 1.0), ALONE)
        assert not tubes.grows.any()


def on_branch(interval, y, direction):
    """The branch's point on the plane through y across a direction, and its tangent, both (1, w +
    1), by Newton's method in the plane.
    """
    for _ in range(6):
        value, slope = interval.evaluate(y[None], ALONE)
        y = y - np.linalg.lstsq(np.vstack([slope[0], direction]), np.append(value[0], 0.0))[0]
    tangent = np.linalg.svd(interval.evaluate(y[None], ALONE)[1][0])[2][-1]
    return y[None], (tangent * np.sign(tangent @ direction))[None]


@pytest.mark.parametrize(
    ("path", "folds"), [((TOGGLE - 1e-2, TOGGLE), True), ((TOGGLE, TOGGLE - 1e-2), False)]
)
def test_curvature_of_the_path_parameter_is_proved_at_a_fold(path, folds):
    """Through the toggle the crank angle has a maximum over the arc of the branch: u curves down
    where it grows to the toggle, and up where it grows away from it.
    """
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    problem = build_problem(mechanism, "direct")
    system = path_systems(problem)[0]
    trajectory = make_trajectory(mechanism, joints=[[v] for v in path])
    interval = Interval(system, coefficients(problem.known_coordinates, *trajectory.samples)[None])
    mode = symkin.modes(mechanism, joints=[TOGGLE - 1e-6])[0]
    z = (
        np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns])
        / system.scale
    )
    y = np.append(z, (TOGGLE - 1e-6 - path[0]) / (path[1] - path[0]))
    null = np.linalg.svd(interval.evaluate(y[None], ALONE)[1][0, :, :-1])[2][-1]
    direction = np.append(null, 0.0)
    a, b = (on_branch(interval, y + s * direction, direction) for s in (-1e-3, 1e-3))
    tubes = interval.tubes(between(a, b), ALONE)
    assert tubes.proved.all()
    slopes = [float(v[1][0, -1]) for v in (a, b)]
    assert tubes.grows.all() <= (min(slopes) > 0.0 or max(slopes) < 0.0)
    assert interval.folds(tubes, ALONE).all() == folds


def test_a_symmetry_that_keeps_unknowns_still_costs_no_steps():
    """A delta whose platform does not turn, and one with a rod's end moved by 0.5 of 520: as many
    steps, to a factor of two.
    """
    symmetric = symkin.load("delta_parallelograms")
    first, *others = symmetric.link_rods
    moved = replace(first, start=tuple(v + 0.5 for v in first.start))
    general = replace(symmetric, link_rods=(moved, *others))
    joints = [[0, 0, 0], [10, 20, 5]]
    steps = [symkin.track(machine, joints=joints).steps for machine in (symmetric, general)]
    assert steps[0] <= 2 * steps[1]
