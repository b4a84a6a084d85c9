"""Find mistakes in data: other units, orders and signs of columns, Euler angles, frames, labels.

`RULES` is the table of what is looked for. A rule puts the readings right by a map of their
columns; one loop tries all of a stage from the same geometry, the nominal one, and names those by
which the readings are explained far better. A few mistakes the readings show by themselves.
"""

from __future__ import annotations

import math
from dataclasses import replace

from symkin.calibration.data.observables import measure_of, written
from symkin.calibration.judge.case import Case, Mistakes
from symkin.calibration.judge.mistaken_columns import COLUMN_MISTAKES
from symkin.calibration.judge.mistaken_frames import FRAME_MISTAKES
from symkin.calibration.judge.trials import NO_TRIAL, Start
from symkin.text import first_of

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
    as_read = case.start()
    before = NO_TRIAL if as_read is None else as_read.trial
    most = _EXPLAINED_SHARE * case.mechanism.characteristic_length
    tried: dict[str, tuple[Start, Case]] = {}
    starts = ((right.start(), text, right) for text, right in judged)
    begun = ((start, text, right) for start, text, right in starts if start is not None)
    for start, text, right in sorted(begun, key=lambda t: t[0].misfit):
        tried.setdefault(text, (start, right))
    return [
        f"{text}: the misfit at the nominal geometry would fall {_fall(as_read, start)}"
        for text, (start, right) in tried.items()
        if start.trial.better_than(before) and start.misfit < most
        if start.trial.score < _EXPLAINED_SHARE**2 * right.left_by_chance
    ]


def _fall(before: Start | None, after: Start) -> str:
    """Write 'from 413 mm to 0.9 mm (position)' of the kinds whose misfit falls."""
    m, parts = after.problem.mechanism, list[str]()
    earlier = {} if before is None else before.misfits
    for kind, there in after.misfits.items():
        here = earlier.get(kind, math.inf)
        if there < here:
            ends = [written(m, measure_of(m, kind), v, ".3g") for v in (here, there)]
            parts.append(f"from {ends[0]} to {ends[1]} ({kind})")
    return first_of(parts)
