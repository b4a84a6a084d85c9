"""Random graphs of links and joints: does `modes` lose a configuration that random starts of
another solver find?

    python tests/campaigns/random_graphs.py [--count 500] [--seed 0] [--starts 600] [--small]
        [--only INDEX ...] [-o FOLDER]

Graphs are planar, spherical and spatial, of 2 to 14 links and 1 to 5 loops, with joints of all
types, rods and couplings. With `--small` they are of one or two loops and quick, planar and
spherical ones (axes of small whole numbers for some) with couplings, and single spatial loops, at
sizes 1e-6 to 1e6; and modes by formulas are compared with those by paths. Values of as many
coordinates as the mobility are those of a closed configuration, so that there is a mode. The judge
is `plain_graph.py`, which shares nothing with symkin. Lost is an isolated configuration of the
judge that a list lacks which is "proved" or of "probability one"; sampled lists are counted. A mode
that the judge finds open is wrong. Every finding names the file. Exit status 1 where anything is
lost or wrong, or differs between the engines, or ends in an error.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from helpers.inside import lowered
from oracle.plain_graph import Found, Graph, configurations, freedom, generic, read

HEAD = 'format = 1\nname = "graph"\nlength_unit = "mm"\nangle_unit = "rad"\n'
FREEDOM = {"R": 1, "P": 1, "C": 2, "U": 2, "S": 3}
FAMILIES = ("planar", "planar", "spherical", "spatial", "spatial", "rods")
SMALL = ("two spherical", "whole spherical", "two planar", "coupled", "single", "single planar")
"""Families of one or two loops."""
SIZES = (-6.0, 6.0)
"""Decimal exponents of the sizes of small graphs, over a tenth of a metre."""
LISTED = ("proved", "probability one")
SAME = 1e-5
"""Largest difference of a coordinate (rad, share of the size) of one configuration in both
writings.
"""


class Drawing:
    """A graph that grows link by link; its text is a mechanism file."""

    def __init__(self, rng: np.random.Generator, families: Sequence[str] = FAMILIES) -> None:
        self.rng, self.name = rng, str(rng.choice(families))
        self.is_small = families is SMALL
        self.scale = float(10.0 ** rng.uniform(*SIZES)) if self.is_small else 1.0
        self.family = self._kind()
        self.links, self.tables, self.joints = ["base"], [HEAD], 0

    def _kind(self) -> str:
        """What joints the family has."""
        if not self.is_small:
            return self.name
        plain = (
            str(self.rng.choice(["planar", "spherical"]))
            if self.name == "coupled"
            else self.name.split()[-1]
        )
        return "spatial" if plain == "single" else plain

    def grow(self) -> str:
        loops = (
            int(self.rng.integers(1, 6))
            if not self.is_small
            else 1
            if self.name.startswith("single")
            else 2
        )
        for loop in range(loops):
            if len(self.links) > 12:
                break
            self._loop(first=loop == 0)
        if self.name == "coupled":
            self._couple()
        return "\n".join(self.tables)

    def _couple(self) -> None:
        """The last joint turns with the first, as a pair of gears."""
        if all('type = "R"' in table for table in (self.tables[1], self.tables[-1])):
            ratio = float(self.rng.choice([1, -1, 2, -2, 0.5, 3]))
            self.tables.append(f'[[coupling]]\njoint = "j{self.joints}"\nof = {{ j1 = {ratio} }}\n')

    def _loop(self, *, first: bool) -> None:
        """A chain between two links: with as many freedoms as the family has, so that it moves
        nothing, or one more.
        """
        need = 6 if self.family in ("spatial", "rods") else 3
        total = need + int(first or self.name == "coupled" or self.rng.random() < 0.3)
        ends = [str(v) for v in self.rng.choice(self.links, 2, replace=len(self.links) < 2)]
        if self.family == "rods" and not first and self.rng.random() < 0.7:
            if ends[0] != ends[1]:
                self._rod(ends[0], ends[1])
            return
        types = self._types(total)
        at = ends[0]
        for k, kind in enumerate(types):
            last = k == len(types) - 1
            to = ends[1] if last else f"link{len(self.links)}"
            if to == at:
                to = "base" if at != "base" else self.links[-1]
                if to == at:
                    return
            if not last:
                self.links.append(to)
            self._joint(kind, at, to)
            at = to

    def _types(self, total: int) -> list[str]:
        allowed = {"planar": "RRRP", "spherical": "R", "spatial": "RRPCUS", "rods": "RRUS"}[
            self.family
        ]
        while True:
            types, left = [], total
            while left > 0:
                kind = str(self.rng.choice([c for c in allowed if FREEDOM[c] <= left]))
                types.append(kind)
                left -= FREEDOM[kind]
            # a chain of two joints or more, at most one ball, which would otherwise let a link spin
            if (
                len(types) >= 2
                and types.count("S") <= 1
                and not (self.family == "planar" and types.count("P") > 1)
            ):
                return types

    def _joint(self, kind: str, a: str, b: str) -> None:
        self.joints += 1
        axis, point = self._direction(), self.scale * self.rng.uniform(-100, 100, 3)
        if self.family == "planar":
            point[2] = 0.0
            turn = self.rng.uniform(0, np.pi)
            axis = (
                np.array([0.0, 0.0, 1.0])
                if kind == "R"
                else np.array([np.cos(turn), np.sin(turn), 0.0])
            )
        if self.family == "spherical":
            if self.name == "whole spherical":
                axis = self._whole_direction()
            point = 100 * self.scale * axis
        table = (
            f'[[joint]]\nname = "j{self.joints}"\ntype = "{kind}"\nlinks = ["{a}", "{b}"]\n'
            f"point = {point.tolist()}\n"
        )
        if kind != "S":
            table += f"axis = {axis.tolist()}\n"
        if kind == "U":
            other = np.cross(axis, self._direction())
            table += f"axis2 = {(other / np.linalg.norm(other)).tolist()}\n"
        self.tables.append(table)

    def _rod(self, a: str, b: str) -> None:
        self.joints += 1
        ends = self.scale * self.rng.uniform(-100, 100, (2, 3))
        self.tables.append(
            f'[[rod]]\nname = "j{self.joints}"\nlinks = ["{a}", "{b}"]\nfrom = {ends[0].tolist()}\n'
            f"to = {ends[1].tolist()}\n"
        )

    def _whole_direction(self) -> np.ndarray:
        """A direction of small whole numbers: links of equal angles, axes at right angles to each
        other.
        """
        v = np.zeros(3)
        while not v.any():
            v = self.rng.integers(-2, 3, 3).astype(float)
        return np.asarray(v / np.linalg.norm(v))

    def _direction(self) -> np.ndarray:
        v = self.rng.normal(size=3)
        return np.asarray(v / np.linalg.norm(v))


def chosen_values(path: Path, rng: np.random.Generator) -> tuple[dict[str, float], int] | None:
    """Values of coordinates, as many as the mobility, that decide all others, at a closed
    configuration; None where the graph does not close beside its reference, or has idle freedoms
    that no coordinate binds.
    """
    g = read(path)
    near = generic(g, count=12, spread=0.3, seed=int(rng.integers(1000)))
    if not len(near):
        return None
    x = near[int(rng.integers(len(near)))]
    mobility = freedom(g, x)[1]
    columns, given = list(range(g.freedom)), []
    for k in rng.permutation(len(g.coordinates)).tolist():
        if len(given) == mobility:
            break
        column = 6 * len(g.names) + k
        left = [c for c in columns if c != column]
        if freedom(g, x, np.array(left))[1] < freedom(g, x, np.array(columns))[1]:
            columns, given = left, [*given, k]
    if freedom(g, x, np.array(columns))[1]:
        return None
    v = g.values(x[None])[0]
    return {g.coordinates[k].name: float(v[k] / g.coordinates[k].unit) for k in given}, mobility


def compare(
    path: Path, given: dict[str, float], starts: int, *, engines: bool = False
) -> tuple[str, dict[str, object]]:
    """ "same", "sampled", "refused", "lost", "wrong" or "differs", and what is told of it."""
    mechanism = symkin.load(path)
    begin = time.perf_counter()
    try:
        found = symkin.modes(mechanism, given=given)
        paths = symkin.modes(mechanism, given=given, method="continuation") if engines else found
    except symkin.SymkinError as error:
        return "refused", {"message": str(error)}
    seconds = time.perf_counter() - begin
    g = read(path, list(given))
    judge = configurations(g, given, starts)
    low = lowered(mechanism, frozenset(given))
    # of three revolutes that are a ball one triple of angles is told: the others tell the mode
    balls = {n for r in (low.readings if low else ()) if len(r.names) == 3 for n in r.names}
    missing, unpaired = (_missing(g, judge, one, balls) for one in (found, paths))
    about: dict[str, object] = {
        "modes": len(found),
        "judge": int(judge.isolated.sum()),
        "missing": missing,
        "complex": found.complex_count,
        "completeness": found.completeness,
        "certified": sum(bool(m.certified) for m in found),
        "seconds": round(seconds, 2),
        "groups": [len(group.unknowns) for group in found.groups],
        "given": given,
    }
    if any(mode.residual > 1e-9 * mechanism.characteristic_length for mode in found):
        return "wrong", about
    if missing and found.completeness in LISTED:
        return "lost", about
    if len(paths) != len(found) and paths.completeness in LISTED and found.completeness in LISTED:
        return "differs", about | {"paths": len(paths), "missing by paths": unpaired}
    return (
        "sampled" if found.completeness == "sampled" else found.completeness if missing else "same"
    ), about


def _missing(g: Graph, judge: Found, found: symkin.Modes, untold: set[str]) -> int:
    """How many isolated configurations of the judge are not in a list, coordinates `untold` of
    either left out.
    """
    ours, missing = [mode.joints for mode in found], 0
    for v, isolated in zip(g.values(judge.x), judge.isolated, strict=True):
        named = {c.name: value for c, value in zip(g.coordinates, v, strict=True)}
        named = {name: value for name, value in named.items() if name not in untold}
        missing += int(isolated and not any(_same(g, named, mode) for mode in ours))
    return missing


def _same(g: Graph, named: dict[str, float], mode: dict[str, object]) -> bool:
    """Whether the coordinates that both tell are the same."""
    for c in g.coordinates:
        value = mode.get(c.name)
        if c.name not in named or not isinstance(value, float):
            continue
        gap = named[c.name] - value * c.unit
        if c.angle:
            gap -= 2 * np.pi * np.round(gap / (2 * np.pi))
        if abs(gap) > SAME:
            return False
    return True


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--starts", type=int, default=600)
    parser.add_argument("--small", action="store_true")
    parser.add_argument(
        "--seconds", type=float, default=np.inf, help="begin no other graph after this many"
    )
    parser.add_argument("--only", type=int, nargs="*")
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    folder = options.output or Path(tempfile.mkdtemp(prefix="random_graphs_"))
    folder.mkdir(parents=True, exist_ok=True)
    print(f"seed {options.seed}, {options.starts} starts, files in {folder}")
    counts: Counter[str] = Counter()
    begin = time.perf_counter()
    for index in options.only if options.only is not None else range(options.count):
        rng = np.random.default_rng([options.seed, index])
        if time.perf_counter() - begin > options.seconds:
            break
        drawing = Drawing(rng, SMALL if options.small else FAMILIES)
        path = folder / f"{index}.toml"
        path.write_text(drawing.grow())
        chosen = chosen_values(path, rng)
        if chosen is None:
            counts["not closed"] += 1
            continue
        try:
            verdict, about = compare(path, chosen[0], options.starts, engines=options.small)
        except Exception as error:
            verdict, about = "error", {"error": repr(error)}
        counts[verdict] += 1
        counts[drawing.name] += 1
        size = (
            f"{drawing.name}, size {drawing.scale:.1g}, {len(drawing.links)} links, "
            f"{drawing.joints} joints"
        )
        print(index, size, verdict, about, flush=True)
    print(dict(counts))
    return int(bool(counts["lost"] or counts["wrong"] or counts["differs"] or counts["error"]))


if __name__ == "__main__":
    sys.exit(main())
