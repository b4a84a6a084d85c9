"""Find mistakes in data: other units, orders and signs of columns, Euler angles, wrong labels.

`RULES` is the table of what is looked for. A rule puts the readings right by a map of their
columns; one loop tries all of a stage from the same geometry, the nominal one, and names those by
which the readings are explained far better. A few mistakes the readings show by themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.data.files import DataFile, euler_quaternions
from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.data.observables import PLATFORM, Observable, written
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.configurations import closed_at, closing_model
from symkin.calibration.estimate.state import readings_at
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.calibration.judge.trials import (
    NO_TRIAL,
    Start,
    Trial,
    begin,
    describe_sequence,
    equal_sequences,
)
from symkin.errors import SymkinError
from symkin.files.euler_columns import SEQUENCES
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import wrapped
from symkin.text import first_of

_EXAMINED_CONFIGURATIONS = 40
"""Configurations that are looked at, spread evenly over the file: enough to see a mistake of all
rows.
"""
_EXPLAINED_SHARE = 0.2
"""Misfit that readings put right have less of, over the size, and over what is left where joints
are those of other rows: factors below one make any misfit smaller, and explain nothing, and a cause
that leaves much is none.
"""
_MAX_SENTENCES = 3
"""Mistakes that are named at most: further ones are likely to follow from these."""
_LENGTH_UNITS = {
    1000.0: "a factor of 1000 too small (m taken for mm?)",
    25.4: "a factor of 25.4 too small (inches taken for mm?)",
    0.001: "a factor of 1000 too large (mm taken for m?)",
    1 / 25.4: "a factor of 25.4 too large (mm taken for inches?)",
}
_ANGLE_UNITS = {
    180 / math.pi: "radians taken for degrees",
    math.pi / 180: "degrees taken for radians",
}
"""Factors that put lengths and angles in another unit right, with what is said of them."""
_REST_SPREAD = 1e-4
"""Joints that spread by less than this share of the size (angles: radians), and of ten times their
value, are at rest.
"""
_USUAL_SPREAD = (3e-3, 1.0)
"""Usual standard deviation of a joint's readings over the size (angles: radians), and the most that
its mean may be: 5 times the upper one.
"""
_ODD_DECADES = 1.2
"""Decades between a joint's readings and the others', from which another unit is tried for it
alone: inches and mm are 1.4 apart.
"""
_MAX_ASSIGNED_JOINTS, _MIN_WHOLE_POSES = 7, 4
"""Joints whose orders are all tried (5040), with more only single exchanges are; and whole poses
from which columns are assigned to joints.
"""
_EXCHANGE_CONFIGURATIONS, _EXCHANGE_GAIN = 16, 0.9
"""Configurations by which exchanges one after the other are judged, and the share below which the
misfit must fall.
"""
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


# --- the table ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Case:
    """What the rules look at: readings of a mechanism, parameters that are unknown frames, and
    Euler angles (n, 3) as they stand with the sequence in which they are read, and whether this was
    sought, so that any other may be meant; and whether a fit took the poses where they stand, so
    that no frame is left out.
    """

    mechanism: Mechanism
    measurements: Measurements
    frames: tuple[str, ...] = ()
    euler: np.ndarray | None = None
    sequence: str = ""
    sought: bool = False
    placed: bool = False

    @staticmethod
    def of(
        mechanism: Mechanism, data: DataFile, sequence: str = "", frames: Sequence[str] = ()
    ) -> Case:
        """Make the case of a file; `sequence` is that of Euler angles whose header names none."""
        named, sought = data.sequence or sequence, data.open_euler is not None
        readings = data.with_sequence(sequence)
        return Case(mechanism, readings, tuple(frames), data.euler, named, sought)

    def start(self) -> Start:
        """Begin a trial of the readings."""
        return begin(self.mechanism, self.measurements, parameters=self.frames or None)

    def trial(self) -> Trial:
        """Try the readings at the nominal geometry."""
        try:
            return self.start().trial
        except SymkinError:
            return NO_TRIAL

    def reading(self, measurements: Measurements) -> Case:
        """Take other readings in place of these."""
        return replace(self, measurements=measurements)

    @property
    def left_by_chance(self) -> float:
        """What is left, as a trial's score, where joints are those of other rows, which explain
        nothing; few rows, or groups alone, whose rows are alike, say nothing of it.
        """
        m = self.measurements
        grouped = all(o.kind == "group" for o, _ in m.channels(self.mechanism))
        if grouped or len(m) < _MIN_WHOLE_POSES:
            return math.inf
        joints = np.random.default_rng(0).permutation(m.joints)
        return self.reading(replace(m, joints=joints)).trial().score

    def subset(self, rows: np.ndarray) -> Case:
        euler = None if self.euler is None else self.euler[rows]
        return replace(self, measurements=self.measurements.subset(rows), euler=euler)

    @property
    def examined(self) -> Case:
        """Some rows, spread over the file, whole groups where there are any."""
        m = self.measurements
        rows = spread_rows(len(m), _EXAMINED_CONFIGURATIONS)
        if m.groups is not None and len(m) > _EXAMINED_CONFIGURATIONS:
            rows = np.flatnonzero(np.isin(m.groups, np.unique(m.groups[rows])))
        return self.subset(rows[: 4 * _EXAMINED_CONFIGURATIONS])

    @property
    def consecutive(self) -> Case:
        """The first rows, so that each stands beside its neighbours."""
        return self.subset(np.arange(min(len(self.measurements), _EXAMINED_CONFIGURATIONS)))

    def is_possible(self, measurements: Measurements) -> bool:
        """Tell whether no reading is below the least of its joint (rods of negative length)."""
        least = [-math.inf if c.least is None else c.least for c in self.mechanism.actuated]
        return bool(np.all(measurements.joints > np.array(least)))

    def angle(self, value: float) -> str:
        return written(self.mechanism, "angle", value, ".3g")


Finding = tuple[str, Case | None]
"""A sentence on a mistake, and the case put right by which it is judged; None where the readings
alone show it.
"""


@dataclass(frozen=True)
class Rule:
    """A mistake that is looked for: `find` yields its possible forms in a case. The stage says when
    it is asked: "readings", "correction" and "order" where those before them found nothing;
    "position", whose orientations may be read wrongly besides, unless an order was found; "row or
    frame" of consecutive rows, and "frames", where nothing was; "labels" by themselves.
    """

    mistake: str
    stage: str
    find: Callable[[Case], Iterable[Finding]]


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
    judged: list[Finding] = []
    for rule in (rule for rule in RULES if rule.stage == stage):
        judged += rule.find(case)
        if shown := [text for text, changed in judged if changed is None]:
            return shown
    if not judged:
        return []
    as_read, unit = case.trial(), case.mechanism.length_unit
    most = _EXPLAINED_SHARE * case.mechanism.characteristic_length
    tried: dict[str, tuple[Trial, Case]] = {}
    trials = ((right.trial(), text, right) for text, right in judged if right is not None)
    for trial, text, right in sorted(trials, key=lambda t: t[0].score):
        tried.setdefault(text, (trial, right))
    return [
        f"{text}: the misfit at the nominal geometry would fall from {as_read.score**0.5:.3g} to "
        f"{trial.score**0.5:.3g} {unit} (angles times the size)"
        for text, (trial, right) in tried.items()
        if trial.better_than(as_read) and trial.score**0.5 < most
        if trial.score < _EXPLAINED_SHARE**2 * right.left_by_chance
    ]


# --- columns, and what is done to them ------------------------------------------------------------


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

    def times(self, factor: float, columns: Sequence[int]) -> np.ndarray:
        """Multiply some columns."""
        return self.values * np.where(np.isin(np.arange(len(self.names)), columns), factor, 1.0)

    def listed(self, columns: Sequence[int]) -> str:
        return ", ".join(self.names[k] for k in columns)


Changes = Iterator[tuple[str, np.ndarray]]
"""Sentences and the numbers put right."""


def _exchanged(block: Block) -> Changes:
    for a, b in combinations(block.columns, 2):
        if block.angular[a] == block.angular[b]:
            order = np.arange(len(block.names))
            order[[a, b]] = b, a
            text = f"the columns {block.names[a]} and {block.names[b]} look exchanged"
            yield text, block.values[:, order]


def _turned_round(block: Block) -> Changes:
    """Three columns and more in another order."""
    for order in permutations(block.columns):
        if np.sum(np.not_equal(order, block.columns)) > 2:
            values, names = np.array(block.values), block.listed(block.columns)
            values[:, block.columns] = values[:, order]
            seem = f"{names} seem to stand in {block.listed(order)}"
            yield f"the columns {names} look exchanged: {seem}", values


def _reversed(block: Block) -> Changes:
    for k in block.columns:
        yield f"the sign of {block.names[k]} looks reversed", block.times(-1.0, [k])


def _all_reversed(block: Block) -> Changes:
    if len(block.columns) > 1:
        yield f"the signs of {block.listed(block.columns)} look reversed", -block.values


def _in_another_unit(block: Block, least: float = 0.0) -> Changes:
    called = block.called or f"the readings of {block.listed(block.columns)}"
    units = _ANGLE_UNITS if block.angular[block.columns[0]] else _LENGTH_UNITS
    for factor, text in units.items():
        if factor > least:
            yield f"{called} look {text}", block.times(factor, block.columns)


def _in_larger_unit(block: Block) -> Changes:
    """Radians, which spread as degrees may, metres or inches. Of other units the spread tells; and
    factors below one make any misfit smaller.
    """
    yield from _in_another_unit(block, least=1.0)


def _one_in_larger_unit(block: Block) -> Changes:
    """Each of several columns by itself."""
    for k in block.columns if len(block.columns) > 1 else ():
        yield from _in_larger_unit(replace(block, columns=[k], called=""))


def _joints(case: Case) -> Iterator[Block]:
    m, read = case.measurements, case.mechanism.actuated
    names, angular = [c.name for c in read], [c.is_angular for c in read]
    put = lambda values: m.replaced("joint", values=values)  # noqa: E731
    yield Block(names, angular, m.joints, put, range(len(read)))


def _a_row_off(block: Block) -> Changes:
    """Joints that stand a row later or earlier than the rest: the row that has none counts as bad
    in any case.
    """
    for rows, how in ((-1, "late"), (1, "early")):
        text = f"the joint readings look one row {how} against the rest (a logger's lag?)"
        yield text, np.roll(block.values, rows, axis=0)


def _kinds_of_joints(case: Case) -> Iterator[Block]:
    """The joints that are lengths, and those that are angles."""
    (block,) = _joints(case)
    for angular in (False, True):
        if columns := [k for k, its in enumerate(block.angular) if its == angular]:
            yield replace(block, columns=columns)


def _angles_of_joints(case: Case) -> Iterator[Block]:
    return (block for block in _kinds_of_joints(case) if block.angular[block.columns[0]])


def _odd_lengths(case: Case) -> Iterator[Block]:
    """Joints that are lengths whose readings spread, and are, far more or less than the others'."""
    (block,) = _joints(case)
    columns = [k for k, angular in enumerate(block.angular) if not angular]
    yield from _odd(block, columns) if len(columns) > 2 else ()


