"""Judge what the C answers, and count it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from asked import STATUSES
from directions import HARD, PLAIN, Direction, Outcome


@dataclass
class Row:
    """Goals, answers that are OK, and what is wrong with them: not where the line leads or not
    closed, refused from themselves, refused on an easy line; paths begun anew; beside what is
    refused: OKs that slip, that are not read as a guess, that are lost; goals that the machine can
    take, and those taken; steps; regular lines by status, refused ones as many as those that were
    walked stand for.
    """

    goals: int = 0
    ok: int = 0
    wrong: int = 0
    moved: int = 0
    stuck: int = 0
    anew: int = 0
    slipped: int = 0
    unread: int = 0
    lost: int = 0
    feasible: int = 0
    taken: int = 0
    steps: int = 0
    most_steps: int = 0
    regular: np.ndarray = field(default_factory=lambda: np.zeros(len(STATUSES)))
    said: list[str] = field(default_factory=list)

    @property
    def ok_of_regular(self) -> float:
        return float(100.0 * self.regular[0] / max(1.0, float(np.sum(self.regular))))

    @property
    def is_good(self) -> bool:
        return not (self.wrong or self.moved or self.stuck or self.unread)

    def add(self, other: Row) -> None:
        """Take the counts of another row too."""
        most = max(self.most_steps, other.most_steps)
        for key, value in vars(other).items():
            setattr(self, key, getattr(self, key) + value)
        self.most_steps = most

    def kept(self) -> dict[str, Any]:
        """As JSON holds it."""
        return {**vars(self), "regular": self.regular.tolist()}

    @classmethod
    def of(cls, kept: Mapping[str, Any]) -> Row:
        return cls(**{**kept, "regular": np.array(kept["regular"])})

    def cells(self) -> dict[str, str]:
        """Cells of a table by their heads; empty where there is nothing to tell."""
        cells = {"goals": f"{self.goals:,}", "OK": f"{self.ok:,}", "OK wrong": f"{self.wrong:,}"}
        for key in ("moved", "stuck", "anew", "slipped", "unread", "lost"):
            cells[key] = f"{count:,}" if (count := getattr(self, key)) else ""
        of = f"{self.taken:,} of {self.feasible:,}" if self.feasible else ""
        share = f"{self.ok_of_regular:.1f} %" if np.any(self.regular) else ""
        refused = zip(STATUSES[1:], self.regular[1:], strict=True)
        told = ", ".join(f"{status} {count:,.0f}" for status, count in refused if count > 0.5)
        steps = (f"{self.steps / max(1, self.goals):.1f}", f"{self.most_steps}")
        mean, most = steps if self.steps else ("", "")
        cells |= {"feasible taken": of, "OK of regular lines": share}
        return cells | {"refused regular lines": told, "mean steps": mean, "most steps": most}


def judged(lines: Direction, outcomes: Iterable[Outcome]) -> Row:
    """Counts of all outcomes, and what is wrong in them."""
    row = Row()
    for outcome in outcomes:
        row.add(_counted(lines, outcome))
    return row


def _counted(lines: Direction, outcome: Outcome) -> Row:
    ok, ends, goals = outcome.ok, outcome.ends, outcome.goals
    status, found, steps = outcome.answers
    row = Row(len(ok), int(np.sum(ok)), steps=int(steps.sum()), most_steps=int(steps.max()))
    reached = lines.stated(ends.unknowns, goals)
    refused = outcome.regular & ~ok
    told = lines.tells(np.where(ok[:, None], found, reached), goals)
    # an answer that a guess cannot state is rightly refused
    refused[refused] = told[refused] & lines.gives_back(reached[refused], goals[refused])
    stands_for = np.sum(~ok) / max(1, np.sum(outcome.walked & ~ok))
    row.regular = stands_for * np.bincount(status[refused], minlength=len(STATUSES))
    row.regular[0] += np.sum(outcome.regular & ok)
    row.anew = int(np.sum(outcome.right & ~told))
    again = lines.answers(goals, np.where(ok[:, None], found, outcome.starts.guesses)).status
    wrong = {
        "wrong": ok & ~outcome.right,
        "moved": outcome.right & outcome.regular & told & (again != 0),
        "stuck": _stuck(lines, outcome, reached, refused),
    }
    for what, which in wrong.items():
        setattr(row, what, int(which.sum()))
        row.said += [_said(lines, outcome, what, int(k), reached[k]) for k in np.flatnonzero(which)]
    return row


def _stuck(
    lines: Direction, outcome: Outcome, reached: np.ndarray, refused: np.ndarray
) -> np.ndarray:
    """Refused lines on which a controller would be locked up."""
    ends, goals = outcome.ends, outcome.goals
    stuck = refused & (ends.shortest >= PLAIN)
    if stuck.any():
        stuck &= lines.problem.system.conditions(ends.unknowns, goals) < HARD
        # an answer that could not be left again, because the code does not read it, is rightly
        # refused
        stuck &= lines.is_firm(ends.unknowns, goals) & lines.tells(reached, goals, easily=True)
    return stuck


def _said(lines: Direction, outcome: Outcome, what: str, k: int, reached: np.ndarray) -> str:
    """One wrong answer, with all that repeats it."""
    guess, goal = (
        ", ".join(repr(float(v)) for v in lines.asked.number(values[k]))
        for values in (outcome.starts.guesses, outcome.goals)
    )
    ends, name = outcome.ends, lines.asked.mechanism.name
    told = f"{name} {lines.real}: {what}, goal [{goal}], guess [{guess}], "
    told += f"{STATUSES[outcome.answers.status[k]]} {outcome.answers.found[k].tolist()}"
    if ends.shortest[k] > 0.0:
        return f"{told}, the line leads to {reached.tolist()} by steps of {ends.shortest[k]:.2g}"
    return f"{told}, the line ends at {ends.done[k]:.9f} of it"
