"""Incidence classes of platforms on six legs: which legs share a base point B1..Bm or a platform point P1..Pn.

A class is a bipartite graph of six edges, a leg B2P1 an edge: no two legs join the same two points, at least three points lie
on either side (else the platform spins about the line through two), at most three legs meet in a point (a fourth is
redundant). Exchanging base and platform changes no count of poses, so that m >= n.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations

import numpy as np

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
        lines = [np.concatenate([d := platform[j] - base[i], np.cross(base[i], d)]) for i, j in self.legs]
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
    """All 0-1 matrices with six ones, one to three in each row and column, rows in falling order."""
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
    return max(tuple(sorted((tuple(row[j] for j in order) for row in matrix), reverse=True)) for order in columns)


def from_list(text: str) -> IncidenceClass:
    legs = {(int(leg[1]) - 1, int(leg[3]) - 1) for leg in text.split()}
    rows, columns = (1 + max(leg[k] for leg in legs) for k in (0, 1))
    matrix = tuple(tuple(int((i, j) in legs) for j in range(columns)) for i in range(rows))
    return IncidenceClass(canonical(matrix))


def random_points(graph: IncidenceClass, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Base points (m, 3) and platform points (n, 3) about the origin, from normal random numbers."""
    return rng.normal(size=(len(graph.matrix), 3)), 0.7 * rng.normal(size=(len(graph.matrix[0]), 3))
