"""The one table of machines that the scripts of this folder ask, and random ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import symkin
from asked import Asked
from campaigns.twin_oracle import Drawing, random_file, to_toml
from generate import HOMES
from generate import MAPS as GIVEN
from processors import BENCH
from symkin.codegen.map.options import Options
from symkin.errors import InputError, SymkinError
from symkin.formats.load import load

PLACE = BENCH / "machines"
PLATFORMS = ("delta", "zhao2000", "zhao2000_links", "ren2008", "ren2008_true", "zhang2009")
ARMS = ("gluon_6l3", "scara", "ur5e", "yao2020")
MAPS = {
    "ankle": " to ".join(map(",".join, GIVEN["ankle"])),
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
SHIPPED = (*PLATFORMS, *ARMS, *MAPS)
OTHERS = sorted(file.stem for file in PLACE.glob("*.toml"))
"""Machines that are not shipped, loops of shipped graphs written as two limbs among them."""
STUDIED = (
    *("zhang2009", "ren2008", "zhao2000", "zhao2000_links", "delta", "five_bar", "three_rrr"),
    *("three_rpr", "three_rps", "linear_delta", "orthoglide", "six_rss", "hexaglide"),
)
"""Those of the table of README.md."""
GOLDEN = (
    *sorted({*STUDIED, *ARMS, "tricept"}),
    *("ankle", "excavator_bucket", "four_bar", "slider_crank", "spherical_wrist"),
    *("stephenson_six_bar", "watt_six_bar"),
)
"""Those of the golden file."""


def machine_of(source: str, given: str | None = None, find: str | None = None) -> Asked:
    """The machine of a name or a file, as a map where joints are given and found; a shipped one
    goes before one of `machines/`.
    """
    made = source in OTHERS and source not in SHIPPED
    sides = (given, find) if given and find else MAPS.get(source, "").split(" to ")
    names = [tuple(side.split(",")) for side in sides if side] or [(), ()]
    options = Options(home=HOMES.get(source), given=names[0], find=names[1])
    return Asked(load(PLACE / f"{source}.toml" if made else source), options)


def named() -> Iterator[Asked]:
    """Shipped machines and those of bench/machines."""
    yield from map(machine_of, (*PLATFORMS, *ARMS))
    for made in (load(PLACE / f"{name}.toml") for name in OTHERS):
        yield Asked(made)
        if made.motion != "spatial":
            # the same without its motion: its pose is then of six numbers, of which its limbs leave
            # some
            yield Asked(replace(made, name=f"{made.name}_six", motion="spatial"))
    yield from map(machine_of, MAPS)


def drawn(seed: int, folder: Path) -> Iterator[Asked]:
    """Random machines: two of three of limbs, one a map of a graph, of tests/campaigns."""
    for number in range(10_000):
        rng, file = np.random.default_rng([seed, number]), folder / f"r{number}.toml"
        try:
            is_map = number % 3 == 2
            text = Drawing(rng).grow() if is_map else to_toml(random_file(rng))
            name = "graph" if is_map else "m"
            file.write_text(text.replace(f'name = "{name}"', f'name = "r{number}"', 1))
            mechanism = load(file)
            if not is_map:
                yield Asked(mechanism)
                continue
            names = [c.name for c in mechanism.coordinates if c.kind != "quaternion"]
            mobility = symkin.mobility(mechanism).mobility
            if 0 < mobility <= 3 and len(names) >= 2 * mobility:
                chosen = [str(n) for n in rng.permutation(names)[: 2 * mobility]]
                sides = tuple(chosen[:mobility]), tuple(chosen[mobility:])
                yield Asked(mechanism, Options(given=sides[0], find=sides[1]))
        except (SymkinError, InputError):
            continue
