"""Choose the assembly mode in which each configuration starts: the one that fits what was read of
it.

Joint readings leave a parallel mechanism several assembly modes. A configuration starts at its
measured pose where that is whole, else at what was read of it, completed from the nearest
configuration whose pose is whole, else from home. Where it is not whole and the solution found so
does not fit the configuration's own readings, solved neighbours are followed to it, and where these
do not fit either all modes of the geometry at its joint readings are listed. Groups of equal
inclination judge no configuration alone: there each mode of one configuration is followed through
the whole file, and the one whose groups agree best is taken.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.modes import modes_at_need
from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.data.parameters import with_parameters
from symkin.calibration.estimate.configuration_model import ConfigurationModel
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    SolvedConfigurations,
    is_carried,
    known_poses,
    nearest_rows,
    newton_configurations,
    solve_configurations,
)
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import linearise
from symkin.calibration.estimate.workspace import home_pose, states_reference
from symkin.closure.closure import build_closure
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism
from symkin.position.transfer import variables_elsewhere
from symkin.spatial.rotation import euler_from_quaternion, quaternion_from_euler, wrapped

_MAX_READING_GAP = 0.05
"""A configuration whose readings are off by more than this share of the size (angles times the
size) at the geometry that it starts from may stand in another mode.
"""
_DOUBTFUL_RATIO, _MIN_DOUBTFUL_GAP = 8.0, 1e-4
"""So may one that is off by so many times the median of the file, and by more than this share of
the size.
"""
_MODE_IMPROVEMENT = 0.5
"""Another mode is taken where the readings are off by less than this share of what they are off in
the present one.
"""
_MAX_LISTED, _FOLLOWED_NEIGHBOURS = 12, 3
"""Configurations whose modes are listed at most in one round, spread over the file, and neighbours
that are followed to a configuration.
"""
_BLOCK_ROWS = 5000
"""Rows whose readings are evaluated at once."""
_RANDOM_STARTS = 200
"""Random starts where the modes of a configuration cannot be listed by continuation."""
_MAX_ROUNDS = 3
"""Rounds of neighbours and lists: a configuration found in one serves its neighbours in the
next.
"""
_INDISTINCT_RATIO = 1.5
"""Modes through whose configurations the groups disagree by less than this times the least
disagreement are not told apart by groups.
"""


# --- where a direct problem begins ----------------------------------------------------------------


def with_starts(
    mechanism: Mechanism, measurements: Measurements, *, posed: bool = True, completed: bool = True
) -> Measurements:
    """Give a start to each configuration that has none and whose pose was not measured as a whole:
    what was read of the pose, the rest from the nearest configuration (in the joints) whose pose is
    whole, else from home. Readings are no starts where they are seen through unknown frames (not
    `posed`), nor parts of a pose where readings are judged (not `completed`): begun at a wrong one,
    a configuration would end in the mode that fits it best.
    """
    if is_carried(build_closure(mechanism)):
        return measurements
    home = home_pose(mechanism)
    bare = np.array([pose is None or not posed for pose in known_poses(measurements)])
    if measurements.starts is not None:
        bare &= ~np.all(np.isfinite(measurements.starts), axis=1)
    if not bare.any():
        return measurements
    starts = (
        np.full((len(measurements), 7), np.nan)
        if measurements.starts is None
        else measurements.starts.copy()
    )
    starts[bare] = [*home.position, *home.quaternion]
    if posed and completed and not mechanism.serial:
        starts[bare] = _complete_poses(measurements, starts, bare)
    return replace(measurements, starts=starts)


def _complete_poses(m: Measurements, starts: np.ndarray, bare: np.ndarray) -> np.ndarray:
    """Return starts (k, 7) for the configurations without one, with what was read of them put
    in.
    """
    rows = np.flatnonzero(bare)
    found = starts[rows].copy()
    whole = np.flatnonzero([pose is not None for pose in known_poses(m, measured=True)])
    if len(whole) and m.position is not None and m.orientation is not None:
        near = whole[nearest_rows(m.joints[whole], m.joints[rows], 1)[:, 0]]
        found = np.hstack([m.position[near], m.orientation[near]])
    if m.position is not None:
        read = m.position[rows]
        found[:, :3] = np.where(np.isfinite(read), read, found[:, :3])
    if m.inclination is not None:
        _incline(found, m.inclination[rows])
    if m.orientation is not None:
        read = m.orientation[rows]
        found[:, 3:] = np.where(np.isfinite(read), read, found[:, 3:])
    return found


def _incline(poses: np.ndarray, inclination: np.ndarray) -> None:
    """Turn poses (k, 7) to the inclinations (k, 2) read, with their own yaw."""
    read = np.all(np.isfinite(inclination), axis=1)
    if read.any():
        yaw = np.asarray(euler_from_quaternion(poses[read, 3:].T, "xyz"))[2]
        poses[read, 3:] = np.asarray(
            quaternion_from_euler(np.array([*inclination[read].T, yaw]), "xyz")
        ).T


# --- modes ----------------------------------------------------------------------------------------


def start_configurations(
    problem: CalibrationProblem, p: np.ndarray, *, seed: int = 0
) -> SolvedConfigurations:
    """Solve the direct problem of every configuration at the parameters p, each in the mode that
    fits what was read of it.
    """
    model, m = problem.model, problem.measurements
    with np.errstate(all="ignore"):
        configurations = solve_configurations(
            model, m, p, seed=seed, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )
        if problem.mechanism.serial or model.observes_through_frames:
            return configurations
        judged = np.any(problem.readings.taken & ~problem.readings.grouped, axis=1)
        if judged.any():
            # a whole measured pose is where the direct problem began, and so tells the mode
            begun = np.array(
                [
                    pose is not None and not is_carried(model.closure)
                    for pose in known_poses(m, measured=True)
                ]
            )
            return _choose_modes(
                problem, p, configurations, judged & ~(begun & configurations.solved)
            )
        if problem.readings.groups and (
            not has_home(problem.mechanism) or not configurations.solved.all()
        ):
            return _choose_branch(problem, p, configurations)
    return configurations


def has_home(mechanism: Mechanism) -> bool:
    """Tell whether the file says where the platform stands: rod limbs leave it open."""
    given = mechanism.example is not None and (
        mechanism.example.pose is not None or mechanism.example.start is not None
    )
    return given or states_reference(mechanism)


def _choose_modes(
    problem: CalibrationProblem,
    p: np.ndarray,
    configurations: SolvedConfigurations,
    judged: np.ndarray,
) -> SolvedConfigurations:
    """Move configurations that do not fit their own readings to a mode that fits them better, where
    there is one.
    """
    gaps = reading_gaps(problem, p, configurations)
    listed = np.zeros(len(gaps), dtype=bool)
    for _ in range(_MAX_ROUNDS):
        bad = _doubtful(problem, gaps, judged)
        if not bad.any():
            break
        configurations, gaps = _follow_neighbours(problem, p, configurations, gaps, bad)
        bad = np.flatnonzero(_doubtful(problem, gaps, judged) & ~listed)
        chosen = bad[spread_rows(len(bad), _MAX_LISTED)] if len(bad) else bad
        if not len(chosen):
            break
        listed[chosen] = True
        points, owner = _all_modes(problem, p, chosen)
        before = gaps
        configurations, gaps = _take_better_points(problem, p, configurations, gaps, points, owner)
        if np.array_equal(before, gaps):
            break
    return configurations


def _doubtful(problem: CalibrationProblem, gaps: np.ndarray, judged: np.ndarray) -> np.ndarray:
    """Tell which configurations (n,) may stand in another mode."""
    read = np.any(problem.readings.taken & ~problem.readings.grouped, axis=1)
    size, known = problem.model.closure.characteristic_length, gaps[read & np.isfinite(gaps)]
    usual = float(np.median(known)) if len(known) else np.inf
    return np.asarray(
        judged
        & ~(
            gaps
            <= min(_MAX_READING_GAP * size, max(_DOUBTFUL_RATIO * usual, _MIN_DOUBTFUL_GAP * size))
        )
    )


def reading_gaps(
    problem: CalibrationProblem,
    p: np.ndarray,
    configurations: SolvedConfigurations,
    rows: np.ndarray | None = None,
) -> np.ndarray:
    """Compute how far the readings of each configuration (of `rows`, default: all) are off, root
    mean square, angles times the size; infinite where it is not solved, 0 where nothing but its
    group was read.
    """
    rows = np.arange(len(problem.measurements)) if rows is None else rows
    blocks = [slice(k, k + _BLOCK_ROWS) for k in range(0, len(rows), _BLOCK_ROWS)]
    found = [
        _gaps_of(
            problem, p, SolvedConfigurations(configurations.z[b], configurations.solved[b]), rows[b]
        )
        for b in blocks
    ]
    return np.concatenate(found) if found else np.zeros(0)


def _gaps_of(
    problem: CalibrationProblem,
    p: np.ndarray,
    configurations: SolvedConfigurations,
    rows: np.ndarray,
) -> np.ndarray:
    model, readings = problem.model, problem.readings
    h = model.evaluate(
        np.nan_to_num(configurations.z),
        problem.measurements.joints[rows],
        p,
        problem.quaternions[rows],
    ).readings
    gap = h - readings.targets[rows]
    used = readings.taken[rows] & ~readings.grouped
    squares = np.where(
        used, (model.lengths * np.where(readings.turning, wrapped(gap), gap)) ** 2, 0.0
    )
    mean = np.sum(squares, axis=1) / np.maximum(np.sum(used, axis=1), 1)
    return np.where(configurations.solved & np.isfinite(mean), np.sqrt(mean), np.inf)


def _follow_neighbours(
    problem: CalibrationProblem,
    p: np.ndarray,
    configurations: SolvedConfigurations,
    gaps: np.ndarray,
    bad: np.ndarray,
) -> tuple[SolvedConfigurations, np.ndarray]:
    """Begin bad configurations again from the nearest good ones."""
    good, wanted = np.flatnonzero(~bad & configurations.solved), np.flatnonzero(bad)
    if not len(good):
        return configurations, gaps
    joints = problem.measurements.joints
    near = good[nearest_rows(joints[good], joints[wanted], _FOLLOWED_NEIGHBOURS)]
    return _take_better_points(
        problem,
        p,
        configurations,
        gaps,
        configurations.z[near.ravel()],
        np.repeat(wanted, near.shape[1]),
    )


def _take_better_points(
    problem: CalibrationProblem,
    p: np.ndarray,
    configurations: SolvedConfigurations,
    gaps: np.ndarray,
    points: np.ndarray,
    owner: np.ndarray,
) -> tuple[SolvedConfigurations, np.ndarray]:
    """Move configurations to the best of the points (k, width) tried for them (`owner` (k,)), where
    that is better by far.
    """
    if not len(owner):
        return configurations, gaps
    found = SolvedConfigurations(
        *newton_configurations(
            problem.model,
            points,
            problem.measurements.joints[owner],
            p,
            tolerance=ROUGHLY_SOLVED_TOLERANCE,
        )
    )
    trial = reading_gaps(problem, p, found, owner)
    z, solved, before, gaps = (
        configurations.z.copy(),
        configurations.solved.copy(),
        gaps,
        gaps.copy(),
    )
    if is_carried(problem.model.closure):
        # what the geometry does not reach near its neighbours is left for the estimate, and no mode
        # far away is taken for it
        before = np.minimum(
            before,
            _MAX_READING_GAP / _MODE_IMPROVEMENT * problem.model.closure.characteristic_length,
        )
    for k in np.argsort(-trial, kind="stable"):  # the best one last
        if trial[k] < _MODE_IMPROVEMENT * before[owner[k]]:
            z[owner[k]], solved[owner[k]], gaps[owner[k]] = found.z[k], True, trial[k]
    return SolvedConfigurations(z, solved), gaps


def _all_modes(
    problem: CalibrationProblem, p: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """List the unknowns (k, width) of all real modes of the geometry p at the joint readings of
    some configurations, and the numbers of these (k,).
    """
    model = problem.model
    values = dict(zip(model.names, p, strict=True))
    mechanism = with_parameters(replace(problem.mechanism, example=None), values)
    points, owner = [np.zeros((0, model.system.width))], [np.zeros(0, dtype=int)]
    for k in rows:
        found = _modes_at(mechanism, model, problem.measurements.joints[k])
        points.append(found)
        owner.append(np.full(len(found), k))
    return np.vstack(points), np.concatenate(owner)


def _modes_at(mechanism: Mechanism, model: ConfigurationModel, joints: np.ndarray) -> np.ndarray:
    """List the unknowns (k, width) of the modes at joint readings; none where they cannot be
    listed.
    """
    given = {
        c.name: mechanism.angle_out(float(v)) if c.is_angular else float(v)
        for v, c in zip(joints, mechanism.actuated, strict=True)
    }
    try:
        found = modes_at_need(mechanism, joints=given, starts=_RANDOM_STARTS)
    except SymkinError:
        return np.zeros((0, model.system.width))
    closure = build_closure(mechanism, model.closure.partition)
    count = len(mechanism.actuated)
    rows = [variables_elsewhere(closure, s)[count:] for s in found]
    return np.array(rows, dtype=float).reshape(len(rows), model.system.width)


# --- groups ---------------------------------------------------------------------------------------


def _choose_branch(
    problem: CalibrationProblem, p: np.ndarray, configurations: SolvedConfigurations
) -> SolvedConfigurations:
    """Choose the branch through all configurations in which the groups agree best: each mode of one
    configuration, followed to its neighbours, theirs, and so on. Of branches that agree equally
    (mirror images) the one whose platform is highest.
    """
    m = problem.measurements
    middle = int(nearest_rows(m.joints, np.mean(m.joints, axis=0)[None], 1)[0, 0])
    points, _ = _all_modes(problem, p, np.array([middle]))
    branches = [_branch(problem, p, middle, z) for z in points]
    whole = [
        b
        for b in branches
        if b.solved.sum() >= max((c.solved.sum() for c in branches), default=0) * 0.9
    ]
    if not whole:
        return configurations
    if configurations.solved.all():
        whole.append(configurations)
    worth = [_disagreement(problem, p, b) for b in whole]
    equal = [b for b, w in zip(whole, worth, strict=True) if w <= _INDISTINCT_RATIO * min(worth)]
    return max(equal, key=lambda b: _height(problem, p, b))


def _height(
    problem: CalibrationProblem, p: np.ndarray, configurations: SolvedConfigurations
) -> float:
    solved, joints = configurations.solved, problem.measurements.joints
    return float(np.mean(problem.model.poses(configurations.z[solved], joints[solved], p)[:, 2]))


def _branch(
    problem: CalibrationProblem, p: np.ndarray, first: int, z: np.ndarray
) -> SolvedConfigurations:
    """Solve all configurations from the mode z of one of them, each from its nearest solved
    neighbour.
    """
    model, joints = problem.model, problem.measurements.joints
    points, solved = np.tile(z, (len(joints), 1)), np.zeros(len(joints), dtype=bool)
    points[first], solved[first] = z, True
    for _ in range(len(joints)):
        open_ = np.flatnonzero(~solved)
        if not len(open_):
            break
        known = np.flatnonzero(solved)
        near = known[nearest_rows(joints[known], joints[open_], 1)[:, 0]]
        order = np.argsort(
            np.linalg.norm(
                (joints[open_] - joints[near]) / np.maximum(np.std(joints, axis=0), 1e-300), axis=1
            )
        )
        order = order[: max(1, len(open_) // 2)]
        found, closed = newton_configurations(
            model, points[near[order]], joints[open_[order]], p, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )
        if not closed.any():
            break
        points[open_[order][closed]], solved[open_[order][closed]] = found[closed], True
    return SolvedConfigurations(points, solved)


def _disagreement(
    problem: CalibrationProblem, p: np.ndarray, configurations: SolvedConfigurations
) -> float:
    """Compute the root mean square by which the inclinations of groups differ from their means,
    over their standard deviations.
    """
    model = problem.model
    h = model.evaluate(
        np.nan_to_num(configurations.z), problem.measurements.joints, p, problem.quaternions
    ).readings
    fit = linearise("means", problem.readings, np.nan_to_num(h), np.zeros((*h.shape, 1)))
    squares = np.sum(fit.residuals**2, axis=1)[configurations.solved]
    return float(np.sqrt(np.mean(squares))) if len(squares) else np.inf
