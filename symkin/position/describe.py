"""What `symkin show` prints: joints, rods, couplings, loops, unknowns, rank, mobility, redundant
constraints, reciprocal screws.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from symkin.model.bar import Bar
from symkin.model.graph import Coupling, LinkRod
from symkin.model.graph_checks import links_of
from symkin.model.joint import BASE, PLATFORM, Joint
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism
from symkin.position.mobility import mobility
from symkin.position.mobility_result import Mobility
from symkin.position.platform_motion import fewer_rows
from symkin.text import counted


def describe(mechanism: Mechanism) -> str:
    """A readable account of a mechanism, with every figure computed from its closure."""
    found = mobility(mechanism)
    sections = (
        _heading(mechanism),
        _parts(found),
        [] if found.limbs else _loops(found),
        _closure(found),
        _mobility(found),
        _screws(found),
    )
    return "\n\n".join("\n".join(lines) for lines in sections if lines)


def _heading(m: Mechanism) -> list[str]:
    """Name and title, what kind of mechanism it is, source, units and size."""
    lines = [m.name + (f": {m.title}" if m.title else ""), _kind(m)]
    if m.source:
        lines.append(f"source: {m.source}")
    size = f"{m.characteristic_length:.6g}"
    lines.append(
        f"units: {m.length_unit}, {m.angle_unit}; size (largest distance of joint points): {size}"
    )
    return lines


def _kind(m: Mechanism) -> str:
    if not m.is_graph:
        return "serial arm" if m.serial else f"parallel mechanism, platform motion {m.motion}"
    parts = ((m.link_rods, "rod"), (m.couplings, "coupling"), (m.limbs, "limb"))
    counts = [
        counted(len(links_of(m)), "link"),
        counted(len(list(m.all_joints)), "joint"),
        *(counted(len(some), word) for some, word in parts if some),
    ]
    return f"graph of {', '.join(counts)}"


# --- parts ----------------------------------------------------------------------------------------


def _parts(found: Mobility) -> list[str]:
    """Joints and rods between links, limbs, couplings, named points, the platform's frame, and what
    the closure does not hold.
    """
    m = found.closure.mechanism
    lines = ["Limbs" if found.limbs else "Joints, at the reference configuration"]
    pairs = [(f"{e.links[0]} - {e.links[1]}", _joint(m, e.joint)) for e in m.link_joints]
    pairs += [(f"{rod.links[0]} - {rod.links[1]}", _link_rod(rod)) for rod in m.link_rods]
    width = min(40, max((len(links) for links, _ in pairs), default=0))
    lines += [f"  {links:{width}}  {text}" for links, text in pairs]
    for limb in m.limbs:
        lines += _limb(found, limb)
    lines += [f"  coupling: {_coupling(m, coupling)}" for coupling in m.couplings]
    lines += [f"  point {p.name} of {p.link} at {_vector(p.point)}" for p in m.link_points]
    if m.is_graph and m.platform_link is not None:
        restricted = "" if m.motion == "spatial" else f", its motion {m.motion}"
        lines.append(
            f"  platform frame on {m.platform_link} at {_vector(m.platform_position)}{restricted}"
        )
    if found.closure.idle:
        lines.append("  not in the closure: " + "; ".join(found.closure.idle))
    return lines


def _limb(found: Mobility, limb: AnyLimb) -> Iterator[str]:
    m = found.closure.mechanism
    relations = Counter(r.relation for r in found.closure.row_sources if r.limb == limb.name)
    rows = ", ".join(f"{count} {relation}" for relation, count in relations.items())
    links, told = "", "rows"
    if limb.links != (BASE, PLATFORM):
        # of a loop of links the rows are those of the limb that closes it
        links, told = f", {limb.links[0]} - {limb.links[1]}", "rows of its loop"
    yield f"  {limb.name} ({limb.type}){links}: {told}: {rows or 'none left'}"
    yield from (f"    {_joint(m, joint)}" for joint in limb.joints)
    yield from (f"    {_rod(bar)}" for bar in limb.bars(m.reference_pose))


def _joint(m: Mechanism, joint: Joint) -> str:
    """A joint in a line: type, name, place, axes, drive."""
    place = f"at {_vector(joint.point)}" if joint.form.has_point else ""
    axis = f"along {_vector(joint.axis)}" if joint.axis else ""
    second = f"then {_vector(joint.axis2)}" if joint.axis2 else ""
    pitch = f"pitch {joint.pitch:g} {m.length_unit} a turn" if joint.type == "H" else ""
    drive = "actuated" if joint.actuated else ""
    texts = (joint.type, joint.name, place, axis, second, pitch, drive)
    return " ".join(text for text in texts if text)


def _rod(bar: Bar) -> str:
    offset = f", length = value + {bar.offset:g}" if bar.offset else ""
    drive = "" if bar.coordinate is None else f", actuated{offset}"
    return f"rod from {_vector(bar.start.point)} to {_vector(bar.end.point)} (platform){drive}"


def _link_rod(rod: LinkRod) -> str:
    ends = f"rod {rod.name} from {_vector(rod.start)} to {_vector(rod.end)}"
    if rod.actuated:
        return f"{ends} actuated, length = value" + (f" + {rod.offset:g}" if rod.offset else "")
    return f"{ends} of length {rod.reference_length if rod.length is None else rod.length:.6g}"


def _coupling(m: Mechanism, coupling: Coupling) -> str:
    """An equation in the mechanism's units."""
    unit = m.units
    own = unit[coupling.joint]
    if coupling.polynomial is not None:
        (name,) = coupling.names
        powers = ["", f" {name}", *(f" {name}^{k}" for k in range(2, len(coupling.polynomial)))]
        terms = [
            (c / own * unit[name] ** k, power)
            for k, (c, power) in enumerate(zip(coupling.polynomial, powers, strict=True))
        ]
    else:
        terms = [(factor / own * unit[name], f" {name}") for name, factor in coupling.terms]
        terms.append((coupling.offset / own, ""))
    text = " + ".join(f"{factor:.6g}{power}" for factor, power in terms if factor) or "0"
    return f"{coupling.joint} = {text}".replace("+ -", "- ")


