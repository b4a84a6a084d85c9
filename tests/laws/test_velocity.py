"""Velocity equations: the Jacobians satisfy them, agree with finite differences and are each
other's inverses.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import symkin
from helpers import jacobian_cases as cases
from helpers import samples
from helpers.gate import in_gate
from helpers.inside import velocity_equations, whole_system
from symkin import InputError, SolveError


def _scaled(equations, direct):
    """The direct Jacobian with angles times the size."""
    return direct * equations.scales[0][:, None] / equations.scales[2]


@pytest.mark.parametrize("name", in_gate(cases.NAMES, cases.FEW))
def test_equations_are_the_closures_differential(name):
    """A, P and B, columns scaled to lengths, are the tangent Jacobian of the closure's rows by
    automatic differentiation; for a serial arm, whose equations are others, A t + B q' vanishes on
    the closure's null space.
    """
    case = cases.case(name)
    equations = velocity_equations(case.mechanism)
    matrices = equations.at(case.values)
    twist, passive, actuated = equations.scales
    columns = list(equations.columns)
    whole = np.hstack(
        [
            matrices.actuated / actuated,
            matrices.passive / passive,
            (matrices.twist / twist)[:, columns],
        ]
    )
    _, expected = whole_system(case.closure).linearise_one(case.values, np.zeros(0))
    if equations.differential.explicit:
        null = np.linalg.svd(expected)[2][np.linalg.matrix_rank(expected) :]
        np.testing.assert_allclose(whole @ null.T, 0.0, atol=1e-12)
    else:
        np.testing.assert_allclose(whole, expected, atol=1e-13 * np.max(np.abs(expected)))


@pytest.mark.parametrize("name", in_gate(cases.NAMES, cases.FEW[::2]))
def test_jacobians_solve_the_equations(name):
    """A J + P Jp + B = 0 (actuation not redundant), columns scaled; J J^-1 is the identity on
    feasible twists and zero on their complement; J^-1 J is the identity where the twist decides the
    rates.
    """
    case = cases.case(name)
    equations = velocity_equations(case.mechanism)
    m = equations.at(case.values)
    direct, inverse = m.direct_jacobian, m.inverse_jacobian
    if name != "redundant actuation":
        left = (m.twist @ direct + m.passive @ m.passive_jacobian + m.actuated) / equations.scales[
            2
        ]
        largest = np.max(np.abs(m.actuated / equations.scales[2]))
        np.testing.assert_allclose(left, 0.0, atol=1e-12 * max(1.0, case.condition / 1e3) * largest)
    columns = list(equations.columns)
    product = (
        _scaled(equations, direct) @ (inverse * equations.scales[2][:, None] / equations.scales[0])
    )[np.ix_(columns, columns)]
    np.testing.assert_allclose(
        product, m.feasible_projector, atol=1e-13 * max(10.0, case.condition)
    )
    np.testing.assert_allclose(product @ product, product, atol=1e-13 * max(10.0, case.condition))
    if name not in cases.REDUNDANT:
        rates = inverse @ direct * equations.scales[2][:, None] / equations.scales[2]
        np.testing.assert_allclose(
            rates, np.eye(len(rates)), atol=1e-13 * max(10.0, case.condition)
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", in_gate([n for n in cases.NAMES if n != "redundant actuation"], cases.FEW[::2])
)
def test_jacobians_equal_differences_of_solved_configurations(name):
    """Column k of J and Jp: twist and passive rates while actuated joint k moves, by central
    differences, to 1e-7 of the largest entry.
    """
    case = cases.case(name)
    equations = velocity_equations(case.mechanism)
    matrices = equations.at(case.values)
    idle = any(part.held for part in equations.limbs)
    for k, expected in enumerate(
        np.vstack([matrices.direct_jacobian, matrices.passive_jacobian]).T[:, : 6 if idle else None]
    ):
        assert cases.agrees(
            expected, partial(_rates_along_joint, case, k, len(expected)), cases.step_of(case, k)
        )


def _rates_along_joint(case, k, count, step):
    path = partial(cases.along_joint, case, k)
    return np.concatenate(
        [cases.twist(case, path, step), cases.joint_rates(case, path, step, "passive")]
    )[:count]


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(cases.UNCONSTRAINED, cases.UNCONSTRAINED[::2]))
def test_inverse_equals_differences_of_solved_configurations(name):
    """Column of J^-1: rates of the actuated joints while the pose moves along one component of the
    motion, to 1e-7 of the largest entry.
    """
    case = cases.case(name)
    equations = velocity_equations(case.mechanism)
    inverse = equations.at(case.values).inverse_jacobian
    for k, column in enumerate(equations.columns):
        unit = 1.0 if column >= 3 else case.closure.characteristic_length
        assert cases.agrees(inverse[:, column], partial(_rates_along_pose, case, k), unit)


def _rates_along_pose(case, k, step):
    return cases.joint_rates(case, partial(cases.along_pose, case, k), step, "actuated")


def test_redundant_actuation_is_least_squares():
    """Seven rods: a motion's rates give its twist, and any rates the twist that leaves the least
    closure error.
    """
    case = cases.case("redundant actuation")
    m = velocity_equations(case.mechanism).at(case.values)
    rates = np.random.default_rng(0).normal(size=7)
    twist = m.direct_jacobian @ rates
    best = np.linalg.lstsq(m.twist, -m.actuated @ rates, rcond=None)[0]
    np.testing.assert_allclose(twist, best, rtol=1e-9)
    np.testing.assert_allclose(m.direct_jacobian @ m.inverse_jacobian, np.eye(6), atol=1e-10)


def test_redundant_arm_takes_the_shortest_rates():
    """Seven joints: J^-1 is the pseudo-inverse of J with angles times the size."""
    case = cases.case("arm RRRRRRR")
    equations = velocity_equations(case.mechanism)
    m = equations.at(case.values)
    scales = equations.scales
    scaled = np.linalg.pinv(_scaled(equations, m.direct_jacobian))
    np.testing.assert_allclose(
        m.inverse_jacobian * scales[2][:, None] / scales[0],
        scaled,
        atol=1e-12 * np.max(np.abs(scaled)),
    )


def test_singular_configurations_are_refused_by_name():
    """The reference of a platform with all rods in one plane is of type 2; an outstretched arm is
    of type 1.
    """
    flat = symkin.load("zhang2009")
    matrices = velocity_equations(flat).at(velocity_equations(flat).closure.reference)
    with pytest.raises(SolveError, match="type 2"):
        _ = matrices.direct_jacobian
    arm = samples.pieper()
    straight = velocity_equations(arm)
    with pytest.raises(SolveError, match="type 1"):
        _ = straight.at(straight.closure.reference).inverse_jacobian
    assert np.all(np.isfinite(straight.at(straight.closure.reference).direct_jacobian))


def test_too_few_actuated_joints_are_refused_with_their_number():
    """Five rods leave the platform one freedom; the inverse Jacobian is defined all the same."""
    mechanism = samples.random_mechanism(np.random.default_rng(3), ["SPS"] * 5)
    equations = velocity_equations(mechanism)
    assert equations.freedom == 1
    matrices = equations.at(equations.closure.reference)
    with pytest.raises(SolveError, match="5 actuated joints held, the platform keeps 1"):
        _ = matrices.direct_jacobian
    assert matrices.inverse_jacobian.shape == (5, 6)


def test_values_may_be_a_solution_or_its_names():
    """A Solution, its values and the closure's vector give the same matrices; what is missing is
    named.
    """
    mechanism = symkin.load("zhao2000")
    solution = symkin.solve(mechanism).solution
    equations = velocity_equations(mechanism)
    first, second = equations.at(solution), equations.at(solution.values)
    np.testing.assert_array_equal(first.direct_jacobian, second.direct_jacobian)
    with pytest.raises(InputError, match=r"pose\.gamma is missing"):
        equations.at({k: v for k, v in solution.values.items() if k != "pose.gamma"})
    with pytest.raises(InputError, match="shape"):
        equations.at(np.zeros(3))
    with pytest.raises(InputError, match="parameters"):
        equations.at(solution, np.zeros(2))
