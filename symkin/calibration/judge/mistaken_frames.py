"""Mistakes in frames and groups, with their sentences: poses in a left-handed frame, or in one that
stands elsewhere, and labels of groups that do not belong.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.state import readings_at
from symkin.calibration.judge.case import (
    EXAMINED_CONFIGURATIONS,
    MIN_WHOLE_POSES,
    Case,
    Finding,
    Mistakes,
)
from symkin.spatial.rotation import wrapped
from symkin.text import first_of

_GROUP_PART, _OUTSTANDING_RATIO = 0.4, 15.0
"""Share of a group by which its middle is sought; and a configuration stands out when it is so many
times further away than half of all are: errors of the nominal geometry spread them too.
"""
_MIN_GROUP_SIZE = 3
"""Configurations of a group from which one can be told from the others."""
_COMPARED_NEIGHBOURS, _SCATTER_RATIO = 3, 5.0
"""Labels mean nothing when a configuration is so many times further from its group than from this
many others of any label.
"""


def _left_handed(case: Case) -> Iterator[Finding]:
    """Poses in a frame of which one axis is reversed, or two are exchanged."""
    m, unit = case.measurements, np.eye(3)
    if m.position is None or m.orientation is None:
        return
    mirrors = {f"{name} reversed": np.diag(1.0 - 2.0 * unit[k]) for k, name in enumerate("xyz")}
    swaps = {"x and y": (1, 0, 2), "x and z": (2, 1, 0), "y and z": (0, 2, 1)}
    mirrors |= {f"{names} exchanged": unit[[*order]] for names, order in swaps.items()}
    for how, mirror in mirrors.items():
        axis = -m.orientation[:, 1:] @ mirror  # of a rotation: its sense is reversed, too
        turns = np.hstack([m.orientation[:, :1], axis])
        right = replace(m, position=m.position @ mirror, orientation=turns)
        text = f"the poses look to stand in a left-handed frame ({how}, of orientations too)"
        yield text, case.reading(right)


_ELSEWHERE = {
    "world": "measured in a frame that stands elsewhere than the mechanism's base",
    "target": "those of a target that is mounted elsewhere than the platform's frame",
}
"""What is said of poses from which a measuring frame is left out."""


def _frames_left_out(left_out: Sequence[str], case: Case) -> Iterator[Finding]:
    """Measuring frames that are not among the parameters, and no others, put where they fit."""
    m, held = case.measurements, {name.partition(".")[0] for name in case.frames}
    unseen = m.position is None or len(m) < MIN_WHOLE_POSES
    if unseen or case.placed or held & {*left_out}:
        return
    names = [name for name in MEASURING_FRAMES if name.partition(".")[0] in left_out]
    what = " and ".join(_ELSEWHERE[frame] for frame in left_out)
    patterns = ",".join(f"{frame}.*" for frame in left_out)
    text = f"the poses look to be {what}, which --parameters all,{patterns} would find"
    yield text, replace(case, frames=(*case.frames, *names))


def _wrong_labels(case: Case) -> Iterator[Finding]:
    """Inclinations at the nominal geometry show labels that have nothing to do with them, two
    groups under one label, or configurations in a wrong group.
    """
    if (start := case.start()) is None:
        return
    problem, m = start.problem, start.problem.measurements
    group = np.where(start.solved, problem.readings.group, -1)
    numbers, counts = np.unique(group[group >= 0], return_counts=True)
    members = np.flatnonzero(np.isin(group, numbers[counts >= _MIN_GROUP_SIZE]))
    if len(members) <= _COMPARED_NEIGHBOURS:
        return
    readings = readings_at(problem, start.p, np.nan_to_num(start.z))
    at, group = readings[members][:, problem.readings.columns], group[members]
    off = _from_middles(at, group)
    k = _COMPARED_NEIGHBOURS
    near = np.median([np.partition(_apart(at, row), k)[k] for row in at])
    usual = np.median(off)
    out = np.flatnonzero(off > _OUTSTANDING_RATIO * usual)
    rest = np.setdiff1d(np.flatnonzero(np.isin(group, group[out])), out)
    named, others = (first_of(m.named(members[rows])) for rows in (out, rest))
    most, half = case.angle(off.max(initial=0.0)), "at the nominal geometry half of the"
    within = f"postures are within {case.angle(usual)}"
    tail = f"from the others of the group; {half} {within}"
    if usual > _SCATTER_RATIO * near:
        said = (
            f"the groups look wrongly labelled: {half} postures are more than {case.angle(usual)} "
            f"from the inclination of their group, and half have {k} postures of any group within "
            f"{case.angle(near)}"
        )
    elif len(out) == 1:
        said = f"posture {named} looks to be in the wrong group, inclined by {most} {tail}"
    elif not len(out):
        return
    elif np.all(
        (group[out] == group[out[0]]) & (_apart(at[out], at[out[0]]) < 0.5 * off[out].min())
    ):
        said = (
            f"the group of posture {named} looks to be two groups under one label, inclined by "
            f"{most} against {others}; {half} {within} of their group"
        )
    else:
        said = f"posture {named} look to be in wrong groups, inclined by up to {most} {tail}"
    yield said, None


def _from_middles(at: np.ndarray, group: np.ndarray) -> np.ndarray:
    """How far inclinations (n, 2) are from the member of their group that a good part of the others
    is nearest to: a mean of two groups is in none.
    """
    off = np.zeros(len(at))
    for number in np.unique(group):
        own = np.flatnonzero(group == number)
        tried = own[spread_rows(len(own), EXAMINED_CONFIGURATIONS)]
        inside = np.array([_apart(at[own], at[k]) for k in tried])
        off[own] = inside[np.argmin(np.quantile(inside, _GROUP_PART, axis=1))]
    return off


def _apart(inclinations: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.linalg.norm(wrapped(inclinations - other), axis=1)


FRAME_MISTAKES: Mistakes = {
    "order": {"poses in a left-handed frame": _left_handed},
    "row or frame": {
        "poses in another frame": partial(_frames_left_out, ["world"]),
        "poses of another target": partial(_frames_left_out, ["target"]),
    },
    "frames": {
        "poses of another target in another frame": partial(_frames_left_out, ["world", "target"])
    },
    "labels": {"groups wrongly labelled": _wrong_labels},
}
"""What is looked for at each stage (see `mistakes`)."""
