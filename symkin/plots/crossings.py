"""Which of two lines that cross in a picture is nearer to the eye: each line is cut into pieces of
one crossing, which are drawn in the order of their depth there. NumPy only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

_INSIDE = 1e-3
"""Share of a line next to its ends in which it only touches others."""


@dataclass(frozen=True, eq=False)
class Piece:
    """The part of line `number` from `start` to `end`, each (3,), with its nearness to the eye;
    `over` is the point (3,) where it passes over another line, None where it passes over none;
    `free` says which of its ends are ends of the whole line.
    """

    number: int
    start: np.ndarray
    end: np.ndarray
    nearness: float
    over: np.ndarray | None
    free: tuple[bool, bool]


def pieces(lines: Sequence[tuple[np.ndarray, np.ndarray]], axes: np.ndarray) -> list[Piece]:
    """The pieces of straight lines from start to end; rows of `axes` are the picture's right and up
    and the direction to the eye.
    """
    seen = [np.array([axes @ start, axes @ end]) for start, end in lines]
    found = []
    for number, (start, end) in enumerate(lines):
        places = sorted(
            _crossings(seen[number], [other for k, other in enumerate(seen) if k != number])
        )
        shares = [share for share, _ in places]
        cuts = [0.0, *(0.5 * (a + b) for a, b in pairwise(shares)), 1.0]
        depths = seen[number][:, 2]
        for k, (a, b) in enumerate(pairwise(cuts)):
            at = shares[k] if shares else 0.5
            nearness = float((1.0 - at) * depths[0] + at * depths[1])
            ends = start + a * (end - start), start + b * (end - start)
            over = start + at * (end - start) if places and places[k][1] else None
            found.append(Piece(number, *ends, nearness, over, (k == 0, k == len(cuts) - 2)))
    return found


def _crossings(line: np.ndarray, others: Sequence[np.ndarray]) -> list[tuple[float, bool]]:
    """Where others (2, 3) cross a line (2, 3) in the picture, from 0 at its start to 1 at its end,
    and whether it is nearer there.
    """
    found = []
    along = (line[1] - line[0])[:2]
    for other in others:
        across = (other[1] - other[0])[:2]
        turn = along[0] * across[1] - along[1] * across[0]
        if abs(turn) <= 1e-12 * float(np.linalg.norm(along) * np.linalg.norm(across)):
            continue
        gap = (other[0] - line[0])[:2]
        t = (gap[0] * across[1] - gap[1] * across[0]) / turn
        u = (gap[0] * along[1] - gap[1] * along[0]) / turn
        if _INSIDE < t < 1.0 - _INSIDE and _INSIDE < u < 1.0 - _INSIDE:
            found.append(
                (
                    float(t),
                    bool(
                        (1.0 - t) * line[0, 2] + t * line[1, 2]
                        > (1.0 - u) * other[0, 2] + u * other[1, 2]
                    ),
                )
            )
    return found
