"""Random mechanism files: limbs of R, P, H, C, U and S joints, rods, serial arms, special
directions, all motions.

Axes are drawn from small sets in most families, so that parallel, meeting and coincident axes,
which random numbers never give, are common; actuated joints are chosen, in most files, so that they
determine the platform at a generic configuration.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from oracle.plain_closure import PlainMechanism
from oracle.plain_search import closed_configurations, named_places

Z = (0.0, 0.0, 1.0)
FREEDOM = {"R": 1, "P": 1, "H": 1, "C": 2, "U": 2, "S": 3}
MOTIONS = ("spatial", "schoenflies", "planar", "translation", "spherical")
DETERMINED = 0.85
"""Share of files whose actuated joints are chosen to determine the platform."""
MOST_PASSIVE, MOST_PASSIVE_SHARES = (2, 3, 4, 6), (0.4, 0.35, 0.17, 0.08)
"""Most passive freedoms that all limbs together have beside one joint of each limb, so that a file
is quick, and how often.
"""


@dataclass
class Draw:
    """Random choices of one file: where points and axes come from."""

    rng: np.random.Generator
    point: Callable[[], list[float]]
    axis: Callable[[], list[float]]
    types: str = "RRRPPHCUS"
    count: int = 0

    def name(self, letter: str) -> str:
        self.count += 1
        return f"{letter.lower()}{self.count}"

    def joint(self, kind: str | None = None) -> dict[str, Any]:
        rng, kind = self.rng, kind or str(self.rng.choice(list(self.types)))
        joint: dict[str, Any] = {"name": self.name(kind), "type": kind, "point": self.point()}
        if kind != "S":
            joint["axis"] = self.axis()
        if kind == "U":
            joint["axis2"] = self.axis()
            while np.linalg.norm(np.cross(joint["axis"], joint["axis2"])) < 0.3:
                joint["axis2"] = [float(v) for v in rng.normal(size=3)]
        if kind == "H":
            joint["pitch"] = float(round(rng.uniform(0.5, 3) * rng.choice([-1, 1]), 2))
        if kind in "RP" and rng.uniform() < 0.2:
            joint["zero"] = float(round(rng.uniform(-60, 60), 1))
        return joint


def random_file(rng: np.random.Generator) -> dict[str, Any]:
    """The tables of one random mechanism file."""
    family = FAMILIES[int(rng.choice(len(FAMILIES), p=SHARES))]
    while True:
        data = family(rng)
        if data is not None:
            return data


def head(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "format": 1,
        "name": "m",
        "length_unit": str(rng.choice(["mm", "m"])),
        "angle_unit": str(rng.choice(["deg", "rad"])),
    }


# --- points and axes ------------------------------------------------------------------------------


def grid_point(rng: np.random.Generator) -> Callable[[], list[float]]:
    return lambda: [float(v) for v in 50 * rng.integers(-2, 3, 3)]


def free_point(rng: np.random.Generator) -> Callable[[], list[float]]:
    return lambda: [float(v) for v in np.round(100 * rng.normal(size=3), 3)]


def free_axis(rng: np.random.Generator) -> Callable[[], list[float]]:
    return lambda: [float(v) for v in rng.normal(size=3)]


def special_axis(rng: np.random.Generator) -> Callable[[], list[float]]:
    """Mostly along the base frame's axes."""
    some = [*np.eye(3), *np.eye(3), *np.eye(3), [1, 1, 0], [0, 1, -1], [1, 1, 1]]
    return lambda: [float(v) for v in some[int(rng.integers(len(some)))]]


def draw(rng: np.random.Generator, types: str) -> Draw:
    """Points and axes that are all free, all special, or mixed."""
    kind = rng.integers(3)
    point = grid_point(rng) if kind > 0 else free_point(rng)
    axis = special_axis(rng) if kind > 1 or rng.uniform() < 0.3 else free_axis(rng)
    return Draw(rng, point, axis, types)


# --- families -------------------------------------------------------------------------------------


def spatial(rng: np.random.Generator) -> dict[str, Any] | None:
    """Limbs of any joints, of rods, or of joints that end in rods."""
    d = draw(rng, "RRRPPHCUSUS")
    limbs = []
    for k in range(int(rng.choice([1, 2, 3, 4], p=[0.15, 0.4, 0.35, 0.1]))):
        form = rng.choice(["joints", "rods", "leg"], p=[0.75, 0.12, 0.13])
        if form == "leg":
            limbs.append(leg(d))
        else:
            joints = [
                d.joint() for _ in range(int(rng.choice([2, 3, 4, 5], p=[0.3, 0.4, 0.2, 0.1])))
            ]
            limb: dict[str, Any] = {"name": f"limb{k}", "joint": joints}
            if form == "rods":
                limb["joint"] = [
                    d.joint("RP"[rng.integers(2)]) for _ in range(int(rng.integers(1, 3)))
                ]
                limb["rod"] = [
                    {"from": d.point(), "platform": d.point()}
                    for _ in range(int(rng.integers(1, 4)))
                ]
            limbs.append(limb)
    return assembled(rng, limbs, d, str(rng.choice(MOTIONS, p=[0.6, 0.1, 0.1, 0.1, 0.1])))


