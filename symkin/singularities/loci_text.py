"""Loci over a plane as text, and the sentences that the text and the picture share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from symkin.plain_number import plain
from symkin.position.varied_pose import turn_text

if TYPE_CHECKING:
    from symkin.singularities.loci import Loci
    from symkin.singularities.locus import Locus

_THIN = (
    "thin lines in the picture are parts in other working modes: there a limb's inverse problem has another solution than in "
    "the configuration"
)


def loci_text(loci: Loci) -> str:
    """The window, one line for each curve, then what the picture's marks mean, the search and its notes."""
    window = " and ".join(
        f"{name} {low:g} to {high:g} {unit}"
        for name, (low, high), unit in zip(loci.plane.names, loci.ranges, loci.units, strict=True)
    )
    lines = [f"{loci.plane.mechanism.name}: singularity loci over {window}; {held_text(loci)}"]
    if loci.angles is not None:
        lines.append(loci.angles)
    lines += [f"{k}: {_curve_text(loci, curve)}" for k, curve in enumerate(loci.curves, start=1)]
    if not loci.curves:
        lines.append(without_curves(loci))
    if any(not curve.in_mode.all() for curve in loci.curves if not curve.is_point):
        lines.append(_THIN)
    lines.append(f"{loci.starts} starts, seed {loci.seed}; a curve that no start reaches is not listed")
    return "\n".join([*lines, *(f"note: {note}" for note in loci.notes)])


def without_curves(loci: Loci) -> str:
    """What loci without a curve mean."""
    from symkin.singularities.loci import EVERYWHERE

    if any(note.endswith(EVERYWHERE) for note in loci.notes):
        return "every configuration in this window is singular"
    return "no locus was met in this window"


def held_text(loci: Loci) -> str:
    """What is held, with names and units: the other pose coordinates, or the other actuated joints."""
    plane, mechanism = loci.plane, loci.plane.mechanism
    held = []
    for c in plane.closure.role("pose" if plane.of_pose else "actuated"):
        name = c.name.removeprefix("pose.")
        if c.kind == "quaternion":
            held.append(_orientation_text(loci))
        elif name not in plane.names:
            value = float(loci.solution.values[c.name])
            shown = plain(mechanism.angle_out(value)) if c.is_angular else plain(value, mechanism.size)
            more = "rz + " if plane.of_pose and name == "gamma" and "rz" in plane.names else ""
            held.append(f"{name} = {more}{shown:.5g} {mechanism.angle_unit if c.is_angular else mechanism.length_unit}")
    return "held: " + ", ".join(held) if held else "nothing else is held"


def _orientation_text(loci: Loci) -> str:
    quaternion = ", ".join(f"{plain(float(v)):.4g}" for v in loci.solution.quaternion)
    return f"orientation ({quaternion}){turn_text(loci.plane.names)}"


def _curve_text(loci: Loci, curve: Locus) -> str:
    head = curve.kind + (f" of {curve.limb}" if curve.limb else "")
    if curve.is_point:
        what = "a motion with both coordinates held" if curve.self_motion else "curves that nearly touch or cross"
        return f"{head}, {what}, at {_place(curve.points[0])}"
    cusps = "".join(f", cusp at {_place(point)}" for point in curve.cusps)
    ends = "".join(f", its tracing ends inside the window at {_place(point)}" for point in curve.loose_ends(loci.ranges))
    starts = f"{curve.hits} start{'' if curve.hits == 1 else 's'}"
    return f"{head}, {'closed' if curve.closed else 'open'}, {len(curve.points)} points, met by {starts}{cusps}{ends}"


def _place(point: object) -> str:
    u, v = (plain(float(x)) for x in point)  # type: ignore[attr-defined]
    return f"({u:.9g}, {v:.9g})"
