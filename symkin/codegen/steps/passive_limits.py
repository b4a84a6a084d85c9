"""Write the C that holds joints which are neither given nor found against their limits, those of
cut joints too.

An angle's limits hold whole turns apart: what is compared is its way d from the middle of the
range, by cosine and sine, with half the range h: |sin d| <= sin h where h is far from a quarter
turn (and on which side d is is told by its cosine), else cos d >= cos h.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import reading_expressions
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.joint_ranges import range_of, standing_range
from symkin.codegen.text.c import Emitter, Real
from symkin.model.joint import Coordinate, places_of
from symkin.text import c_comment


@dataclass(frozen=True, eq=False)
class PassiveCheck:
    """What C asks of a joint that is neither given nor found: expressions over the closure's
    variables that are compared, and the condition on their C texts.
    """

    name: str
    compared: tuple[ca.SX, ...]
    condition: str
    still: str
    """The condition on a guess that is the answer, with room for its rounding."""


@dataclass(frozen=True, eq=False)
class PassiveLimit(PassiveCheck):
    """Of limits: what the coordinate reads over the closure's variables, a length, or cosine and
    sine of an angle.
    """

    limits: tuple[float, float]
    parts: tuple[ca.SX, ...]


def _limit(c: Coordinate, parts: tuple[ca.SX, ...], real: Real, size: float) -> PassiveLimit:
    """What is compared is the length, or cosine and, if it is needed, sine of the way from the
    middle.
    """
    assert c.limits is not None  # noqa: S101 - that is why it is here
    ranges = range_of(c, real, size), standing_range(c, real, size)
    if len(parts) == 1:
        kept, stands = (f"({{0}} >= {low}) && ({{0}} <= {high})" for low, high in ranges)
        return PassiveLimit(c.name, parts, kept, stands, c.limits, parts)
    (half, still), (middle, _) = (
        [0.5 * (high + sign * low) for low, high in ranges] for sign in (-1.0, 1.0)
    )
    cosine, sine = parts
    way = (
        cosine * np.cos(middle) + sine * np.sin(middle),
        sine * np.cos(middle) - cosine * np.sin(middle),
    )
    if abs(half - 0.5 * np.pi) <= 0.25 * np.pi:
        kept, stands = (f"{{0}} >= {np.cos(h)}" for h in (half, still))
        return PassiveLimit(c.name, way[:1], kept, stands, c.limits, parts)
    beyond, join = ("<=", "&&") if half < 0.5 * np.pi else (">=", "||")
    kept, stands = (
        f"({{0}} > 0.0) {join} (fabs({{1}}) {beyond} {np.sin(h)})" for h in (half, still)
    )
    return PassiveLimit(c.name, way, kept, stands, c.limits, parts)


def passive_limits(
    closure: Closure, answered: Sequence[Coordinate], real: Real, known: ca.SX | None = None
) -> list[PassiveLimit]:
    """The limits of coordinates that are not `answered`, which are checked elsewhere, as far as
    they follow from the variables `known` (all where it is None); none of a range of a whole turn
    or more.
    """
    names, size = {c.name for c in answered}, closure.characteristic_length
    wanted = [
        c for c in closure.mechanism.coordinates if c.limits is not None and c.name not in names
    ]
    wanted = [
        c
        for c in wanted
        if not c.is_periodic or np.subtract(*range_of(c, real, size)[::-1]) < 2.0 * np.pi
    ]
    if not wanted:
        return []
    held = {c.name: closure.variables[closure.slices[c.name]] for c in closure.coordinates}
    read: Mapping[str, tuple[ca.SX, ...]] = (
        {} if all(c.name in held for c in wanted) else reading_expressions(closure)
    )
    found = []
    for c in wanted:
        if c.name in held:
            own = held[c.name]
            parts = (ca.cos(own), ca.sin(own)) if c.is_periodic else (own,)
            found.append(_limit(c, parts, real, size))
        elif c.name in read:
            found.append(_limit(c, read[c.name], real, size))
    return [limit for limit in found if _follows(limit, closure, known)]


def _follows(limit: PassiveLimit, closure: Closure, known: ca.SX | None) -> bool:
    """Whether a reading moves, and by known variables alone."""
    reads = _read(ca.vertcat(*limit.parts), closure.variables)
    theirs = reads if known is None else _read(known, closure.variables)
    return any(reads) and all(mine <= other for mine, other in zip(reads, theirs, strict=True))


def _read(expression: ca.SX, variables: ca.SX) -> list[bool]:
    """Which variables an expression holds."""
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(expression, variables), 1)) != 0
    return [bool(v) for v in pattern.any(axis=0)]


_ASIDE = 1e-2
"""How far from its limits, as a share of the range, a configuration of a test has a passive
joint.
"""


def keeps_limits(
    limits: Sequence[PassiveLimit], closure: Closure, values: np.ndarray, side: float = 1.0
) -> bool:
    """Whether a configuration, all variables of the closure, is clearly within limits; of side -1,
    whether it is not clearly beyond.
    """
    for limit in limits:
        low, high = limit.limits
        read = ca.Function("read", [closure.variables], [closure.bound(ca.vertcat(*limit.parts))])
        parts = np.asarray(read(values)).ravel()
        middle, half = 0.5 * (low + high), (0.5 - side * _ASIDE) * (high - low)
        way = (
            parts[0] - middle
            if len(parts) == 1
            else np.angle(complex(*parts) * np.exp(-1j * middle))
        )
        if not abs(float(way)) <= half:
            return False
    return True


def texts_of(array: str, coordinates: Sequence[Coordinate]) -> dict[str, list[str]]:
    """C text of the numbers of each of some coordinates, which stand beside each other in an
    array.
    """
    places = places_of(coordinates, [c.width for c in coordinates])
    return {name: [f"{array}[{k}]" for k in own] for name, own in places.items()}


def limit_lines(
    limits: Sequence[PassiveCheck],
    variables: Sequence[str],
    geometry: Geometry,
    real: Real,
    status: str,
    *,
    stands: bool,
) -> list[str]:
    """Statements that set the status to `status` where a limit is not kept, or a joint does not
    exist; `variables` are C text of the closure's variables. Where a guess that `stands` is asked
    too, C's `still` tells that.
    """
    outputs = ca.vertcat(*(part for limit in limits for part in limit.compared))
    inputs = [(geometry.closure.variables, variables), (geometry.symbols, geometry.names)]
    emitter = Emitter.of(real, inputs, outputs, prefix="l")
    place, tests = 0, list[str]()
    for limit in limits:
        texts = [emitter.value(0, place + i) for i in range(len(limit.compared))]
        place += len(texts)
        kept, still = (c.format(*texts) for c in (limit.condition, limit.still))
        asked = f"still ? ({still}) : ({kept})" if stands and still != kept else kept
        tests += [
            f"if (!({asked})) {{ /* {c_comment(limit.name)} */",
            f"    status = {status};",
            "}",
        ]
    return [*emitter.lines, *tests]
