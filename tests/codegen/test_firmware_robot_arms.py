"""Code of arms and legs as robots' files have them: its own test passes, digits of the file and
narrow limits or not.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.firmware_tools import built, passed
from helpers.gate import in_gate
from helpers.inside import arm_of
from symkin import Joint, LinkJoint, Mechanism

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
Row = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float]]


def robot(name: str, *rows: Row, tool: tuple[float, float, float]) -> Mechanism:
    """A graph of links l1, l2, ... in metres, each row a turn: point, axis, limits."""
    links = ["base", *(f"l{k}" for k in range(1, len(rows) + 1))]
    chain = [
        LinkJoint(
            Joint(f"q{k + 1}", "R", point, axis, actuated=True, limits=limits),
            (links[k], links[k + 1]),
        )
        for k, (point, axis, limits) in enumerate(rows)
    ]
    return Mechanism(
        name, link_joints=chain, platform_link=links[-1], platform_position=tool, length_unit="m"
    )


WIDE = (-3.0, 3.0)
NOISE = 4.9e-12
"""What is left of pi/2 written with eleven digits."""
ROBOTS = [
    # a quadruped's leg: hip, thigh and knee; its file has angles of eleven digits
    robot(
        "leg",
        ((0.37, 0.2, 0.0), (-1.0, -2e-13, NOISE), (-1.2, 0.5)),
        ((0.37 - 4e-13, 0.2, -0.08), (-NOISE, 1.0, 0.0), (-0.9, 1.2)),
        ((0.37 - 2e-12, 0.2, -0.43), (-NOISE, 1.0, 0.0), (-2.4, -0.3)),
        tool=(0.37 - 4e-12, 0.2, -0.776),
    ),
    # a humanoid's leg, whose ranges are narrow and end at its straight knee
    robot(
        "humanoid_leg",
        ((0.0, 0.1, -0.2), Z, (-0.26, 0.26)),
        ((0.0, 0.1, -0.2), X, (-0.26, 0.52)),
        ((0.0, 0.1, -0.2), Y, (-1.7, 0.4)),
        ((0.0, 0.1, -0.52), Y, (0.0, 2.0)),
        ((0.0, 0.1, -0.81), Y, (-0.52, 0.78)),
        ((0.0, 0.1, -0.81), X, (-0.35, 0.35)),
        tool=(0.0, 0.1, -0.81),
    ),
    # an arm that is singular at zero, which its limits leave out
    robot(
        "beyond",
        ((0.0, 0.0, 0.16), Z, (-6.0, 6.0)),
        ((0.0, 0.0, 0.28), X, (0.8, 5.4)),
        ((0.0, 0.0, 0.69), X, (0.3, 5.9)),
        ((0.0, 0.01, 0.9), Z, (-6.0, 6.0)),
        ((0.0, 0.01, 1.0), X, (0.5, 5.7)),
        ((0.0, 0.01, 1.1), Z, (-6.0, 6.0)),
        tool=(0.0, 0.01, 1.2),
    ),
    # seven joints, singular at zero
    robot(
        "seven",
        *(((0.0, 0.0, 0.1 + 0.15 * k), (Z, Y)[k % 2], WIDE) for k in range(7)),
        tool=(0.0, 0.0, 1.2),
    ),
]
NAMED = {mechanism.name: mechanism for mechanism in ROBOTS}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "real"),
    in_gate(
        product(NAMED, ["double", "float"]),
        [("humanoid_leg", "float"), ("seven", "float")],
    ),
)
def test_the_generated_test_passes(name: str, real: str, tmp_path: Path) -> None:
    mechanism = NAMED[name]
    symkin.write_firmware(mechanism, tmp_path, real=real)  # type: ignore[arg-type]
    assert "0 failures" in passed(
        built("gcc", tmp_path, [f"{name}.c", f"{name}_test.c"], "own_test", "-O1")
    )


def test_digits_of_a_file_leave_no_error_in_the_closed_form() -> None:
    """Axes that are parallel or square to eleven digits are so exactly in the arm, whose closed
    form then meets its pose to rounding; the arm is the graph to these digits.
    """
    graph = ROBOTS[0]
    arm = arm_of(graph)
    assert arm is not None
    assert [tuple(joint.axis or ()) for _, joint in arm.joints] == [(-1.0, 0.0, 0.0), Y, Y]
    rng = np.random.default_rng(3)
    for values in rng.uniform((-1.0, 0.2, -2.0), (0.4, 1.0, -0.5), (5, 3)).tolist():
        ends = [symkin.solve(m, joints=values).solution for m in (graph, arm)]
        np.testing.assert_allclose(ends[0].position, ends[1].position, atol=1e-10)
        again = symkin.solve(
            arm, pose=[*ends[1].position, *ends[1].quaternion], solver="closed"
        ).solution
        assert again.residual < 1e-15
