"""MuJoCo's own account of its equality constraints."""

from __future__ import annotations

from typing import Any

import numpy as np


def equality_rows(mujoco: Any, model: Any, data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Violations (rows,) and Jacobian (rows, freedoms) of the equality constraints, after
    `mj_forward`.
    """
    count, nv = int(data.nefc), int(model.nv)
    rows = np.asarray(data.efc_type[:count]) == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    if mujoco.mj_isSparse(model):
        jacobian = np.zeros((count, nv))
        mujoco.mju_sparse2dense(
            jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind
        )
    else:
        jacobian = np.array(data.efc_J)[: count * nv].reshape(count, nv)
    return np.array(data.efc_pos[:count])[rows], jacobian[rows]
