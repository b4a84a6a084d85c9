"""Write the C of a platform's speeds: joint rates of a twist, the twist of joint rates, and the
feed that keeps speed limits.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.line_parts import line_target
from symkin.codegen.linear_solver import SINGULAR, singular_condition
from symkin.codegen.newton_kernel import Kernel, system_kernel
from symkin.codegen.newton_source import NewtonCode
from symkin.codegen.pose_coordinates import COLUMNS
from symkin.codegen.pose_kernel import PoseKernel
from symkin.codegen.pose_target import core_target
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import copy, fill, substitute
from symkin.model.mechanism import Mechanism

_FASTEST = 1e6
"""Speeds beyond this many sizes (and radians) for each unit of time are refused: their products
stay far below the largest float.
"""


def fastest(size: float) -> float:
    """The largest speed that is taken."""
    return float(f"{_FASTEST * max(size, 1.0):.1g}")


def speeds_text(
    function: str, at: str, size: float, real: Real, values: Mapping[str, object]
) -> str:
    """NAME_rates of a twist or NAME_twist of rates, which is the Jacobian at a `pose`, or at
    `joints`, times the other one; and NAME_feed.
    """
    count, of_twist = values["nq"], function == "rates"
    declared = {"pose": "const @{p}_pose *pose", "joints": f"const @{{real}} joints[{count}]"}
    shown = {
        **values,
        "function": function,
        "about": "Joint rates of a twist" if of_twist else "The twist of joint rates",
        "given": "twist" if of_twist else "rates",
        "rows": count if of_twist else 6,
        "columns": 6 if of_twist else count,
        "at": substitute(declared[at], values),
        "at_name": at,
        "no_info": "" if at == "pose" else ", NULL",
        "fastest": real.literal(fastest(size)),
    }
    return fill("check_speeds.c", shown) + fill("speeds.c", shown)


def decides_twist(mechanism: Mechanism) -> bool:
    """Whether the Jacobian is square on the motion: joint rates decide the twist by it alone."""
    return len(mechanism.actuated) == len(COLUMNS[mechanism.motion])


def square_twist(mechanism: Mechanism, real: Real, values: Mapping[str, object]) -> str:
    """NAME_twist by the Jacobian, its rows scaled to lengths and its columns to lengths of
    turns.
    """
    size, columns = mechanism.characteristic_length, COLUMNS[mechanism.motion]
    scales = [real.literal(size if c.is_angular else 1.0) for c in mechanism.actuated]
    shown = {
        "row_scales": ", ".join(scales),
        "columns": ", ".join(f"{c}U" for c in columns),
        "column_scales": ", ".join(real.literal(1.0 / size if c > 2 else 1.0) for c in columns),
        "others": indent(
            [f"twist[{c}] = {real.literal(0.0)};" for c in range(6) if c not in columns], 2
        ),
        "least_pivots": ", ".join([real.literal(SINGULAR * real.epsilon)] * len(columns)),
    }
    return fill("square_twist.c", {**values, **shown})


def closure_twist(made: LimbPlatform, values: Mapping[str, object], driver: Kernel | None) -> str:
    """NAME_twist by the closure's rows: the driver's kernel where it is that of the whole closure,
    else one of its own (None: no driver).
    """
    kernel, text = made.direct_kernel, ""
    if made.core is not None:
        return core_twist(made, made.core.direct, values, driver)
    if driver is not kernel or kernel.n != made.direct.system.freedom:
        kernel = system_kernel(
            "velocity",
            made.geometry.system(made.direct),
            made.direct.known_coordinates,
            made.geometry.symbols,
        )
        code = _newton_code(made, kernel)
        text = code.work + code.linear.text
    k, ga = f"{made.name}_{kernel.name}", str(values["ga"])
    passive = sum(c.width for c in made.passive)
    state = [
        *copy("w->x", "passive", passive),
        *(f"w->x[{passive + i}] = c[{i}];" for i in range(int(str(values["nc"])))),
    ]
    shown = {
        "k": k,
        "into": "w->k",
        "state": indent(state, 2),
        "sides": indent(_side_lines(made, kernel), 3),
        "singular_there": singular_condition(kernel, k, "w", ga, compact=made.options.compact),
        "nf": kernel.n,
        "store": indent(_stores(made, kernel), 2),
    }
    return text + fill("closure_twist.c", {**values, **shown})


def core_twist(
    made: LimbPlatform, core: PoseKernel, values: Mapping[str, object], driver: Kernel | None
) -> str:
    """NAME_twist by the rows over the pose."""
    kernel, nq = core.kernel, len(made.actuated)
    k, text, rates = f"{made.name}_{kernel.name}", "", ca.SX.sym("v", nq)
    if driver is not kernel:
        # the direct problem has another way: these rows are written for the twist alone
        state_at, known = zip(*(made.direct_state(s.values) for s in made.samples), strict=True)
        matrices = np.array(
            [kernel.matrix(*at, np.zeros(0)) for at in zip(state_at, known, strict=True)]
        )
        lines = core_target(core, made.real)
        code = NewtonCode(
            kernel, made.name, made.real, [], matrices, 1.0, lines, nq, compact=made.options.compact
        )
        text = code.work + code.functions + code.target + code.linear.text
    rows = ca.substitute(kernel.rows, kernel.known, core.target)
    change = snapped_expression(
        ca.jtimes(rows, core.joints, rates), [kernel.state, core.joints, rates]
    )
    state = indexed("w->x", int(kernel.state.shape[0]))
    inputs = [
        (kernel.state, state),
        (core.joints, indexed("w->at", nq)),
        (rates, indexed("rates", nq)),
    ]
    sides = Emitter.of(made.real, inputs, change).stored(indexed("w->f", kernel.m))
    inputs = [(kernel.state, state), (kernel.step, indexed("w->f", kernel.n))]
    twist = Emitter.of(made.real, inputs, core.twist).stored(indexed("twist", 6))
    aim = [f"{k}_set_target(w, w->at, {made.real.literal(1.0)});", f"{k}_rows(w);"]
    if driver is kernel and kernel.reads_known:
        aim += copy("w->k0", "w->k", int(kernel.known.shape[0]))
    shown = {
        "k": k,
        "into": "w->at",
        "state": indent([*copy("w->x", "c", len(state)), *aim], 2),
        "sides": indent(sides, 3),
        "singular_there": singular_condition(kernel, k, "w", "", compact=made.options.compact),
        "nf": kernel.n,
        "store": indent(twist, 2),
    }
    return text + fill("closure_twist.c", {**values, **shown})


def _newton_code(made: LimbPlatform, kernel: Kernel) -> NewtonCode:
    values = made.geometry.values
    matrices = np.array([kernel.matrix(s.unknown, s.known, values) for s in made.samples])
    lines = line_target(made.real, len(made.actuated), None)
    names, nq = made.geometry.names, len(made.actuated)
    return NewtonCode(
        kernel, made.name, made.real, names, matrices, 1.0, lines, nq, compact=made.options.compact
    )


def _side_lines(made: LimbPlatform, kernel: Kernel) -> list[str]:
    """Statements w->f = change of the rows (closure's sign turned) by the joint rates."""
    rates = ca.SX.sym("v", len(made.actuated))
    change = snapped_expression(
        ca.jtimes(kernel.rows, kernel.known, rates),
        [kernel.state, kernel.known, kernel.geometry, rates],
    )
    inputs = [
        (kernel.state, indexed("w->x", int(kernel.state.shape[0]))),
        (kernel.known, indexed("w->k", int(kernel.known.shape[0]))),
        (kernel.geometry, made.geometry.names),
        (rates, indexed("rates", len(made.actuated))),
    ]
    return Emitter.of(made.real, inputs, change).stored(indexed("w->f", kernel.m))


def _stores(made: LimbPlatform, kernel: Kernel) -> list[str]:
    """Statements of the twist from the step's last entries, turns by the size."""
    columns, literal = COLUMNS[made.mechanism.motion], made.real.literal
    first = kernel.n - len(columns)
    per_size = f" * {literal(1.0 / made.closure.characteristic_length)}"
    texts = {c: f"w->f[{first + i}]" + (per_size if c > 2 else "") for i, c in enumerate(columns)}
    return [f"twist[{c}] = {texts.get(c, literal(0.0))};" for c in range(6)]