def _odd_positions(case: Case) -> Iterator[Block]:
    """Columns of positions that do."""
    for block in _positions(case):
        yield from _odd(replace(block, called=""), block.columns)


def _odd(block: Block, columns: Sequence[int]) -> Iterator[Block]:
    values = block.values[:, columns]
    sizes = np.array([np.nanstd(values, axis=0), np.sqrt(np.nanmean(values**2, axis=0))])
    decades = np.log10(np.maximum(sizes, 1e-300))
    for place, k in enumerate(columns if len(columns) > 1 else ()):
        others = np.median(np.delete(decades, place, axis=1), axis=1)
        if np.all(np.abs(decades[:, place] - others) > _ODD_DECADES):
            yield replace(block, columns=[k])


def _taken(case: Case, is_meant: Callable[[Observable], bool], called: str = "") -> Iterator[Block]:
    """What was read beside the joints and is meant, together: those columns that hold numbers."""
    m = case.measurements
    read = [(o, r) for o, r in m.channels(case.mechanism) if is_meant(o)]
    if not read:
        return
    tables = [r.values for _, r in read]
    values, ends = np.hstack(tables), np.cumsum([table.shape[1] for table in tables])[:-1]

    def put(values: np.ndarray) -> Measurements:
        made = m
        for (o, _), part in zip(read, np.hsplit(values, ends), strict=True):
            made = made.replaced(o.key, by_name=o.by_name, values=part)
        return made

    names, angular = zip(*((name, o.angular) for o, _ in read for name in o.columns), strict=True)
    held = np.flatnonzero(np.any(np.isfinite(values), axis=0)).tolist()
    yield Block(names, angular, values, put, held, called)


