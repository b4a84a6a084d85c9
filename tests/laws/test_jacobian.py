"""Symbolic Jacobians: equal to differences, derivatives too; names, refusals."""

from __future__ import annotations

from functools import partial

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import jacobian_cases as cases
from helpers import samples
from helpers.gate import in_gate
from helpers.inside import KINDS, closed_configurations
from symkin import InputError, jacobian


def _kinds(case):
    return [kind for kind in KINDS if kind != "passive" or case.closure.role("passive")]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("name", [n for n in cases.NAMES if n != "redundant actuation"])
def test_analytic_equals_differences_of_pose_coordinates(name):
    """Column k of Ja: rates of the pose coordinates while actuated joint k moves, to 1e-7 of the
    largest entry; a serial arm's quaternion up to sign.
    """
    case = cases.case(name)
    analytic = jacobian(case.mechanism, "analytic")
    expected = analytic.at(case.values)
    place = slice(case.closure.slices[case.closure.role("pose")[0].name].start, None)
    if case.mechanism.serial:
        forward = _forward_quaternion(analytic, case.values)
        base = cases.along_joint(case, 0, 0.0)[place]
        expected[3:] *= np.sign(forward @ base[3:])
    for k in range(len(case.mechanism.actuated)):
        assert cases.agrees(
            expected[:, k], partial(_pose_rates, case, k, place), cases.step_of(case, k)
        )


def _pose_rates(case, k, place, step):
    return cases.differences(lambda s: cases.along_joint(case, k, s)[place], step)


def _forward_quaternion(analytic, values):
    pose = analytic.expressions.differential.pose
    return np.asarray(
        ca.Function("q", [analytic.closure.variables], [pose.quaternion])(values)
    ).ravel()


SECOND_ORDER = [
    "zhang2009",
    "gluon_6l3",
    "zhao2000",
    "delta",
    "3 RPS",
    "planar three_rrr",
    "cylindrical",
    "loop HPUS",
    "translation PUS",
    "spherical HUS",
    "arm RPRHRR",
]


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(SECOND_ORDER, SECOND_ORDER[::4]))
def test_second_order_equals_differences(name):
    """dJ/dq_k along the closure by differences of J at solved configurations, to 1e-7 of the
    largest entry of J and its derivative; dJ/dt is their sum with the rates, given all rates or the
    actuated ones.
    """
    case = cases.case(name)
    rates = np.random.default_rng(0).normal(size=len(case.mechanism.actuated))
    passive = cases.closure_passive(case) @ rates if case.closure.role("passive") else []
    full = np.concatenate([rates, passive, jacobian(case.mechanism).at(case.values) @ rates])
    for kind in _kinds(case):
        symbolic = jacobian(case.mechanism, kind)
        hessian = symbolic.hessian_at(case.values)
        assert hessian.shape == (len(rates), *symbolic.shape)
        for k in range(len(rates)):
            unit = cases.step_of(case, k)
            scale = max(np.max(np.abs(hessian[k])), np.max(np.abs(symbolic.at(case.values))) / unit)
            errors = (
                np.max(np.abs(_rates_of(symbolic, case, k, h * unit) - hessian[k]))
                for h in (1e-3, 1e-4, 1e-5)
            )
            assert any(error < 1e-7 * scale for error in errors)
        total = np.einsum("k,krc->rc", rates, hessian)
        bound = 1e-9 * max(np.max(np.abs(hessian)) * np.sum(np.abs(rates)), 1e-300)
        np.testing.assert_allclose(
            symbolic.time_derivative_at(case.values, rates), total, rtol=0, atol=bound
        )
        np.testing.assert_allclose(
            symbolic.time_derivative_at(case.values, full), total, rtol=0, atol=bound
        )


def _rates_of(symbolic, case, k, step):
    return cases.differences(lambda s: symbolic.at(cases.along_joint(case, k, s)), step)


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000", "gluon_6l3", "three_rps"])
def test_geometry_may_stay_symbols(name):
    """With `parameters`, the nominal geometry gives the bound Jacobian, and another geometry one
    that satisfies the velocity equations with it.
    """
    case = cases.case(name)
    other, found = 1.001 * case.closure.parameter_values, {}
    for kind in ("direct", "inverse"):
        open_, bound = (
            jacobian(case.mechanism, kind, parameters=True),
            jacobian(case.mechanism, kind),
        )
        expected = bound.at(case.values)
        np.testing.assert_allclose(
            open_.at(case.values), expected, rtol=0, atol=1e-11 * np.max(np.abs(expected))
        )
        assert open_.parameters
        assert not bound.parameters
        found[kind] = open_.at(case.values, other)
    m = cases.matrices(case, other)
    left = m.twist @ found["direct"] + m.actuated
    if m.passive.size:
        left -= m.passive @ np.linalg.lstsq(m.passive, left, rcond=None)[0]
    np.testing.assert_allclose(left, 0.0, atol=1e-9 * np.max(np.abs(m.actuated)))
    product = found["direct"] @ found["inverse"]
    np.testing.assert_allclose(product @ product, product, atol=1e-8 * np.max(np.abs(product)))


