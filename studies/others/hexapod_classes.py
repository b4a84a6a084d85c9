"""How many assembly modes has a platform on six legs that share joint centres? Every incidence
class, counted.

An incidence class says which legs share a base point B1..Bm or a platform point P1..Pn; 6-4 has six
base and four platform points. A class is a bipartite graph of six edges, a leg B2P1 an edge: no two
legs join the same two points, at least three points lie on either side (else the platform spins
about the line through two), at most three legs meet in a point (a fourth is redundant). Exchanging
base and platform changes no count of poses, so that m >= n. The study

  - lists all such graphs and tells those apart that do not hold the platform: generic rank of the
    six leg lines below 6;
  - counts the complex modes of each: joint points and a pose from random numbers, its leg lengths,
    all modes of these;
  - shows the types m-n whose count depends on the incidence list;
  - counts general hexagons in planes, and semi-regular ones, whose corners alternate on one circle
    with a symmetry of order three in base and platform.

Sources of known counts: Ronga and Vust 1992, Raghavan 1993 (40, 6-6); Innocenti and
Parenti-Castelli 1993 (40, 5-5); Innocenti 1995 (32, 6-4); Innocenti and Parenti-Castelli 1990 (16,
6-3); Nanua, Waldron and Murthy 1990 (16, the octahedral 3-3). Such classes were first counted by
Faugere and Lazard, Mechanism and Machine Theory 30(6), 1995.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations
from pathlib import Path

import numpy as np

import symkin
from symkin import Modes

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, new_figure, options_parser
from studies.shared.words import certified

Matrix = tuple[tuple[int, ...], ...]
"""Incidences: entry (i, j) is 1 where a leg joins base point i and platform point j."""


@dataclass(frozen=True)
class IncidenceClass:
    matrix: Matrix

    @property
    def legs(self) -> list[tuple[int, int]]:
        return [(i, j) for i, row in enumerate(self.matrix) for j, there in enumerate(row) if there]

    @property
    def type(self) -> str:
        return f"{len(self.matrix)}-{len(self.matrix[0])}"

    @cached_property
    def is_rigid(self) -> bool:
        """Whether six leg lines (d; a x d) between random points have rank 6."""
        base, platform = random_points(self, np.random.default_rng(0))
        lines = [
            np.concatenate([d := platform[j] - base[i], np.cross(base[i], d)]) for i, j in self.legs
        ]
        return bool(np.linalg.matrix_rank(np.array(lines), tol=1e-9) == 6)

    def __str__(self) -> str:
        return " ".join(f"B{i + 1}P{j + 1}" for i, j in self.legs)


def all_classes() -> list[IncidenceClass]:
    """One graph of each class, most points first."""
    found = set()
    for points in range(3, 7):
        for other in range(3, points + 1):
            for matrix in matrices(points, other, ()):
                turned = [canonical(tuple(zip(*matrix, strict=True)))] if points == other else []
                found.add(max([canonical(matrix), *turned]))
    ordered = sorted(found, key=lambda m: (-len(m), -len(m[0]), m))
    return [IncidenceClass(matrix) for matrix in ordered]


def matrices(rows: int, columns: int, above: Matrix) -> Iterator[Matrix]:
    """All 0-1 matrices with six ones, one to three in each row and column, rows in falling
    order.
    """
    left = 6 - sum(map(sum, above))
    if len(above) == rows:
        if left == 0 and all(1 <= sum(column) <= 3 for column in zip(*above, strict=True)):
            yield above
        return
    for legs in range(1, min(3, left) + 1):
        for places in combinations(range(columns), legs):
            row = tuple(int(j in places) for j in range(columns))
            if not above or row <= above[-1]:
                yield from matrices(rows, columns, (*above, row))


def canonical(matrix: Matrix) -> Matrix:
    """The same graph with its points named in one way: the largest of all orders."""
    columns = permutations(range(len(matrix[0])))
    return max(
        tuple(sorted((tuple(row[j] for j in order) for row in matrix), reverse=True))
        for order in columns
    )


def from_list(text: str) -> IncidenceClass:
    legs = {(int(leg[1]) - 1, int(leg[3]) - 1) for leg in text.split()}
    rows, columns = (1 + max(leg[k] for leg in legs) for k in (0, 1))
    matrix = tuple(tuple(int((i, j) in legs) for j in range(columns)) for i in range(rows))
    return IncidenceClass(canonical(matrix))


def random_points(graph: IncidenceClass, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Base points (m, 3) and platform points (n, 3) about the origin, from normal random
    numbers.
    """
    return rng.normal(size=(len(graph.matrix), 3)), 0.7 * rng.normal(size=(len(graph.matrix[0]), 3))


# --- what is known --------------------------------------------------------------------------------