_positions = partial(_taken, is_meant=PLATFORM["position"].__eq__, called="the positions")
_orientations = partial(_taken, is_meant=PLATFORM["orientation"].__eq__)
_inclinations = partial(_taken, is_meant=PLATFORM["inclination"].__eq__)
_distances = partial(_taken, is_meant=lambda o: bool(o.ends), called="the distances")
_encoders = partial(_taken, is_meant=lambda o: o.kind == "joint")
"""Of the platform, between it and the base, and of passive joints, together."""


def _readings(case: Case) -> Iterator[Block]:
    """Readings of passive joints, points, distances and links, one by one."""
    for o, _ in case.measurements.channels(case.mechanism):
        if o.of and o.kind != "orientation":
            yield from _taken(case, o.__eq__, f"the readings of {o.name}")


def _quaternions(case: Case) -> Iterator[Block]:
    """Orientations that do not stand as Euler angles in the file."""
    return iter(()) if case.euler is not None else _orientations(case)


def _euler(case: Case) -> Iterator[Block]:
    m, sequence = case.measurements, case.sequence

    def put(angles: np.ndarray) -> Measurements:
        return replace(m, orientation=euler_quaternions(angles, sequence))

    if case.euler is not None and sequence:
        yield Block(sequence, [True] * 3, case.euler, put, range(3), "the Euler angles")


