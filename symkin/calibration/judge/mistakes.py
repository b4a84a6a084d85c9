"""Find mistakes in data: other units, orders and signs of columns, Euler angles, frames, labels.

`RULES` is the table of what is looked for. A rule puts the readings right by a map of their
columns; one loop tries all of a stage from the same geometry, the nominal one, and names those by
which the readings are explained far better. A few mistakes the readings show by themselves.
"""

from __future__ import annotations

from dataclasses import replace

from symkin.calibration.judge.case import Case, Mistakes
from symkin.calibration.judge.mistaken_columns import COLUMN_MISTAKES
from symkin.calibration.judge.mistaken_frames import FRAME_MISTAKES
from symkin.calibration.judge.trials import Trial

_EXPLAINED_SHARE = 0.2
"""Misfit that readings put right have less of, over the size, and over what is left where joints
are those of other rows: factors below one make any misfit smaller, and explain nothing, and a cause
that leaves much is none.
"""
_MAX_SENTENCES = 3
"""Mistakes that are named at most: further ones are likely to follow from these."""


RULES: Mistakes = {
    stage: COLUMN_MISTAKES.get(stage, {}) | FRAME_MISTAKES.get(stage, {})
    for stage in (*COLUMN_MISTAKES, *FRAME_MISTAKES)
}
"""The mistakes that are looked for, by the stage at which each is, in the order in which those that
the readings alone show are: "readings", "correction" and "order" where those before them found
nothing; "position", whose orientations may be read wrongly besides, unless an order was found; "row
or frame" of consecutive rows, and "frames", where nothing was; "labels" by themselves.
"""


def diagnose(case: Case) -> tuple[str, ...]:
    """Sentences on mistakes in the columns, at most three; none where nothing explains the readings
    far better than they are.
    """
    some = case.examined
    found = _sentences(some, "readings")
    if not found:
        found = _sentences(some, "correction")
        if not found and (whole := _sentences(some, "order")):
            return tuple(whole[:_MAX_SENTENCES])
        positions = some.reading(replace(some.measurements, orientation=None))
        found += _sentences(positions, "position")
    if not found:
        found = _sentences(case.consecutive, "row or frame") or _sentences(some, "frames")
    return tuple(found[:_MAX_SENTENCES])


def diagnose_labels(case: Case) -> tuple[str, ...]:
    """Sentences on labels of groups that look wrong."""
    return tuple(_sentences(case, "labels"))


def _sentences(case: Case, stage: str) -> list[str]:
    """What a stage finds: the sentences of the first rule that the readings alone show, else of all
    mistakes that explain the readings far better if they are put right, best first.
    """
    judged: list[tuple[str, Case]] = []
    for find in RULES[stage].values():
        found = [*find(case)]
        if shown := [text for text, right in found if right is None]:
            return shown
        judged += [(text, right) for text, right in found if right is not None]
    if not judged:
        return []
    as_read, unit = case.trial(), case.mechanism.length_unit
    most = _EXPLAINED_SHARE * case.mechanism.characteristic_length
    tried: dict[str, tuple[Trial, Case]] = {}
    trials = ((right.trial(), text, right) for text, right in judged)
    for trial, text, right in sorted(trials, key=lambda t: t[0].score):
        tried.setdefault(text, (trial, right))
    return [
        f"{text}: the misfit at the nominal geometry would fall from {as_read.score**0.5:.3g} to "
        f"{trial.score**0.5:.3g} {unit} (angles times the size)"
        for text, (trial, right) in tried.items()
        if trial.better_than(as_read) and trial.score**0.5 < most
        if trial.score < _EXPLAINED_SHARE**2 * right.left_by_chance
    ]
