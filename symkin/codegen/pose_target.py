"""Write the C that aims the direct problem over the pose at a point of the joints' line: known
values of joint values.
"""

from __future__ import annotations

import casadi as ca

from symkin.codegen.pose_kernel import PoseKernel
from symkin.codegen.text.c import Emitter, Real, indexed


def core_target(made: PoseKernel, real: Real) -> list[str]:
    """Statements that set w->k at a part of the line from w->at to `to`: sin and cos of each joint
    once.
    """
    count = int(made.joints.shape[0])
    function = ca.Function("target", [made.joints], [made.target], {"cse": True})
    emitter = Emitter(function, [indexed("q", count)], real)
    stores = [f"w->k[{i}] = {emitter.value(0, i)};" for i in range(int(made.target.shape[0]))]
    return [
        f"{real.type} q[{count}];",
        f"for (int i = 0; i < {count}; ++i) {{",
        f"    q[i] = (part < {real.literal(1.0)}) ? (w->at[i] + part * (to[i] - w->at[i])) : "
        f"to[i];",
        "}",
        *emitter.lines,
        *stores,
    ]