NAMED: dict[str, tuple[str, int]] = {
    "6-6": ("B1P1 B2P2 B3P3 B4P4 B5P5 B6P6", 40),
    "6-5": ("B1P1 B2P1 B3P2 B4P3 B5P4 B6P5", 40),
    "5-5": ("B1P1 B1P2 B2P1 B3P3 B4P4 B5P5", 40),
    "6-4": ("B1P1 B2P1 B3P2 B4P2 B5P3 B6P4", 32),
    "4-4": ("B1P1 B1P2 B2P1 B2P3 B3P2 B4P4", 24),
    "6-3": ("B1P1 B2P1 B3P2 B4P2 B5P3 B6P3", 16),
    "3-3": ("B1P1 B1P2 B2P1 B2P3 B3P2 B3P3", 16),
}
"""Incidence lists that the names of types usually stand for, and their known counts."""
SEED = 3
COLOURS = {40: "#7b3294", 32: "#2c5fa8", 28: "#0f8b8d", 24: "#2e8b57", 16: "#d98c00", 8: "#c0392b"}


# --- machines -------------------------------------------------------------------------------------


def machine(graph: IncidenceClass, base: np.ndarray, platform: np.ndarray) -> symkin.Mechanism:
    limbs = [
        symkin.RodLimb(f"leg{k}", base[i], platform[j])
        for k, (i, j) in enumerate(graph.legs, start=1)
    ]
    return symkin.Mechanism("hexapod", limbs, platform_position=(0, 0, 1.5))


def modes_at_random_pose(hexapod: symkin.Mechanism, rng: np.random.Generator) -> Modes:
    """All modes of the leg lengths of a random pose."""
    turn = rng.normal(size=4)
    pose = symkin.Pose(rng.normal(size=3) + [0, 0, 1.5], turn / np.linalg.norm(turn))
    return symkin.modes(hexapod, joints=symkin.solve(hexapod, pose=pose).solution.actuated_values)


def hexagon(half_gap: float | np.ndarray, radius: float) -> np.ndarray:
    """Semi-regular hexagon: corners `half_gap` degrees before and after 0, 120 and 240."""
    angles = np.radians([middle + side * half_gap for middle in (0, 120, 240) for side in (-1, 1)])
    return radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(6)])


def planar_pairs(rng: np.random.Generator) -> dict[str, tuple[np.ndarray, np.ndarray, int]]:
    """6-6 platforms with both hexagons plane: general ones, and semi-regular ones with corners
    joined in order.
    """
    flat = (1.0, 1.0, 0.0)
    gaps = rng.uniform(8, 24, 1), rng.uniform(36, 52, 1)
    semi_regular = (
        hexagon(float(gaps[0][0]), 1.0),
        hexagon(float(gaps[1][0]), rng.uniform(0.5, 0.9)),
    )
    return {
        "plane hexagons": (
            rng.normal(size=(6, 3)) * flat,
            0.7 * rng.normal(size=(6, 3)) * flat,
            40,
        ),
        "semi-regular hexagons": (*semi_regular, 28),
    }


# --- report ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Count:
    """Complex counts and completeness found at each random geometry, and the numbers of real and
    certified modes.
    """

    complex: tuple[int | None, ...]
    words: tuple[str, ...]
    real: tuple[int, ...]
    certified: tuple[int, ...]

    @property
    def value(self) -> int | None:
        """The count, where all geometries agree."""
        return self.complex[0] if len(set(self.complex)) == 1 else None

    @staticmethod
    def of(found: list[Modes]) -> Count:
        return Count(
            tuple(f.complex_count for f in found),
            tuple(f.completeness for f in found),
            tuple(len(f) for f in found),
            tuple(certified(f) for f in found),
        )


def count_class(graph: IncidenceClass, geometries: int, rng: np.random.Generator) -> Count:
    return Count.of(
        [
            modes_at_random_pose(machine(graph, *random_points(graph, rng)), rng)
            for _ in range(geometries)
        ]
    )


def report_classes(
    report: Report, geometries: int, rng: np.random.Generator, only_named: bool
) -> dict[IncidenceClass, Count]:
    classes = all_classes()
    loose = [graph for graph in classes if not graph.is_rigid]
    report.row("incidence classes", None, len(classes))
    report.row(
        "classes that do not hold the platform", None, "; ".join(f"{g.type}: {g}" for g in loose)
    )
    known = {from_list(text): count for text, count in NAMED.values()}
    chosen = [g for g in classes if g.is_rigid and (g in known or not only_named)]
    counts = {}
    for graph in chosen:
        counts[graph] = count_class(graph, geometries, rng)
        report.row(f"{graph.type}: {graph}", known.get(graph), counts[graph].value)
    return counts


def report_certainty(report: Report, counts: list[Count]) -> None:
    """How complete all these lists are, and how many of their real modes are certified."""
    words = [word for count in counts for word in count.words]
    text = ", ".join(f"{word}: {words.count(word)}" for word in sorted(set(words)))
    report.row("completeness of these searches", None, text)
    real, proved = (
        sum(sum(getattr(count, name)) for count in counts) for name in ("real", "certified")
    )
    report.row("real modes met; certified", None, [real, proved])