def _euler_of_any_sequence(case: Case) -> Iterator[Block]:
    """Euler angles in the sequence named; where none was, in each that differs: in a wrong unit all
    fit badly, and which fits least badly says nothing.
    """
    for sequence in SEQUENCES if case.sought else [case.sequence]:
        yield from _euler(replace(case, sequence=sequence))


def _find(
    blocks: Callable[[Case], Iterator[Block]], change: Callable[[Block], Changes], case: Case
) -> Iterator[Finding]:
    for block in blocks(case):
        for text, values in change(block):
            if case.is_possible(put_right := block.put(values)):
                yield text, case.reading(put_right)


# --- orientations ---------------------------------------------------------------------------------


def _inverted(block: Block) -> Changes:
    inverse = block.values * (1.0, -1.0, -1.0, -1.0)
    yield "the orientations look inverted (base seen from the platform)", inverse


def _scalar_last(block: Block) -> Changes:
    yield "qw looks to stand last, not first", np.roll(block.values, 1, axis=1)


def _other_sequences(case: Case) -> Iterator[Finding]:
    for block in _euler(case):
        for names in equal_sequences(block.values):
            if case.sequence not in names:
                read = _euler(replace(case, sequence=names[0]))
                text = (
                    f"the Euler angles look to be of another sequence than {case.sequence}, in "
                    f"which they are read: {describe_sequence(names[0])} fits"
                )
                yield text, case.reading(next(read).put(block.values))


# --- frames ---------------------------------------------------------------------------------------


def _left_handed(case: Case) -> Iterator[Finding]:
    """Poses in a frame of which one axis is reversed, or two are exchanged."""
    m = case.measurements
    if m.position is None or m.orientation is None:
        return
    turns = [np.diag(1.0 - 2.0 * np.eye(3)[k]) for k in range(3)]
    swaps = [np.eye(3)[[*order]] for order in ((1, 0, 2), (2, 1, 0), (0, 2, 1))]
    said = [f"{k} reversed" for k in "xyz"] + ["x and y exchanged", "x and z exchanged"]
    for mirror, how in zip([*turns, *swaps], [*said, "y and z exchanged"], strict=True):
        axis = -m.orientation[:, 1:] @ mirror  # of a rotation: its sense is reversed, too
        right = replace(
            m, position=m.position @ mirror, orientation=np.hstack([m.orientation[:, :1], axis])
        )
        text = f"the poses look to stand in a left-handed frame ({how}, of orientations too)"
        yield text, case.reading(right)


