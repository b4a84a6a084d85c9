"""Write the C that holds joints which are neither given nor found against their limits, those of
cut joints too.

An angle's limits hold whole turns apart: what is compared is its way d from the middle of the
range, by cosine and sine, with half the range h: |sin d| <= sin h where h is far from a quarter
turn (and on which side d is is told by its cosine), else cos d >= cos h.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import reading_expressions
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.joint_ranges import range_of
from symkin.codegen.text.c import Emitter, Real
from symkin.model.joint import Coordinate, places_of
from symkin.text import c_comment


class PassiveCheck(Protocol):
    """What C asks of a joint that is neither given nor found: expressions over the closure's
    variables that are compared, and the condition on their C texts.
    """

    @property
    def name(self) -> str: ...

    def compared(self, real: Real, size: float) -> list[ca.SX]: ...

    def test(self, texts: Sequence[str], real: Real, size: float) -> str: ...


@dataclass(frozen=True, eq=False)
class PassiveLimit:
    """A coordinate with limits, and what it reads over the closure's variables: a length, or cosine
    and sine of an angle.
    """

    coordinate: Coordinate
    parts: tuple[ca.SX, ...]

    @property
    def name(self) -> str:
        return self.coordinate.name

    def _half(self, real: Real, size: float) -> float:
        low, high = range_of(self.coordinate, real, size)
        return 0.5 * (high - low)

    def compared(self, real: Real, size: float) -> list[ca.SX]:
        """What C compares: the length, or cosine and, if it is needed, sine of the way from the
        middle.
        """
        if len(self.parts) == 1:
            return list(self.parts)
        middle, (c, s) = 0.5 * sum(range_of(self.coordinate, real, size)), self.parts
        cosine, sine = (
            c * np.cos(middle) + s * np.sin(middle),
            s * np.cos(middle) - c * np.sin(middle),
        )
        return (
            [cosine]
            if abs(self._half(real, size) - 0.5 * np.pi) <= 0.25 * np.pi
            else [cosine, sine]
        )

    def test(self, texts: Sequence[str], real: Real, size: float) -> str:
        """C condition that the coordinate is within its limits."""
        (low, high), half = range_of(self.coordinate, real, size), self._half(real, size)
        if len(self.parts) == 1:
            return f"({texts[0]} >= {low}) && ({texts[0]} <= {high})"
        if len(texts) == 1:
            return f"{texts[0]} >= {np.cos(half)}"
        cosine, sine = texts
        beyond, join = ("<=", "&&") if half < 0.5 * np.pi else (">=", "||")
        return f"({cosine} > 0.0) {join} (fabs({sine}) {beyond} {np.sin(half)})"


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
            found.append(PassiveLimit(c, (ca.cos(own), ca.sin(own)) if c.is_periodic else (own,)))
        elif c.name in read:
            found.append(PassiveLimit(c, read[c.name]))
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
        assert limit.coordinate.limits is not None  # noqa: S101 - that is why it is here
        low, high = limit.coordinate.limits
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
) -> list[str]:
    """Statements that set the status to `status` where a limit is not kept, or a joint does not
    exist; `variables` are C text of the closure's variables.
    """
    closure = geometry.closure
    size = closure.characteristic_length
    compared = [limit.compared(real, size) for limit in limits]
    outputs = ca.vertcat(*(part for parts in compared for part in parts))
    inputs = [(closure.variables, variables), (geometry.symbols, geometry.names)]
    emitter = Emitter.of(real, inputs, outputs, prefix="l")
    place, tests = 0, list[str]()
    for limit, parts in zip(limits, compared, strict=True):
        texts = [emitter.value(0, place + i) for i in range(len(parts))]
        place += len(parts)
        tests += [
            f"if (!({limit.test(texts, real, size)})) {{ /* {c_comment(limit.name)} */",
            f"    status = {status};",
            "}",
        ]
    return [*emitter.lines, *tests]
