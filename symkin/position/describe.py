"""What `symkin show` prints of limbs and arms: unknowns, rank, mobility, redundant constraints,
reciprocal screws.

Graphs: see `describe_graph`.
"""

from __future__ import annotations

from collections import Counter

from symkin.model.bar import Bar
from symkin.model.mechanism import Mechanism
from symkin.position.describe_graph import describe_graph
from symkin.position.describe_parts import (
    coordinates_text,
    heading,
    joint_text,
    ranks_text,
    rows_text,
    vector_text,
    where_text,
)
from symkin.position.mobility import mobility
from symkin.position.mobility_result import Mobility
from symkin.position.platform_motion import fewer_rows
from symkin.position.problem import build_problem


def describe(mechanism: Mechanism) -> str:
    """A readable account of a mechanism, with every figure computed from its closure."""
    found = mobility(mechanism)
    if not found.limbs:
        return describe_graph(found)
    kind = (
        "serial arm"
        if mechanism.serial
        else f"parallel mechanism, platform motion {mechanism.motion}"
    )
    sections = [
        heading(mechanism, kind),
        _limbs(mechanism, found),
        _closure(mechanism, found),
        _mobility(found),
        _screws(found),
    ]
    return "\n\n".join(sections)


def _limbs(mechanism: Mechanism, found: Mobility) -> str:
    lines = ["Limbs"]
    relations = Counter((row.limb, row.relation) for row in found.closure.row_sources)
    for limb in mechanism.limbs:
        rows = (
            ", ".join(
                f"{count} {relation}"
                for (name, relation), count in relations.items()
                if name == limb.name
            )
            or "none left"
        )
        lines.append(f"  {limb.name} ({limb.type}): rows: {rows}")
        lines += [f"    {joint_text(mechanism, joint)}" for joint in limb.joints]
        lines += [f"    {_rod(bar)}" for bar in limb.bars(mechanism.reference_pose)]
    if found.closure.idle:
        lines.append("  not in the closure: " + "; ".join(found.closure.idle))
    return "\n".join(lines)


def _rod(bar: Bar) -> str:
    offset = f", length = value + {bar.offset:g}" if bar.offset else ""
    drive = "" if bar.coordinate is None else f", actuated{offset}"
    return (
        f"rod from {vector_text(bar.start.point)} to {vector_text(bar.end.point)} (platform){drive}"
    )


def _closure(mechanism: Mechanism, found: Mobility) -> str:
    lines = coordinates_text(found.closure)
    lines.append(f"  p, geometry: {len(found.closure.parameter_names)} parameters")
    for kind in ("direct", "inverse"):
        system = build_problem(mechanism, kind).system
        lines.append(
            f"  {kind} problem: {system.rows.shape[0]} equations, {system.freedom} unknowns"
        )
    return "\n".join(lines)


def _mobility(m: Mobility) -> str:
    lines = [
        "Mobility"
        + (
            ""
            if m.closed
            else " (no closed configuration was found: what follows holds at the open reference)"
        )
    ]
    lines += ranks_text(m, "equations")
    restriction = fewer_rows(m)
    if restriction is not None:
        motion, left = restriction
        lines.append(
            f'  note: the joints leave the platform this motion anyway: with motion = "{motion}" '
            f"in [platform] "
            f"{left or 'none'} of them {'is' if left == 1 else 'are'} "
            f"left{'' if left else ', and paths can be certified'}"
        )
    lines += [f"  warning: {warning}" for warning in m.warnings]
    lines.append(
        f"  screws below: at {where_text(m)}, base frame, (force; moment about the origin)"
    )
    return "\n".join(lines)


def _screws(m: Mobility) -> str:
    lines = ["Reciprocal screws (wrenches that do no work on what the joints allow)"]
    for limb in m.limbs:
        lines += rows_text(f"  {limb.limb}: constraint", limb.constraints)
        lines += rows_text(f"  {limb.limb}: with actuated joints locked", limb.locked)
    lines += rows_text(
        f"  platform: constraints of all limbs, rank {len(m.platform_constraints)}",
        m.platform_constraints,
    )
    lines += rows_text(
        "  platform: twists left (angular velocity; velocity at the origin)", m.platform_twists
    )
    return "\n".join(lines)