def report_dependence(report: Report, counts: dict[IncidenceClass, Count]) -> None:
    """Types that have more than one count."""
    for kind in dict.fromkeys(graph.type for graph in counts):
        values = [counts[g].value for g in counts if g.type == kind]
        text = ", ".join(
            f"{v} for {values.count(v)}" for v in sorted(set(values), key=lambda v: -(v or 0))
        )
        report.row(f"{kind}: counts, of {len(values)} lists", None, text)


def report_planar(report: Report, geometries: int, rng: np.random.Generator) -> dict[str, Count]:
    general, counts = from_list(NAMED["6-6"][0]), {}
    for name in planar_pairs(rng):
        pairs = [planar_pairs(rng)[name] for _ in range(geometries)]
        counts[name] = Count.of(
            [modes_at_random_pose(machine(general, b, p), rng) for b, p, _ in pairs]
        )
        report.row(f"6-6 with {name}", pairs[0][2], counts[name].value)
    return counts


# --- picture --------------------------------------------------------------------------------------


def draw_graph(axes, graph: IncidenceClass, value: int | None) -> None:
    """Platform points above, base points below, a line a leg; the count beside."""
    colour = COLOURS.get(value, "0.55")
    (bx, by), (px, py) = places(len(graph.matrix), 0.0), places(len(graph.matrix[0]), 1.0)
    for i, j in graph.legs:
        axes.plot([bx[i], px[j]], [by[i], py[j]], color=colour, lw=2.0, solid_capstyle="round")
    axes.plot(bx, by, "s", color="#616e7c", ms=5.5)
    axes.plot(px, py, "o", color="#1b5a91", ms=5.5)
    axes.text(-0.18, 1.3, graph.type, fontsize=10, color="0.35", va="center", ha="left")
    axes.text(
        1.18,
        1.3,
        "not rigid" if not graph.is_rigid else str(value),
        fontsize=13 if graph.is_rigid else 9,
        color=colour,
        weight="bold",
        va="center",
        ha="right",
    )
    axes.set(xlim=(-0.25, 1.25), ylim=(-0.2, 1.55))
    axes.axis("off")


def places(count: int, height: float) -> tuple[np.ndarray, np.ndarray]:
    return (np.arange(count) + 0.5) / count, np.full(count, height)


def draw_hexagons(axes, name: str, value: int | None) -> None:
    """The semi-regular pair from above."""
    colour = COLOURS.get(value, "0.55")
    for points, edge in ((hexagon(15, 1.0), "#616e7c"), (hexagon(45, 0.6), "#1b5a91")):
        axes.fill(*points[:, :2].T, facecolor=edge, alpha=0.12, edgecolor=edge, lw=1.2)
    for b, p in zip(hexagon(15, 1.0), hexagon(45, 0.6), strict=True):
        axes.plot(*np.array([b, p])[:, :2].T, color=colour, lw=2.0)
    axes.text(-1.15, 1.32, name, fontsize=9, color="0.35", va="center", ha="left")
    axes.text(
        1.2, 1.32, str(value), fontsize=13, color=colour, weight="bold", va="center", ha="right"
    )
    axes.set(xlim=(-1.25, 1.25), ylim=(-1.1, 1.6), aspect="equal")
    axes.axis("off")


def draw(counts: dict[IncidenceClass, Count], planar: dict[str, Count]):
    shown = [
        g for g in all_classes() if g in counts or (len(counts) > len(NAMED) and not g.is_rigid)
    ]
    columns = 9 if len(shown) > 9 else 4
    rows = math.ceil((len(shown) + 1) / columns)
    figure = new_figure(1.6 * columns + 0.4, 1.85 * rows + 1.1)
    figure.get_layout_engine().set(hspace=0.03, wspace=0.04)
    figure.suptitle(
        "Assembly modes (complex) of platforms on six legs, by shared joint centres",
        fontsize=15,
        weight="bold",
    )
    axes = figure.subplots(rows, columns).ravel()
    for place in axes:
        place.axis("off")
    for place, graph in zip(axes, shown, strict=False):
        draw_graph(place, graph, counts[graph].value if graph in counts else None)
    draw_hexagons(axes[len(shown)], "semi-regular", planar["semi-regular hexagons"].value)
    figure.supxlabel(
        "squares: base points    circles: platform points    lines: legs", fontsize=11, color="0.35"
    )
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0], SEED)
    parser.add_argument(
        "--geometries", type=int, default=1, help="random geometries of each class (default: 1)"
    )
    parser.add_argument(
        "--named",
        action="store_true",
        help="only the seven lists that the names of types stand for",
    )
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    report = Report(
        "hexapod_classes",
        "Platforms on six legs that share joint centres: complex assembly modes",
        options.seed,
    )
    counts = report_classes(report, options.geometries, rng, options.named)
    report_dependence(report, counts)
    planar = report_planar(report, options.geometries, rng)
    report_certainty(report, [*counts.values(), *planar.values()])
    report.finish(draw(counts, planar), options.output)


if __name__ == "__main__":
    main()