_ELSEWHERE = {
    "world": "measured in a frame that stands elsewhere than the mechanism's base",
    "target": "those of a target that is mounted elsewhere than the platform's frame",
}
"""What is said of poses from which a measuring frame is left out."""


def _frames_left_out(case: Case, left_out: Sequence[str]) -> Iterator[Finding]:
    """Measuring frames that are not among the parameters, and no others, put where they fit."""
    m, held = case.measurements, {name.partition(".")[0] for name in case.frames}
    unseen = m.position is None or len(m) < _MIN_WHOLE_POSES
    if unseen or case.placed or held & {*left_out}:
        return
    names = [name for name in MEASURING_FRAMES if name.partition(".")[0] in left_out]
    what = " and ".join(_ELSEWHERE[frame] for frame in left_out)
    patterns = ",".join(f"{frame}.*" for frame in left_out)
    text = f"the poses look to be {what}, which --parameters all,{patterns} would find"
    yield text, replace(case, frames=(*case.frames, *names))


# --- what the readings alone show -----------------------------------------------------------------


def _joints_at_rest(case: Case) -> Iterator[Finding]:
    """Every joint stays where it is but for noise: its spread is nothing beside the size and, of a
    length, which may be in another unit, beside its value.
    """
    m, said = case.mechanism, []
    for block in _kinds_of_joints(case):
        values, angular = block.values[:, block.columns], block.angular[block.columns[0]]
        spread, mean = np.std(values, axis=0), np.abs(np.mean(values, axis=0))
        most = 1.0 if angular else np.minimum(m.characteristic_length, 10.0 * mean)
        if len(values) < 2 or not np.all(spread <= _REST_SPREAD * most):
            return
        widest = np.max(spread)
        said.append(case.angle(widest) if angular else f"{widest:.3g} {m.length_unit}")
    yield (
        f"the posture never changes: the joint readings spread by {' and '.join(said)} only; one "
        f"posture determines no geometry, measure many that differ",
        None,
    )


def _units_of_all_joints(case: Case) -> Iterator[Finding]:
    """Joint readings whose spread or mean is out of all proportion, by a decade or more, and would
    not be in other units.
    """
    for block in _kinds_of_joints(case):
        one, of = case.mechanism.characteristic_length, "of the mechanism's size"
        if block.angular[block.columns[0]]:
            one, of = 1.0, "rad"
        as_read, spread = _out_of_proportion(block.values[:, block.columns] / one)
        left = {
            text: _out_of_proportion(values[:, block.columns] / one)[0]
            for text, values in _in_another_unit(block)
        }
        best = min(left, key=left.__getitem__)
        if as_read - left[best] >= 1.0:
            yield f"{best}: they spread by {spread:.2g} {of}", None


def _out_of_proportion(values: np.ndarray) -> tuple[float, float]:
    """Decades by which the spread lies outside its usual range, or the mean above it, none where a
    joint does not move; and the spread.
    """
    spread = np.median(np.std(values, axis=0))
    mean = np.median(np.abs(np.mean(values, axis=0)))
    low, high = _USUAL_SPREAD
    if np.any(np.ptp(values, axis=0) == 0.0):
        return 0.0, spread
    return math.log10(max(1.0, low / spread, spread / high, mean / (5 * high))), spread


# --- the order of joint columns -------------------------------------------------------------------


def _reordered_joints(case: Case) -> Iterator[Finding]:
    """The order and signs of the joint columns that explain the readings. Where whole poses were
    measured, each limb of a parallel mechanism has a joint value of its own at each pose (the
    inverse problem at the nominal geometry), and the columns are assigned to the limbs that they
    fit best. Elsewhere exchanges and signs are taken one after the other.
    """
    (block,), m = _joints(case), case.measurements
    poses = np.isfinite(m.poses[:, 0])
    by_poses = not case.mechanism.serial and len(block.names) <= _MAX_ASSIGNED_JOINTS
    if by_poses and sum(poses) >= _MIN_WHOLE_POSES:
        holds = _assigned_columns(case.subset(np.array(poses)), block)
    else:
        holds = _exchanged_in_turn(case, block)
    order, signs = np.abs(holds).astype(int) - 1, np.sign(holds)
    put_right = block.put(signs * m.joints[:, order])
    text = _describe_order(block.names, order, signs)
    if text and case.is_possible(put_right):
        yield text, case.reading(put_right)


