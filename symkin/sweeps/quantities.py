"""What a sweep stores: the arrays of each quantity, and a chunk's modes laid out in them.

`modes`: all of them, with the named points of links; `conditioning`: their distances from
singularities of type 1 and type 2 (see `symkin.singularities.singularity_result`) with what is
given as what drives, their condition numbers, and the least and largest of these at each point;
`reach`: how many there are, how many within limits, and whether there is any. An array with the
dimension `mode` is as long there as the most modes of any point, and filled up with its `fill`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symkin.assembly.mode_table import COMPLETENESS, ModeTable
from symkin.errors import InputError
from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.position.problem import Problem
from symkin.position.transfer import many_elsewhere
from symkin.singularities.motion_ranks import distances, generic_ranks
from symkin.text import not_among
from symkin.velocity.limb_equations import limbwise_equations
from symkin.velocity.roles import roles_of

QUANTITIES = ("modes", "conditioning", "reach")


@dataclass(frozen=True)
class Variable:
    """One array over the points: its type, value where nothing is, dimensions after the points'
    own, and attributes.
    """

    name: str
    dtype: str
    fill: float
    dimensions: tuple[str, ...]
    attributes: tuple[tuple[str, Any], ...]

    @property
    def per_mode(self) -> bool:
        return "mode" in self.dimensions

    def in_units(self, length_unit: str) -> Variable:
        """The array of a mechanism whose lengths have this unit."""
        told = tuple((k, length_unit if v == _LENGTH else v) for k, v in self.attributes)
        return replace(self, attributes=told)


def variables(quantity: str, certify: bool, problem: Problem) -> tuple[Variable, ...]:
    """The arrays of a quantity. Raises InputError for one that is unknown."""
    if quantity not in QUANTITIES:
        raise InputError(f"quantity = {not_among(quantity, QUANTITIES)}")
    mechanism, found = problem.mechanism, [*_COMMON]
    if quantity == "modes":
        found += _PLATFORM if mechanism.platform_link is not None else []
        found += _POINTS if mechanism.link_points else []
        found += [*_MODES, *(_CERTIFICATES if certify else [])]
    elif quantity == "conditioning":
        found += [*_DISTANCES, *(_INCREASED if problem.by_name else []), *_CONDITIONING]
    else:
        found += _REACH
    return tuple(v.in_units(mechanism.length_unit) for v in found)


_LENGTH = "length"
"""Stands for the mechanism's length unit."""


def _number(name: str, dimensions: str = "", **attributes: Any) -> Variable:
    """An array of numbers, NaN where nothing is."""
    return Variable(name, "float64", np.nan, tuple(dimensions.split()), tuple(attributes.items()))


def _whole(name: str, dtype: str, dimensions: str = "", **attributes: Any) -> Variable:
    """An array of whole numbers or flags, -1 where nothing is."""
    return Variable(name, dtype, -1, tuple(dimensions.split()), tuple(attributes.items()))


