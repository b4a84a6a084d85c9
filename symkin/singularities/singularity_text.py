"""A configuration's singularity as text for terminals and as JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from symkin.plain_number import plain

if TYPE_CHECKING:
    from symkin.position.solution import Solution
    from symkin.singularities.singularity import Singularity


def singularity_text(found: Singularity) -> str:
    """Kind and conditions, distances, condition and manipulability, then the screws and joint rates that show it."""
    from symkin.singularities.singularity import CONDITIONS, KINDS, OUTPUT_KINDS

    mechanism = found.solution.mechanism
    head = ", ".join(found.kinds) + " singularity" if found.kinds else "no further singularity" if found.loose else "regular"
    names = f" ({', '.join(CONDITIONS[name] for name in found.conditions)})" if found.conditions else ""
    about = [] if found.output is None else [f"output: velocity {found.output}"]
    lines = [_solution_text(found.solution), *about, *_loose(found), f"{head}{names}"]
    what, meanings = ("platform", KINDS) if found.output is None else ("output", OUTPUT_KINDS)
    lines += [f"  {kind}: {meanings[kind]}" for kind in found.kinds]
    distances = ", ".join(f"{kind} {plain(value):.3g}{_beyond(found, kind)}" for kind, value in found.distances.items())
    lines.append(f"distance (0 singular; rows of unit length, angles times the size {mechanism.size:.6g}): {distances}")
    lines.append(
        f"direct map, joint rates to {'twist' if found.output is None else 'output'}: condition {found.condition:.4g}, manipulability {found.manipulability:.4g}; "
        f"inverse map {found.inverse_manipulability:.4g}"
    )
    free = "constraint" in found.kinds and "type 2" not in found.kinds
    held = "with the actuated joints free" if free else "with the actuated joints held"
    lines += [f"platform motion {held}: {screw}" for screw in found.twists]
    lines += [f"borne without the actuated joints: {screw}" for screw in found.wrenches]
    lines += [f"joint rates with the {what} at rest: {_rates(rates)}" for rates in found.inputs]
    lines += [f"note: {note}" for note in (*found.solution.notes, *found.notes)]
    return "\n".join(lines)


def _loose(found: Singularity) -> list[str]:
    """What the actuated joints never decide."""
    if not found.loose:
        return []
    freedoms = f"{found.loose} freedom{'' if found.loose == 1 else 's'}"
    return [
        f"singular everywhere: with all actuated joints held the {'platform' if found.output is None else 'output'} keeps {freedoms} at every configuration"
    ]


def _beyond(found: Singularity, kind: str) -> str:
    """The freedoms that a distance does not count."""
    count = found.everywhere.get(kind, 0)
    return f" (from more than the {count} everywhere)" if count else ""


def singularity_dict(found: Singularity) -> dict[str, Any]:
    """The same as one object; infinite numbers are null."""
    mechanism = found.solution.mechanism
    return {
        "mechanism": mechanism.name,
        "length_unit": mechanism.length_unit,
        "angle_unit": mechanism.angle_unit,
        "size": mechanism.size,
        "output": None if found.output is None else found.output.to_dict(),
        "configuration": found.solution.to_dict(),
        "kinds": list(found.kinds),
        "conditions": list(found.conditions),
        "everywhere": found.everywhere,
        "distances": dict(found.distances),
        "condition": _finite(found.condition),
        "manipulability": _finite(found.manipulability),
        "inverse_manipulability": _finite(found.inverse_manipulability),
        "singular_values": [_finite(float(value)) for value in found.singular_values],
        "twists": [screw.to_dict() for screw in found.twists],
        "wrenches": [screw.to_dict() for screw in found.wrenches],
        "inputs": list(found.inputs),
        "notes": list(found.notes),
    }


def _solution_text(solution: Solution) -> str:
    """Pose, joints, residual and condition in one line, rounding noise as 0."""
    mechanism = solution.mechanism
    position = ", ".join(f"{plain(float(v), mechanism.size):.6g}" for v in solution.position)
    quaternion = ", ".join(f"{plain(float(v), least=5e-7):.6f}" for v in solution.quaternion)
    joints = ", ".join(f"{k} = {plain(v, mechanism.size):.6g}" for k, v in solution.joints.items() if isinstance(v, float))
    return (
        f"{mechanism.name} at ({position}) {mechanism.length_unit}, quaternion ({quaternion}); {joints}; residual "
        f"{solution.residual:.1e}, condition {solution.condition:.3g}"
    )


def _rates(rates: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in rates.items())


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
