"""Machines that the scripts of this folder ask: by name, of all kinds, and random ones."""

from __future__ import annotations

import importlib
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np

import symkin
from asked import BENCH, Machine
from symkin.errors import InputError, SymkinError
from symkin.formats.load import load
from symkin.model.mechanism import Mechanism
from symkin.model.writer import mechanism_to_toml

PLACE = BENCH / "machines"
PLATFORMS = ("delta", "zhao2000", "zhao2000_links", "ren2008", "ren2008_true", "zhang2009")
ARMS = ("gluon_6l3", "scara", "ur5e", "yao2020")
HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
"""Home of the platform whose singular reference asks for one, as in generate.py."""
HOMES = {"zhang2009": HOME}
MAPS = {
    "ankle": "upper_motor,lower_motor to ankle.1,ankle.2",
    "four_bar": "crank to follower",
    "bennett": "input to output",
    "sarrus": "foot_x to head_y",
    "slider_crank": "crank to piston",
    "watt_six_bar": "crank to output",
    "stephenson_six_bar": "crank to output",
    "goldberg": "input to output",
    "pantograph_five_bar": "arm1,arm2 to wrist1,plate_pivot",
    "excavator_bucket": "boom_cylinder,stick_cylinder,bucket_cylinder to boom,stick,bucket",
    "spherical_wrist": "motor1,motor2,motor3 to tip1,tip2,tip3",
}
"""Maps between joints: given and found coordinates."""
LOOPS = {
    "four_bar": (("crank", "crank_pin"), ("follower", "follower_pin")),
    "bennett": (("input", "crank_pin"), ("output", "rocker_pin")),
    "sarrus": (("foot_x", "elbow_x", "head_x"), ("foot_y", "elbow_y", "head_y")),
    "goldberg": (("input", "q_pin"), ("output", "p4_pin", "w_pin")),
}
"""Loops of a graph that are written as two limbs: which joints each has, from the base on."""


def machine_of(source: str, given: str | None = None, find: str | None = None) -> Machine:
    """The machine of a name or a file, as a map where joints are given and found; a shipped one
    goes before one of `machines/`.
    """
    made = PLACE / f"{source}.toml"
    known = source in (*PLATFORMS, *ARMS, *MAPS) or not made.exists()
    sides = (given, find) if given and find else MAPS.get(source, "").split(" to ")
    names = [tuple(side.split(",")) for side in sides if side] or [(), ()]
    return Machine(load(source if known else made), *names, HOMES.get(source))


def named() -> Iterator[Machine]:
    """Shipped machines and those of bench/machines."""
    yield from map(machine_of, (*PLATFORMS, *ARMS))
    for file in sorted(PLACE.glob("*.toml")):
        made = load(file)
        yield Machine(made)
        if made.motion != "spatial":
            # the same without its motion: its pose is then of six numbers, of which its limbs leave
            # some
            yield Machine(replace(made, name=f"{made.name}_six", motion="spatial"))
    for name, limbs in LOOPS.items():
        yield Machine(_as_limbs(name, limbs))
    yield from map(machine_of, MAPS)


def _as_limbs(name: str, limbs: tuple[tuple[str, ...], ...]) -> Mechanism:
    """A shipped loop of a graph as limbs that meet at a platform."""
    data = tomllib.loads(mechanism_to_toml(load(name)))
    joints = {
        joint["name"]: {k: v for k, v in joint.items() if k != "links"} for joint in data["joint"]
    }
    kept = {key: data[key] for key in ("format", "length_unit", "angle_unit")}
    kept |= {"name": f"{name}_limbs", "platform": {"position": joints[limbs[0][-1]]["point"]}}
    tables = [
        {"name": f"limb{i}", "joint": [joints[j] for j in chain]} for i, chain in enumerate(limbs)
    ]
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(_campaigns().to_toml(kept | {"limb": tables}))
        file.flush()
        return load(file.name)


def _campaigns() -> ModuleType:
    """The random files of tests/campaigns."""
    sys.path.append(str(BENCH.parents[1] / "tests"))
    return importlib.import_module("campaigns.random_files")


def drawn(seed: int, folder: Path) -> Iterator[Machine]:
    """Random machines: two of three of limbs, one a map of a graph."""
    files = _campaigns()
    from campaigns.random_graphs import Drawing

    for number in range(10_000):
        rng, file = np.random.default_rng([seed, number]), folder / f"r{number}.toml"
        try:
            is_map = number % 3 == 2
            text = Drawing(rng).grow() if is_map else files.to_toml(files.random_file(rng))
            name = "graph" if is_map else "m"
            file.write_text(text.replace(f'name = "{name}"', f'name = "r{number}"', 1))
            mechanism = load(file)
            if not is_map:
                yield Machine(mechanism)
                continue
            names = [c.name for c in mechanism.coordinates if c.kind != "quaternion"]
            mobility = symkin.mobility(mechanism).mobility
            if 0 < mobility <= 3 and len(names) >= 2 * mobility:
                chosen = [str(n) for n in rng.permutation(names)[: 2 * mobility]]
                yield Machine(mechanism, tuple(chosen[:mobility]), tuple(chosen[mobility:]))
        except (SymkinError, InputError):
            continue
