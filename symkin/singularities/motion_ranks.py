"""Count ranks at a configuration, compare them with generic ones, and measure the distance to
losing one.

The feasible motions (t, q') are the null space of [A B]. Their part in q' has less than its generic
rank where some inputs become impossible, their part in t where some outputs do; A loses rank where
the platform moves with q' = 0, B where joints move with t = 0 (Zlatanov, Fenton and Benhabib 1995).
"""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.numeric.rank import null_space, row_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations, whole_system
from symkin.singularities.named_screw import joint_rates
from symkin.singularities.output import Output, output_equations
from symkin.spatial.screw import tidy_rows
from symkin.velocity.limb_equations import LimbwiseEquations, Ranks, limbwise_equations, row_basis
from symkin.velocity.roles import Roles, columns_by_name, other_joints


@lru_cache(maxsize=128)
def generic_ranks(roles: Roles, output: Output | None = None) -> Ranks:
    """Ranks at a random closed configuration near the reference, the one with the fewest motions
    (seed 0); with an output, those of the equations that are reduced to it.
    """
    closure, found = roles.closure, []
    for values in closed_configurations(closure, 0):
        equations = limbwise_equations(closure, values, RANK_TOLERANCE, roles)
        if output is not None:
            equations = output_equations(
                closure, values, equations, output, RANK_TOLERANCE
            ).equations
        found.append(Ranks.of(equations, RANK_TOLERANCE))
    return Ranks.generic(found)


def distances(
    closure: Closure, equations: LimbwiseEquations, generic: Ranks, roles: Roles
) -> dict[str, float]:
    """For each kind that the mechanism can have, the smallest singular value (of those that are not
    zero everywhere) of its matrix.
    """
    found = {"type 1": singular_value(equations.rates, generic.rates)} if roles.names_output else {}
    if not closure.mechanism.serial:
        found["type 2"] = singular_value(equations.twist, generic.twist)
    if roles.by_name:
        rank = len(equations.spectrum) - generic.freedoms
        found["increased"] = float(equations.spectrum[rank - 1]) if rank > 0 else 1.0
    passive = [float(ratio) for limb in equations.limbs for ratio in limb.passive]
    if passive and roles.names_output:
        found["passive"] = sorted(passive)[min(generic.idle, len(passive) - 1)]
    return found


def singular_value(matrix: np.ndarray, rank: int) -> float:
    """Singular value number `rank` of a matrix; 0 where it has fewer."""
    s = np.linalg.svd(matrix, compute_uv=False) if min(matrix.shape) else np.zeros(0)
    return float(s[rank - 1]) if 0 < rank <= len(s) else 0.0


# --- motions that are left while what drives stands -----------------------------------------------


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
    names = other_joints(closure, roles.inputs)
    joints = [c for name in names for c in closure.coordinates if c.name == name]
    told = row_space(motions[:, columns_by_name(closure, names)], tolerance)
    return tuple(joint_rates(closure.mechanism, joints, row) for row in tidy_rows(told))
