"""What `symkin show` prints of a graph of links: links, joints, rods, couplings, loops, unknowns,
mobility, what the platform may do.
"""

from __future__ import annotations

from collections.abc import Iterable

from symkin.model.graph import Coupling, LinkRod
from symkin.model.graph_checks import links_of
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.position.describe_parts import (
    coordinates_text,
    heading,
    joint_text,
    ranks_text,
    rows_text,
    vector_text,
    where_text,
)
from symkin.position.mobility_result import Mobility
from symkin.text import counted


def describe_graph(found: Mobility) -> str:
    """A readable account of a graph, with every figure computed from its closure."""
    mechanism = found.closure.mechanism
    sections = [
        _heading(mechanism),
        _joints(mechanism),
        _loops(found),
        _closure(found),
        _mobility(found),
        _platform(found),
    ]
    return "\n\n".join(section for section in sections if section)


def _heading(m: Mechanism) -> str:
    counts = [
        counted(len(links_of(m)), "link"),
        counted(len(list(m.all_joints)), "joint"),
        *(
            counted(len(some), word)
            for some, word in ((m.link_rods, "rod"), (m.couplings, "coupling"), (m.limbs, "limb"))
            if some
        ),
    ]
    return heading(m, f"graph of {', '.join(counts)}")


def _joints(m: Mechanism) -> str:
    lines = ["Joints, at the reference configuration"]
    pairs = [(f"{e.links[0]} - {e.links[1]}", joint_text(m, e.joint)) for e in m.link_joints]
    pairs += [(f"{rod.links[0]} - {rod.links[1]}", _rod(rod)) for rod in m.link_rods]
    width = min(40, max((len(links) for links, _ in pairs), default=0))
    lines += [f"  {links:{width}}  {text}" for links, text in pairs]
    for limb in m.limbs:
        lines.append(f"  {limb.links[0]} - {limb.links[1]}: limb {limb.name} ({limb.type})")
        lines += [f"    {joint_text(m, joint)}" for joint in limb.joints]
    lines += [f"  coupling: {_coupling(m, coupling)}" for coupling in m.couplings]
    lines += [
        f"  point {point.name} of {point.link} at {vector_text(point.point)}"
        for point in m.link_points
    ]
    if m.platform_link is not None:
        restricted = "" if m.motion == "spatial" else f", its motion {m.motion}"
        lines.append(
            f"  platform frame on {m.platform_link} at "
            f"{vector_text(m.platform_position)}{restricted}"
        )
    return "\n".join(lines)


def _rod(rod: LinkRod) -> str:
    ends = f"rod {rod.name} from {vector_text(rod.start)} to {vector_text(rod.end)}"
    if rod.actuated:
        return f"{ends} actuated, length = value" + (f" + {rod.offset:g}" if rod.offset else "")
    return f"{ends} of length {rod.reference_length if rod.length is None else rod.length:.6g}"


def _coupling(m: Mechanism, coupling: Coupling) -> str:
    """An equation in the mechanism's units."""
    kinds = {c.name: c for c in _coordinates(m)}
    unit = {name: m.value_in(c, 1.0) for name, c in kinds.items()}
    own = unit[coupling.joint]
    if coupling.polynomial is not None:
        (name,) = coupling.names
        powers = ["", f" {name}", *(f" {name}^{k}" for k in range(2, len(coupling.polynomial)))]
        terms = [
            (c / own * unit[name] ** k, power)
            for k, (c, power) in enumerate(zip(coupling.polynomial, powers, strict=True))
        ]
    else:
        terms = [(factor / own * unit[name], f" {name}") for name, factor in coupling.terms] + [
            (coupling.offset / own, "")
        ]
    text = " + ".join(f"{factor:.6g}{power}" for factor, power in terms if factor) or "0"
    return f"{coupling.joint} = {text}".replace("+ -", "- ")


def _coordinates(m: Mechanism) -> Iterable[Coordinate]:
    yield from (c for joint in m.all_joints for c in joint.coordinates)
    yield from m.actuated


def _loops(m: Mobility) -> str:
    if not m.loops:
        return "Loops: none"
    lines = [
        f"Loops ({len(m.loops)} independent ones; rows of each by itself, cut at its passive joint "
        f"of most freedom)"
    ]
    for number, loop in enumerate(m.loops, start=1):
        redundant = f", {loop.redundant} redundant" if loop.redundant else ""
        lines.append(
            f"  {number}: {loop.name}: {counted(loop.rows, 'row')}, rank {loop.rank}{redundant}"
        )
    return "\n".join(lines)


def _closure(m: Mobility) -> str:
    closure = m.closure
    lines = coordinates_text(closure)
    vanishing = (
        f", and {counted(closure.vanishing, 'row')} that vanish everywhere"
        if closure.vanishing
        else ""
    )
    lines.append(
        f"  {counted(closure.rows.shape[0], 'row')}{vanishing}; p, geometry: "
        f"{len(closure.parameter_names)} parameters"
    )
    if closure.idle:
        lines.append(f"  not in the closure: {'; '.join(closure.idle)}")
    return "\n".join(lines)


def _mobility(m: Mobility) -> str:
    lines = ["Mobility"]
    if m.closed:
        lines += ranks_text(m, "rows")
        if m.reference_rank is not None and not m.at_reference:
            there = m.reference_rank.value
            lines.append(
                f"  at the reference: rank {there}, mobility {m.freedoms - there}, redundant "
                f"constraints {m.redundant_at_reference}"
            )
    return "\n".join([*lines, *(f"  warning: {warning}" for warning in m.warnings)])


def _platform(m: Mobility) -> str:
    mechanism = m.closure.mechanism
    if mechanism.platform_link is None or m.misfit is not None:
        return ""
    lines = [f"Screws of {mechanism.platform_link} at {where_text(m)}, base frame"]
    lines += rows_text("  constraints (force; moment about the origin)", m.platform_constraints)
    lines += rows_text(
        "  twists left (angular velocity; velocity at the origin)", m.platform_twists
    )
    return "\n".join(lines)