# --- figures --------------------------------------------------------------------------------------


def _loops(found: Mobility) -> list[str]:
    if not found.loops:
        return ["Loops: none"]
    lines = [
        f"Loops ({len(found.loops)} independent ones; rows of each by itself, cut at its passive "
        f"joint of most freedom)"
    ]
    for number, loop in enumerate(found.loops, start=1):
        redundant = f", {loop.redundant} redundant" if loop.redundant else ""
        lines.append(
            f"  {number}: {loop.name}: {counted(loop.rows, 'row')}, rank {loop.rank}{redundant}"
        )
    return lines


def _closure(found: Mobility) -> list[str]:
    """The closure's coordinates by their roles, poses only where there are any; its rows."""
    closure, lines = found.closure, ["Closure F(q, x, X, p) = 0"]
    roles = (
        ("actuated", "q, actuated"),
        ("passive", "x, passive"),
        ("body", "x, poses of floating links"),
        ("pose", "X, pose"),
    )
    for role, text in roles:
        coordinates = closure.role(role)
        if coordinates or role in ("actuated", "passive"):
            names = ", ".join(c.name for c in coordinates) or "none"
            lines.append(f"  {text} ({sum(c.freedom for c in coordinates)}): {names}")
    vanishing = counted(closure.vanishing, "row") if closure.vanishing else ""
    lines.append(
        f"  {counted(closure.rows.shape[0], 'row')}"
        f"{vanishing and f', and {vanishing} that vanish everywhere'}; "
        f"p, geometry: {len(closure.parameter_names)} parameters"
    )
    for kind, known in (("direct", "actuated"), ("inverse", "pose")) if found.limbs else ():
        unknowns = sum(c.freedom for c in closure.coordinates if c.role != known)
        lines.append(f"  {kind} problem: {closure.rows.shape[0]} equations, {unknowns} unknowns")
    return lines


def _mobility(found: Mobility) -> list[str]:
    lines = ["Mobility"]
    if found.closed or found.limbs:
        lines += _ranks(found)
    if found.closed and found.reference_rank is not None and not found.at_reference:
        there = found.reference_rank.value
        lines.append(
            f"  at the reference: rank {there}, mobility {found.freedoms - there}, redundant "
            f"constraints {found.redundant_at_reference}"
        )
    restriction = fewer_rows(found)
    if restriction is not None:
        motion, left = restriction
        lines.append(
            f'  note: the joints leave the platform this motion anyway: with motion = "{motion}" '
            f"in [platform] "
            f"{left or 'none'} of them {'is' if left == 1 else 'are'} "
            f"left{'' if left else ', and paths can be certified'}"
        )
    return [*lines, *(f"  warning: {warning}" for warning in found.warnings)]


def _ranks(found: Mobility) -> Iterator[str]:
    """Rank, mobility and redundant constraints at generic closed configurations, or where none was
    found at the open reference.
    """
    alone = found.infinitesimal and not found.mobility
    where = "the reference" if alone else "generic closed configurations"
    where = where if found.closed else "the open reference"
    less = f" - {found.infinitesimal} of first order alone" if found.infinitesimal else ""
    yield (
        f"  rows {found.rows}, rank at {where} {found.rank.value}, freedoms of the coordinates "
        f"{found.freedoms}"
    )
    yield (
        f"  mobility = {found.freedoms} - {found.rank.value}{less} = {found.mobility}   "
        f"(Gruebler-Kutzbach, geometry and idle freedoms unseen: {found.gruebler})"
    )
    declared = (
        ", of the loops in space; the rows are those of the declared motion"
        if found.redundant != found.implied_rows
        else ""
    )
    yield f"  redundant constraints: {found.redundant}{declared}"


# --- screws ---------------------------------------------------------------------------------------


def _screws(found: Mobility) -> list[str]:
    platform = found.closure.mechanism.platform_link
    if platform is None or (found.misfit is not None and not found.limbs):
        return []
    where = "the reference" if found.at_reference else "a configuration near the reference"
    lines = [
        f"Reciprocal screws (wrenches that do no work on what the joints allow) at {where}, base "
        f"frame, (force; moment about the origin)"
    ]
    for limb in found.limbs:
        lines += _rows(f"  {limb.limb}: constraint", limb.constraints)
        lines += _rows(f"  {limb.limb}: with actuated joints locked", limb.locked)
    rank = len(found.platform_constraints)
    lines += _rows(f"  {platform}: constraints, rank {rank}", found.platform_constraints)
    title = f"  {platform}: twists left (angular velocity; velocity at the origin)"
    return lines + _rows(title, found.platform_twists)


def _rows(title: str, rows: np.ndarray) -> list[str]:
    """Screws, a line each, under a title."""
    if len(rows) in (0, 6):
        return [f"{title}: {'all' if len(rows) else 'none'}"]
    return [f"{title}:"] + [f"    ({_plain(row[:3])}; {_plain(row[3:])})" for row in rows]


def _plain(values: np.ndarray) -> str:
    return ", ".join(f"{0.0 if abs(v) < 5e-6 else v:.5g}" for v in values)


def _vector(values: object) -> str:
    """A vector to six digits, rounding noise as 0."""
    numbers = (f"{0.0 if abs(v) < 1e-12 else v:.6g}" for v in np.asarray(values, dtype=float))
    return f"({', '.join(numbers)})"
