"""Counts of what goals came to, in one range of one machine or of many."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from asked import STATUSES


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
