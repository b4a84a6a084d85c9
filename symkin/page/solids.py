"""Shapes of marks on links for the page: lists of tubes, balls, blocks, threads and arrows, each in
the base frame at the reference.

A solid is of one link, or hangs `between` two points, or is a rod that is `stretched` between them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

Json = dict[str, Any]
Part = list[Any]
Vector = Sequence[float] | np.ndarray

_DRUM, _LINK, _EDGE, _ROD, _FRAME = 0.26, 0.13, 0.05, 0.085, 1.6
"""Radii of hinges, links, edges of the base and rods, and length of a frame's axes, over the length
of a joint's symbol.
"""
_BARREL, _LEAST_BARREL = 0.52, 0.3
"""The drive of a rod over its length, at the reference at most; and that length over the size at
least.
"""
_DOWN = (0.0, 0.0, -1.0)


def with_solids(item: Json, symbol: float, size: float, view: Json) -> Json:
    """An item with its `solids`, its `extent` (points that a picture holds), and the points whose
    middle its label stands `at`.
    """
    made, more = _Solids(item, symbol, size, view), Json()
    match item["kind"]:
        case "body":
            more["solids"] = [*made.body(), *made.ground()]
            more |= {"extent": item["points"], "at": [made.at(item["link"], made.centre())]}
        case "joint":
            ends = made.ends()
            more |= {"solids": [*made.joint()], "at": ends if item["type"] == "P" else ends[1:]}
        case "rod":
            more |= {"solids": [*made.rod()], "at": made.ends()}
        case "point":
            more |= {"solids": [*made.point()], "at": [made.at(item["link"], item["point"])]}
        case "frame":
            more |= {"solids": [*made.frame()], "extent": made.axis_ends()}
        case "mesh":
            more["extent"] = made.corners()
    return item | more


class _Solids:
    """The solids of one item; `symbol` is the length of a joint's symbol."""

    def __init__(self, item: Json, symbol: float, size: float, view: Json) -> None:
        self.item, self.symbol, self.size, self.view = item, symbol, size, view

    def at(self, link: int, point: Vector) -> Json:
        return {"link": link, "point": list(point)}

    def ends(self) -> list[Json]:
        """The points of a joint or a rod on the links before and after it."""
        item = self.item
        if item["kind"] == "rod":
            return [item["from"], item["to"]]
        points = (item["start"], item["point"])
        return [self.at(link, point) for link, point in zip(item["links"], points, strict=True)]

    # --- links ------------------------------------------------------------------------------------

    def centre(self) -> Vector:
        return [float(v) for v in np.mean(self.item["points"], axis=0)]

    def body(self) -> Iterator[Json]:
        """Tubes along edges, with a ball at each point; those that are not on the rim of a plate
        are thinner. Of a base without plates the edges are dashed.
        """
        item, points, role = self.item, self.item["points"], self.item["role"]
        if role == "base" and not item["faces"]:
            return
        rim = {k for face in item["faces"] for k in face} or set(range(len(points)))
        wide = {"base": _EDGE, "platform": 1.15 * _LINK}.get(role, _LINK) * self.symbol
        radius = [wide if k in rim else 0.45 * wide for k in range(len(points))]
        parts = [tube(points[a], points[b], min(radius[a], radius[b])) for a, b in item["edges"]]
        if parts:
            knots = [ball(point, r, 10) for point, r in zip(points, radius, strict=True)]
            yield solid(item["link"], item["colour"], [*parts, *knots])

    def ground(self) -> Iterator[Json]:
        """The sign of the fixed link below each point: a bar with hatches in a planar mechanism, a
        foot in others.
        """
        s, view = self.symbol, self.view
        for point in self.item["points"] if self.item["role"] == "base" else ():
            if not view["planar"]:
                foot = np.array(point) + 0.3 * s * np.array(_DOWN)
                yield solid(0, "base", [drum(foot, _DOWN, 0.14 * s, 0.42 * s)], idle=True)
                continue
            axes = s * np.array([view["right"], view["up"]])
            lines = [((-0.75, -0.5), (0.75, -0.5), 0.045, 8)]
            lines += [
                ((-0.65 + 0.26 * k, -0.5), (-0.85 + 0.26 * k, -0.75), 0.025, 6) for k in range(6)
            ]
            lines += [((0.0, 0.0), (side, -0.5), 0.04, 8) for side in (-0.42, 0.42)]
            parts = [
                tube(point + np.array(a) @ axes, point + np.array(b) @ axes, r * s, sides)
                for a, b, r, sides in lines
            ]
            yield solid(0, "base edge", parts, idle=True, bare=True)

    # --- joints -----------------------------------------------------------------------------------

    def joint(self) -> Iterator[Json]:
        item, s, p, axes = self.item, self.symbol, self.item["point"], self.item["axes"]
        before, after = item["links"]
        fill, hold = "accent" if item["actuated"] else "white", after if item["slides"] else before
        if item["type"] in "RHC":
            yield solid(hold, fill, [drum(p, axes[0], s, _DRUM * s)])
        if item["type"] == "H":
            thread = ["thread", p, axes[0], 0.85 * s, _DRUM * s, 0.035 * s]
            yield solid(hold, "link", [thread])
        elif item["type"] == "C":
            yield solid(hold, "link", [drum(p, axes[0], 2.2 * s, 0.08 * s, 12)])
        elif item["type"] == "P":
            # a prism in the middle of its rail
            middle, parts = [0.0, 0.0, 0.0], {}
            parts[fill] = ["block", middle, axes[0], s, 2.0 * _DRUM * s]
            parts["link"] = drum(middle, axes[0], 1.7 * s, 0.07 * s, 12)
            for colour, part in parts.items():
                yield solid(before, colour, [part], between=self.ends())
        elif item["type"] == "U":
            for link, axis in zip(item["links"], axes, strict=True):
                arm = 0.46 * s * np.array(axis) / np.linalg.norm(axis)
                yield solid(link, fill, [drum(p, axis, 0.92 * s, 0.09 * s, 14), ball(p, 0.2 * s)])
                caps = [drum(p + side * arm, axis, 0.12 * s, 0.17 * s, 18) for side in (1, -1)]
                yield solid(link, "link", caps)
        elif item["type"] == "S":
            yield solid(after, fill, [ball(p, _DRUM * s)])
        elif item["type"] != "R":
            block = ["block", p, [0.0, 0.0, 1.0], 0.36 * s, 0.36 * s]
            yield solid(after, "link", [block])
        if item["slides"]:
            yield self._stretched(0.07, "link", idle=True, bare=True)

    def rod(self) -> Iterator[Json]:
        rest = float(
            np.linalg.norm(np.subtract(self.item["to"]["point"], self.item["from"]["point"]))
        )
        yield self._stretched(_ROD, "link")
        if self.item["actuated"]:
            most = max(rest, _LEAST_BARREL * self.size)
            yield self._stretched(2.0 * _ROD, "accent", share=_BARREL, most=most)
        for end in self.ends():
            yield solid(end["link"], "white", [ball(end["point"], 0.2 * self.symbol)])

    def _stretched(self, radius: float, colour: str, **more: Any) -> Json:
        """A rod between the item's ends; of their distance, `most` of it at most, a `share`."""
        unit = tube((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), radius * self.symbol)
        return solid(0, colour, [unit], stretched=self.ends(), **more)

    # --- points and frames ------------------------------------------------------------------------

    def point(self) -> Iterator[Json]:
        yield solid(self.item["link"], "text", [["mark", self.item["point"], 0.22 * self.symbol]])

    def axis_ends(self) -> list[list[float]]:
        axes = np.vstack([np.zeros(3), np.transpose(self.item["rotation"])])
        return (np.array(self.item["position"]) + _FRAME * self.symbol * axes).tolist()

    def corners(self) -> list[list[float]]:
        """Of the box that holds a mesh."""
        shares = np.stack(np.meshgrid(*([0.0, 1.0],) * 3), axis=-1).reshape(-1, 3)
        return (np.array(self.item["low"]) + shares * np.array(self.item["span"])).tolist()

    def frame(self) -> Iterator[Json]:
        s, origin = self.symbol, self.item["position"]
        for name, way in zip("xyz", np.transpose(self.item["rotation"]).tolist(), strict=True):
            arrow = ["arrow", origin, way, _FRAME * s, 0.045 * s]
            yield solid(self.item["link"], f"frame {name}", [arrow], idle=True, bare=True)


def solid(link: int, colour: str, parts: Sequence[Part], **more: Any) -> Json:
    """Parts of one colour on a link; `idle` ones the pointer does not find, `bare` ones have no
    contour.
    """
    return {"link": link, "colour": colour, "parts": list(parts), **more}


def tube(start: Vector, end: Vector, radius: float, sides: int = 10) -> Part:
    return ["tube", [*map(float, start)], [*map(float, end)], radius, sides]


def drum(centre: Vector, axis: Vector, length: float, radius: float, sides: int = 20) -> Part:
    """A cylinder about an axis through a centre."""
    middle, half = np.array(centre), 0.5 * length * np.array(axis) / np.linalg.norm(axis)
    return tube(middle - half, middle + half, radius, sides)


def ball(centre: Vector, radius: float, detail: int = 12) -> Part:
    return ["ball", [*map(float, centre)], radius, detail]
