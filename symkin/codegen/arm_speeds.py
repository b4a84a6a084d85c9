"""Write the C of an arm's speeds and of its control loop: joint rates of a twist, the twist of
joint rates, feed, and one damped step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symkin.codegen.map.platform_rates import speeds_text
from symkin.codegen.text.c import Real
from symkin.codegen.text.templates import fill
from symkin.model.joint import Coordinate

DAMPED_BELOW = 0.02
"""Root of the smallest pivot of the normal equations over their mean diagonal entry below which
rates are damped: a 50th of the usual speed for a joint's rate.
"""
MOST_TURN = 0.2
"""Longest step of a joint in one call of NAME_track (rad, or of the size)."""
_ROUNDS = 4
"""How often a step that does not come nearer is tried, each time a quarter of it."""


def arm_error(
    coordinates: Sequence[Coordinate], real: Real, size: float, values: Mapping[str, object]
) -> str:
    """NAME_error_at, how far the tool is from a pose, and NAME_damped, joint rates of least
    error: what solves and speeds share.
    """
    count = len(coordinates)
    wide, slides = count >= 6, not all(c.is_angular for c in coordinates)
    scales = ", ".join(str(1.0 if c.is_angular else size) for c in coordinates)
    scale = f"static const real column_scale[{count}] = {{ {scales} }};"
    own = {
        "nm": min(count, 6),
        "last": min(count, 6) - 1,
        "per_count": 1.0 / min(count, 6),
        "row_scales": (values["per_size"],) * 3 + (1.0,) * 3,
        "column_scale": slides * [scale],
        "times_column": slides * " * column_scale[j]",
        "damped_pivot": real.literal(DAMPED_BELOW**2),
        "least_pivot": 16.0 * real.epsilon,
        # of six joints or more J J^T z = e and y = J^T z, of fewer J^T J y = J^T e
        "right": "e[i]" if wide else _sum("a[{0}][i] * e[{0}]", 6),
        "product": _sum("a[i][{0}] * a[j][{0}]", count)
        if wide
        else _sum("a[{0}][i] * a[{0}][j]", 6),
        "back": ("column_scale[i] * " if slides else "")
        + (f"({_sum('a[{0}][i] * z[{0}]', 6)})" if wide else "z[i]"),
    }
    return fill("arm_error.c", {**values, **own})


def _sum(product: str, count: int) -> str:
    """C text of a sum of products."""
    return " + ".join(f"({product.format(k)})" for k in range(count))


def arm_speeds(
    coordinates: Sequence[Coordinate],
    rounding: float,
    values: Mapping[str, object],
) -> str:
    """NAME_rates, NAME_twist, NAME_feed and NAME_track of an arm; `rounding`: error of a pose that
    rounding makes, as a length.
    """
    own = {
        "per_turns": tuple(1.0 if c.is_angular else values["per_size"] for c in coordinates),
        "most_turn_literal": MOST_TURN,
        "rounds": _ROUNDS,
        "rounding": rounding,
    }
    twist = speeds_text("twist", "joints", values)
    return twist + fill("arm_rates.c", {**values, **own})
