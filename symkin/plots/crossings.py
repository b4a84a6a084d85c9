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


def pieces(
    lines: Sequence[tuple[np.ndarray, np.ndarray]], axes: np.ndarray, *, whole: bool = False
) -> list[Piece]:
    """The pieces of straight lines from start to end; rows of `axes` are the picture's right and up
    and the direction to the eye. With `whole`, where all lie in one plane, no line is cut.
    """
    seen = np.array([[axes @ start, axes @ end] for start, end in lines]).reshape(-1, 2, 3)
    found = []
    for number, (start, end) in enumerate(lines):
        places = [] if whole else _crossings(seen[number], np.delete(seen, number, axis=0))
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


def _crossings(line: np.ndarray, others: np.ndarray) -> list[tuple[float, bool]]:
    """Where others (n, 2, 3) cross a line (2, 3) in the picture, from 0 at its start to 1 at its
    end, and whether it is nearer there.
    """
    along, across = (line[1] - line[0])[:2], (others[:, 1] - others[:, 0])[:, :2]
    turn = along[0] * across[:, 1] - along[1] * across[:, 0]
    apart = np.abs(turn) > 1e-12 * np.linalg.norm(along) * np.linalg.norm(across, axis=1)
    others, across, turn = others[apart], across[apart], turn[apart]
    gap = (others[:, 0] - line[0])[:, :2]
    t = (gap[:, 0] * across[:, 1] - gap[:, 1] * across[:, 0]) / turn
    u = (gap[:, 0] * along[1] - gap[:, 1] * along[0]) / turn
    own = (1.0 - t) * line[0, 2] + t * line[1, 2]
    nearer = own > (1.0 - u) * others[:, 0, 2] + u * others[:, 1, 2]
    inside = (np.minimum(t, u) > _INSIDE) & (np.maximum(t, u) < 1.0 - _INSIDE)
    return sorted(zip(t[inside].tolist(), nearer[inside].tolist(), strict=True))
