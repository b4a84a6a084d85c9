"""Move to where generated C refuses to go on, ever nearer, and ask whether what was called OK there
can be held and left again.

Lines go from home until a goal is refused: at a fold, a dead centre, a meeting of branches. Between
the last goal that was OK and the refused one others are asked for, each from the last OK. An OK
whose own answer is refused as a guess, or leads elsewhere, slips; it is lost where the goals before
it are refused as well: a controller that holds it comes no further.
"""

from __future__ import annotations

import numpy as np

from directions import OUT_OF_RANGE, Direction
from rows import Row

_STEP = 0.03
"""Length of a step from home (rad, or of the size)."""
_STEPS = 120
_GOALS = 40
"""Goals on each line between the last OK and what is refused."""
_FINE = {"float": 3.0, "double": 6.0}
"""Every second goal lies at most ten to this power nearer to what is refused."""
_STAYS = 10.0
"""Roots of rounding (rad, or of the size) by which an answer that is asked for from itself may
differ: beside a fold an error t of given values is one of sqrt(t).
"""
_WAYS_OUT = (1.0, 0.5, 0.1, 0.01)
"""Parts of the way back to the last goal."""


def grazed(lines: Direction, count: int, rng: np.random.Generator) -> Row:
    """Go from home in random directions; nothing where the given values are a pose, which has no
    straight lines.
    """
    found, coordinates = Row(), lines.problem.known_coordinates
    if any(c.width != 1 for c in coordinates):
        return found
    known, guesses, beyond = _refused(lines, count, rng)
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


def _refused(
    lines: Direction, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Last given values that were OK, their guesses, and the refused ones after them, of lines that
    end within limits.
    """
    coordinates = lines.problem.known_coordinates
    units = np.array([1.0 if c.is_angular else lines.size for c in coordinates])
    low, high = np.array([c.limits or (-np.inf, np.inf) for c in coordinates]).T
    _, known, guesses = lines.home.repeated(count)
    way = rng.normal(size=known.shape)
    step = _STEP * units * way / np.linalg.norm(way, axis=1, keepdims=True)
    beyond, going, refused = known.copy(), np.ones(count, bool), np.zeros(count, bool)
    for _ in range(_STEPS):
        goal = lines.asked.rounded(known + step)
        going &= np.all((goal >= low) & (goal <= high), axis=1)
        status, answers, _ = lines.answers(goal, guesses)
        ends = going & (status != 0)
        beyond[ends], refused, going = goal[ends], refused | ends, going & ~ends
        known = np.where(going[:, None], goal, known)
        guesses = np.where(going[:, None], answers, guesses)
    return known[refused], guesses[refused], beyond[refused]
