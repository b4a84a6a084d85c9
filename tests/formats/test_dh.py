"""Denavit-Hartenberg tables against products of the four elementary matrices of each row."""

import math
from functools import reduce

import numpy as np
import pytest
from hypothesis import given, settings

import symkin
from helpers.laws import axis_turn, frame, refused_in_one_line
from helpers.samples import seeds
from symkin import DHRow, DHTable, Joint, Limb, Mechanism, serial_arm_from_dh

X, Z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])


def screw_motion(axis, angle, slide):
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = axis_turn(axis, angle), slide * axis
    return g


def dh_product(table, values):
    """standard: Rz(theta) Tz(d) Tx(a) Rx(alpha); modified (Craig): Rx(alpha) Tx(a) Rz(theta)
    Tz(d).
    """
    total = np.eye(4)
    for row, q in zip(table.rows, values, strict=True):
        theta, d = (row.theta + q, row.d) if row.type == "R" else (row.theta, row.d + q)
        z, x = screw_motion(Z, theta, d), screw_motion(X, row.alpha, row.a)
        total = total @ (z @ x if table.convention == "standard" else x @ z)
    return total


def random_table(rng, convention, count=5):
    rows = [
        DHRow(
            f"q{k}",
            str(rng.choice(["R", "P"])),
            rng.uniform(-3, 3),
            *rng.uniform(-50, 50, 2),
            rng.uniform(-3, 3),
        )
        for k in range(count)
    ]
    return DHTable(convention, rows)


def forward(mechanism, values):
    """Tool pose of a serial arm by symkin's forward kinematics."""
    result = symkin.solve(mechanism, joints=list(values))
    return frame(result.solution.position, result.solution.quaternion)


@pytest.mark.slow
@pytest.mark.parametrize("convention", ["standard", "modified"])
@settings(max_examples=10)
@given(rng=seeds)
def test_forward_kinematics_is_the_product_of_the_rows(convention, rng):
    """Random rows, revolute and prismatic, random joint values."""
    table, values = random_table(rng, convention, int(rng.integers(1, 8))), None
    values = rng.uniform(-3, 3, len(table.rows))
    arm = serial_arm_from_dh("arm", table)
    assert np.allclose(forward(arm, values), dh_product(table, values), atol=1e-9)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("convention", ["standard", "modified"])
@given(rng=seeds)
def test_the_same_arm_by_joints(convention, rng):
    """A DH arm equals the arm given by its joints (point, axis) and tool at zero: forward
    kinematics agree.
    """
    table = random_table(rng, convention, 4)
    arm = serial_arm_from_dh("arm", table)
    joints, g = [], np.eye(4)
    for row in table.rows:
        z, x = screw_motion(Z, row.theta, row.d), screw_motion(X, row.alpha, row.a)
        at = g if convention == "standard" else g @ x
        joints.append(Joint(row.name, row.type, tuple(at[:3, 3]), tuple(at[:3, 2]), actuated=True))
        g = g @ (z @ x if convention == "standard" else x @ z)
    tool = symkin.Pose.from_matrix(g)
    same = Mechanism(
        "arm",
        [Limb("arm", joints)],
        serial=True,
        platform_position=tuple(tool.position),
        platform_quaternion=tuple(tool.quaternion),
    )
    values = rng.uniform(-3, 3, 4)
    assert np.allclose(forward(arm, values), forward(same, values), atol=1e-9)
    assert math.isclose(arm.characteristic_length, same.characteristic_length, rel_tol=1e-9)


@pytest.mark.slow
@settings(max_examples=8)
@given(seeds)
def test_standard_is_modified_shifted_by_one_link(rng):
    """Rz Tz Tx Rx of rows 1..n is Craig's Rx Tx Rz Tz of the same rows with (a, alpha) one row
    down, and a last one.
    """
    table = random_table(rng, "standard", 4)
    links = [(0.0, 0.0), *((row.a, row.alpha) for row in table.rows)]
    rows = [
        DHRow(r.name, r.type, r.theta, r.d, *link)
        for r, link in zip(table.rows, links, strict=False)
    ]
    values = rng.uniform(-3, 3, 4)
    last = screw_motion(X, links[-1][1], links[-1][0])
    shifted = forward(serial_arm_from_dh("arm", DHTable("modified", rows)), values)
    assert np.allclose(forward(serial_arm_from_dh("arm", table), values), shifted @ last, atol=1e-9)


@given(seeds)
def test_gluon_is_its_table(rng):
    """The shipped arm at random angles (degrees) is the product of its printed rows, R for every
    joint.
    """
    rows = [
        (0, 105.03, 0, 90),
        (-90, 0, -174.42, 0),
        (0, 0, -174.42, 0),
        (-90, 75.66, 0, 90),
        (0, 80.09, 0, -90),
        (0, 44.36, 0, 0),
    ]
    q = rng.uniform(-180, 180, 6)
    matrices = [
        screw_motion(Z, math.radians(theta + v), d) @ screw_motion(X, math.radians(alpha), a)
        for (theta, d, a, alpha), v in zip(rows, q, strict=True)
    ]
    assert np.allclose(forward(symkin.load("gluon_6l3"), q), reduce(np.matmul, matrices), atol=1e-9)


BAD = {
    "type": (lambda: DHRow("q1", "S"), ["'q1'", "'S'", "R, P"]),
    "theta": (lambda: DHRow("q1", theta=math.nan), ["'q1'", "theta", "nan"]),
    "a": (lambda: DHRow("q1", a="wide"), ["'q1'", "a", "'wide'"]),
    "alpha": (lambda: DHRow("q1", alpha=math.inf), ["'q1'", "alpha", "inf"]),
    "limits": (lambda: DHRow("q1", limits=(1, 0)), ["'q1'", "limits", "low < high"]),
    "convention": (
        lambda: DHTable("Craig", [DHRow("q1")]),
        ["convention", "'Craig'", "standard, modified"],
    ),
    "empty": (lambda: DHTable("standard", []), ["dh.rows", "empty"]),
    "names": (
        lambda: serial_arm_from_dh("arm", DHTable("standard", [DHRow("q"), DHRow("q")])),
        ["'q'", "unique"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_names_offender_value_and_choice(case):
    """MechanismError in one line."""
    refused_in_one_line(*BAD[case])
