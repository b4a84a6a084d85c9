"""Write the C of a platform's speeds: joint rates of a twist, the twist of joint rates, and the
feed that keeps speed limits.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from symkin.codegen.line_parts import core_target, line_target
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.rates import step_text, summed
from symkin.codegen.steps.linear_solver import SINGULAR, singular_condition
from symkin.codegen.steps.newton_kernel import Kernel, system_kernel
from symkin.codegen.steps.newton_source import NewtonCode
from symkin.codegen.steps.pose_coordinates import COLUMNS
from symkin.codegen.text.c import Emitter, Real
from symkin.codegen.text.templates import copy, copy_loop, fill, substitute
from symkin.model.mechanism import Mechanism

_FASTEST = 1e6
"""Speeds beyond this many sizes (and radians) for each unit of time are refused: their products
stay far below the largest float.
"""


def fastest(size: float) -> float:
    """The largest speed that is taken."""
    return float(f"{_FASTEST * max(size, 1.0):.1g}")


def speeds_text(function: str, at: str, values: Mapping[str, object]) -> str:
    """NAME_rates of a twist or NAME_twist of rates, which is the Jacobian at a `pose`, or at
    `joints`, times the other one; and NAME_feed.
    """
    count = int(str(values["nq"]))
    sides = ("twist", 6), ("rates", count)
    (given, taken), (asked, found) = sides if function == "rates" else sides[::-1]
    about = {"rates": "Joint rates of a twist", "twist": "Twist of joint rates"}
    declared = {"pose": "const name_pose *pose", "joints": f"const name_real joints[{count}]"}
    shown = {
        **values,
        "function": function,
        "about": f"{about[function]}: the Jacobian times the {given}.",
        "at": substitute(declared[at], values),
        "of": at,
        "matrix": "jacobian",
        "nj": 6 * count,
        "given": given,
        "taken": taken,
        "least": f"-{values['largest']}",
        "before": substitute("name_jacobian(@{ga}" + at + ", jacobian)", values),
        "then": "",
        "asked": asked,
        "count": found,
        "body": summed(f"jacobian[{taken} * i + j] * {given}[j]", taken),
        "give": copy_loop(asked, "result", found),
        "no_info": "" if at == "pose" else ", NULL",
    }
    return "".join(fill(part, shown) for part in ("check_sizes.c", "applied.c", "speeds.c"))


def decides_twist(mechanism: Mechanism) -> bool:
    """Whether the Jacobian is square on the motion: joint rates decide the twist by it alone."""
    return len(mechanism.actuated) == len(COLUMNS[mechanism.motion])


def square_twist(mechanism: Mechanism, real: Real, values: Mapping[str, object]) -> str:
    """NAME_twist by the Jacobian, its rows scaled to lengths and its columns to lengths of
    turns.
    """
    size, columns = mechanism.characteristic_length, COLUMNS[mechanism.motion]
    scales = tuple(size if c.is_angular else 1.0 for c in mechanism.actuated)
    shown = {
        "row_scales": scales,
        "columns": tuple(f"{c}U" for c in columns),
        "column_scales": tuple(1.0 / size if c > 2 else 1.0 for c in columns),
        "others": [f"twist[{c}] = 0.0;" for c in range(6) if c not in columns],
        "least_pivots": (SINGULAR * real.epsilon,) * len(columns),
    }
    return fill("square_twist.c", {**values, **shown})


def direct_target(made: LimbPlatform) -> list[str]:
    """Statements that aim the direct problem at a point of the joints' line."""
    if made.core is None:
        return line_target(len(made.actuated), None)
    return core_target(made.core.direct, made.real)


def closure_twist(made: LimbPlatform, values: Mapping[str, object], driver: Kernel | None) -> str:
    """NAME_twist by the rows of the direct problem, over the pose alone or of the whole closure: by
    the driver's kernel where it is that of these rows, else by one of its own (None: no driver).
    """
    kernel, text, nq = made.direct_kernel, "", len(made.actuated)
    core = None if made.core is None else made.core.direct
    if driver is not kernel or (core is None and kernel.n != made.direct.system.freedom):
        # the direct problem has another way: these rows are written for the twist alone
        if core is None:
            known, symbols = made.direct.known_coordinates, made.geometry.symbols
            system = made.geometry.system(made.direct)
            kernel = system_kernel("velocity", system, known, symbols)
        code = _newton_code(made, kernel)
        own = "" if core is None else code.functions + code.target
        text = code.work + own + code.linear.text
    k, passive = f"{made.name}_{kernel.name}", 0
    joints, target, into = kernel.known, kernel.known, "w->k"
    if core is None:
        passive = sum(c.width for c in made.passive)
        store, aim = _stores(made, kernel), list[str]()
    else:
        joints, target, into = core.joints, core.target, "w->at"
        # its temporaries stand within the scope of those of the sides
        store = _of_state(kernel, core.twist, kernel.step, "s", made, prefix="u").stored("twist")
        aim = [f"{k}_set_target(w, w->at, 1.0);", f"{k}_rows(w);"]
        if driver is kernel and kernel.reads_known:
            aim += copy("w->k0", "w->k", kernel.known.numel())
    rates = ca.SX.sym("v", nq)
    change = ca.jtimes(ca.substitute(kernel.rows, kernel.known, target), joints, rates)
    sides = _of_state(kernel, change, joints, into, made, rates).stored("w->f")
    count = kernel.state.numel() - passive
    state = [
        *copy("w->x", "passive", passive),
        *(f"w->x[{passive + i}] = c[{i}];" for i in range(count)),
    ]
    shown = {
        "k": k,
        "into": into,
        "state": [*state, *aim],
        "sides": sides,
        "singular_there": singular_condition(kernel, k, "w", compact=made.options.compact),
        "nf": kernel.n,
        "store": store,
    }
    return text + fill("closure_twist.c", {**values, **shown})


def _newton_code(made: LimbPlatform, kernel: Kernel) -> NewtonCode:
    """Of rows that are written for the twist alone."""
    states = (made.direct_state(s.values) for s in made.samples)
    matrices = np.array([kernel.matrix(*at, made.geometry.values) for at in states])
    return NewtonCode(
        kernel,
        made.name,
        made.real,
        made.geometry.names,
        matrices,
        1.0,
        direct_target(made),
        len(made.actuated),
        compact=made.options.compact,
    )


def _of_state(
    kernel: Kernel,
    expression: ca.SX,
    read: ca.SX,
    array: str,
    made: LimbPlatform,
    rates: ca.SX | None = None,
    prefix: str = "t",
) -> Emitter:
    """Emitter of an expression of the state, of what stands in an array, and of joint rates."""
    inputs = [
        (kernel.state, "w->x"),
        (read, array),
        (kernel.geometry, made.geometry.names),
    ]
    if rates is not None:
        inputs.append((rates, "rates"))
    return Emitter.of(made.real, inputs, expression, prefix=prefix)


def _stores(made: LimbPlatform, kernel: Kernel) -> list[str]:
    """Statements of the twist from the step's last entries, turns by the size."""
    columns, per_size = COLUMNS[made.mechanism.motion], 1.0 / made.size
    first = kernel.n - len(columns)
    texts = {c: step_text(first + i, per_size if c > 2 else 1.0) for i, c in enumerate(columns)}
    return [f"twist[{c}] = {texts.get(c, '0.0')};" for c in range(6)]
