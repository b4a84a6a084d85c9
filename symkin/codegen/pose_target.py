"""Write the C that aims the direct problem over the pose at a point of the joints' line: known
values of joint values.
"""

from __future__ import annotations

from symkin.codegen.pose_kernel import PoseKernel
from symkin.codegen.text.c import Emitter, Real


def core_target(made: PoseKernel, real: Real) -> list[str]:
    """Statements that set w->k at a part of the line from w->at to `to`: sin and cos of each joint
    once.
    """
    count = made.joints.numel()
    emitter = Emitter.of(real, [(made.joints, "q")], made.target)
    return [
        f"{real.type} q[{count}];",
        f"for (int i = 0; i < {count}; ++i) {{",
        f"    q[i] = (part < {real.one}) ? (w->at[i] + part * (to[i] - w->at[i])) : to[i];",
        "}",
        *emitter.stored("w->k"),
    ]
