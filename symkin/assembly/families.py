"""Families of structure groups: groups whose rows are the same but for their numbers.

A family is a problem in which these numbers are known values too, so that its formulas, paths and
proofs are derived once for all of its members.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from symkin.assembly.laid_loops import LaidLoop, laid_loop
from symkin.closure.expression_graph import instructions, rebuilt
from symkin.computed_once import lru_cache
from symkin.homotopy.systems import joint_rows
from symkin.model.joint import Coordinate
from symkin.position.gear_train import gear_train
from symkin.position.groups import is_linear
from symkin.position.problem import Problem

_FEWEST = 8
"""Members of a family at least: the formulas of a single group are shorter with its own numbers."""
_MOST_UNKNOWNS = 4
_LITERAL = (0.0, 0.5, 1.0, 2.0)
"""Sizes of constants that belong to the formulas and not to the geometry: an angle is halved."""

_ROUNDING = 2.0**-50
"""Of the size, or of the largest coordinate: difference of sums that are one number."""


@dataclass(frozen=True, eq=False)
class Member:
    """A group as a member of a `family`, whose known values have the member's `numbers` behind its
    own. Those of a `laid` loop are rounded: proofs are of its own rows.
    """

    family: Problem
    numbers: np.ndarray
    laid: LaidLoop | None

    def known(self, known: np.ndarray) -> np.ndarray:
        """Known values of the family from those of the group (n, known)."""
        known = known if self.laid is None else self.laid.known(known)
        return np.hstack([known, np.tile(self.numbers, (len(known), 1))])


@lru_cache(maxsize=32)
def members_of(groups: tuple[Problem, ...]) -> dict[Problem, Member]:
    """Those of some groups that are members of large families."""
    many = len(groups) >= _FEWEST
    candidates = [group for group in groups if many and _may_be_member(group)]
    if len(candidates) < _FEWEST:
        return {}
    laid = {group: None if _is_whole(group) else laid_loop(group) for group in candidates}
    alike = {group: group if own is None else own.problem for group, own in laid.items()}
    taken = {group: _Numbers.of(own) for group, own in alike.items() if _is_whole(own)}
    families: dict[Hashable, list[Problem]] = {}
    for group, numbers in taken.items():
        families.setdefault(numbers.key, []).append(group)
    found: dict[Problem, Member] = {}
    for members in families.values():
        if len(members) < _FEWEST:
            continue
        first = members[0]
        units = np.exp2(np.floor(np.log2(np.abs(taken[first].values))))
        family = _family(first, alike[first], taken[first], units)
        found |= {
            group: Member(family, np.array(taken[group].values) / units, laid[group])
            for group in members
        }
    return found


def _is_whole(group: Problem) -> bool:
    """Whether a group has no more rows than unknowns, and turns as a family."""
    return (
        group.system.rows.shape[0] == group.system.freedom
        and _turns_as_family(group)
        and joint_rows(group).shape[0] == group.system.freedom
    )


def _may_be_member(group: Problem) -> bool:
    system = group.system
    return (
        system.freedom <= _MOST_UNKNOWNS
        and not group.implied
        and not group.closure.partition.geometry
        and all(c.body is None and c.kind in ("angle", "length") for c in system.unknowns)
        and not any(c.is_advancing for c in group.known_coordinates)
        # whose solutions are told by their own numbers, without a search
        and gear_train(group) is None
        and not is_linear(group)
    )


def _turns_as_family(group: Problem) -> bool:
    """Whether turns stay what they are whatever the numbers: about axes of the frame, whose numbers
    are none of the geometry. Those of others are tied, without which there are more solutions.
    """
    own = {c.name for c in (*group.system.unknowns, *group.known_coordinates) if c.is_periodic}
    return all(
        abs(number) in _LITERAL
        for joint in group.mechanism.all_joints
        if not own.isdisjoint(c.name for c in joint.coordinates)
        for axis in (joint.axis, joint.axis2)
        for number in axis or ()
    )


@dataclass(eq=False)
class _Numbers:
    """The numbers of a group's rows, each once, and what is left of the rows without them (`key`);
    numbers within `rounding` are one.
    """

    rounding: float
    values: list[float] = field(default_factory=list)
    key: Hashable = ()

    @staticmethod
    def of(group: Problem) -> _Numbers:
        size = max(group.system.farthest, group.system.characteristic_length)
        found, left, slots = _Numbers(_ROUNDING * size), list[Hashable](), dict[int, Hashable]()
        for op, a, o, number in instructions(_function(group)):
            if op == ca.OP_CONST:
                slots[o[0]] = found.signed_place(number)
                continue
            read = tuple(a) if op == ca.OP_INPUT else tuple(slots[slot] for slot in a)
            left.append((op, read, tuple(o) if op == ca.OP_OUTPUT else None))
            if op != ca.OP_OUTPUT:
                slots[o[0]] = len(left)
        coordinates = (*group.system.unknowns, *group.known_coordinates)
        plain = tuple(replace(c, name="", reference=()) for c in coordinates)
        found.key = (plain, group.system.freedom, tuple(left))
        return found

    def signed_place(self, number: float) -> tuple[float, int]:
        """Place of a number and its sign, beside that of the number that stands there; itself and
        -1 where it is no geometry.
        """
        if abs(number) in _LITERAL:
            return number, -1
        for place, value in enumerate(self.values):
            sign = float(np.sign(number * value))
            if abs(sign * number - value) <= self.rounding:
                return sign, place
        self.values.append(number)
        return 1.0, len(self.values) - 1


@lru_cache(maxsize=128)
def _function(group: Problem) -> ca.Function:
    """Rows, of any length of a known quaternion as those that paths follow, and closure errors."""
    system = group.system
    both = ca.densify(ca.vertcat(joint_rows(group), system.errors))
    return ca.Function("rows", [system.unknown, system.known], [both])


def _family(group: Problem, alike: Problem, numbers: _Numbers, units: np.ndarray) -> Problem:
    """The problem of a group by the rows of the one that it is `alike`, with their numbers, in
    their `units`, among the known values.
    """
    system, closure = group.system, group.closure
    symbols = ca.SX.sym("number", len(units))
    values = (np.array(numbers.values) / units).tolist()
    more = tuple(
        Coordinate(f"number {k}", "turns", "geometry", (value,)) for k, value in enumerate(values)
    )

    def lifted(number: float) -> ca.SX:
        sign, place = numbers.signed_place(number)
        return ca.SX(sign) if place < 0 else sign * units[place] * symbols[place]

    whole = rebuilt(_function(alike), [system.unknown, system.known], lifted, lambda value: value)
    count = alike.system.rows.shape[0]
    # what is known of a body is any numbers to its rows
    plain = (replace(c, role="geometry") if c.body else c for c in alike.known_coordinates)
    known = (*plain, *more)
    rows, errors = whole[:count], whole[count:]
    return replace(
        group,
        closure=replace(
            closure,
            coordinates=(*system.unknowns, *known),
            variables=ca.vertcat(system.unknown, system.known, symbols),
            rows=rows,
            errors=errors,
            parameters=ca.SX(0, 1),
            parameter_names=(),
            parameter_values=np.zeros(0),
            row_sources=tuple(closure.row_sources[k] for k in group.row_places)[:count],
            row_numbers=(),
            error_sources=(),
        ),
        system=replace(system, known=ca.vertcat(system.known, symbols), rows=rows, errors=errors),
        known_coordinates=known,
        row_places=tuple(range(count)),
    )
