"""Places of labels in a picture: each beside what it names, none over another, and clear of symbols
and lines as far as there is room. Pixels; NumPy only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

_DIRECTIONS = 24
_RINGS = (
    0.0,
    4.0,
    9.0,
    15.0,
    22.0,
    30.0,
    40.0,
    52.0,
    66.0,
    82.0,
    100.0,
    120.0,
    145.0,
    175.0,
    210.0,
    250.0,
)
"""Gaps between the anchor's own reach and a label that are tried, nearest first."""
_GAP = 4.0
"""Least gap between two labels."""
_CLEAR = 5.0
"""Wished gap between a label and a line."""
_STEP = 5.0
"""Distance of the points that stand for a line: the gap that is wished."""
_OVER_SYMBOL, _OVER_POINT, _FAR, _TURNED = 60.0, 6.0, 0.16, 1.5
"""Costs: of a covered symbol, of a covered point of a line, of a pixel of distance, of a direction
that is not the wished one.
"""


@dataclass(frozen=True)
class Label:
    """A text for what lies at `anchor` (2,) with radius `reach`, its size in points and its look;
    `wish` is the direction (2,) that it would best lie in; `width` and `height` are its pixels.
    """

    text: str
    anchor: np.ndarray
    reach: float
    font: float
    look: dict[str, Any]
    wish: np.ndarray | None = None
    width: float = 0.0
    height: float = 0.0


@dataclass(frozen=True)
class Box:
    """A rectangle by its middle and its half sides."""

    x: float
    y: float
    wide: float
    high: float

    def meets(self, other: Box, gap: float = 0.0) -> bool:
        return (
            abs(self.x - other.x) < self.wide + other.wide + gap
            and abs(self.y - other.y) < self.high + other.high + gap
        )

    def holds(self, points: np.ndarray, gap: float = 0.0) -> np.ndarray:
        """Which of the points (n, 2) lie inside (n,)."""
        return np.all(
            np.abs(points - (self.x, self.y)) < (self.wide + gap, self.high + gap), axis=1
        )


@dataclass
class Page:
    """The picture, or the part above and right of `left` and `foot`, while labels are placed: its
    size, boxes of symbols, points on lines.
    """

    width: float
    height: float
    symbols: list[Box] = field(default_factory=list)
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    placed: list[Box] = field(default_factory=list)
    left: float = 0.0
    foot: float = 0.0

    def add_line(self, start: Sequence[float], end: Sequence[float]) -> None:
        """Points of a line, to be kept clear."""
        a, b = np.array(start, dtype=float), np.array(end, dtype=float)
        count = max(2, int(np.linalg.norm(b - a) / _STEP))
        self.points = np.vstack([self.points, a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)])

    def place(self, label: Label) -> Box:
        """The best box for a label, kept for those that follow. Where all is full, the nearest that
        meets no other label.
        """
        best = self.find(label)
        if best is None:
            best = self._anywhere(label)
            self.placed.append(best)
        return best

    def find(self, label: Label, farthest: float = np.inf, most: float = np.inf) -> Box | None:
        """The best box within a distance of the anchor and below a cost, kept for those that
        follow; None where there is none.
        """
        best, least = None, most
        for ring in _RINGS:
            if ring > farthest or _FAR * ring >= least:
                break
            for box, turned in self._around(label, ring):
                cost = self._cost(box, ring, turned)
                if cost < least:
                    best, least = box, cost
        if best is not None:
            self.placed.append(best)
        return best

    def _around(self, label: Label, ring: float) -> list[tuple[Box, float]]:
        """Boxes at a distance from the anchor in all directions, with how far each is from the
        wished one (0 to 2).
        """
        half = 0.5 * np.array([label.width, label.height])
        wish = np.array([0.0, 1.0]) if label.wish is None else label.wish
        found = []
        for k in range(_DIRECTIONS):
            angle = 2 * np.pi * k / _DIRECTIONS
            way = np.array([np.cos(angle), np.sin(angle)])
            middle = (
                label.anchor + (label.reach + ring) * way + half * np.clip(1.5 * way, -1.0, 1.0)
            )
            found.append((Box(float(middle[0]), float(middle[1]), *half), 1.0 - float(way @ wish)))
        return found

    def _cost(self, box: Box, ring: float, turned: float) -> float:
        """Infinite outside the picture and over another label."""
        x, y = box.x - self.left, box.y - self.foot
        inside = (
            box.wide + 2 < x < self.width - box.wide - 2
            and box.high + 2 < y < self.height - box.high - 2
        )
        if not inside or any(box.meets(other, _GAP) for other in self.placed):
            return float("inf")
        symbols = sum(1 for symbol in self.symbols if box.meets(symbol, 2.0))
        return (
            _OVER_SYMBOL * symbols
            + _OVER_POINT * float(box.holds(self.points, _CLEAR).sum())
            + _FAR * ring
            + _TURNED * turned
        )

    def _anywhere(self, label: Label) -> Box:
        """The free place nearest to the anchor on a grid over the picture, or the anchor where
        there is none.
        """
        wide, high = 0.5 * label.width, 0.5 * label.height
        xs = np.arange(wide + 3, max(wide + 4, self.width - wide - 2), 12.0)
        ys = np.arange(high + 3, max(high + 4, self.height - high - 2), high + 2)
        boxes = [
            Box(self.left + float(x), self.foot + float(y), wide, high) for x in xs for y in ys
        ]
        free = [box for box in boxes if not any(box.meets(other, _GAP) for other in self.placed)]
        x, y = label.anchor
        return min(
            free, key=lambda box: (box.x - x) ** 2 + (box.y - y) ** 2, default=Box(x, y, wide, high)
        )
