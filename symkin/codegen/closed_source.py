"""Source text of parallel mechanisms of any limbs: limbs for a pose, direct problem, inverse, Jacobian."""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.codegen.closed import Block, ClosedMechanism, line_target, ranges
from symkin.codegen.emit import Emitter, indent, indexed
from symkin.codegen.factor import curvature, rounded
from symkin.codegen.motion import COLUMNS, coordinates_text, pose_text
from symkin.codegen.source import KernelSource, Tuning, common_values, copy, factored, fill, kernel_source
from symkin.model.names import identifiers
from symkin.numeric.system import System


def closed_source(made: ClosedMechanism) -> tuple[str, KernelSource, dict[str, object]]:
    """Everything of NAME.c between its beginning and end, the direct kernel, and the values that templates need."""
    made.check()
    real, name = made.real, made.name
    nq, ns = len(made.actuated), made.direct.system.width
    pose = made.closure.role("pose")
    geometry = made.geometry
    values = common_values(name, real, geometry.at_run_time) | {
        "nq": nq, "ns": ns, "nc": sum(c.width for c in pose), "np": max(1, sum(c.width for c in made.passive)),
        "least_norm": real.literal(0.98), "most_norm": real.literal(1.0201),
        "turn": real.literal(2 * np.pi), "per_turn": real.literal(0.5 / np.pi), "many": real.literal(1e4), "minus_half": real.literal(-0.5),
    }  # fmt: skip
    text = fill("unit.c", values) + coordinates_text(geometry, real, values) + pose_text(geometry, real, values)
    text += fill("joints.c", values | {"positive": "", "ranges": ranges(made.actuated, real, made.closure.size)})
    for block in made.blocks:
        text += _block_text(made, block, values)
    text += _limbs_text(made, values)
    kernel = made.direct_kernel
    matrices = np.array([kernel.matrix(s.unknown, s.known, geometry.values) for s in made.samples])
    kappa = curvature(kernel, [s.unknown for s in made.samples], [s.known for s in made.samples], geometry.values)
    source = kernel_source(
        kernel, name, real, geometry.names, matrices, line_target(real, nq, None), kappa, start_aim="w->aim", known_count=nq
    )
    values |= _direct_values(made, source, values)
    text += source.text + _towards(made, values) + _within(made, values) + _agrees(made, values, source.tuning)
    text += fill("direct.c", values) + "\n" + _inverse_text(made, values)
    return text, source, values


def _block_text(made: ClosedMechanism, block: Block, values: dict[str, object]) -> str:
    if block.kernel is None:
        return ""
    kernel, real = block.kernel, made.real
    nc = int(kernel.known.shape[0])
    known = made.inverse.known_coordinates
    states = [made.inverse.select_values(s.values, block.system.unknowns) for s in made.samples]
    poses = [made.inverse.select_values(s.values, known) for s in made.samples]
    matrices = np.array([kernel.matrix(z, k, made.geometry.values) for z, k in zip(states, poses, strict=True)])
    kappa = curvature(kernel, states, poses, made.geometry.values)
    source = kernel_source(
        kernel, made.name, real, made.geometry.names, matrices, line_target(real, nc, kernel.quaternion), kappa
    )
    reference = made.closure.reference
    start = made.inverse.select_values(reference, block.system.unknowns)
    at = made.inverse.select_values(reference, known)
    freedom = int(block.sides.shape[1])
    emitter = Emitter(
        ca.Function("sides", [kernel.state, kernel.known, kernel.geometry], [block.sides], {"cse": True}),
        [indexed("w->x", int(kernel.state.shape[0])), indexed("w->k", nc), made.geometry.names], real,
    )  # fmt: skip
    entries = []
    places = {place: k for k, place in enumerate(zip(*emitter.function.sparsity_out(0).get_triplet(), strict=True))}
    for i in range(kernel.m):
        for j in range(freedom):
            k = places.get((i, j))
            entries.append(f"sides[{freedom * i + j}] = {real.literal(0.0) if k is None else emitter.value(0, k)};")
    if not any("w->" in line for line in [*emitter.lines, *entries]):
        entries.insert(0, "(void)w;")
    begin = [f"w->x[{i}] = {real.literal(float(v))};" for i, v in enumerate(start)]
    begin += [f"w->at[{i}] = {real.literal(float(v))};" for i, v in enumerate(at)]
    return source.text + fill("limb.c", values | {
        "k": f"{made.name}_{kernel.name}", "begin": indent(begin), "sides": indent([*emitter.lines, *entries]),
        "count": kernel.m * freedom,
    })  # fmt: skip


def _places(made: ClosedMechanism, block: Block) -> list[tuple[str, int, int]]:
    """(array, index there, index in the block) of each number of the block's unknowns."""
    found, start = [], 0
    for c, place in zip(block.system.unknowns, block.system.slices, strict=True):
        group = made.actuated if c.role == "actuated" else made.passive
        before = sum(other.width for other in group[: group.index(c)])
        array = "q" if c.role == "actuated" else "passive"
        found += [(array, before + i, place.start + i) for i in range(c.width)]
        start += c.width
    return found


