"""Counts of what goals came to, in one range of one machine or of many."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

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
        for key in (f.name for f in fields(self)):
            setattr(self, key, getattr(self, key) + getattr(other, key))
        self.most_steps = most

    def cells(self) -> dict[str, str]:
        """Cells of a table by their heads; empty where there is nothing to tell."""
        counts = {"goals": self.goals, "OK": self.ok, "OK wrong": self.wrong}
        rare = {f.name: getattr(self, f.name) for f in fields(self)[3:9]}
        is_walked = bool(np.any(self.regular))
        by_status = zip(STATUSES[1:], self.regular[1:], strict=True)
        refused = (f"{status} {count:,.0f}" for status, count in by_status if count > 0.5)
        return {
            **{head: f"{count:,}" for head, count in counts.items()},
            **{head: f"{count:,}" if count else "" for head, count in rare.items()},
            "feasible taken": f"{self.taken:,} of {self.feasible:,}" if self.feasible else "",
            "OK of regular lines": f"{self.ok_of_regular:.1f} %" if is_walked else "",
            "refused regular lines": ", ".join(refused),
            "mean steps": f"{self.steps / max(1, self.goals):.1f}" if self.steps else "",
            "most steps": f"{self.most_steps}" if self.steps else "",
        }
