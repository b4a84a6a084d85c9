"""Write the C that checks limits of rods along a straight line of poses, exactly.

With the unit quaternions q0, q1 of both ends and c = q0 . q1 the turn on the way is that of q =
q0 + t (q1 - q0), whose squared length n has the Bernstein coefficients 1, c, 1. The vector n d of a
rod, d = p + R(q) a - b, is a cubic in t: R(q) |q|^2 is quadratic in q and p is linear. Its
coefficients follow from d at both ends and at the middle pose (the rotation of q0 + q1):

    d0,  (2 (1 + c) dm - d1 + (1 - c) v) / 3,  (2 (1 + c) dm - d0 - (1 - c) v) / 3,  d1,
    v = p1 - p0.

So n^2 (|d|^2 - L^2) is a polynomial of degree 6. It is at least 0 where its Bernstein coefficients
are; parts decide it else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symkin.codegen.steps.joint_ranges import Range
from symkin.codegen.text.templates import fill

_LEAST_PART = 2.0**-10
"""Shortest part, of what is left of a line, that is looked at: nearer to a limit than that is not
within it.
"""


def rod_line(ranges: Sequence[Range], values: Mapping[str, object]) -> str:
    """NAME_line, of rods whose joint values have these ranges."""
    numbers = {
        "third": 1.0 / 3.0,
        "least_part": _LEAST_PART,
    }
    # a rod without limits, whose range is that of its length, is as short as it likes
    lows = [r.low if r.above == Range.above else f"-{r.high}" for r in ranges]
    ends = {"lows": tuple(lows), "highs": tuple(r.high for r in ranges)}
    return fill("rod_line.c", {**values, **numbers, **ends})
