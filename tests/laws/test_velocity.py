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
from helpers.inside import conjugate, multiply, rate_names, velocity_equations, whole_system
from symkin import InputError, Joint, LinkJoint, Mechanism, jacobian


def _scaled(matrices, direct):
    """The direct Jacobian with angles times the size."""
    return direct * matrices.scales[0][:, None] / matrices.scales[2]


@pytest.mark.parametrize("name", in_gate(cases.NAMES, cases.FEW))
def test_equations_are_the_closures_differential(name):
    """A, P and B, columns scaled to lengths, are the tangent Jacobian of the closure's rows by
    automatic differentiation; for a serial arm, whose equations are others, A t + B q' vanishes on
    the closure's null space.
    """
    case = cases.case(name)
    equations = velocity_equations(
        case.mechanism, case.mechanism.characteristic_length, bound=False
    )
    matrices = cases.matrices(case)
    twist, passive, actuated = matrices.scales
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
    """A J + P Jp + B = 0 (actuation not redundant), columns scaled; J J^-1 is the orthogonal
    projector onto the feasible twists, as many as the motion has less those that the limbs forbid;
    J^-1 J is the identity where the twist decides the rates.
    """
    case = cases.case(name)
    equations, m = (
        velocity_equations(case.mechanism, case.mechanism.characteristic_length, bound=False),
        cases.matrices(case),
    )
    direct, inverse = (jacobian(case.mechanism, k).at(case.values) for k in ("direct", "inverse"))
    if name != "redundant actuation":
        left = m.twist @ direct + m.actuated
        if case.closure.role("passive"):
            joints = cases.closure_passive(case)
            floating = m.passive[:, len(joints) :]
            left += m.passive[:, : len(joints)] @ joints
            left -= floating @ np.linalg.lstsq(floating, left, rcond=None)[0]
        largest = np.max(np.abs(m.actuated / m.scales[2]))
        bound = 1e-12 * max(1.0, case.condition / 1e3)
        np.testing.assert_allclose(left / m.scales[2], 0.0, atol=bound * largest)
    columns = list(equations.columns)
    product = (_scaled(m, direct) @ (inverse * m.scales[2][:, None] / m.scales[0]))[
        np.ix_(columns, columns)
    ]
    bound = 1e-13 * max(10.0, case.condition)
    np.testing.assert_allclose(product @ product, product, atol=bound)
    np.testing.assert_allclose(product, product.T, atol=bound)
    assert round(np.trace(product)) == len(columns) - equations.ranks.constraints
    if name not in cases.REDUNDANT:
        rates = inverse @ direct * m.scales[2][:, None] / m.scales[2]
        np.testing.assert_allclose(rates, np.eye(len(rates)), atol=bound)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", in_gate([n for n in cases.NAMES if n != "redundant actuation"], cases.FEW[::2])
)
def test_jacobians_equal_differences_of_solved_configurations(name):
    """Column k of J and Jp: twist and passive rates while actuated joint k moves, by central
    differences, to 1e-7 of the largest entry.
    """
    case = cases.case(name)
    equations = velocity_equations(
        case.mechanism, case.mechanism.characteristic_length, bound=False
    )
    rates = jacobian(case.mechanism).at(case.values)
    passive = rate_names(case.closure.role("passive"))
    if passive and len(equations.used) == len(passive):
        rates = np.vstack([rates, cases.closure_passive(case)])
    for k, expected in enumerate(rates.T):
        assert cases.agrees(
            expected, partial(_rates_along_joint, case, k, len(expected)), cases.step_of(case, k)
        )


def _rates_along_joint(case, k, count, step):
    path = partial(cases.along_joint, case, k)
    return np.concatenate(
        [cases.twist(case, path, step), cases.joint_rates(case, path, step, "passive")]
    )[:count]


CUT = ["zhao2000", "three_rps", "five_bar", "helical_actuated", "3 RUU", "loop HPUS", "3 RCU"]


@pytest.mark.parametrize("name", in_gate(CUT, CUT[:4]))
def test_rates_of_cut_joints_equal_differences_of_what_they_read(name):
    """Every passive joint is told, those at which limbs are cut too: rows are central differences
    of what joints read while an actuated joint moves, to 1e-7 of the largest entry; a spherical
    joint's angular velocity.
    """
    case = cases.case(name)
    made = jacobian(case.mechanism, "passive")
    passive = [c for c in case.mechanism.coordinates if c.role != "actuated"]
    names = [c.name for c in passive]
    assert made.rows == rate_names(passive)
    for k, expected in enumerate(made.at(case.values).T):
        assert cases.agrees(
            expected, partial(_reading_rates, case, names, k), cases.step_of(case, k)
        )


