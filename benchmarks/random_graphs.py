"""Random graphs of links and joints: does `modes` lose a configuration that random starts of another solver find?

    python benchmarks/random_graphs.py [--count 500] [--seed 0] [--starts 600] [--only INDEX ...] [-o FOLDER]

Graphs are planar, spherical and spatial, of 2 to 14 links and 1 to 5 loops, with joints of all types, rods and couplings. Values
of as many coordinates as the mobility are those of a closed configuration, so that there is a mode. The judge is
`plain_graph.py`, which shares nothing with symkin. Lost is an isolated configuration of the judge that a list lacks which is
"proved" or of "probability one"; sampled lists are counted. A mode that the judge finds open is wrong. Every finding names the
file. Exit status 1 where anything is lost or wrong, or ends in an error.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import symkin
from plain_graph import Graph, configurations, freedom, generic, read

HEAD = 'format = 1\nname = "graph"\nlength_unit = "mm"\nangle_unit = "rad"\n'
FREEDOM = {"R": 1, "P": 1, "C": 2, "U": 2, "S": 3}
FAMILIES = ("planar", "planar", "spherical", "spatial", "spatial", "rods")
SAME = 1e-5
"""Largest difference of a coordinate (rad, share of the size) of one configuration in both writings."""


class Drawing:
    """A graph that grows link by link; its text is a mechanism file."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.family = rng, str(rng.choice(FAMILIES))
        self.links, self.tables, self.joints = ["base"], [HEAD], 0

    def grow(self) -> str:
        loops = int(self.rng.integers(1, 6))
        for loop in range(loops):
            if len(self.links) > 12:
                break
            self._loop(first=loop == 0)
        return "\n".join(self.tables)

    def _loop(self, *, first: bool) -> None:
        """A chain between two links: with as many freedoms as the family has, so that it moves nothing, or one more."""
        need = 6 if self.family in ("spatial", "rods") else 3
        total = need + int(first or self.rng.random() < 0.3)
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
        allowed = {"planar": "RRRP", "spherical": "R", "spatial": "RRPCUS", "rods": "RRUS"}[self.family]
        while True:
            types, left = [], total
            while left > 0:
                kind = str(self.rng.choice([c for c in allowed if FREEDOM[c] <= left]))
                types.append(kind)
                left -= FREEDOM[kind]
            # a chain of two joints or more, at most one ball, which would otherwise let a link spin
            if len(types) >= 2 and types.count("S") <= 1 and not (self.family == "planar" and types.count("P") > 1):
                return types

    def _joint(self, kind: str, a: str, b: str) -> None:
        self.joints += 1
        axis, point = self._direction(), self.rng.uniform(-100, 100, 3)
        if self.family == "planar":
            point[2] = 0.0
            turn = self.rng.uniform(0, np.pi)
            axis = np.array([0.0, 0.0, 1.0]) if kind == "R" else np.array([np.cos(turn), np.sin(turn), 0.0])
        if self.family == "spherical":
            point = 100 * axis
        table = f'[[joint]]\nname = "j{self.joints}"\ntype = "{kind}"\nlinks = ["{a}", "{b}"]\npoint = {point.tolist()}\n'
        if kind != "S":
            table += f"axis = {axis.tolist()}\n"
        if kind == "U":
            other = np.cross(axis, self._direction())
            table += f"axis2 = {(other / np.linalg.norm(other)).tolist()}\n"
        self.tables.append(table)

    def _rod(self, a: str, b: str) -> None:
        self.joints += 1
        ends = self.rng.uniform(-100, 100, (2, 3))
        self.tables.append(
            f'[[rod]]\nname = "j{self.joints}"\nlinks = ["{a}", "{b}"]\nfrom = {ends[0].tolist()}\nto = {ends[1].tolist()}\n'
        )

    def _direction(self) -> np.ndarray:
        v = self.rng.normal(size=3)
        return np.asarray(v / np.linalg.norm(v))


def chosen_values(path: Path, rng: np.random.Generator) -> tuple[dict[str, float], int] | None:
    """Values of coordinates, as many as the mobility, that decide all others, at a closed configuration; None where the graph
    does not close beside its reference, or has idle freedoms that no coordinate binds."""
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


def compare(path: Path, given: dict[str, float], starts: int) -> tuple[str, dict[str, object]]:
    """ "same", "sampled", "refused", "lost" or "wrong", and what is told of it."""
    mechanism = symkin.load(path)
    begin = time.perf_counter()
    try:
        found = symkin.modes(mechanism, given=given)
    except symkin.SymkinError as error:
        return "refused", {"message": str(error)}
    seconds = time.perf_counter() - begin
    g = read(path, list(given))
    judge = configurations(g, given, starts)
    ours = [mode.joints for mode in found]
    missing = 0
    for v, isolated in zip(g.values(judge.x), judge.isolated, strict=True):
        named = {c.name: value for c, value in zip(g.coordinates, v, strict=True)}
        if isolated and not any(_same(g, named, mode) for mode in ours):
            missing += 1
    about: dict[str, object] = {
        "modes": len(found), "judge": int(judge.isolated.sum()), "missing": missing, "complex": found.complex_count,
        "completeness": found.completeness, "certified": sum(bool(m.certified) for m in found), "seconds": round(seconds, 2),
        "groups": [len(group.unknowns) for group in found.groups],
    }  # fmt: skip
    if any(mode.residual > 1e-9 * mechanism.characteristic_length for mode in found):
        return "wrong", about
    if missing and found.completeness in ("proved", "probability one"):
        return "lost", about
    return ("sampled" if found.completeness == "sampled" else found.completeness if missing else "same"), about


def _same(g: Graph, named: dict[str, float], mode: dict[str, object]) -> bool:
    """Whether the coordinates that both tell are the same."""
    for c in g.coordinates:
        value = mode.get(c.name)
        if value is None or not isinstance(value, float):
            continue
        gap = named[c.name] - value * c.unit
        if c.angle:
            gap -= 2 * np.pi * np.round(gap / (2 * np.pi))
        if abs(gap) > SAME:
            return False
    return True


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--starts", type=int, default=600)
    parser.add_argument("--only", type=int, nargs="*")
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    folder = options.output or Path(tempfile.mkdtemp(prefix="random_graphs_"))
    folder.mkdir(parents=True, exist_ok=True)
    print(f"seed {options.seed}, {options.starts} starts, files in {folder}")
    counts: Counter[str] = Counter()
    for index in options.only if options.only is not None else range(options.count):
        rng = np.random.default_rng([options.seed, index])
        drawing = Drawing(rng)
        path = folder / f"{index}.toml"
        path.write_text(drawing.grow())
        chosen = chosen_values(path, rng)
        if chosen is None:
            counts["not closed"] += 1
            continue
        try:
            verdict, about = compare(path, chosen[0], options.starts)
        except Exception as error:
            verdict, about = "error", {"error": repr(error)}
        counts[verdict] += 1
        counts[drawing.family] += 1
        print(index, drawing.family, f"{len(drawing.links)} links", f"{drawing.joints} joints", verdict, about, flush=True)
    print(dict(counts))
    return int(bool(counts["lost"] or counts["wrong"] or counts["error"]))


if __name__ == "__main__":
    sys.exit(main())