def _limbs_text(made: ClosedMechanism, values: dict[str, object]) -> str:
    """All limbs for a pose, on the reference's branches."""
    name, ga = made.name, values["ga"]
    lines: list[str] = []
    for block in made.blocks:
        if block.kernel is None:
            lines += _rod_lines(made, block)
            continue
        k = f"{name}_{block.kernel.name}"
        copies = [f"{array}[{there}] = w.x[{here}];" for array, there, here in _places(made, block)]
        lines += [f"if (status == {name.upper()}_OK) {{", f"    {k}_work w;", f"    status = {k}_at({ga}&w, c);",
                  *("    " + text for text in copies), "}"]  # fmt: skip
    if int(made.conditions.rows.shape[0]):
        lines += _condition_lines(made, made.conditions)
    return fill("limbs.c", values | {"limbs": indent(lines)})


def _prefix(made: ClosedMechanism, block: Block) -> str:
    """What temporaries of a rod limb begin with: its name as an identifier, different from those of the other rods."""
    rods = [other for other in made.blocks if other.kernel is None]
    return identifiers([other.system.unknowns[0].name for other in rods])[rods.index(block)] + "_"


def _rod_lines(made: ClosedMechanism, block: Block) -> list[str]:
    emitter = Emitter(
        ca.Function("rod", [block.system.known, made.geometry.symbols], [block.rod], {"cse": True}),
        [indexed("c", int(block.system.known.shape[0])), made.geometry.names], made.real, prefix=_prefix(made, block),
    )  # fmt: skip
    text = emitter.value(0, 0)
    array, there, _ = _places(made, block)[0]
    return [*emitter.lines, f"{array}[{there}] = {text};"]


def _condition_lines(made: ClosedMechanism, conditions: System) -> list[str]:
    """Rows that no joint enters: the pose alone must satisfy them."""
    real = made.real
    emitter = Emitter(
        ca.Function("conditions", [conditions.known, made.geometry.symbols], [conditions.rows], {"cse": True}),
        [indexed("c", int(conditions.known.shape[0])), made.geometry.names],
        real,
        prefix="v",
    )
    tests = [
        f"({real.call('fabs')}({emitter.value(0, i)}) <= {real.literal(max(1e-6, 64 * real.epsilon) * conditions.size)})"
        for i in range(int(conditions.rows.shape[0]))
    ]
    return [*emitter.lines, f"if (!({' && '.join(tests)})) {{", f"    status = {made.name.upper()}_OUT_OF_RANGE;", "}"]


def _direct_values(made: ClosedMechanism, source: KernelSource, values: dict[str, object]) -> dict[str, object]:
    real, name, ga = made.real, made.name, str(values["ga"])
    passive = sum(c.width for c in made.passive)
    nc = int(str(values["nc"]))
    enter = [f"{real.type} c[{nc}];", f"{real.type} passive[{values['np']}] = {{ {real.literal(0.0)} }};",  f"status = {name}_coordinates({ga}guess, c);",
             f"if (status == {name.upper()}_OK) {{", f"    status = {name}_limbs({ga}c, w->at, passive);",
             *("    " + line for line in copy("w->x", "passive", passive) if passive),
             *([f"    {name}_within(w->at, joints);"] if any(made.limited_angles) else []), "}",
             f"if (status != {name.upper()}_OK) {{", f"    status = {name}_verdict(guess->position, 3, {name.upper()}_OUT_OF_RANGE);", "}",
             *(f"w->x[{passive + i}] = c[{i}];" for i in range(nc))]  # fmt: skip
    literal = real.literal
    agrees = [f"if (status == {name.upper()}_OK) {{", f"    status = {name}_agrees({ga}&w.x[{passive}], given);", "}"]
    return {
        "agrees": indent(agrees, 2) if made.has_dead_centres else "",
        "enter": indent(enter, 2), "leave": indent([f"{name}_pose_of({ga}&w->x[{passive}], pose);"]),
        "towards": indent([f"{real.type} given[{values['nq']}];", f"w.aim = {name}_towards(w.at, joints, given);"], 2), "to": "given", "whole": ", " + literal(1.0), "track_factor": factored(source.kernel, f"{name}_direct", "&w", ga),
        "kappa": literal(float(np.sqrt(source.tuning.kappa2))), "track2": literal((made.closure.size / 24) ** 2),
    }  # fmt: skip


