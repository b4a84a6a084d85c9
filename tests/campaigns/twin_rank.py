"""How many parameters exact poses identify, by differences of an independent closure.

At each posture the readings of the joints stand, and dF/dx dx + dF/dp dp = 0 gives the pose's
change with a parameter: dF/dx from the independent closure, dF/dp by central differences of the
numbers in the file.
"""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from campaigns.twin_oracle import Limbs, Links, graphs, numbers_only, oracle_of, rotation

STEP = 1e-5
"""Step of the differences, of the size for lengths and in rad for angles and directions."""
WITHOUT, RANK_GAP = 1e-8, 1e-9
"""A column below this share of the longest one is rounding of the differences; a singular value
below the second share of the largest, columns of unit length, is none."""
OPEN = 1e-6
"""Rows that no motion closes after a change, of the change: the loops are redundant."""
PLACES = {"w": 0, "x": 1, "y": 2, "z": 3}


def rank_of(text: str, postures: Mapping[str, Any], names: Sequence[str]) -> int | None:
    """The identified rank of some parameters; None where a name has no number of its own in the
    file, or a change of it opens redundant loops for good."""
    data = explicit(numbers_only(tomllib.loads(text)))
    here = oracle_of(data)
    x = _configurations(here, postures)
    slopes = [_slopes(here, configuration) for configuration in x]
    columns = []
    for name in names:
        if reach(data, name) is None:
            return None
        column = _change(data, here, x, slopes, name)
        if column is None:
            return None
        columns.append(column)
    matrix = np.array(columns).T
    norms = np.linalg.norm(matrix, axis=0)
    moving = matrix[:, norms > WITHOUT * max(norms.max(initial=0.0), 1e-300)]
    if not moving.size:
        return 0
    s = np.linalg.svd(moving / np.linalg.norm(moving, axis=0), compute_uv=False)
    return int(np.sum(s > RANK_GAP * s[0]))


def explicit(data: dict[str, Any]) -> dict[str, Any]:
    """The file with what it leaves to the reference written out: lengths of rods, zeros,
    offsets.
    """
    data = copy.deepcopy(data)
    oracle = oracle_of(data)
    if isinstance(oracle, Limbs):
        chains = {c.name: c for c in oracle.m.chains}
        for limb in data.get("limb", []):
            for rod, (_, _, length) in zip(
                limb.get("rod", []), chains[limb["name"]].rods, strict=False
            ):
                rod.setdefault("length", length)
    else:
        plain = [r for r in oracle.g.rods if r.coordinate < 0]
        rods = [r for limb in data.get("limb", []) for r in limb.get("rod", [])]
        rods += [r for r in data.get("rod", []) if not r.get("actuated", False)]
        for rod, known in zip(rods, plain, strict=False):
            rod.setdefault("length", known.length * oracle.g.size)
    for limb in data.get("limb", []):
        if "joint" not in limb:
            limb.setdefault("offset", 0.0)
    for rod in data.get("rod", []):
        if rod.get("actuated", False):
            rod.setdefault("offset", 0.0)
    for joint in [
        *data.get("joint", []),
        *(j for limb in data.get("limb", []) for j in limb.get("joint", [])),
    ]:
        if joint["type"] in "RPH":
            joint.setdefault("zero", 0.0)
    for key in ("platform", "tool"):
        if key in data:
            data[key].setdefault("position", [0.0, 0.0, 0.0])
            data[key].setdefault("quaternion", [1.0, 0.0, 0.0, 0.0])
    for row in data.get("dh", {}).get("rows", []):
        for key in ("theta", "d", "a", "alpha"):
            row.setdefault(key, 0.0)
    return data


def reach(data: Mapping[str, Any], name: str) -> tuple[Any, Any] | None:
    """The table or list that holds a parameter's number, and its key there."""
    head, *rest = name.split(".")
    if head == "dh" and len(rest) == 2:
        return data["dh"]["rows"][int(rest[0]) - 1], rest[1]
    table = data.get(head) if head in ("platform", "tool") else None
    if table is None:
        everything = [*data.get("joint", []), *data.get("rod", []), *data.get("limb", [])]
        table = next((t for t in everything if t["name"] == head), None)
    if isinstance(table, Mapping) and ("joint" in table or "rod" in table) and rest:
        inner = [*table.get("joint", []), *table.get("rod", [])]
        numbered = {f"rod{k}": r for k, r in enumerate(table.get("rod", []), start=1)}
        table = numbered.get(rest[0]) or next((t for t in inner if t.get("name") == rest[0]), None)
        rest = rest[1:]
    if table is None or not rest or rest[0] not in table:
        return None
    if len(rest) == 1:
        return table, rest[0]
    values = table[rest[0]]
    return values, PLACES[rest[1]] - (len(values) == 3)


