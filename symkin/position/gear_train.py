"""Solve the couplings of a structure group by their whole numbers: n joint = n1 first + n2 second +
... + n offset.

Whole turns of any angle leave such a row as it is. A group of nothing but couplings is therefore Q
u = r modulo whole turns, with a square matrix Q of whole numbers, and has |det Q| solutions, which
differ by turns times Q^-1 k for vectors k of whole numbers. They are all of the complex ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.computed_once import lru_cache
from symkin.position.problem import Problem
from symkin.position.roots import MOST_MODES

_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class GearTrain:
    """The couplings `own` u + `read` k = `constant` (modulo whole turns) of unknown angles u and
    known ones k, and the angles `places` (count, unknowns) by which the solutions differ.
    """

    own: np.ndarray
    read: np.ndarray
    constant: np.ndarray
    places: np.ndarray

    def solutions(self, known: np.ndarray) -> np.ndarray:
        """All solutions (n, count, unknowns) at known values (n, known)."""
        first = np.linalg.solve(self.own, (self.constant - known @ self.read.T).T).T
        return first[:, None, :] + self.places[None, :, :]


@lru_cache(maxsize=256)
def gear_train(group: Problem) -> GearTrain | None:
    """The gear train that a structure group is; None where it is anything else, or has more places
    than are listed.
    """
    unknowns, known = group.system.unknowns, group.known_coordinates
    sources = [group.closure.row_sources[place] for place in group.row_places]
    angles = all(c.is_periodic for c in (*unknowns, *known))
    if (
        not sources
        or not angles
        or len(sources) != len(unknowns)
        or any(row.relation != "coupling" for row in sources)
    ):
        return None
    column = {c.name: place for place, c in enumerate((*unknowns, *known))}
    couplings = {
        f"coupling of {coupling.joint}": coupling for coupling in group.mechanism.couplings
    }
    matrix, constant = np.zeros((len(sources), len(column))), np.zeros(len(sources))
    for line, source in enumerate(sources):
        coupling = couplings[source.limb]
        numbers = coupling.whole_numbers
        if numbers is None:
            return None
        matrix[line, column[coupling.joint]] = numbers[0]
        for name, number in zip(coupling.names, numbers[1], strict=True):
            matrix[line, column[name]] -= number
        constant[line] = numbers[0] * coupling.constant
    own = matrix[:, : len(unknowns)]
    places = _places(own)
    return None if places is None else GearTrain(own, matrix[:, len(unknowns) :], constant, places)


def _places(own: np.ndarray) -> np.ndarray | None:
    """The angles Q^-1 k modulo whole turns for all whole k, the first of them 0; None where they
    are too many.
    """
    count = round(abs(float(np.linalg.det(own))))
    if not 1 <= count <= MOST_MODES:
        return None
    steps = np.round(count * np.linalg.inv(own)).astype(int).T
    # whole multiples of a turn over the count, each reached from another by one whole turn of a row
    found = {(0,) * len(own): None}
    todo = list(found)
    while todo:
        place = todo.pop()
        for step in steps:
            beside = tuple(((np.array(place) + step) % count).tolist())
            if beside not in found:
                found[beside] = None
                todo.append(beside)
    return _TURN / count * np.array(list(found), dtype=float)
