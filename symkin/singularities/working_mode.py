"""Decide whether configurations belong to the working mode of another one, by the signs of the
limbs' inverse problems.

With the pose given each limb is a problem of its own, F_i(q_i, x_i) = 0; where it is square, two of
its solutions between which det dF_i/d(q_i, x_i) changes its sign are different working modes.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from symkin.position.closed_configurations import whole_system
from symkin.singularities.locus_system import LocusSystem
from symkin.velocity.limb_equations import limb_blocks


def same_mode(system: LocusSystem, points: np.ndarray) -> np.ndarray:
    """For points (n, width) of a curve, whether every limb's sign is that of the plane's
    configuration. Limbs whose inverse problem is not square, or that the curve's equations leave
    out, tell nothing.
    """
    blocks = _blocks(system)
    if not blocks:
        return np.ones(len(points), dtype=bool)
    count = system.uv.stop
    own = _signs(blocks, system.centre)
    here = np.array([_signs(blocks, z[:count]) for z in points])
    return np.asarray(np.all((own == 0.0) | (here == own), axis=1))


def _signs(blocks: Sequence[ca.Function], z: np.ndarray) -> np.ndarray:
    return np.array([np.sign(np.linalg.det(np.asarray(block(z)))) for block in blocks])


def _blocks(system: LocusSystem) -> list[ca.Function]:
    """dF_i/d(q_i, x_i) of the limbs where it is square, as functions of (free, u, v)."""
    if system.plane.known or (system.kind == "type 1" and system.plane.of_pose):
        return []
    plane = system.plane
    closure, whole = plane.closure, whole_system(plane.closure)
    unknown = ca.vertcat(plane.stacked(system.free), plane.symbols)
    found = []
    for limb in limb_blocks(closure):
        if len(limb.joints) == len(limb.rows) and limb.limb != system.limb:
            block = ca.substitute(
                whole.jacobian[limb.rows, limb.joints], closure.variables, plane.values
            )
            found.append(ca.Function("block", [unknown], [ca.densify(block)], {"cse": True}))
    return found
