"""The third method of twins: one interface to the independent closures, none of which is symkin's.

A machine of limbs, or an arm, is closed by products of exponentials (`plain_closure`), a graph of
links in maximal coordinates (`plain_graph`). This module alone imports them, and the random
machines that are made by them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from campaigns.random_files import random_file, to_toml
from campaigns.random_graphs import FAMILIES, SMALL, Drawing, chosen_values
from helpers.random_graphs import random_graph
from oracle import plain_graph as graphs
from oracle import plain_search as search
from oracle.plain_closure import PlainMechanism, matrix_quaternion, quaternion_matrix
from oracle.plain_graph_file import Reader, number

ROOT = Path(__file__).resolve().parents[2]

__all__ = [
    "FAMILIES",
    "ROOT",
    "SMALL",
    "Drawing",
    "Oracle",
    "chosen_values",
    "joint_kinds",
    "numbers_only",
    "oracle_of",
    "random_file",
    "random_graph",
    "rotation",
    "to_toml",
]

CLOSED = 1e-7
"""Largest closure error of a mode that closes, over the size."""
SAME = 1e-5
"""Largest difference of features of one configuration, found twice."""
REGULAR = 1e-5
"""A configuration whose least singular value is above this share of the largest is regular."""
FREE = 1e-8
"""A singular value below this share of the largest is none."""
FITS = 24
"""Random starts for coordinates that a mode does not list."""
Given = Mapping[str, Any]
"""A problem's given values: `joints` (file order), `pose` (x, y, z, quaternion) or `given` by
name."""
_NUMERIC = {
    *("point", "axis", "axis2", "pitch", "zero", "limits", "base", "platform", "from", "to"),
    *("offset", "length", "position", "quaternion", "polynomial", "theta", "d", "a", "alpha"),
    *("joints", "pose", "start", "given", "points", "of"),
}
"""Keys of a mechanism file whose strings are arithmetic."""


def numbers_only(data: Any, key: str = "") -> Any:
    """A parsed mechanism file with its arithmetic worked out."""
    radians = math.pi / 180 if data.get("angle_unit") == "deg" else 1.0

    def worked(value: Any, key: str) -> Any:
        if isinstance(value, dict):
            inner = {"points", "given", "of"}
            return {k: worked(v, key if key in inner else k) for k, v in value.items()}
        if isinstance(value, list):
            return [worked(v, key) for v in value]
        if isinstance(value, str) and key in _NUMERIC and not (key == "of" or value.isidentifier()):
            return number(value, radians)
        return value

    return worked(data, key)


def joint_kinds(data: Mapping[str, Any]) -> dict[str, str]:
    """What each joint coordinate of a file is: angle, length, turns (of a screw) or quaternion."""
    found: dict[str, str] = {}
    for limb in data.get("limb", []):
        if "joint" not in limb:
            found[limb["name"]] = "length"
    found |= {r["name"]: "length" for r in data.get("rod", []) if r.get("actuated", False)}
    for k, row in enumerate(data.get("dh", {}).get("rows", []), start=1):
        found[row.get("name", f"q{k}")] = "angle" if row["type"] == "R" else "length"
    joints = [j for limb in data.get("limb", []) for j in limb.get("joint", [])]
    for joint in [*joints, *data.get("joint", [])]:
        name = joint["name"]
        found |= {
            "R": {name: "angle"},
            "P": {name: "length"},
            "H": {name: "turns"},
            "S": {name: "quaternion"},
            "C": {f"{name}.angle": "angle", f"{name}.slide": "length"},
            "U": {f"{name}.1": "angle", f"{name}.2": "angle"},
            "weld": {},
        }[joint["type"]]
    return found


def rotation(quaternion: Sequence[float]) -> np.ndarray:
    """The rotation matrix (3, 3) of a unit quaternion."""
    return np.asarray(quaternion_matrix(np.array([quaternion], dtype=float))[0])


class Oracle(Protocol):
    """A machine by a closure of its own; configurations are rows of numbers of that closure."""

    size: float
    idle: frozenset[str]
    actuated: list[str]
    has_platform: bool

    def closed(self, count: int, spread: float, rng: np.random.Generator) -> np.ndarray:
        """Closed configurations near the reference, at most `count`."""

    def joints(self, x: np.ndarray) -> dict[str, float]:
        """Scalar joint coordinates of one configuration, in the file's units."""

    def pose(self, x: np.ndarray) -> list[float]:
        """x, y, z and quaternion of the platform at one configuration."""

    def fitted(
        self, mode: Mapping[str, Any], near: np.ndarray | None = None
    ) -> tuple[float, np.ndarray]:
        """The closure error of a printed mode, over the size, with what it does not print fitted,
        from a configuration `near` it first, and the configuration."""

    def others(self, given: Given, starts: int) -> Iterator[np.ndarray]:
        """Regular configurations at given values, from random starts."""

    def features(self, x: np.ndarray) -> np.ndarray:
        """Numbers in which one configuration, written twice, is the same."""

    def motions(self, x: np.ndarray, held: Sequence[str]) -> tuple[np.ndarray, np.ndarray, float]:
        """Motions while coordinates stand: of joints that are not idle (rows), of the platform
        (rows), and the least singular value that counts, over the largest."""

    def rates(self, x: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """Rates of the joints (radians, length unit) and the twists (6, n) of all motions."""

    def mobility(self) -> int | None:
        """The most frequent mobility at closed configurations, None where none closes."""


def oracle_of(data: Mapping[str, Any], given: Sequence[str] = ()) -> Oracle:
    """The independent closure of a parsed file (of numbers only)."""
    tables = [*data.get("joint", []), *data.get("limb", [])]
    is_graph = "rod" in data or "coupling" in data or any("links" in t for t in tables)
    return Links(data, given) if is_graph else Limbs(data)


def _split(j: np.ndarray) -> tuple[np.ndarray, float]:
    """The null space (rows) of a matrix and its least singular value that counts, over the
    largest."""
    _, s, right = np.linalg.svd(j, full_matrices=True)
    rank = int(np.sum(s > FREE * s[0])) if len(s) else 0
    return right[rank:], float(s[rank - 1] / s[0]) if rank else 1.0


def _best(
    batches: Iterable[np.ndarray], errors: Callable[[np.ndarray], np.ndarray]
) -> tuple[float, np.ndarray]:
    """The least error and its configuration, of the first batch that has one which closes."""
    least, best = np.inf, np.zeros(0)
    for x in batches:
        left = errors(x)
        k = int(np.argmin(left)) if len(left) else -1
        if k >= 0 and left[k] < least:
            least, best = float(left[k]), x[k]
        if least < CLOSED:
            break
    return least, np.asarray(best)


class Limbs:
    """A platform on limbs, or an arm."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.m = PlainMechanism(dict(data))
        self.size, self.idle = self.m.size, frozenset(self.m.idle)
        self.actuated = [self.m.names[i] for i in self.m.places("actuated")]
        self.has_platform = True

    def closed(self, count: int, spread: float, rng: np.random.Generator) -> np.ndarray:
        return np.asarray(search.closed_configurations(self.m, count, spread, rng))

    def joints(self, x: np.ndarray) -> dict[str, float]:
        m = self.m
        return {
            n.name: float(x[m.slices[i]][0]) / self._unit(i)
            for i, n in enumerate(m.numbers)
            if n.role != "pose" and n.kind != "quaternion"
        }

    def _unit(self, i: int) -> float:
        return self.m.unit if self.m.numbers[i].kind in ("angle", "turns") else 1.0

    def pose(self, x: np.ndarray) -> list[float]:
        position, turned = self.m.pose(x[None])
        return [*position[0].tolist(), *matrix_quaternion(turned[0]).tolist()]

    def fitted(
        self, mode: Mapping[str, Any], near: np.ndarray | None = None
    ) -> tuple[float, np.ndarray]:
        m, x, cut = self.m, self.m.reference if near is None else near, []
        pose = np.array(mode["pose"])
        x = m.with_pose(x[None], pose[:3], pose[3:])[0]
        for i, n in enumerate(m.numbers):
            if n.role != "pose" and n.name in mode["joints"]:
                x[m.slices[i]] = np.ravel(mode["joints"][n.name]) * self._unit(i)
            elif n.role != "pose":
                cut.append(i)
        away = np.abs(np.array(self.pose(x))[:3] - pose[:3]).max() / m.size
        starts, some = [x[None]], np.tile(x, (FITS, 1))
        if cut:
            starts.append(search.random_configurations(m, some, cut, np.random.default_rng(0)))
        left, best = _best(
            (search.solve(m, begin, m.tangent(cut), 100) for begin in starts), m.residual
        )
        return max(left, float(away)), best

    def others(self, given: Given, starts: int) -> Iterator[np.ndarray]:
        m, x = self.m, self.m.reference.copy()
        if "pose" in given:
            pose = np.array(given["pose"], dtype=float)
            x, known = m.with_pose(x[None], pose[:3], pose[3:])[0], set(m.places("pose"))
        else:
            known = {m.names.index(name) for name in self.actuated}
            for name, value in zip(self.actuated, given["joints"], strict=True):
                i = m.names.index(name)
                x[m.slices[i]] = value * self._unit(i)
        free = [i for i in range(len(m.numbers)) if i not in known]
        for found in search.solutions(m, x, free, starts, np.random.default_rng(0)):
            if found.regular:
                yield found.x

    def features(self, x: np.ndarray) -> np.ndarray:
        return np.asarray(search.features(self.m, x[None], search.named_places(self.m))[0])

    def _columns(self, names: Sequence[str]) -> list[int]:
        m = self.m
        places = [m.names.index(n) for n in names if n in m.names]
        if "pose" in names:
            places += m.places("pose")
        return [int(c) for c in m.tangent(sorted(places))] if places else []

    def motions(self, x: np.ndarray, held: Sequence[str]) -> tuple[np.ndarray, np.ndarray, float]:
        m = self.m
        free = np.setdiff1d(np.arange(m.freedom), self._columns(held))
        null, least = _split(m.closure(x[None])[1][0][:, free])
        whole = np.zeros((len(null), m.freedom))
        whole[:, free] = null
        named = [i for i in search.named_places(m) if m.numbers[i].role != "pose"]
        pose = m.places("pose")
        return (
            whole[:, m.tangent(named)],
            whole[:, m.tangent(pose)] if pose else whole[:, :0],
            least,
        )

    def rates(self, x: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
        m = self.m
        null, _ = _split(m.closure(x[None])[1][0])
        moved, turned = m._pose_derivatives(m.pose(x[None])[1])
        found = {}
        for i, n in enumerate(m.numbers):
            if n.kind != "quaternion" and n.role != "pose":
                scale = 1.0 if n.kind == "length" else 1.0 / m.size
                found[n.name] = scale * null[:, m.columns[i].start]
        return found, np.concatenate([moved[0] @ null.T, turned[0] @ null.T])

    def mobility(self) -> int | None:
        near = self.closed(12, 0.1, np.random.default_rng(0))
        return _most_frequent([search.freedom_at(self.m, x) for x in near])


class Links:
    """A graph of links; the platform's pose is a coordinate where its names are given."""

    def __init__(self, data: Mapping[str, Any], given: Sequence[str] = ()) -> None:
        self.data, self.g = data, graphs.Graph(**vars(Reader(data, given).graph()))
        g, frame = self.g, data.get("platform", {})
        self.size, self.has_platform = g.size, g.platform >= 0
        self.idle = frozenset(g.coordinates[k].name for k in g.idle)
        self.actuated = [c.name for c in g.coordinates if c.actuated]
        self.origin = np.array(frame.get("position", (0.0, 0.0, 0.0)), dtype=float) / g.size
        home = np.array(frame.get("quaternion", (1.0, 0.0, 0.0, 0.0)), dtype=float)
        self.home = home / np.linalg.norm(home)

    def closed(self, count: int, spread: float, rng: np.random.Generator) -> np.ndarray:
        return np.asarray(graphs.generic(self.g, count, spread, int(rng.integers(1 << 30))))

    def joints(self, x: np.ndarray) -> dict[str, float]:
        values = self.g.values(x[None])[0]
        return {c.name: float(v / c.unit) for c, v in zip(self.g.coordinates, values, strict=True)}

    def pose(self, x: np.ndarray) -> list[float]:
        g = self.g
        here = g.point(x[None], g.platform, self.origin)[0] * g.size
        turned = graphs.product(g.link(x[None], g.platform)[1], self.home[None])[0]
        return [*here.tolist(), *(turned if turned[0] >= 0 else -turned).tolist()]

    def _with_pose(self, x: np.ndarray, pose: Sequence[float]) -> np.ndarray:
        """Configurations with the platform's link at a pose."""
        g, x, i = self.g, x.copy(), self.g.platform
        back = self.home * np.array([1.0, -1.0, -1.0, -1.0])
        q = graphs.product(np.array([pose[3:]], dtype=float), back[None])
        q = q / np.linalg.norm(q)
        centre = np.array(pose[:3]) / g.size + graphs.rotate(q, g.centres[i] - self.origin)[0]
        x[:, 7 * i : 7 * i + 3], x[:, 7 * i + 3 : 7 * i + 7] = centre, q
        return x

    def fitted(
        self, mode: Mapping[str, Any], near: np.ndarray | None = None
    ) -> tuple[float, np.ndarray]:
        g, first = self.g, 6 * len(self.g.names)
        listed = {k: c for k, c in enumerate(g.coordinates) if c.name in mode["joints"]}
        fixed = {k: float(mode["joints"][c.name]) * c.unit for k, c in listed.items()}
        free = np.setdiff1d(np.arange(g.freedom), [first + k for k in fixed if k not in g.idle])
        starts = [graphs.random_starts(g, FITS, fixed, np.random.default_rng(0))]
        if near is not None:
            starts.insert(0, near[None].copy())
            for k, value in fixed.items():
                starts[0][:, 7 * len(g.names) + k] = value
        if mode["pose"] is not None:
            starts = [self._with_pose(begin, mode["pose"]) for begin in starts]
            i = g.platform
            free = np.setdiff1d(free, np.arange(6 * i, 6 * i + 6))
        return _best(
            (graphs.solve(g, begin, free) for begin in starts),
            lambda x: np.max(np.abs(g.closure(x)[0]), axis=1, initial=0.0),
        )

    def others(self, given: Given, starts: int) -> Iterator[np.ndarray]:
        g = self.g
        named = dict(given.get("given", {}))
        if "joints" in given:
            named = dict(zip(self.actuated, given["joints"], strict=True))
        if "pose" not in given and "pose" not in named:
            oracle = Links(self.data, list(named))
            found = graphs.configurations(oracle.g, named, starts)
            regular = found.isolated & (found.clearance > REGULAR)
            yield from (x[: self.g.reference().size] for x in found.x[regular])
            return
        i, first = g.platform, 6 * len(g.names)
        fixed = {
            g.place(n): v * g.coordinates[g.place(n)].unit for n, v in named.items() if n != "pose"
        }
        held = [*range(6 * i, 6 * i + 6), *(first + k for k in fixed)]
        columns = np.setdiff1d(np.arange(g.freedom), held)
        pose = given.get("pose", named.get("pose"))
        begin = graphs.random_starts(g, starts, fixed, np.random.default_rng(0))
        x = graphs.solve(g, self._with_pose(begin, pose), columns)
        for end in _distinct(g, x[graphs.closed(g, x)]):
            _, moving, least = graphs.freedom(g, end, columns)
            if not moving and least > REGULAR:
                yield end

    def features(self, x: np.ndarray) -> np.ndarray:
        return np.asarray(self.g.observed(x[None])[0][0])

    def motions(self, x: np.ndarray, held: Sequence[str]) -> tuple[np.ndarray, np.ndarray, float]:
        g, first = self.g, 6 * len(self.g.names)
        stand = [first + k for k, c in enumerate(g.coordinates) if c.name in held]
        if "pose" in held:
            stand += range(6 * g.platform, 6 * g.platform + 6)
        free = np.setdiff1d(np.arange(g.freedom), stand)
        null, least = _split(g.closure(x[None])[1][0][:, free])
        whole = np.zeros((len(null), g.freedom))
        whole[:, free] = null
        named = [first + k for k in range(len(g.coordinates)) if k not in g.idle]
        i = g.platform
        return whole[:, named], whole[:, 6 * i : 6 * i + 6] if i >= 0 else whole[:, :0], least

    def rates(self, x: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
        g, first, i = self.g, 6 * len(self.g.names), self.g.platform
        null, _ = _split(g.closure(x[None])[1][0])
        found = {}
        for k, c in enumerate(g.coordinates):
            found[c.name] = null[:, first + k] * (1.0 if c.angle else g.size)
        if i < 0:
            return found, np.zeros((6, len(null)))
        moved = g.point_derivative(x[None], i, self.origin)[0] @ null.T * g.size
        return found, np.concatenate([moved, null[:, 6 * i + 3 : 6 * i + 6].T])

    def mobility(self) -> int | None:
        near = self.closed(12, 0.1, np.random.default_rng(0))
        return _most_frequent([graphs.freedom(self.g, x)[1] for x in near])


def _distinct(g: graphs.Graph, x: np.ndarray) -> Iterator[np.ndarray]:
    kept: list[np.ndarray] = []
    for end, f in zip(x, g.observed(x)[0], strict=True):
        if all(np.max(np.abs(f - other)) > SAME for other in kept):
            kept.append(f)
            yield end


def _most_frequent(values: Sequence[int | None]) -> int | None:
    known = [v for v in values if v is not None]
    return max(set(known), key=lambda v: (known.count(v), v)) if known else None
