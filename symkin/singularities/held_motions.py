"""Motions that are left at a configuration while the coordinates that drive stand, as rates of
joints.
"""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure
from symkin.numeric.rank import null_space, row_space
from symkin.position.closed_configurations import whole_system
from symkin.singularities.named_screw import joint_rates
from symkin.spatial.screw import tidy_rows
from symkin.velocity.limb_equations import row_basis
from symkin.velocity.roles import Roles, columns_by_name, other_joints


def held_motions(
    closure: Closure, values: np.ndarray, roles: Roles, tolerance: float
) -> tuple[dict[str, float], ...]:
    """Independent motions with F_x x' = 0 as rates of joints by name in the mechanism's units, the
    largest of each 1. Motions of spherical joints and links alone are none.
    """
    _, jacobian = whole_system(closure).linearise_one(values, np.zeros(0))
    rows = row_basis(jacobian, max(tolerance, roles.dependent_rows))
    driven = set(roles.input_columns(closure))
    free = [k for k in range(jacobian.shape[1]) if k not in driven]
    left = null_space(rows[:, free], tolerance)
    motions = np.zeros((len(left), jacobian.shape[1]))
    motions[:, free] = left
    names = other_joints(closure, roles.inputs or ())
    joints = [c for name in names for c in closure.coordinates if c.name == name]
    told = row_space(motions[:, columns_by_name(closure, names)], tolerance)
    return tuple(joint_rates(closure.mechanism, joints, row) for row in tidy_rows(told))