def _reading_rates(case, names, k, step):
    here = cases.readings(case, case.values)

    def read(name, s):
        there = cases.readings(case, cases.along_joint(case, k, s))[name]
        if len(there) == 1:
            return np.remainder(there - here[name] + np.pi, 2 * np.pi) - np.pi
        return there * np.sign(there @ here[name])

    found = []
    for name in names:
        rate = cases.differences(partial(read, name), step)
        found.append(rate if len(rate) == 1 else 2 * multiply(rate, conjugate(here[name]))[1:])
    return np.concatenate(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(cases.UNCONSTRAINED, cases.UNCONSTRAINED[::2]))
def test_inverse_equals_differences_of_solved_configurations(name):
    """Column of J^-1: rates of the actuated joints while the pose moves along one component of the
    motion, to 1e-7 of the largest entry.
    """
    case = cases.case(name)
    equations = velocity_equations(
        case.mechanism, case.mechanism.characteristic_length, bound=False
    )
    inverse = jacobian(case.mechanism, "inverse").at(case.values)
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
    m = cases.matrices(case)
    direct, inverse = (jacobian(case.mechanism, k).at(case.values) for k in ("direct", "inverse"))
    rates = np.random.default_rng(0).normal(size=7)
    best = np.linalg.lstsq(m.twist, -m.actuated @ rates, rcond=None)[0]
    np.testing.assert_allclose(direct @ rates, best, rtol=1e-9)
    np.testing.assert_allclose(direct @ inverse, np.eye(6), atol=1e-10)


def test_redundant_arm_takes_the_shortest_rates():
    """Seven joints: J^-1 is the pseudo-inverse of J with angles times the size."""
    case = cases.case("arm RRRRRRR")
    m = cases.matrices(case)
    direct, inverse = (jacobian(case.mechanism, k).at(case.values) for k in ("direct", "inverse"))
    scaled = np.linalg.pinv(_scaled(m, direct))
    np.testing.assert_allclose(
        inverse * m.scales[2][:, None] / m.scales[0],
        scaled,
        atol=1e-12 * np.max(np.abs(scaled)),
    )


def test_angles_of_an_arm_are_weighed_by_the_size_of_the_whole_mechanism():
    """Of a graph that is an arm, beside which a long link hangs: J^-1 is the pseudo-inverse of J
    with angles times the size.
    """
    axes, joints = {"a": (0, 0, 1), "b": (0.6, 0.8, 0), "c": (0, 1, 0)}, []
    places, links = [(0, 0, 0), (1, 0.2, 0.5), (2, 1, 0)], ["base", "l1", "l2", "l3"]
    for k, (name, axis) in enumerate(axes.items()):
        joint = Joint(name, "R", places[k], axis, actuated=True)
        joints.append(LinkJoint(joint, (links[k], links[k + 1])))
    joints.append(LinkJoint(Joint("h", "R", (30, 0, 0), (0, 1, 0), actuated=True), ("base", "h")))
    arm = Mechanism("arm", link_joints=joints, platform_link="l3", platform_position=(3, 2, 1))
    at, size = symkin.solve(arm, joints=[10, 20, 30, 40]).solution, arm.characteristic_length
    direct, inverse = (jacobian(arm, kind).at(at) for kind in ("direct", "inverse"))
    lengths = np.repeat([1.0, size], 3)
    expected = np.linalg.pinv(lengths[:, None] * direct) * lengths
    np.testing.assert_allclose(inverse, expected, rtol=1e-9, atol=1e-12)


def test_singular_configurations_have_no_finite_jacobian():
    """The reference of a platform with all rods in one plane is of type 2, where the direct
    Jacobian is not finite; an outstretched arm is of type 1, where the inverse one is not.
    """
    flat, arm = symkin.load("zhang2009"), samples.pieper()
    direct, inverse = jacobian(flat), jacobian(arm, "inverse")
    assert not np.isfinite(direct.at(direct.closure.reference)).all()
    straight = inverse.closure.reference
    assert not np.abs(inverse.at(straight)).max() < 1e12
    assert np.isfinite(jacobian(arm).at(straight)).all()


def test_values_may_be_a_solution_or_its_names():
    """A Solution, its values and the closure's vector give the same matrices; what is missing is
    named.
    """
    mechanism = symkin.load("zhao2000")
    solution = symkin.solve(mechanism).solution
    direct = jacobian(mechanism)
    np.testing.assert_array_equal(direct.at(solution), direct.at(solution.values))
    with pytest.raises(InputError, match=r"pose\.gamma is missing"):
        direct.at({k: v for k, v in solution.values.items() if k != "pose.gamma"})
    with pytest.raises(InputError, match="shape"):
        direct.at(np.zeros(3))
    with pytest.raises(InputError, match="parameters"):
        direct.at(solution, np.zeros(2))
