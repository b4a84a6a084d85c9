"""What a mechanism has at every configuration, which kinds and distances of singularities do not count, and notes on it."""

from __future__ import annotations

from symkin.closure.closure import Closure
from symkin.singularities.motion_ranks import Ranks
from symkin.singularities.output import Output

_STANDING = {
    "type 1": "freedoms of the actuated joints with the platform at rest",
    "type 2": "freedoms that are not actuated",
    "passive": "freedoms of passive joints alone",
}
"""What a mechanism has of each kind at every configuration."""


def notes_on(closure: Closure, ranks: Ranks, generic: Ranks, output: Output | None = None) -> tuple[str, ...]:
    """Sentences on what is not looked for or counted, and where the freedoms differ from those elsewhere."""
    mechanism, full = closure.mechanism, sum(c.freedom for c in closure.role("pose"))
    notes = []
    if mechanism.motion != "spatial":
        notes.append(f"the platform's motion is declared {mechanism.motion}: constraint singularities are not looked for")
    if output is None and not mechanism.serial and generic.outputs < full:
        notes.append(_of_few_freedoms(generic.outputs, full))
    if output is None and mechanism.serial and generic.outputs < full:
        notes.append(_of_short_arm(len(mechanism.actuated), generic.outputs, full))
    if generic.inputs < len(mechanism.actuated):
        notes.append(f"only {generic.inputs} of {len(mechanism.actuated)} actuated joints are independent")
    notes += [f"{_STANDING[kind]}, everywhere: {count}" for kind, count in everywhere(generic).items()]
    if ranks.motions + ranks.idle != generic.motions + generic.idle:
        notes.append(f"freedoms of motion here {ranks.motions + ranks.idle}, elsewhere {generic.motions + generic.idle}")
    return tuple(notes)


def everywhere(generic: Ranks) -> dict[str, int]:
    """Freedoms of each kind of singularity that every configuration has, where there are any."""
    counts = {
        "type 1": generic.motions - generic.outputs,
        "type 2": generic.motions - generic.inputs,
        "passive": generic.idle,
    }
    return {kind: count for kind, count in counts.items() if count}


def _of_short_arm(joints: int, freedoms: int, full: int) -> str:
    return (
        f"with {joints} joint{'' if joints == 1 else 's'} the tool has {freedoms} of {full} freedoms: type 1 means that joints move "
        "while position and orientation of the tool both stand; where only its position loses a direction, as a stretched arm's "
        "may, is not named without an output, such as --output x,y,z"
    )


def _of_few_freedoms(freedoms: int, full: int) -> str:
    return (
        f"the platform has {freedoms} of {full} freedoms; type 1 and type 2 are about its position and orientation together: joints that "
        "turn it about a point at rest are no type 1; for a point or some coordinates name the output, such as --output x,y"
    )
