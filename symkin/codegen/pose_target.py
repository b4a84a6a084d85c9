"""Write the C that aims the direct problem over the pose at a point of the joints' line: known
values of joint values.
"""

from __future__ import annotations

from symkin.codegen.pose_kernel import PoseKernel
from symkin.codegen.text.c import Emitter, Real, indexed


def core_target(made: PoseKernel, real: Real) -> list[str]:
    """Statements that set w->k at a part of the line from w->at to `to`: sin and cos of each joint
    once.
    """
    count = int(made.joints.shape[0])
    emitter = Emitter.of(real, [(made.joints, indexed("q", count))], made.target)
    return [
        f"{real.type} q[{count}];",
        f"for (int i = 0; i < {count}; ++i) {{",
        f"    q[i] = (part < {real.literal(1.0)}) ? (w->at[i] + part * (to[i] - w->at[i])) : "
        f"to[i];",
        "}",
        *emitter.stored(indexed("w->k", int(made.target.shape[0]))),
    ]
