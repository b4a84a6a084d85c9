"""Hold answers of code that is written for the machine which a description means against the
description's own rows.
"""

from __future__ import annotations

import numpy as np

from symkin.codegen.folder.vectors import Vectors
from symkin.codegen.map.program import Program
from symkin.errors import InputError
from symkin.position.given import read_given
from symkin.position.problem import build_problem
from symkin.position.solve import solve
from symkin.spatial.pose import Pose

_JUDGED = 4
"""Vectors of which the description is asked: enough to tell another machine."""


def check_description(program: Program, vectors: Vectors) -> None:
    """Raises InputError where the described machine, from the pose of a vector, does not come to
    rest at that pose with the vector's joint values.
    """
    described, size = program.described, program.described.characteristic_length
    if described == program.lowered:
        return
    answers = vectors.answers
    rows = zip(answers["joints"], answers["poses"], vectors.bounds, strict=True)
    for joints, pose, bound in list(rows)[:_JUDGED]:
        given = {
            c.name: described.angle_out(value) if c.is_angular else value
            for c, value in zip(described.actuated, joints.tolist(), strict=True)
        }
        there = Pose(pose[:3], pose[3:])
        # the pose of a chain of driven joints is no matter of a start
        problem = build_problem(described, read_given(described, given).names)
        start = None if problem.is_explicit else there
        found = solve(described, joints=given, start=start, check=False).solution
        away = np.inf if found is None else _distance(found.pose, there, size)
        if not away <= bound:
            raise InputError(
                f"{described.name}: at {given} the described machine is {away:.3g} "
                f"{described.length_unit} from where its generated code is; write its links as "
                f"limbs and declare its motion"
            )


def _distance(pose: Pose, other: Pose, size: float) -> float:
    """How far poses are apart, turns times the size."""
    away = pose.inverse() @ other
    turn = 2.0 * float(np.linalg.norm(away.quaternion[1:]))
    return float(np.linalg.norm(away.position)) + size * turn