def _assigned_columns(case: Case, block: Block) -> np.ndarray:
    """For each joint the column (from 1, with its sign) that fits its values at the measured poses
    best, each column once.
    """
    angular = np.array(block.angular)
    closing, points, reached = closed_at(closing_model(case.mechanism), case.measurements.poses)
    values = closing.split(points)[1]
    if not reached.any():
        return np.arange(1, len(angular) + 1)
    read = np.multiply.outer([1.0, -1.0], case.measurements.joints[reached].T)
    gap = read[:, None] - values[reached].T[:, None]  # signs, joints, columns, configurations
    gap = np.where(angular[:, None, None], wrapped(gap), gap)
    off = np.apply_along_axis(rms_of_better_part, -1, gap**2)
    cost = np.where(angular[:, None] == angular, off**2, np.inf)
    each, orders = np.arange(len(angular)), np.array([*permutations(range(len(angular)))])
    order = orders[np.argmin(np.sum(np.min(cost, axis=0)[each, orders], axis=1))]
    signs = 1 - 2 * np.argmin(cost, axis=0)[each, order]
    return signs * (order + 1)


def _exchanged_in_turn(case: Case, block: Block) -> np.ndarray:
    """The same by exchanges of two columns and changes of one sign, the best first, while the
    misfit falls.
    """
    some = case.subset(spread_rows(len(case.measurements), _EXCHANGE_CONFIGURATIONS))
    (few,) = _joints(some)

    def score(holds: np.ndarray) -> float:
        changed = few.put(np.sign(holds) * few.values[:, np.abs(holds).astype(int) - 1])
        return some.reading(changed).trial().score if case.is_possible(changed) else math.inf

    holds = np.arange(1.0, len(block.names) + 1)
    least = score(holds)
    for _ in block.names:
        now = replace(block, values=holds[None])
        trials = [row[0] for change in (_exchanged, _reversed) for _, row in change(now)]
        value, best = min(((score(t), k) for k, t in enumerate(trials)), default=(math.inf, 0))
        if not value < _EXCHANGE_GAIN**2 * least:
            break
        holds, least = trials[best], value
    return holds


def _describe_order(names: Sequence[str], order: np.ndarray, signs: np.ndarray) -> str:
    """'the columns a, b, c look exchanged: they seem to hold b, c, a; the sign of d looks
    reversed'; nothing where all stand as they should.
    """
    holds = np.argsort(order)  # column order[j] holds joint j
    parts = []
    if moved := [k for k, held in enumerate(holds) if held != k]:
        parts.append(
            f"the columns {', '.join(names[k] for k in moved)} look exchanged: they seem to hold "
            f"{', '.join(names[holds[k]] for k in moved)}"
        )
    if turned := [names[k] for k, sign in zip(order, signs, strict=True) if sign < 0]:
        several = len(turned) > 1
        parts.append(
            f"the sign{'s' * several} of {', '.join(turned)} look{'s' * (not several)} reversed"
        )
    return "; ".join(parts)


# --- labels of groups -----------------------------------------------------------------------------


