"""Choose columns of a file that are of one kind, with how other numbers are put in their place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symkin.calibration.data.files import euler_quaternions
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import PLATFORM, Observable
from symkin.calibration.judge.case import Case
from symkin.files.euler_columns import SEQUENCES

_ODD_DECADES = 1.2
"""Decades between a joint's readings and the others', from which another unit is tried for it
alone: inches and mm are 1.4 apart.
"""


@dataclass(frozen=True, eq=False)
class Block:
    """Numbers (n, w) of one kind, with their names and which of them are angles; how others are put
    in their place; which columns are meant, and what these are called.
    """

    names: Sequence[str]
    angular: Sequence[bool]
    values: np.ndarray
    put: Callable[[np.ndarray], Measurements]
    columns: Sequence[int]
    called: str = ""
    is_odd: bool = False

    @property
    def turns(self) -> bool:
        """Whether the columns that are meant are angles."""
        return self.angular[self.columns[0]]

    @property
    def own(self) -> np.ndarray:
        """The columns that are meant (n, k)."""
        return self.values[:, self.columns]

    def times(self, factor: float, columns: Sequence[int]) -> np.ndarray:
        """Multiply some columns."""
        return self.values * np.where(np.isin(np.arange(len(self.names)), columns), factor, 1.0)

    def listed(self, columns: Iterable[int]) -> str:
        return ", ".join(self.names[k] for k in columns)


Blocks = Callable[[Case], Iterator[Block]]


def joint_columns(case: Case) -> Iterator[Block]:
    m, read = case.measurements, case.mechanism.actuated
    names, angular = [c.name for c in read], [c.is_angular for c in read]
    put = partial(m.replaced, "joint")
    yield Block(names, angular, m.joints, lambda values: put(values=values), range(len(read)))


def joint_columns_by_kind(case: Case) -> Iterator[Block]:
    """The joints that are lengths, and those that are angles."""
    (block,) = joint_columns(case)
    for angular in (False, True):
        if columns := [k for k, its in enumerate(block.angular) if its == angular]:
            yield replace(block, columns=columns)


def joint_angles(case: Case) -> Iterator[Block]:
    return (block for block in joint_columns_by_kind(case) if block.turns)


def odd_joints(case: Case) -> Iterator[Block]:
    """Joints whose readings spread, and are, far more or less than the others' of their kind."""
    for block in joint_columns_by_kind(case):
        yield from _odd(block) if len(block.columns) > 2 else ()


def odd_positions(case: Case) -> Iterator[Block]:
    """Columns of positions that do."""
    for block in positions(case):
        yield from _odd(replace(block, called=""))


def _odd(block: Block) -> Iterator[Block]:
    sizes = np.array([np.nanstd(block.own, axis=0), np.sqrt(np.nanmean(block.own**2, axis=0))])
    decades = np.log10(np.maximum(sizes, 1e-300))
    for place, k in enumerate(block.columns if len(block.columns) > 1 else ()):
        others = np.median(np.delete(decades, place, axis=1), axis=1)
        if np.all(np.abs(decades[:, place] - others) > _ODD_DECADES):
            yield replace(block, columns=[k], is_odd=True)


def _taken(case: Case, is_meant: Callable[[Observable], bool], called: str = "") -> Iterator[Block]:
    """What was read beside the joints and is meant, together: those columns that hold numbers."""
    m = case.measurements
    read = [(o, r) for o, r in m.channels(case.mechanism) if is_meant(o)]
    if not read:
        return
    values = np.hstack([r.values for _, r in read])
    ends = np.cumsum([len(o.columns) for o, _ in read])[:-1]

    def put(values: np.ndarray) -> Measurements:
        made = m
        for (o, _), part in zip(read, np.hsplit(values, ends), strict=True):
            made = made.replaced(o.key, by_name=o.by_name, values=part)
        return made

    names, angular = zip(*((name, o.angular) for o, _ in read for name in o.columns), strict=True)
    held = np.flatnonzero(np.isfinite(values).any(axis=0)).tolist()
    yield Block(names, angular, values, put, held, called)


positions = partial(_taken, is_meant=PLATFORM["position"].__eq__, called="the positions")
orientations = partial(_taken, is_meant=PLATFORM["orientation"].__eq__)
inclinations = partial(_taken, is_meant=PLATFORM["inclination"].__eq__)
distances = partial(_taken, is_meant=lambda o: bool(o.ends), called="the distances")
encoders = partial(_taken, is_meant=lambda o: o.kind == "joint")
_SIGNED = ("joint", "point", "inclination", "position")
signed_readings = partial(
    _taken, is_meant=lambda o: o.kind in _SIGNED and o is not PLATFORM["position"]
)
"""Of the platform, between it and the base, of passive joints, and what has signs but the place of
the platform, together.
"""


def other_readings(case: Case) -> Iterator[Block]:
    """Readings of passive joints, points, distances and links, one by one."""
    for o, _ in case.measurements.channels(case.mechanism):
        if o.of and o.kind != "orientation":
            yield from _taken(case, o.__eq__, f"the readings of {o.name}")


def quaternions(case: Case) -> Iterator[Block]:
    """Orientations that do not stand as Euler angles in the file."""
    return iter(()) if case.euler is not None else orientations(case)


def euler_angles(case: Case) -> Iterator[Block]:
    m, sequence = case.measurements, case.sequence

    def put(angles: np.ndarray) -> Measurements:
        return replace(m, orientation=euler_quaternions(angles, sequence))

    if case.euler is not None and sequence:
        yield Block(sequence, [True] * 3, case.euler, put, range(3), "the Euler angles")


def euler_angles_of_any_sequence(case: Case) -> Iterator[Block]:
    """Euler angles in the sequence named; where none was, in each that differs: in a wrong unit all
    fit badly, and which fits least badly says nothing.
    """
    for sequence in SEQUENCES if case.sought else [case.sequence]:
        yield from euler_angles(replace(case, sequence=sequence))
