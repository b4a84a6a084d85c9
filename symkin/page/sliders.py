"""Which coordinates get sliders where the actuated joints do not decide a configuration: too few of
them, or some that others decide.
"""

from __future__ import annotations

from collections.abc import Sequence

from symkin.model.mechanism import Mechanism
from symkin.position.determination import Determination, determination
from symkin.position.problem import build_problem
from symkin.position.solve import solve
from symkin.text import first_of

_NAMED = 4
"""Names that a note lists."""


def completed_sliders(mechanism: Mechanism) -> tuple[dict[str, float], str] | None:
    """Values by name, in the mechanism's units, of as many coordinates as decide its
    configuration, and a note of what was left out or added to the actuated ones; None where these
    decide it, where an example tells what is given, and where no joints do.
    """
    example = mechanism.example
    if example is not None and example.joints is None:
        return None
    names = [c.name for c in mechanism.actuated]
    found = _determination(mechanism, names)
    left_out = [name for name in names if name in found.decided]
    kept = [name for name in names if name not in left_out]
    added = _added(mechanism, kept, found) if found.free else []
    if added is None or not (left_out or added):
        return None
    values = {c.name: mechanism.value_out(c, c.reference[0]) for c in mechanism.actuated}
    if example is not None and example.joints is not None:
        values = dict(zip(names, example.joints, strict=True))
    start = solve(
        mechanism, given={name: values[name] for name in kept} or None, check=False
    ).solution
    if start is None:
        return None
    return {name: float(start.joints[name]) for name in (*kept, *added)}, _note(
        names, left_out, added
    )


def _determination(mechanism: Mechanism, names: Sequence[str]) -> Determination:
    return determination(build_problem(mechanism, tuple(names)))


def _added(mechanism: Mechanism, kept: Sequence[str], found: Determination) -> list[str] | None:
    """Names that bind what the kept ones leave free: of the closure's coordinates, then of joints
    at which loops are cut; None where some motion is left.
    """
    added = list(found.binding)
    free = _determination(mechanism, (*kept, *added)).free
    for c in mechanism.coordinates:
        if not free:
            break
        if c.is_rotation or c.name in (*kept, *added, *found.decided):
            continue
        more = _determination(mechanism, (*kept, *added, c.name))
        if not more.decided:
            added.append(c.name)
            free = more.free
    return None if free else added


def _note(names: Sequence[str], left_out: Sequence[str], added: Sequence[str]) -> str:
    said = []
    if added:
        verb = "has a slider" if len(added) == 1 else "have sliders"
        why = (
            "the actuated joints leave the mechanism free to move"
            if names
            else "no joint of the mechanism is actuated"
        )
        said.append(f"{first_of(added, _NAMED)} {verb}: {why}.")
    if left_out:
        verb, them = ("has", "it") if len(left_out) == 1 else ("have", "them")
        said.append(
            f"{first_of(left_out, _NAMED)} {verb} no slider: other actuated joints decide {them}."
        )
    return " ".join([*said, "--given gives sliders to others."])