def _wrong_labels(case: Case) -> Iterator[Finding]:
    """Inclinations at the nominal geometry show labels that have nothing to do with them, two
    groups under one label, or configurations in a wrong group.
    """
    try:
        start = case.start()
    except SymkinError:
        return
    problem, m = start.problem, start.problem.measurements
    group = np.where(start.solved, problem.readings.group, -1)
    numbers, counts = np.unique(group[group >= 0], return_counts=True)
    members = np.flatnonzero(np.isin(group, numbers[counts >= _MIN_GROUP_SIZE]))
    if len(members) <= _COMPARED_NEIGHBOURS:
        return
    readings = readings_at(problem, start.p, np.nan_to_num(start.z))
    at, group = readings[members][:, problem.readings.columns], group[members]
    off = np.zeros(len(at))
    for number in np.unique(group):
        own = np.flatnonzero(group == number)
        tried = own[spread_rows(len(own), _EXAMINED_CONFIGURATIONS)]
        inside = np.array([_apart(at[own], at[k]) for k in tried])
        # the member that a good part of the others is nearest to: a mean of two groups is in none
        off[own] = inside[np.argmin(np.quantile(inside, _GROUP_PART, axis=1))]
    k = _COMPARED_NEIGHBOURS
    near = np.median([np.partition(_apart(at, row), k)[k] for row in at])
    usual = np.median(off)
    out = np.flatnonzero(off > _OUTSTANDING_RATIO * usual)
    rest = np.setdiff1d(np.flatnonzero(np.isin(group, group[out])), out)
    named, others = (first_of(m.named(members[rows])) for rows in (out, rest))
    most, half = case.angle(np.max(off, initial=0.0)), "at the nominal geometry half of the"
    tail = f"from the others of the group; {half} postures are within {case.angle(usual)}"
    if usual > _SCATTER_RATIO * near:
        yield (
            f"the groups look wrongly labelled: {half} postures are more than {case.angle(usual)} "
            f"from the inclination of their group, and half have {_COMPARED_NEIGHBOURS} postures "
            f"of any group within {case.angle(near)}",
            None,
        )
    elif len(out) == 1:
        yield f"posture {named} looks to be in the wrong group, inclined by {most} {tail}", None
    elif len(out) and np.all(
        (group[out] == group[out[0]]) & (_apart(at[out], at[out[0]]) < 0.5 * np.min(off[out]))
    ):
        yield (
            f"the group of posture {named} looks to be two groups under one label, inclined by "
            f"{most} against {others}; {half} postures are within {case.angle(usual)} of their "
            f"group",
            None,
        )
    elif len(out):
        yield f"posture {named} look to be in wrong groups, inclined by up to {most} {tail}", None


def _apart(inclinations: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.linalg.norm(wrapped(inclinations - other), axis=1)


RULES = (
    Rule("the joints never move", "readings", _joints_at_rest),
    Rule("all joints of a kind in another unit", "readings", _units_of_all_joints),
    *(
        Rule(mistake, stage, partial(_find, blocks, change))
        for mistake, stage, blocks, change in (
            ("one joint in another unit", "correction", _odd_lengths, _in_another_unit),
            ("two joint columns exchanged", "correction", _joints, _exchanged),
            ("the sign of a joint reversed", "correction", _joints, _reversed),
            ("the signs of all joints reversed", "correction", _joints, _all_reversed),
            ("angles of joints in radians", "correction", _angles_of_joints, _in_larger_unit),
            ("one joint in radians", "correction", _angles_of_joints, _one_in_larger_unit),
            ("positions in another unit", "correction", _positions, _in_another_unit),
            ("distances in another unit", "correction", _distances, _in_another_unit),
            (
                "Euler angles in another unit",
                "correction",
                _euler_of_any_sequence,
                _in_another_unit,
            ),
            ("the sign of an encoder reversed", "correction", _encoders, _reversed),
            ("two encoders exchanged", "correction", _encoders, _exchanged),
            ("a reading in another unit", "correction", _readings, _in_another_unit),
            ("alpha and beta exchanged", "correction", _inclinations, _exchanged),
            ("orientations of the base in the platform", "correction", _orientations, _inverted),
            ("quaternions with their scalar last", "correction", _quaternions, _scalar_last),
            ("two position columns exchanged", "position", _positions, _exchanged),
            ("position columns in another order", "position", _positions, _turned_round),
            ("the sign of a position column reversed", "position", _positions, _reversed),
            ("one position column in metres", "position", _positions, _one_in_larger_unit),
            ("one position column in millimetres", "position", _odd_positions, _in_another_unit),
        )
    ),
    Rule("Euler angles of another sequence", "correction", _other_sequences),
    Rule("joint columns in another order, with other signs", "order", _reordered_joints),
    Rule("poses in a left-handed frame", "order", _left_handed),
    Rule("joints a row off", "row or frame", partial(_find, _joints, _a_row_off)),
    *(
        Rule(mistake, stage, partial(_frames_left_out, left_out=frames))
        for mistake, stage, frames in (
            ("poses in another frame", "row or frame", ["world"]),
            ("poses of another target", "row or frame", ["target"]),
            ("poses of another target in another frame", "frames", ["world", "target"]),
        )
    ),
    Rule("groups wrongly labelled", "labels", _wrong_labels),
)
"""The mistakes that are looked for, in the order in which those that the readings alone show
are.
"""
