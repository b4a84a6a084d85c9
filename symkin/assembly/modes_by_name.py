"""The modes of inputs whose coordinates are told by name, with what is said where there are
none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.by_groups import modes_by_groups
from symkin.assembly.least_modes import with_least_modes
from symkin.assembly.modes_result import Modes
from symkin.assembly.search import Search
from symkin.position.given import Given
from symkin.position.platform_motion import motion_notes
from symkin.position.problem import Problem


def modes_by_name(
    problem: Problem,
    givens: Sequence[Given],
    search: Search,
    choose: Sequence[int] = (),
    *,
    least_errors: bool = True,
) -> tuple[Modes, ...]:
    """The modes of each input of a problem; `choose` takes one solution of each of the first
    structure groups. With `least_errors` inputs without a solution are searched for the least
    closure error.
    """
    known = np.array([given.values for given in givens])
    grouped = modes_by_groups(
        problem, known, search, choose, least_errors=least_errors, certify=True
    )
    found = []
    for number, given in enumerate(givens):
        modes = grouped.modes_of(number, given)
        if given.off_motion > 0.0:
            modes = _off_the_motion(modes, given)
        found.append(with_least_modes(problem, given, search, modes))
    if any(
        modes.completeness == "sampled" and given.off_motion == 0.0
        for modes, given in zip(found, givens, strict=True)
    ):
        notes = motion_notes(problem)
        found = [
            replace(m, notes=(*m.notes, *notes)) if m.completeness == "sampled" else m
            for m in found
        ]
    return tuple(found)


def _off_the_motion(modes: Modes, given: Given) -> Modes:
    """No modes, for a pose that the platform cannot take: those of the nearest pose are none of
    it.
    """
    return replace(
        modes,
        modes=modes.modes.chosen(slice(0)),
        count=0,
        completeness="sampled",
        complex_count=None,
        unresolved_paths=None,
        smallest_residual=given.off_motion,
        groups=(),
        engine=None,
    )