def equal_limbs(rng: np.random.Generator) -> dict[str, Any] | None:
    """Two or three equal limbs turned about z, with an optional other one: the way in which
    machines are made.
    """
    d = draw(rng, "RRPPCUSUS")
    d.axis = special_axis(rng)
    limb = [d.joint() for _ in range(int(rng.choice([2, 3, 4], p=[0.2, 0.6, 0.2])))]
    limbs = []
    count = int(rng.integers(2, 4))
    for k in range(count):
        turn = 2 * np.pi * k / count
        r = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        joints = []
        for joint in limb:
            turned = {**joint, "name": f"{joint['name']}_{k}"}
            turned |= {
                key: [float(v) for v in r @ joint[key]]
                for key in ("point", "axis", "axis2")
                if key in joint
            }
            joints.append(turned)
        limbs.append({"name": f"limb{k}", "joint": joints})
    if rng.uniform() < 0.4:
        limbs.append(
            {"name": "other", "joint": [d.joint() for _ in range(int(rng.integers(1, 4)))]}
        )
    return assembled(rng, limbs, d, str(rng.choice(MOTIONS, p=[0.6, 0.1, 0.1, 0.1, 0.1])))


def us_limbs(rng: np.random.Generator) -> dict[str, Any] | None:
    """Limbs U-S, a joint between, beside a limb of few freedoms that keeps a passive joint."""
    d = draw(rng, "RP")
    limbs = []
    for k in range(int(rng.integers(1, 4))):
        between = [d.joint(str(rng.choice(["R", "P"])))] if rng.uniform() < 0.8 else []
        limbs.append({"name": f"limb{k}", "joint": [d.joint("U"), *between, d.joint("S")]})
    other = rng.choice(["UP", "PU", "RP", "PR", "RPR", "C", "PP", "UR", "SP", "RRP"])
    limbs.append({"name": "centre", "joint": [d.joint(kind) for kind in str(other)]})
    return assembled(
        rng, limbs, d, str(rng.choice(["spatial", "spatial", "spherical", "schoenflies"]))
    )


def planar(rng: np.random.Generator) -> dict[str, Any] | None:
    """All turns about z, all slides in the plane."""
    flat = lambda: [float(v) for v in rng.normal(size=2)] + [0.0]  # noqa: E731
    points = grid_point(rng) if rng.uniform() < 0.4 else free_point(rng)
    d = Draw(rng, lambda: [*points()[:2], 0.0], flat, "RRRP")
    limbs = []
    for k in range(int(rng.choice([1, 2, 3, 4], p=[0.1, 0.4, 0.4, 0.1]))):
        joints = [d.joint() for _ in range(int(rng.choice([2, 3, 4], p=[0.3, 0.6, 0.1])))]
        for joint in joints:
            joint["axis"] = list(Z) if joint["type"] == "R" else joint["axis"]
        limbs.append({"name": f"limb{k}", "joint": joints})
    return assembled(rng, limbs, d, str(rng.choice(["planar", "planar", "spatial", "schoenflies"])))


def spherical(rng: np.random.Generator) -> dict[str, Any] | None:
    """All axes through one point, which is the platform's origin in most files."""
    centre = [0.0, 0.0, 0.0] if rng.uniform() < 0.6 else free_point(rng)()
    axis = special_axis(rng) if rng.uniform() < 0.3 else free_axis(rng)
    d = Draw(rng, lambda: list(centre), axis, "RRRRRRUS")
    limbs = [
        {
            "name": f"limb{k}",
            "joint": [d.joint() for _ in range(int(rng.choice([2, 3], p=[0.3, 0.7])))],
        }
        for k in range(int(rng.integers(1, 4)))
    ]
    data = assembled(rng, limbs, d, str(rng.choice(["spherical", "spatial"])))
    if data is not None and rng.uniform() < 0.8:
        data["platform"]["position"] = list(centre)
    return data


def legs(rng: np.random.Generator) -> dict[str, Any] | None:
    """Rods only: three to six of them."""
    d = draw(rng, "R")
    limbs = [leg(d) for _ in range(int(rng.choice([3, 4, 5, 6], p=[0.2, 0.2, 0.2, 0.4])))]
    return assembled(rng, limbs, d, str(rng.choice(MOTIONS)))


