"""Write the C that checks joint values against their ranges, and that names the first one
outside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symkin.codegen.text.c import Real
from symkin.codegen.text.templates import FARTHEST, fill
from symkin.model.joint import Coordinate

_ROUNDINGS = 64
"""Roundings of an angle or a slide by which what stands still may be beyond its range."""


@dataclass(frozen=True)
class Range:
    """C text of one joint's range: what is compared with `low`, the joint's value where nothing
    else is told, and `high`.
    """

    low: str
    high: str
    above: str = "joints[{i}]"

    def test(self, i: int | str) -> str:
        """C condition that joint i is within its range."""
        return f"(({self.above.format(i=i)} >= {self.low}) && (joints[{i}] <= {self.high}))"


def ranges_of(coordinates: Sequence[Coordinate], real: Real, size: float) -> list[Range]:
    """The limits, with room for rounding; rods are not shorter than zero; without limits a value is
    at least finite.
    """
    return [Range(*map(str, range_of(c, real, size))) for c in coordinates]


def range_of(c: Coordinate, real: Real, size: float) -> tuple[float, float]:
    """Least and largest value of one joint."""
    slack = max(1e-9, 16 * real.epsilon) * (1.0 if c.is_angular else size)
    low, high = c.limits or (
        (-FARTHEST, FARTHEST) if c.is_angular else (-FARTHEST * size, FARTHEST * size)
    )
    if c.least is not None:
        low = max(low, c.least + 1e-6 * size)
    return low - slack, high + slack


def standing_range(c: Coordinate, real: Real, size: float) -> tuple[float, float]:
    """The same with room for what rounding makes of an answer at a limit that stands still."""
    room = max(1e-9, _ROUNDINGS * real.epsilon) * (1.0 if c.is_angular else size)
    low, high = range_of(c, real, size)
    return low - room, high + room


def range_functions(
    ranges: Sequence[Range], real: Real, values: Mapping[str, object], positive: str = ""
) -> str:
    """NAME_first_beyond and NAME_limit_joints. In float, where room counts, ranges that are all
    alike are checked in a loop.
    """
    tables, inside = _by_number(ranges)
    named = fill("first_beyond.c", {**values, "tables": tables, "inside": inside})
    tests, shared = "", "NAME_SHARED "
    if real.name == "float" and len(ranges) > 1 and len(set(ranges)) == 1:
        shared = ""
        tests = f"name_first_beyond(GEOMETRY joints) == {len(ranges)}U"
    shown = {**values, "positive": positive, "shared": shared}
    return named + check_text("joint values", "ranges", "limit_joints", ranges, shown, tests)


def check_text(
    what: str,
    bounds: str,
    check: str,
    ranges: Sequence[Range],
    values: Mapping[str, object],
    tests: str = "",
) -> str:
    """The function `check` that holds values against ranges, or asks by other `tests`."""
    told = tests or "\n        && ".join(r.test(i) for i, r in enumerate(ranges))
    plain = {"positive": "", "shared": ""}
    own = {"what": what, "bounds": bounds, "check": check, "ranges": told}
    return fill("within.c", {**plain, **values, **own})


def _by_number(ranges: Sequence[Range]) -> tuple[list[str], str]:
    """Tables of limits, and the C condition that the joint of number `joint` is within them."""
    if len({r.above for r in ranges}) > 1:
        return [], "(" + " || ".join(
            f"((joint == {i}U) && {r.test(i)})" for i, r in enumerate(ranges)
        ) + ")"
    tables, ends = [], []
    for end in ("low", "high"):
        texts = [getattr(r, end) for r in ranges]
        ends.append(texts[0] if len(set(texts)) == 1 else f"{end}[joint]")
        if len(set(texts)) > 1:
            tables.append(f"static const real {end}[{len(ranges)}] = {{ {', '.join(texts)} }};")
    return tables, Range(ends[0], ends[1], ranges[0].above).test("joint")
