"""Mistakes in the columns of a file, with their sentences: other units, orders and signs, Euler
angles and quaternions; and what the joints' columns show by themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.data.observables import written
from symkin.calibration.estimate.configurations import closed_at, closing_model
from symkin.calibration.judge.case import MIN_WHOLE_POSES, Case, Finding, Mistakes
from symkin.calibration.judge.column_blocks import (
    Block,
    Blocks,
    distances,
    encoders,
    euler_angles,
    euler_angles_of_any_sequence,
    inclinations,
    joint_angles,
    joint_columns,
    joint_columns_by_kind,
    odd_joints,
    odd_positions,
    orientations,
    other_readings,
    positions,
    quaternions,
    signed_readings,
)
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.calibration.judge.trials import describe_sequence, equal_sequences
from symkin.spatial.rotation import wrapped

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
_SLIPS = {
    1000.0: "a factor of 1000 too small",
    0.001: "a factor of 1000 too large (mrad taken for rad?)",
}
"""Factors that put lengths and angles in another unit right, with what is said of them; and an
angle alone, whose readings spread otherwise than the others'.
"""
_REST_SPREAD = 1e-4
"""Joints that spread by less than this share of the size (angles: radians), and of ten times their
value, are at rest.
"""
_USUAL_SPREAD = (3e-3, 1.0)
"""Usual standard deviation of a joint's readings over the size (angles: radians), and the most that
its mean may be: 5 times the upper one.
"""
_MAX_ASSIGNED_JOINTS = 7
"""Joints whose orders are all tried (5040); with more only single exchanges are."""
_EXCHANGE_CONFIGURATIONS, _EXCHANGE_GAIN = 16, 0.9
"""Configurations by which exchanges one after the other are judged, and the share below which the
misfit must fall.
"""
Changes = Iterator[tuple[str, np.ndarray]]
"""Sentences and the numbers put right."""


def _put_right(blocks: Blocks, change: Callable[[Block], Changes], case: Case) -> Iterator[Finding]:
    """Yield what a change of some columns would put right, where such joints can be."""
    for block in blocks(case):
        for text, values in change(block):
            if case.is_possible(made := block.put(values)):
                yield text, case.reading(made)


# --- what is done to them -------------------------------------------------------------------------


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
        if np.not_equal(order, block.columns).sum() > 2:
            values, names = np.array(block.values), block.listed(block.columns)
            values[:, block.columns] = values[:, order]
            seem = f"{names} seem to stand in {block.listed(order)}"
            yield f"the columns {names} look exchanged: {seem}", values


def _reversed_one(block: Block) -> Changes:
    for k in block.columns:
        yield f"the sign of {block.names[k]} looks reversed", block.times(-1.0, [k])


def _all_reversed(block: Block) -> Changes:
    if len(block.columns) > 1:
        yield f"the signs of {block.listed(block.columns)} look reversed", -block.values


def _in_another_unit(block: Block, least: float = 0.0) -> Changes:
    called = block.called or f"the readings of {block.listed(block.columns)}"
    units = _ANGLE_UNITS if block.turns else _LENGTH_UNITS
    if block.turns and block.is_odd:
        units = units | _SLIPS
    for factor, text in units.items():
        if factor > least:
            yield f"{called} look {text}", block.times(factor, block.columns)


_in_larger_unit = partial(_in_another_unit, least=1.0)
"""Radians, which spread as degrees may, metres or inches. Of other units the spread tells; and
factors below one make any misfit smaller.
"""


def _one_in_larger_unit(block: Block) -> Changes:
    """Each of several columns by itself."""
    for k in block.columns if len(block.columns) > 1 else ():
        yield from _in_larger_unit(replace(block, columns=[k], called=""))


def _a_row_off(block: Block) -> Changes:
    """Joints that stand a row later or earlier than the rest: the row that has none counts as bad
    in any case.
    """
    for rows, how in ((-1, "late"), (1, "early")):
        text = f"the joint readings look one row {how} against the rest (a logger's lag?)"
        yield text, np.roll(block.values, rows, axis=0)


def _inverted(block: Block) -> Changes:
    inverse = block.values * (1.0, -1.0, -1.0, -1.0)
    yield "the orientations look inverted (base seen from the platform)", inverse


def _scalar_last(block: Block) -> Changes:
    yield "qw looks to stand last, not first", np.roll(block.values, 1, axis=1)


def _other_sequences(case: Case) -> Iterator[Finding]:
    for block in euler_angles(case):
        for first, *same in equal_sequences(block.values):
            if case.sequence not in (first, *same):
                text = (
                    f"the Euler angles look to be of another sequence than {case.sequence}, in "
                    f"which they are read: {describe_sequence(first)} fits"
                )
                read = next(euler_angles(replace(case, sequence=first)))
                yield text, case.reading(read.put(block.values))


# --- what the readings alone show -----------------------------------------------------------------


def _joints_at_rest(case: Case) -> Iterator[Finding]:
    """Every joint stays where it is but for noise: its spread is nothing beside the size and, of a
    length, which may be in another unit, beside its value.
    """
    m, said = case.mechanism, []
    for block in joint_columns_by_kind(case):
        spread, mean = block.own.std(axis=0), np.abs(block.own.mean(axis=0))
        most = 1.0 if block.turns else np.minimum(m.characteristic_length, 10.0 * mean)
        if len(block.own) < 2 or not np.all(spread <= _REST_SPREAD * most):
            return
        said.append(written(m, "angle" if block.turns else "length", spread.max(), ".3g"))
    yield (
        f"the posture never changes: the joint readings spread by {' and '.join(said)} only; one "
        f"posture determines no geometry, measure many that differ",
        None,
    )


def _units_of_all_joints(case: Case) -> Iterator[Finding]:
    """Joint readings whose spread or mean is out of all proportion, by a decade or more, and would
    not be in other units.
    """
    for block in joint_columns_by_kind(case):
        one, of = case.mechanism.characteristic_length, "of the mechanism's size"
        if block.turns:
            one, of = 1.0, "rad"
        as_read, spread = _out_of_proportion(block.own / one)
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
    spread = np.median(values.std(axis=0))
    mean = np.median(np.abs(values.mean(axis=0)))
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
    (block,), poses = joint_columns(case), np.isfinite(case.measurements.poses[:, 0])
    by_poses = not case.mechanism.serial and len(block.names) <= _MAX_ASSIGNED_JOINTS
    if by_poses and sum(poses) >= MIN_WHOLE_POSES:
        holds = _assigned_columns(case.subset(poses), block)
    else:
        holds = _exchanged_in_turn(case, block)
    made = block.put(_with_columns(block.values, holds))
    text = _describe_order(block, holds)
    if text and case.is_possible(made):
        yield text, case.reading(made)


def _with_columns(values: np.ndarray, holds: np.ndarray) -> np.ndarray:
    """Values of the columns (from 1, with their signs) that stand for each joint."""
    return np.sign(holds) * values[:, np.abs(holds).astype(int) - 1]


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
    order = orders[np.argmin(cost.min(axis=0)[each, orders].sum(axis=1))]
    signs = 1 - 2 * cost.argmin(axis=0)[each, order]
    return signs * (order + 1)


def _exchanged_in_turn(case: Case, block: Block) -> np.ndarray:
    """The same by exchanges of two columns and changes of one sign, the best first, while the
    misfit falls.
    """
    some = case.subset(spread_rows(len(case.measurements), _EXCHANGE_CONFIGURATIONS))
    (few,) = joint_columns(some)

    def score(holds: np.ndarray) -> float:
        changed = few.put(_with_columns(few.values, holds))
        return some.reading(changed).trial().score if case.is_possible(changed) else math.inf

    holds = np.arange(1.0, len(block.names) + 1)
    least = score(holds)
    for _ in block.names:
        now = replace(block, values=holds[None])
        trials = [row[0] for change in (_exchanged, _reversed_one) for _, row in change(now)]
        value, best = min(((score(t), k) for k, t in enumerate(trials)), default=(math.inf, 0))
        if not value < _EXCHANGE_GAIN**2 * least:
            break
        holds, least = trials[best], value
    return holds


def _describe_order(block: Block, holds: np.ndarray) -> str:
    """'the columns a, b, c look exchanged: they seem to hold b, c, a; the sign of d looks
    reversed'; nothing where all stand as they should.
    """
    order = np.abs(holds).astype(int) - 1
    held, parts = np.argsort(order), []  # column order[j] holds joint j
    if len(moved := np.flatnonzero(held != np.arange(len(held)))):
        parts.append(
            f"the columns {block.listed(moved)} look exchanged: they seem to hold "
            f"{block.listed(held[moved])}"
        )
    if len(turned := order[holds < 0]):
        several = len(turned) > 1
        parts.append(
            f"the sign{'s' * several} of {block.listed(turned)} look{'s' * (not several)} reversed"
        )
    return "; ".join(parts)


# --- the table ------------------------------------------------------------------------------------


_rule = partial(partial, _put_right)
"""Which columns, and what puts them right."""
COLUMN_MISTAKES: Mistakes = {
    "readings": {
        "the joints never move": _joints_at_rest,
        "all joints of a kind in another unit": _units_of_all_joints,
    },
    "correction": {
        "one joint in another unit": _rule(odd_joints, _in_another_unit),
        "two joint columns exchanged": _rule(joint_columns, _exchanged),
        "the sign of a joint reversed": _rule(joint_columns, _reversed_one),
        "the signs of all joints reversed": _rule(joint_columns, _all_reversed),
        "angles of joints in radians": _rule(joint_angles, _in_larger_unit),
        "one joint in radians": _rule(joint_angles, _one_in_larger_unit),
        "positions in another unit": _rule(positions, _in_another_unit),
        "distances in another unit": _rule(distances, _in_another_unit),
        "Euler angles in another unit": _rule(euler_angles_of_any_sequence, _in_another_unit),
        "the sign of a reading reversed": _rule(signed_readings, _reversed_one),
        "two encoders exchanged": _rule(encoders, _exchanged),
        "a reading in another unit": _rule(other_readings, _in_another_unit),
        "alpha and beta exchanged": _rule(inclinations, _exchanged),
        "orientations of the base in the platform": _rule(orientations, _inverted),
        "quaternions with their scalar last": _rule(quaternions, _scalar_last),
        "Euler angles of another sequence": _other_sequences,
    },
    "order": {"joint columns in another order, with other signs": _reordered_joints},
    "position": {
        "two position columns exchanged": _rule(positions, _exchanged),
        "position columns in another order": _rule(positions, _turned_round),
        "the sign of a position column reversed": _rule(positions, _reversed_one),
        "one position column in metres": _rule(positions, _one_in_larger_unit),
        "one position column in millimetres": _rule(odd_positions, _in_another_unit),
    },
    "row or frame": {"joints a row off": _rule(joint_columns, _a_row_off)},
}
"""What is looked for at each stage (see `mistakes`)."""