def _agrees(made: ClosedMechanism, values: dict[str, object], tuning: Tuning) -> str:
    """NAME_agrees, where a pose may leave limbs more than one way to stand. Two ways meet at a dead centre, where errors of the
    tolerance are their square roots in joint values: what differs by less is one."""
    if not made.has_dead_centres:
        return ""
    size = made.closure.size
    near = [4.0 * np.sqrt(tuning.tolerance / size) * (1.0 if c.is_angular else size) for c in made.actuated]
    within = [f"{made.name}_within(q, given);"] if any(made.limited_angles) else []
    return fill("agrees.c", values | {
        "near": ", ".join(made.real.literal(rounded(float(v))) for v in near), "within_given": indent(within, 2),
    })  # fmt: skip


def _within(made: ClosedMechanism, values: dict[str, object]) -> str:
    """NAME_within, where angles have limits."""
    if not any(made.limited_angles):
        return ""
    literal = made.real.literal
    limits = [c.limits if c.limits is not None else (0.0, 0.0) for c in made.actuated]
    return fill("within.c", values | {
        "limited": ", ".join("true" if flag else "false" for flag in made.limited_angles), "low": ", ".join(literal(float(low)) for low, _ in limits), "high": ", ".join(literal(float(high)) for _, high in limits),
    })  # fmt: skip


def _towards(made: ClosedMechanism, values: dict[str, object]) -> str:
    flags = ", ".join("true" if c.kind == "angle" and c.limits is None else "false" for c in made.actuated)
    angular = ", ".join("true" if c.is_angular else "false" for c in made.actuated)
    literal = made.real.literal
    return fill("towards.c", values | {
        "turns": flags, "angular": angular, "largest": literal(0.5),
    })  # fmt: skip


def _inverse_text(made: ClosedMechanism, values: dict[str, object]) -> str:
    """NAME_inverse and NAME_jacobian."""
    real, name, size, ga = made.real, made.name, made.closure.size, str(values["ga"])
    columns = COLUMNS[made.mechanism.motion]
    lines: list[str] = []
    for block in made.blocks:
        places = [(there, here) for array, there, here in _places(made, block) if array == "q"]
        if block.kernel is None:
            emitter = Emitter(ca.Function("rod", [block.system.unknown, block.system.known, made.geometry.symbols], [ca.densify(block.sides)], {"cse": True}),
                              [["0"], indexed("c", int(block.system.known.shape[0])), made.geometry.names], real, prefix=_prefix(made, block))  # fmt: skip
            texts = [emitter.value(0, j) for j in range(len(columns))]
            lines += [
                *emitter.lines,
                *(f"jacobian[{6 * places[0][0] + column}] = {text};" for column, text in zip(columns, texts, strict=True)),
            ]
            continue
        k, m = f"{name}_{block.kernel.name}", block.kernel.m
        tangent = _tangent_index(block.system)
        scales = {c_index: (1 / size if angular else 1.0) for c_index, angular in tangent.values()}
        body = [f"{k}_work w;", f"{real.type} sides[{m * len(columns)}];", f"status = {k}_at({ga}&w, c);", f"if (status == {name.upper()}_OK) {{",
                f"    {k}_sides({ga}&w, sides);", f"    if ({factored(block.kernel, k, '&w', ga)}) {{", f"        status = {name.upper()}_SINGULAR;", "    } else {"]  # fmt: skip
        for j, column in enumerate(columns):
            body += [
                f"        for (int i = 0; i < {m}; ++i) {{",
                f"            w.f[i] = sides[{len(columns)} * i{_plus(j)}];",
                "        }",
                f"        {k}_solve(&w);",
            ]
            for there, here in places:
                index = tangent[here][0]
                scale = scales[index]
                body.append(
                    f"        jacobian[{6 * there + column}] = w.f[{index}]"
                    + ("" if scale == 1.0 else f" * {real.literal(scale)}")
                    + ";"
                )
        lines += [f"if (status == {name.upper()}_OK) {{", *("    " + line for line in [*body, "    }", "}"]), "}"]
    return fill(
        "closed.c",
        values
        | {
            "within_middle": indent(_to_middle(made), 3),
            "rates": indent(lines, 2),
            "copy_joints": indent(copy("joints", "q", int(str(values["nq"]))), 3),
        },
    )


def _to_middle(made: ClosedMechanism) -> list[str]:
    """Statements that move limited angles into their limits."""
    if not any(made.limited_angles):
        return []
    middles = ", ".join(made.real.literal(0.0 if c.limits is None else 0.5 * float(sum(c.limits))) for c in made.actuated)
    return [f"static const {made.real.type} middle[{len(made.actuated)}] = {{ {middles} }};", f"{made.name}_within(q, middle);"]


def _plus(offset: int) -> str:
    return f" + {offset}" if offset else ""


def _tangent_index(system: System) -> dict[int, tuple[int, bool]]:
    """For each single-number unknown of a block: its column in the tangent space, and whether it is an angle."""
    found, column = {}, 0
    for c, place in zip(system.unknowns, system.slices, strict=True):
        if c.width == 1:
            found[place.start] = (column, c.is_angular)
        column += c.freedom
    return found
