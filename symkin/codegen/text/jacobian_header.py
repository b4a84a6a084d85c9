"""Write the head of an exported Jacobian (kind, shape, units, inputs), and find names that a
language allows.
"""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Sequence

from symkin._version import __version__
from symkin.velocity.jacobian import Jacobian

_MEANING = {
    "direct": (
        "twist = J * actuated joint rates; twist = (velocity of the {origin}, angular "
        "velocity), base frame"
    ),
    "inverse": "actuated joint rates = J * twist; twist = (velocity of the {origin}, angular "
    "velocity), base frame; J acts on "
    "feasible twists and vanishes on their complement",
    "analytic": (
        "rates of the pose coordinates = J * actuated joint rates; base frame, unit quaternion "
        "w, x, y, z"
    ),
    "rates": "rates of the rows' coordinates = J * rates of the columns' coordinates",
    "passive": (
        "passive joint rates = J * actuated joint rates; a spherical joint has its angular "
        "velocity before the joint"
    ),
}

_RANGE = (
    "By least squares of all equations: right at every closed configuration at which the columns' "
    "coordinates decide all rates. "
    "Where they do not (a singularity), entries grow without bound towards it and are not finite "
    "at it."
)
_CHOICE = (
    "Of redundant constraints some rows are chosen, which are independent at generic "
    "configurations. Where just these lose rank, "
    "entries grow without bound and are not finite, though the configuration may be regular."
)


def meaning(jacobian: Jacobian) -> str:
    """The equation in words."""
    return _MEANING[jacobian.kind].format(origin=f"{jacobian.mechanism.frame_name} origin")


def header(jacobian: Jacobian, names: dict[str, str]) -> list[str]:
    """Lines about a Jacobian: mechanism, kind, shape, units, frames, inputs in order (with their
    `names` in the language).
    """
    mechanism = jacobian.mechanism
    rows, columns = jacobian.shape
    lines = [
        f"{mechanism.name}: {jacobian.kind} Jacobian, {rows} x {columns}",
        *textwrap.wrap(mechanism.title, 110),
        "",
        *textwrap.wrap(meaning(jacobian) + ".", 110),
        f"Lengths in {mechanism.length_unit}, angles in rad, rates per unit of time.",
        *_listed("Rows:", jacobian.rows),
        *_listed("Columns:", jacobian.columns),
        *_listed(
            "Inputs, in this order:",
            [f"{names[v.name]} [{v.unit}]" for v in jacobian.inputs] or ["none"],
        ),
        *_renamed(jacobian, names),
    ]
    if jacobian.parameters:
        lines += _listed(
            "Geometry, after the inputs:",
            [f"{names[v.name]} ({v.source})" for v in jacobian.parameters],
        )
    if _reads_loops(jacobian):
        lines.append("Inputs must be those of a configuration that closes all loops.")
    limbs = jacobian.expressions.limbs
    if limbs is None:
        lines += textwrap.wrap(_RANGE, 110)
    elif jacobian.kind == "inverse" and limbs.chooses_rows:
        lines += textwrap.wrap(_CHOICE, 110)
    return [*lines, f"Made by symkin {__version__}; model SHA-256 {mechanism.digest}"]


def _reads_loops(jacobian: Jacobian) -> bool:
    """Whether the inputs are tied by loops."""
    limbs = jacobian.expressions.limbs
    return limbs is None or (
        bool(jacobian.closure.role("passive")) and not limbs.differential.explicit
    )


def allowed_names(jacobian: Jacobian, reserved: Collection[str]) -> dict[str, str]:
    """For each input and parameter a name that is not reserved."""
    names: dict[str, str] = {}
    for v in (*jacobian.inputs, *jacobian.parameters):
        name = v.name
        while name in reserved or name in names.values():
            name += "_"
        names[v.name] = name
    return names


def free_prefix(names: Collection[str]) -> str:
    """A beginning of numbered names that no input has."""
    prefix = "v"
    while any(name.startswith(prefix) and name[len(prefix) :].isdigit() for name in names):
        prefix += "_"
    return prefix


def _listed(what: str, items: Sequence[str]) -> list[str]:
    """Lines of items that are not broken."""
    whole = " ".join([what, *(f"{item},".replace(" ", "\0") for item in items)]).rstrip(",")
    lines = textwrap.wrap(
        whole, 110, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    return [line.replace("\0", " ") for line in lines]


def _renamed(jacobian: Jacobian, names: dict[str, str]) -> list[str]:
    """Which joints' names had to change."""
    changed = [
        f"{names[v.name]} is {v.source}" for v in jacobian.inputs if names[v.name] != v.source
    ]
    return _listed("Of these,", changed) if changed else []
