"""Reads a mechanism file as a graph of links and joints, with the standard library and NumPy only.

Forms read: joints and rods between links, couplings, named points, limbs of joints and of rods
between links.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Array = np.ndarray
POSITION, ANGLES = ("x", "y", "z"), ("azimuth", "tilt", "torsion")


# --- numbers of a file ----------------------------------------------------------------------------

_OPERATORS: dict[type, Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def number(value: float | str, radians: float = 1.0) -> float:
    """A number, or the value of a string of arithmetic whose angles are `radians` each."""
    return (
        float(value)
        if not isinstance(value, str)
        else _value(ast.parse(value.replace("^", "**"), mode="eval").body, radians)
    )


def _value(node: ast.expr, radians: float) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.Name) and node.id == "pi":
        return math.pi
    if isinstance(node, ast.UnaryOp):
        return _OPERATORS[type(node.op)](_value(node.operand, radians))
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_value(node.left, radians), _value(node.right, radians))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1:
        functions = {"sqrt": math.sqrt, "sin": math.sin, "cos": math.cos, "tan": math.tan}
        unit = 1.0 if node.func.id == "sqrt" else radians
        return functions[node.func.id](unit * _value(node.args[0], radians))
    raise ValueError(f"not arithmetic: {ast.dump(node)}")


# --- the graph ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Coordinate:
    """A joint coordinate: whether an angle, its value at the reference, and its file unit, both
    internal (rad, sizes).
    """

    name: str
    angle: bool
    zero: float
    unit: float
    actuated: bool = False


Motion = tuple[Array, int, float]
"""Unit axis at the reference, place of the coordinate, factor on it."""


@dataclass(frozen=True)
class Joint:
    """A joint of links A and B (-1 is the base): turns in order, slides, and whether it leaves the
    orientation free (S).
    """

    links: tuple[int, int]
    ends: tuple[Array, Array]
    turns: tuple[Motion, ...] = ()
    slides: tuple[Motion, ...] = ()
    holds: tuple[bool, bool] = (True, True)
    home: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))


@dataclass(frozen=True)
class Rod:
    """A rod between points of links A and B: its length, or the place of its coordinate and the
    offset.
    """

    links: tuple[int, int]
    ends: tuple[Array, Array]
    length: float
    coordinate: int = -1


@dataclass(frozen=True)
class Coupling:
    """v[joint] / unit = offset + sum of polynomials of v / unit: (place, coefficients from degree
    1).
    """

    joint: int
    terms: tuple[tuple[int, tuple[float, ...]], ...]
    offset: float


@dataclass(frozen=True)
class GraphFile:
    """Moving links by name, with the mean of their joint points, and what joins them; lengths are
    over the size.
    """

    names: list[str]
    size: float
    centres: Array
    coordinates: list[Coordinate]
    joints: list[Joint]
    rods: list[Rod]
    couplings: list[Coupling]
    points: list[tuple[int, Array]]
    platform: int = -1
    idle: frozenset[int] = frozenset()


# --- reading --------------------------------------------------------------------------------------


class Reader:
    """Collects links, coordinates, joints, rods and couplings of a file; lengths stay in the file's
    until `graph`.
    """

    def __init__(self, data: Mapping[str, Any], given: Sequence[str] = ()) -> None:
        self.data, self.given = data, given
        self.radians = math.pi / 180 if data["angle_unit"] == "deg" else 1.0
        self.links: dict[str, list[Array]] = {}
        self.coordinates: list[Coordinate] = []
        self.joints: list[Joint] = []
        self.rods: list[Rod] = []
        self.points: list[tuple[int, Array]] = []

    def number(self, value: float | str) -> float:
        return number(value, self.radians)

    def vector(self, values: Sequence[float | str]) -> Array:
        return np.array([self.number(v) for v in values])

    def place(self, link: str, point: Array | None = None) -> int:
        """Number of a link, -1 for the base; a joint's point on it counts for its centre and the
        size.
        """
        points = self.links.setdefault(link, [])
        if point is not None:
            points.append(point)
        return [n for n in self.links if n != "base"].index(link) if link != "base" else -1

    def coordinate(self, name: str, angle: bool, actuated: bool, zero: float = 0.0) -> int:
        self.coordinates.append(
            Coordinate(name, angle, zero, self.radians if angle else 1.0, actuated)
        )
        return len(self.coordinates) - 1

    def joint(self, entry: Mapping[str, Any], links: Sequence[str]) -> None:
        kind, name, actuated = entry["type"], entry["name"], bool(entry.get("actuated", False))
        point = self.vector(entry["point"]) if "point" in entry else None
        ends = (self.place(links[0], point), self.place(links[1], point))
        axes = [
            np.asarray(a / np.linalg.norm(a))
            for a in (self.vector(entry[k]) for k in ("axis", "axis2") if k in entry)
        ]
        zero = self.number(entry.get("zero", 0.0)) * (self.radians if kind in "RH" else 1.0)
        turns: list[Motion] = []
        slides: list[Motion] = []
        if kind in "RH":
            turns = [(axes[0], self.coordinate(name, True, actuated, zero), 1.0)]
        if kind == "H":
            slides = [(axes[0], turns[0][1], self.number(entry["pitch"]) / (2 * math.pi))]
        if kind == "P":
            slides = [(axes[0], self.coordinate(name, False, actuated, zero), 1.0)]
        if kind == "C":
            turns = [(axes[0], self.coordinate(f"{name}.angle", True, actuated), 1.0)]
            slides = [(axes[0], self.coordinate(f"{name}.slide", False, actuated), 1.0)]
        if kind == "U":
            turns = [
                (axes[k], self.coordinate(f"{name}.{k + 1}", True, actuated), 1.0) for k in (0, 1)
            ]
        there = np.zeros(3) if point is None else point
        if kind == "S":
            self.points.append((ends[0], there))
        self.joints.append(
            Joint(ends, (there, there), tuple(turns), tuple(slides), (True, kind != "S"))
        )

    def rod(self, entry: Mapping[str, Any], links: Sequence[str], a: Array, b: Array) -> None:
        ends = (self.place(links[0], a), self.place(links[1], b))
        far = float(np.linalg.norm(a - b))
        self.points += [(ends[0], a), (ends[1], b)]
        k = -1
        if entry.get("actuated", False):
            offset = self.number(entry.get("offset", 0.0))
            k, far = self.coordinate(entry["name"], False, True, far - offset), offset
        self.rods.append(
            Rod(ends, (a, b), self.number(entry.get("length", far)) if k < 0 else far, k)
        )

    def limb(self, entry: Mapping[str, Any], position: Array, home: Array) -> None:
        """A limb of joints from link to link, with links of its own between, or a rod whose
        coordinate is its length.
        """
        links = entry.get("links", ["base", "platform"])
        if "joint" not in entry:
            end = position + _rotated(home, self.vector(entry["platform"]))
            return self.rod({**entry, "actuated": True}, links, self.vector(entry["base"]), end)
        rods, last = entry.get("rod", []), len(entry["joint"]) - 1
        chain = [
            links[0],
            *(f"{entry['name']} link {k + 1}" for k in range(last + bool(rods))),
            links[1],
        ]
        for k, joint in enumerate(entry["joint"]):
            self.joint(joint, chain[k : k + 2])
        for rod in rods:
            end = position + _rotated(home, self.vector(rod["platform"]))
            self.rod(rod, chain[-2:], self.vector(rod["from"]), end)
        return None

    def pose(self, link: int, position: Array, home: Array) -> None:
        """Coordinates of the platform's pose, where some are given: joints of their own between
        base and platform.
        """
        axes, none = np.eye(3), np.zeros(3)
        if set(self.given) & set(POSITION):
            slides = tuple(
                (axes[k], self.coordinate(n, False, False), 1.0) for k, n in enumerate(POSITION)
            )
            self.joints.append(Joint((-1, link), (none, position), (), slides, (True, False)))
        if set(self.given) & set(ANGLES):  # R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth)
            azimuth, tilt, torsion = (self.coordinate(n, True, False) for n in ANGLES)
            z, y = axes[2], axes[1]
            turns = ((z, azimuth, 1.0), (y, tilt, 1.0), (z, torsion, 1.0), (z, azimuth, -1.0))
            self.joints.append(Joint((-1, link), (none, none), turns, (), (False, True), home))

    def couplings(self) -> list[Coupling]:
        places, found = {c.name: k for k, c in enumerate(self.coordinates)}, []
        for entry in self.data.get("coupling", []):
            of, offset = entry["of"], self.number(entry.get("offset", 0.0))
            if isinstance(of, str):
                constant, *higher = [self.number(c) for c in entry["polynomial"]]
                offset += constant
                terms: tuple[tuple[int, tuple[float, ...]], ...] = ((places[of], tuple(higher)),)
            else:
                terms = tuple((places[n], (self.number(f),)) for n, f in of.items())
            found.append(Coupling(places[entry["joint"]], terms, offset))
        return found

    def graph(self) -> GraphFile:
        platform = self.data.get("platform", {})
        position, home = (
            self.vector(platform.get("position", [0, 0, 0])),
            self.vector(platform.get("quaternion", [1, 0, 0, 0])),
        )
        home = home / np.linalg.norm(home)
        for entry in self.data.get("joint", []):
            self.joint(entry, entry["links"])
        for entry in self.data.get("limb", []):
            self.limb(entry, position, home)
        for entry in self.data.get("rod", []):
            self.rod(entry, entry["links"], self.vector(entry["from"]), self.vector(entry["to"]))
        for entry in self.data.get("link", []):
            self.points += [
                (self.place(entry["name"]), self.vector(p))
                for p in entry.get("points", {}).values()
            ]
        everywhere = np.array([p for points in self.links.values() for p in points])
        size = float(np.max(np.linalg.norm(everywhere[:, None] - everywhere[None], axis=2)))
        names = [n for n in self.links if n != "base"]
        link = platform.get("link", "platform" if "platform" in names else None)
        if link is not None:
            self.pose(names.index(link), position, home)
            self.points += [
                (names.index(link), position + size * v) for v in (np.zeros(3), *np.eye(3))
            ]
        centres = [np.mean(self.links[n], axis=0) if self.links[n] else np.zeros(3) for n in names]
        unscaled = GraphFile(
            names,
            size,
            np.array(centres),
            self.coordinates,
            self.joints,
            self.rods,
            self.couplings(),
            self.points,
        )
        return _scaled(unscaled, -1 if link is None else names.index(link))


def _rotated(q: Array, v: Array) -> Array:
    u = 2 * np.cross(q[1:], v)
    return np.asarray(v + q[0] * u + np.cross(q[1:], u))


def _scaled(g: GraphFile, platform: int) -> GraphFile:
    """The same graph with lengths over the size."""
    s = 1 / g.size
    long = [not c.angle for c in g.coordinates]
    coordinates = [
        c if c.angle else Coordinate(c.name, False, c.zero * s, s, c.actuated)
        for c in g.coordinates
    ]
    joints = [
        Joint(
            j.links,
            (j.ends[0] * s, j.ends[1] * s),
            j.turns,
            tuple((a, k, f if long[k] else f * s) for a, k, f in j.slides),
            j.holds,
            j.home,
        )
        for j in g.joints
    ]
    rods = [
        Rod(r.links, (r.ends[0] * s, r.ends[1] * s), r.length * s, r.coordinate) for r in g.rods
    ]
    return GraphFile(
        g.names,
        g.size,
        g.centres * s,
        coordinates,
        joints,
        rods,
        g.couplings,
        [(i, p * s) for i, p in g.points],
        platform,
        _idle_angles(g, platform),
    )


def _idle_angles(g: GraphFile, platform: int) -> frozenset[int]:
    """Angles within a strut: links that only two spherical ends hold, joined along the line between
    these ends alone.
    """
    coupled = {k for c in g.couplings for k in (c.joint, *(place for place, _ in c.terms))}
    idle: set[int] = set()
    for group in _rigidly_oriented(g) - {next(s for s in _rigidly_oriented(g) if -1 in s)}:
        ends = [j.ends[0] for j in g.joints if not j.holds[1] and len(group & set(j.links)) == 1]
        ends += [r.ends[k] for r in g.rods for k in (0, 1) if r.links[k] in group]
        inner = [j for j in g.joints if j.holds[1] and set(j.links) <= group]
        if (
            platform not in group
            and len(ends) == 2
            and all(_along(j, ends[0], ends[1]) for j in inner)
        ):
            idle |= {
                k
                for j in inner
                for _, k, _ in j.turns
                if not g.coordinates[k].actuated and k not in coupled
            }
    return frozenset(idle)


def _rigidly_oriented(g: GraphFile) -> set[frozenset[int]]:
    """Sets of links connected by joints other than spherical ones; the base is -1."""
    groups = {frozenset([i]) for i in range(-1, len(g.names))}
    for joint in (j for j in g.joints if j.holds[1]):
        met = {s for s in groups if s & set(joint.links)}
        groups = groups - met | {frozenset().union(*met)}
    return groups


def _along(joint: Joint, a: Array, b: Array) -> bool:
    """Whether a joint turns about the line through two points, freely of any slide, or slides along
    it.
    """
    screw = {k for _, k, _ in joint.turns} & {k for _, k, _ in joint.slides}
    arms = [axis for axis, _, _ in (*joint.turns, *joint.slides)] + (
        [joint.ends[0] - a] if joint.turns else []
    )
    return not screw and all(
        np.linalg.norm(np.cross(v, b - a)) < 1e-9 * np.linalg.norm(b - a) ** 2 for v in arms
    )