@pytest.mark.parametrize("limbs", [["rCU"] * 3, ["hRS"] * 3, ["rH", "CS"], ["RpS"] * 3])
def test_rates_of_cut_joints_are_those_of_the_geometry_that_is_given(limbs):
    """With `parameters`, the passive Jacobian of one machine at the geometry of another of the same
    limbs is that of the other: axes, points and pitches of cut joints are symbols too.
    """
    one, other = (samples.random_mechanism(np.random.default_rng(k), limbs) for k in (3, 4))
    open_, bound = jacobian(one, "passive", parameters=True), jacobian(other, "passive")
    closure = bound.closure
    assert closure.parameter_names == open_.closure.parameter_names
    values = closed_configurations(closure, 1)[0]
    expected = bound.at(values)
    np.testing.assert_allclose(
        open_.at(values, closure.parameter_values),
        expected,
        rtol=0,
        atol=1e-9 * np.max(np.abs(expected)),
    )


def test_six_rods_have_the_closed_form():
    """Row i of the inverse Jacobian of six rods is (d, s x d) / length, d the rod, s = R a; no
    other operation is left.
    """
    mechanism = symkin.load("zhang2009")
    case = cases.case("zhang2009")
    inverse = jacobian(mechanism, "inverse")
    x = case.values
    q = x[9:13]
    rows = []
    for k, limb in enumerate(mechanism.limbs):
        arm = symkin.Pose(np.zeros(3), q).apply(np.array(limb.platform))
        d = x[6:9] + arm - np.array(limb.base)
        rows.append(np.concatenate([d, np.cross(arm, d)]) / x[k])
    np.testing.assert_allclose(inverse.at(x), rows, rtol=1e-13)
    assert inverse.function.n_instructions() < 300


def test_names_are_identifiers():
    """Inputs are named after coordinates; what no identifier allows becomes _, and names stay
    different.
    """
    limbs = [
        symkin.Limb(
            "a",
            [samples.turning("x", 0.0, 0.0, actuated=True), samples.turning("my joint", 0.0, 60.0)],
        ),
        symkin.Limb(
            "b",
            [
                samples.turning("1st", 100.0, 0.0, actuated=True),
                samples.turning("my-joint", 100.0, 60.0),
                samples.turning("e", 50.0, 120.0),
            ],
        ),
    ]
    mechanism = symkin.Mechanism(
        "odd", limbs, platform_position=(50.0, 120.0, 0.0), motion="planar"
    )
    names = [v.name for v in jacobian(mechanism, "direct", parameters=True).inputs]
    assert all(name.isidentifier() for name in names)
    assert len(set(names)) == len(names)
    assert {"x", "q_1st", "my_joint", "my_joint_2", "x_2", "y", "gamma"} >= set(names)


def test_what_is_not_defined_is_refused_in_a_sentence():
    """Unknown kinds, passive joints that there are not, too few or no actuated joints, rates of a
    wrong number, values that are none.
    """
    platform = symkin.load("zhang2009")
    with pytest.raises(InputError, match="allowed: direct, inverse, analytic, passive"):
        jacobian(platform, "forward")
    with pytest.raises(InputError, match="no passive joint"):
        jacobian(platform, "passive")
    five = samples.random_mechanism(np.random.default_rng(3), ["SPS"] * 5)
    with pytest.raises(InputError, match="5 actuated joints held the platform keeps 1"):
        jacobian(five, "direct")
    assert jacobian(five, "inverse").shape == (5, 6)
    none = symkin.Mechanism("none", [symkin.Limb("a", [samples.turning("r", 0.0, 0.0)])])
    with pytest.raises(InputError, match="no actuated joint"):
        jacobian(none)
    with pytest.raises(InputError, match="rates: 4 values given"):
        jacobian(platform).time_derivative_at(cases.case("zhang2009").values, np.zeros(4))
    for name in ("zhang2009", "ankle"):
        matrix = jacobian(symkin.load(name))
        with pytest.raises(InputError, match=r"values: .* = nan is not finite"):
            matrix.at(np.full(matrix.closure.reference.shape, np.nan))


def test_a_serial_arm_needs_its_joints_only():
    """The Jacobian of an arm is one of its joints: their values suffice."""
    arm = symkin.load("gluon_6l3")
    values = dict(zip([c.name for c in arm.actuated], [0.1, 0.2, -0.4, 0.3, 0.7, 0.5], strict=True))
    assert [v.source for v in jacobian(arm).inputs] == list(values)
    assert jacobian(arm).at(values).shape == (6, 6)