def arm(rng: np.random.Generator) -> dict[str, Any] | None:
    """A serial arm by joints or by DH."""
    count = int(rng.choice([2, 3, 4, 5, 6, 7], p=[0.15, 0.2, 0.15, 0.15, 0.25, 0.1]))
    if rng.uniform() < 0.5:
        angles = [0.0, 90.0, -90.0, 180.0, 45.0]
        data = head(rng)
        unit = 1.0 if data["angle_unit"] == "deg" else np.pi / 180
        rows = []
        for _ in range(count):
            lengths = [float(v) for v in rng.choice([0.0, 0.0, 100.0, 55.5, -30.0], 2)]
            turns = [float(rng.choice(angles)) * unit for _ in range(2)]
            rows.append(
                {
                    "type": str(rng.choice(["R", "R", "R", "P"])),
                    "theta": turns[0],
                    "d": lengths[0],
                    "a": lengths[1],
                    "alpha": turns[1],
                }
            )
        return data | {
            "dh": {"convention": str(rng.choice(["standard", "modified"])), "rows": rows}
        }
    d = draw(rng, "RRRRPH")
    return head(rng) | {"joint": [d.joint() for _ in range(count)], "tool": {"position": d.point()}}


def leg(d: Draw) -> dict[str, Any]:
    kind = str(d.rng.choice(["SPS", "UPS", "SPU"]))
    return {"name": d.name("leg"), "type": kind, "base": d.point(), "platform": d.point()}


FAMILIES = (spatial, equal_limbs, us_limbs, planar, spherical, legs, arm)
SHARES = (0.3, 0.18, 0.14, 0.12, 0.1, 0.05, 0.11)


# --- which joints are actuated --------------------------------------------------------------------


def assembled(
    rng: np.random.Generator, limbs: list[dict[str, Any]], d: Draw, motion: str
) -> dict[str, Any] | None:
    """The file of some limbs with its actuated joints chosen; None where it is too large to be
    quick.
    """
    freedoms = [sum(FREEDOM[j["type"]] for j in limb["joint"]) for limb in limbs if "joint" in limb]
    if motion == "spatial" and sum(freedoms) < 6 * (len(limbs) - 1) and rng.uniform() < 0.7:
        return None
    quaternion = (
        [1.0, 0.0, 0.0, 0.0]
        if rng.uniform() < 0.6
        else [float(v) for v in _unit(rng.normal(size=4))]
    )
    platform = {"position": d.point(), "quaternion": quaternion, "motion": motion}
    data = head(rng) | {"platform": platform, "limb": limbs}
    candidates = [j for limb in limbs for j in limb.get("joint", []) if j["type"] in "RPH"]
    if rng.uniform() < DETERMINED:
        _actuate(rng, data, candidates)
    else:
        for joint in candidates:
            joint["actuated"] = bool(rng.uniform() < 0.35)
    return data if _passive(limbs) <= rng.choice(MOST_PASSIVE, p=MOST_PASSIVE_SHARES) else None


def _passive(limbs: list[dict[str, Any]]) -> int:
    """Passive freedoms beside the freest passive joint of each limb."""
    total = 0
    for limb in limbs:
        freedoms = sorted(
            FREEDOM[j["type"]] for j in limb.get("joint", []) if not j.get("actuated", False)
        )
        total += sum(freedoms if limb.get("rod") else freedoms[:-1])
    return total


def _actuate(
    rng: np.random.Generator, data: dict[str, Any], candidates: list[dict[str, Any]]
) -> None:
    """Actuate joints at random as long as each adds to what is determined at a generic closed
    configuration.
    """
    m = PlainMechanism(data)
    closed = closed_configurations(m, 6, 0.2, rng)
    if not len(closed):
        return
    _, s, right = np.linalg.svd(m.closure(closed[:1])[1][0], full_matrices=True)
    free = right[int(np.sum(s > 1e-8 * max(s[0], 1e-300))) :]
    left = m.tangent(named_places(m))
    wanted = np.linalg.matrix_rank(free[:, left], tol=1e-7) if len(free) else 0
    chosen: list[int] = [m.columns[i].start for i in m.places("actuated")]
    for joint in [candidates[i] for i in rng.permutation(len(candidates))]:
        column = m.columns[m.names.index(joint["name"])].start
        if _rank(free, chosen) >= wanted:
            break
        if _rank(free, [*chosen, column]) > _rank(free, chosen):
            chosen.append(column)
            joint["actuated"] = True


def _rank(free: np.ndarray, columns: list[int]) -> int:
    return int(np.linalg.matrix_rank(free[:, columns], tol=1e-7)) if columns and len(free) else 0


def _unit(v: np.ndarray) -> np.ndarray:
    return np.asarray(v / np.linalg.norm(v))


# --- text -----------------------------------------------------------------------------------------


def to_toml(data: dict[str, Any]) -> str:
    """TOML of nested tables and arrays of tables; numbers as repr writes them."""
    text = "\n".join(_tables(data, ""))
    assert tomllib.loads(text) == data
    return text + "\n"


def _tables(data: dict[str, Any], path: str) -> list[str]:
    lines = [f"{key} = {_value(v)}" for key, v in data.items() if not _is_table(v)]
    for key, value in data.items():
        name = f"{path}{key}"
        if isinstance(value, dict):
            lines += [f"[{name}]", *_tables(value, f"{name}.")]
        elif _is_table(value):
            for item in value:
                lines += [f"[[{name}]]", *_tables(item, f"{name}.")]
    return lines


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], dict)
    )


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    return repr(value)
