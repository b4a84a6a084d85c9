"""Move to where generated C refuses to go on, ever nearer, and ask whether what was called OK there
can be held and left again.

Between home and random goals that are refused from there, others are asked for, each from the last
OK: to a fold, a dead centre, a meeting of branches. An OK whose own answer is refused as a guess,
or leads elsewhere, slips; it is lost where the goals before it are refused as well: a controller
that holds it comes no further.
"""

from __future__ import annotations

import numpy as np

from directions import OUT_OF_RANGE, Direction
from ranges import WIDEST, goals_about
from rows import Row

_DRAWN = 8
"""Goals that are drawn for each that is refused, at most."""
_GOALS = 56
"""Goals on each line between the last OK and what is refused; every second one is in the middle."""
_FINE = {"float": 3.0, "double": 6.0}
"""The others lie at most ten to this power nearer to what is refused."""
_STAYS = 10.0
"""Roots of rounding (rad, or of the size) by which an answer that is asked for from itself may
differ: beside a fold an error t of given values is one of sqrt(t).
"""
_WAYS_OUT = (1.0, 0.5, 0.1, 0.01)
"""Parts of the way back to the last goal."""


def grazed(lines: Direction, count: int, rng: np.random.Generator) -> Row:
    """Go to where goals are refused; nothing where the given values are a pose, which has no
    straight lines.
    """
    found = Row()
    if any(c.width != 1 for c in lines.problem.known_coordinates):
        return found
    beyond = goals_about(lines, _DRAWN * count, WIDEST, rng)
    status = lines.answers(beyond, lines.home.repeated(len(beyond)).guesses).status
    beyond = beyond[np.flatnonzero(status)[:count]]
    _, known, guesses = lines.home.repeated(len(beyond))
    near = _STAYS * np.sqrt(lines.epsilon)
    for k in range(_GOALS if len(known) else 0):
        part = 10.0 ** -rng.uniform(0.0, _FINE[lines.real], (len(known), 1)) if k % 2 else 0.5
        goal = lines.asked.rounded(beyond + part * (known - beyond))
        status, answers, _ = lines.answers(goal, guesses)
        ok = (status == 0)[:, None]
        held = np.where(ok, answers, guesses)
        again, there, _ = lines.answers(goal, held)
        there = np.where((again == 0)[:, None], there, held)
        slips = ok[:, 0] & ((again != 0) | (lines.off(there, held) > near))
        lost = slips.copy()
        for way in _WAYS_OUT if slips.any() else ():
            back = lines.asked.rounded(goal + way * (known - goal))
            lost &= lines.answers(back, held).status != 0
        row = Row(len(known), int(ok.sum()), slipped=int(slips.sum()), lost=int(lost.sum()))
        row.unread = int(np.sum(slips & (again == OUT_OF_RANGE)))
        row.said = [
            f"from {guesses[i].tolist()} to {goal[i].tolist()}: OK, {answers[i].tolist()}, "
            f"again: status {again[i]}, {there[i].tolist()}{', lost' if lost[i] else ''}"
            for i in np.flatnonzero(slips)[:1]
        ]
        found.add(row)
        known, guesses, beyond = np.where(ok, goal, known), held, np.where(ok, beyond, goal)
    return found