def _moved(data: dict[str, Any], name: str, step: float) -> Any:
    moved = copy.deepcopy(data)
    place = reach(moved, name)
    assert place is not None
    place[0][place[1]] = float(place[0][place[1]]) + step
    return oracle_of(moved)


def _configurations(oracle: Any, postures: Mapping[str, Any]) -> np.ndarray:
    """The closed configurations of the readings."""
    found = []
    for joints, pose in zip(postures["joints"], postures["poses"], strict=True):
        named = dict(zip(oracle.actuated, joints, strict=True))
        found.append(oracle.fitted({"joints": named, "pose": pose, "points": {}})[1])
    return np.array(found)


def _slopes(here: Any, configuration: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """dF/dx of what the readings leave free, its pseudo-inverse, and the pose's slopes by it."""
    x = configuration[None]
    if isinstance(here, Limbs):
        m = here.m
        columns = m.tangent([i for i in range(len(m.numbers)) if i not in m.places("actuated")])
        moved, turned = m._pose_derivatives(m.pose(x)[1])
        pose = np.concatenate([moved[0] / m.size, turned[0]])
    else:
        g, first, i = here.g, 6 * len(here.g.names), here.g.platform
        held = [first + k for k, c in enumerate(g.coordinates) if c.actuated]
        columns = np.setdiff1d(np.arange(g.freedom), held)
        turned = np.zeros((3, g.freedom))
        turned[:, 6 * i + 3 : 6 * i + 6] = np.eye(3)
        pose = np.concatenate([g.point_derivative(x, i, here.origin)[0], turned])
    j = _model(here).closure(x)[1][0][:, columns]
    return j, np.linalg.pinv(j, rcond=1e-9), pose[:, columns]


def _change(
    data: dict[str, Any], here: Any, x: np.ndarray, slopes: Sequence[Any], name: str
) -> np.ndarray | None:
    """How the poses change with a parameter (positions over the size, rotation vectors)."""
    step = STEP * _unit(data, here, name)
    moved = [_moved(data, name, s) for s in (step, -step)]
    up, down = ((m, _kept(m, here, x)) for m in moved)
    rows = (_model(up[0]).closure(up[1])[0] - _model(down[0]).closure(down[1])[0]) / (2 * STEP)
    parts = []
    for k, (by_p, (j, inverse, pose)) in enumerate(zip(rows, slopes, strict=True)):
        dx = -inverse @ by_p
        if np.max(np.abs(j @ dx + by_p)) > OPEN * max(1.0, float(np.max(np.abs(by_p)))):
            return None
        still = _twist(up[0].pose(up[1][k]), down[0].pose(down[1][k]), here.size) / (2 * STEP)
        parts.append(pose @ dx + still)
    return np.concatenate(parts)


def _twist(a: Sequence[float], b: Sequence[float], size: float) -> np.ndarray:
    """The small displacement from pose b to pose a: lengths over the size, a rotation vector."""
    turned = rotation(a[3:]) @ rotation(b[3:]).T
    vector = 0.5 * np.array(
        [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
    )
    return np.concatenate([np.subtract(a[:3], b[:3]) / size, vector])


def _unit(data: Mapping[str, Any], here: Any, name: str) -> float:
    last = name.split(".")
    angle = 1.0 if data["angle_unit"] == "rad" else 180.0 / np.pi
    if last[-1] in ("theta", "alpha"):
        return float(angle)
    if last[-1] == "zero":
        place = reach(data, name)
        turning = place is not None and place[0].get("type") in ("R", "H")
        return float(angle) if turning else float(here.size)
    return 1.0 if {"axis", "axis2", "quaternion"} & set(last) else float(here.size)


def _model(oracle: Limbs | Links) -> Any:
    return oracle.m if isinstance(oracle, Limbs) else oracle.g


def _kept(moved: Any, here: Any, x: np.ndarray) -> np.ndarray:
    """Configurations of this machine as those of a moved one: its links stand where they stand."""
    if isinstance(here, Limbs):
        return x
    # lengths of a graph are over its own size, positions those of its own centres
    g, other = here.g, moved.g
    y, ratio, count = x.copy(), g.size / other.size, len(g.names)
    for i in range(count):
        away = graphs.rotate(g.link(x, i)[1], other.centres[i] / ratio - g.centres[i])
        y[:, 7 * i : 7 * i + 3] = (x[:, 7 * i : 7 * i + 3] + away) * ratio
    for k, c in enumerate(g.coordinates):
        if not c.angle:
            y[:, 7 * count + k] *= ratio
    return np.asarray(y)