_COMMON = [
    _whole(
        "count",
        "int32",
        long_name="real modes",
        values=(
            "-1: not computed, or too many to list; 0: none, and the least closure error is "
            "what symkin modes says there"
        ),
    ),
    Variable(
        "completeness",
        "uint8",
        0,
        (),
        (
            ("flag_values", list(range(len(COMPLETENESS)))),
            ("flag_meanings", list(COMPLETENESS)),
        ),
    ),
    _whole("unresolved", "int32", long_name="unresolved paths", values="-1: no paths were tracked"),
    _whole(
        "continuum",
        "int8",
        long_name="solutions that are not isolated were met",
        values="1: yes, 0: no",
    ),
]
_CONDITION = _number(
    "condition", "mode", long_name="condition of the unknowns' Jacobian", units="1"
)
_WITHIN = _whole("within_limits", "int8", "mode", values="1: yes, 0: no, -1: no mode, or no limits")
_DISTANCES = [
    _number(
        f"distance_{kind.replace(' ', '_')}",
        "mode",
        units="1",
        long_name=(
            f"distance from a singularity of {kind} (0: singular; rows of unit length, angles "
            f"times the size)"
        ),
    )
    for kind in ("type 1", "type 2")
]
_INCREASED = [
    _number(
        "distance_increased",
        "mode",
        units="1",
        long_name=(
            "distance from configurations of more freedoms (0: there; singular value of all rows "
            "over their largest)"
        ),
    )
]
_CONDITIONING = [
    _CONDITION,
    _WITHIN,
    _number("least_condition", long_name="condition of the best mode", units="1"),
    _number("largest_condition", long_name="condition of the worst mode", units="1"),
]
_REACH = [
    _whole(
        "count_within_limits",
        "int32",
        long_name="real modes within limits",
        values="all, where there are no limits",
    ),
    _whole(
        "reached",
        "int8",
        long_name="some solution lies within limits",
        values="1: yes, 0: no, -1: not decided",
    ),
]
_PLATFORM = [
    _number("position", "mode axis", units=_LENGTH),
    _number("quaternion", "mode component", units="1"),
]
_POINTS = [
    _number(
        "points",
        "mode named_point axis",
        long_name="named points of links in the base frame",
        units=_LENGTH,
    )
]
_MODES = [
    _number("joints", "mode joint", long_name="joint coordinates, units in joint_units"),
    _number("residual", "mode", long_name="largest closure error", units=_LENGTH),
    _CONDITION,
    _WITHIN,
]
_CERTIFICATES = [
    _whole(
        "certified", "int8", "mode", values="1: one exact solution is proved, 0: not, -1: no mode"
    ),
    _number("radius", "mode", long_name="distance of the exact solution at most", units=_LENGTH),
]
ALL_NAMES = frozenset(
    v.name
    for part in (_COMMON, _PLATFORM, _POINTS, _MODES, _CERTIFICATES, _DISTANCES, _INCREASED)
    + (_CONDITIONING, _REACH)
    for v in part
)
"""Names of the arrays of all quantities."""


def arrays_of(
    found: ModeTable, quantity: str, certify: bool, problem: Problem
) -> dict[str, np.ndarray]:
    """The arrays of a chunk: points (n, ...) in order, the dimension `mode` as long as this chunk
    needs.
    """
    chosen = variables(quantity, certify, problem)
    told = found.listed.columns | vars(found)
    if quantity == "modes":
        told |= dict(zip(("joints", "points"), found.joints_and_points, strict=True))
    else:
        told |= _derived(found)
    if quantity == "conditioning":
        told |= _distances(found, problem)
    arrays = {}
    for v in chosen:
        values = told[v.name]
        arrays[v.name] = (
            _spread(found, values, v) if v.per_mode else np.asarray(values).astype(v.dtype)
        )
    return arrays


def _spread(found: ModeTable, values: Any, variable: Variable) -> np.ndarray:
    """Values (m, ...) of all modes as (points, most modes, ...)."""
    count, owner = found.count, found.owner
    begins = np.cumsum(np.maximum(count, 0)) - np.maximum(count, 0)
    spread = np.full(
        (len(count), int(count.max(initial=0)), *values.shape[1:]),
        variable.fill,
        dtype=variable.dtype,
    )
    spread[owner, np.arange(len(owner)) - begins[owner]] = values
    return spread


def _derived(found: ModeTable) -> dict[str, np.ndarray]:
    """What is computed for each point from its modes."""
    n, owner = len(found.count), found.owner
    least, largest = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(least, owner, found.listed.condition)
    np.maximum.at(largest, owner, found.listed.condition)
    inside = np.bincount(owner, weights=found.listed.within_limits != 0, minlength=n).astype(int)
    decided = (inside > 0) | ((found.count >= 0) & ~found.continuum)
    return {
        "least_condition": np.where(found.count > 0, least, np.nan),
        "largest_condition": np.where(found.count > 0, largest, np.nan),
        "count_within_limits": np.where(found.count < 0, -1, inside),
        "reached": np.where(decided, inside > 0, -1),
    }


def _distances(found: ModeTable, problem: Problem) -> dict[str, np.ndarray]:
    """Of each mode; NaN for a kind that the mechanism cannot have."""
    names = ("pose" if c.role == "pose" else c.name for c in problem.known_coordinates)
    roles = roles_of(problem.mechanism, list(dict.fromkeys(names)))
    closure, generic = roles.closure, generic_ranks(roles)
    there = many_elsewhere(closure, problem.closure, found.listed.values)
    rows = [
        distances(
            closure, limbwise_equations(closure, values, SINGULAR_VALUE, roles), generic, roles
        )
        for values in there
    ]
    return {
        f"distance_{kind.replace(' ', '_')}": np.array([row.get(kind, np.nan) for row in rows])
        for kind in ("type 1", "type 2", "increased")
    }
