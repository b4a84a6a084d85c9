"""Choose the assembly mode in which each configuration starts: the one that fits what was read of
it.

Joint readings leave a parallel mechanism several assembly modes. A configuration starts at its
measured pose where that is whole, else at what was read of it, completed from the nearest
configuration whose pose is whole, else from home. Where it is not whole and the solution found so
does not fit the configuration's own readings, solved neighbours are followed to it, and where these
do not fit either all modes of the geometry at its joint readings are listed. Groups of equal
inclination judge no configuration alone: there each mode of one configuration is followed through
the whole file, and the one whose groups agree best is taken.

A laser tracker stands anywhere and sees a reflector that is mounted anywhere on the platform:
observed pose = world, platform pose, target one after the other. These frames have no nominal value
near which they could be sought. With the platform's poses known from the mechanism's own geometry,
only the frames are fitted: from many orientations of the world frame, the target's orientation from
those that were read.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import product

import numpy as np

from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.data.parameters import MEASURING_FRAMES, with_parameters
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    SolvedConfigurations,
    follow_joints,
    is_carried,
    nearest_rows,
    newton_configurations,
    solve_configurations,
)
from symkin.calibration.estimate.estimator import estimate
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.residuals import deviations
from symkin.calibration.estimate.state import evaluate, readings_at
from symkin.calibration.estimate.workspace import home_pose, states_reference
from symkin.closure.closure import build_closure
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism
from symkin.position.transfer import variables_elsewhere
from symkin.spatial.rotation import (
    conjugate,
    euler_from_quaternion,
    multiply,
    quaternion_from_euler,
    rotation_vector_from_quaternion,
)

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
    mechanism: Mechanism,
    measurements: Measurements,
    parameters: Sequence[str] | None = None,
    fixed: Sequence[str] = (),
    *,
    completed: bool = True,
) -> Measurements:
    """Give a start to each configuration that has none and whose pose was not measured as a whole:
    what was read of the pose, the rest from the nearest configuration (in the joints) whose pose is
    whole, else from home. Readings are no starts where they are seen through frames that are
    unknown (among the `parameters` that are not `fixed`), nor parts of a pose where readings are
    judged (not `completed`): begun at a wrong one, a configuration would end in the mode that fits
    it best.
    """
    posed = set(MEASURING_FRAMES).isdisjoint(set(parameters or ()) - set(fixed))
    if is_carried(build_closure(mechanism)):
        return measurements
    m, home = measurements, home_pose(mechanism)
    starts = np.full((len(m), 7), np.nan) if m.starts is None else m.starts.copy()
    read = m.poses
    rows = np.flatnonzero(np.isnan(starts).any(axis=1) & (np.isnan(read[:, 0]) | (not posed)))
    if not len(rows):
        return m
    starts[rows] = [*home.position, *home.quaternion]
    if posed and completed and not mechanism.serial:
        whole = np.flatnonzero(~np.isnan(read[:, 0]))
        if len(whole):
            starts[rows] = read[whole[nearest_rows(m.joints[whole], m.joints[rows], 1)[:, 0]]]
        if m.inclination is not None:  # with their own yaw
            angles = np.array(euler_from_quaternion(starts[:, 3:].T, "xyz"))
            _put_in(m.inclination, angles[:2].T, rows)
            starts[rows, 3:] = quaternion_from_euler(angles, "xyz").T[rows]
        for table, part in ((m.position, starts[:, :3]), (m.orientation, starts[:, 3:])):
            if table is not None:
                _put_in(table, part, rows)
    return replace(m, starts=starts)


def _put_in(read: np.ndarray, table: np.ndarray, rows: np.ndarray) -> None:
    """Put what was read into some rows of a table."""
    table[rows] = np.where(np.isfinite(read[rows]), read[rows], table[rows])


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
        judged = problem.readings.judged
        if judged.any():
            # a whole measured pose is where the direct problem began, and so tells the mode
            begun = np.isfinite(m.poses[:, 0])
            begun &= configurations.solved & (not is_carried(model.closure))
            return _Modes(problem, p, configurations).chosen(judged & ~begun)
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


def reading_gaps(
    problem: CalibrationProblem, p: np.ndarray, configurations: SolvedConfigurations
) -> np.ndarray:
    """Compute how far the readings of each configuration are off, root mean square, angles times
    the size; infinite where it is not solved, 0 where nothing but its group was read.
    """
    model, readings = problem.model, problem.readings
    h = readings_at(problem, p, np.nan_to_num(configurations.z))
    used, gap = readings.taken & ~readings.grouped, model.lengths * deviations(readings, h)
    mean = np.where(used, gap**2, 0.0).sum(axis=1) / np.maximum(used.sum(axis=1), 1)
    return np.where(configurations.solved & np.isfinite(mean), np.sqrt(mean), np.inf)


def went_astray(
    problem: CalibrationProblem, p: np.ndarray, configurations: SolvedConfigurations
) -> np.ndarray:
    """Tell which configurations (n,) without a whole measured pose stand in a mode that is not
    theirs, or have gross readings: theirs are off by far, where those of most are not.
    """
    gaps = reading_gaps(problem, p, configurations)
    judged = problem.readings.judged & np.isfinite(gaps) & (not problem.mechanism.serial)
    usual = np.median(gaps[judged]) if judged.any() else np.inf
    judged &= np.isnan(problem.measurements.poses[:, 0])
    return judged & (gaps > max(_DOUBTFUL_RATIO * usual, _MAX_READING_GAP * problem.size))


class _Modes:
    """Configurations (z, solved) on the way to the modes that fit their own readings, and how far
    these are off.
    """

    def __init__(
        self, problem: CalibrationProblem, p: np.ndarray, begin: SolvedConfigurations
    ) -> None:
        self.problem, self.p = problem, p
        self.z, self.solved = begin.z.copy(), begin.solved.copy()
        self.gaps = reading_gaps(problem, p, begin)
        self.size = problem.size

    def chosen(self, judged: np.ndarray) -> SolvedConfigurations:
        """Move those of the `judged` that do not fit their own readings to a mode that fits them
        better, where there is one.
        """
        joints, listed = self.problem.joints, ~judged
        for _ in range(_MAX_ROUNDS):
            bad = judged & self.doubtful
            good, wanted = np.flatnonzero(~bad & self.solved), np.flatnonzero(bad)
            if not len(wanted):
                break
            if len(good):
                near = good[nearest_rows(joints[good], joints[wanted], _FOLLOWED_NEIGHBOURS)]
                self.take_better(self.z[near.ravel()], np.repeat(wanted, near.shape[1]))
            bad = np.flatnonzero(self.doubtful & ~listed)
            if not len(bad):
                break
            rows = bad[spread_rows(len(bad), _MAX_LISTED)]
            listed[rows] = True
            if not self.take_better(*_all_modes(self.problem, self.p, rows)):
                break
        return SolvedConfigurations(self.z, self.solved)

    @property
    def doubtful(self) -> np.ndarray:
        """Which configurations (n,) may stand in another mode."""
        known = self.gaps[self.problem.readings.judged & np.isfinite(self.gaps)]
        usual = np.median(known) if len(known) else np.inf
        far = max(_DOUBTFUL_RATIO * usual, _MIN_DOUBTFUL_GAP * self.size)
        return ~(self.gaps <= min(_MAX_READING_GAP * self.size, far))

    def take_better(self, points: np.ndarray, owner: np.ndarray) -> bool:
        """Move configurations to the best of the points (k, width) tried for them (`owner` (k,)),
        where that is better by far; tell whether any is.
        """
        if not len(owner):
            return False
        part = self.problem.of(owner)
        found = newton_configurations(
            part.model, points, part.joints, self.p, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )
        trial = reading_gaps(part, self.p, found)
        before = self.gaps[owner]
        if is_carried(part.model.closure):
            # what the geometry does not reach near its neighbours is left for the estimate, and no
            # mode far away is taken for it
            before = np.minimum(before, _MAX_READING_GAP / _MODE_IMPROVEMENT * self.size)
        better = trial < _MODE_IMPROVEMENT * before
        for k in np.argsort(-trial, kind="stable"):  # the best one last
            if better[k]:
                self.z[owner[k]], self.solved[owner[k]] = found.z[k], True
                self.gaps[owner[k]] = trial[k]
        return bool(better.any())


def _all_modes(
    problem: CalibrationProblem, p: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """List the unknowns (k, width) of all real modes of the geometry p at the joint readings of
    some configurations, and the numbers of these (k,).
    """
    from symkin.assembly.modes import modes_at_need  # half of the imports, and rarely needed

    model, values = problem.model, dict(zip(problem.names, p, strict=True))
    mechanism = with_parameters(replace(problem.mechanism, example=None), values)
    closure, count = build_closure(mechanism, model.closure.partition), len(mechanism.actuated)
    points, owner = [np.zeros((0, model.system.width))], list[int]()
    for k in rows:
        given = {
            c.name: mechanism.value_out(c, float(v))
            for v, c in zip(problem.joints[k], mechanism.actuated, strict=True)
        }
        with suppress(SymkinError):  # modes that cannot be listed
            for solution in modes_at_need(mechanism, joints=given, starts=_RANDOM_STARTS):
                points.append(variables_elsewhere(closure, solution)[None, count:])
                owner.append(k)
    return np.vstack(points), np.array(owner, dtype=int)


# --- groups ---------------------------------------------------------------------------------------


def _choose_branch(
    problem: CalibrationProblem, p: np.ndarray, configurations: SolvedConfigurations
) -> SolvedConfigurations:
    """Choose the branch through all configurations in which the groups agree best: each mode of one
    configuration, followed to its neighbours, theirs, and so on. Of branches that agree equally
    (mirror images) the one whose platform is highest.
    """
    m = problem.measurements
    middle = nearest_rows(m.joints, m.joints.mean(axis=0)[None], 1)[0, 0]
    begin = np.tile(m.joints[middle], (len(m), 1))

    def branch(z: np.ndarray) -> SolvedConfigurations:
        """Solve all configurations from the mode z of one, by following it to their joints."""
        points = np.tile(z, (len(m), 1))
        points = follow_joints(problem.model, points, begin, m.joints, p)
        return newton_configurations(
            problem.model, points, m.joints, p, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )

    branches = [branch(z) for z in _all_modes(problem, p, np.array([middle]))[0]]
    most = max((b.solved.sum() for b in branches), default=0)
    whole = [b for b in branches if b.solved.sum() >= 0.9 * most]
    if not whole:
        return configurations
    if configurations.solved.all():
        whole.append(configurations)

    def disagreement(b: SolvedConfigurations) -> float:
        """By how much the inclinations of groups differ from their means, root mean square over
        their standard deviations.
        """
        rows = np.flatnonzero(b.solved)
        residuals = evaluate(problem.of(rows).by_means, p, b.z[rows]).linearised.residuals
        return float(np.sqrt(np.mean(np.sum(residuals**2, axis=1)))) if len(rows) else np.inf

    worth = [disagreement(b) for b in whole]
    equal = [b for b, w in zip(whole, worth, strict=True) if w <= _INDISTINCT_RATIO * min(worth)]

    def height(b: SolvedConfigurations) -> float:
        return float(problem.model.poses(b.z[b.solved], m.joints[b.solved], p)[:, 2].mean())

    return max(equal, key=height)


# --- measuring frames -----------------------------------------------------------------------------


_FRAME_CONFIGURATIONS = 40
"""Configurations that the start is found from, spread evenly: twelve numbers at most are wanted,
and only nearly.
"""
_TRIAL_STEPS, _FOLLOWED_TRIALS, _FINAL_STEPS = 4, 3, 40
"""Steps from each orientation, how many of what they lead to are followed, and the steps from
there.
"""


def fit_measuring_frames(
    problem: CalibrationProblem, z: np.ndarray, p: np.ndarray, solved: np.ndarray
) -> np.ndarray:
    """Fit the free measuring frames to the configurations z (n, width) that are solved (n,), all
    other parameters nominal.
    """
    free = np.flatnonzero([name in MEASURING_FRAMES for name in problem.names])
    if not len(free) or not solved.any():
        return p
    closed = np.flatnonzero(solved)
    rows = closed[spread_rows(len(closed), _FRAME_CONFIGURATIONS)]
    frames = [problem.names[k] for k in free]
    whole = build_calibration(problem.mechanism, problem.measurements, parameters=frames)
    few = whole.of(rows)

    def fitted(start: np.ndarray, steps: int) -> tuple[float, np.ndarray]:
        state = estimate(few, z[rows], p=start, max_iterations=steps).state
        return state.cost if np.isfinite(state.cost) else np.inf, state.p

    trials = [fitted(start, _TRIAL_STEPS) for start in _frame_starts(few, z[rows], p[free])]
    best = sorted(trials, key=lambda trial: trial[0])[:_FOLLOWED_TRIALS]
    found, ends = p.copy(), [fitted(near, _FINAL_STEPS) for _, near in best]
    found[free] = min(ends, key=lambda end: end[0])[1]
    return found


def _frame_starts(
    problem: CalibrationProblem, z: np.ndarray, p: np.ndarray
) -> Iterator[np.ndarray]:
    """Yield p, and p with the world frame in the orientations of a cube where all of its rotation
    is free; the target's orientation is then the mean of those that were read, where all of it is
    free.
    """
    yield p
    places = {name: k for k, name in enumerate(problem.names)}
    world, target = (
        [places.get(f"{frame}.rotation.{k}", -1) for k in "xyz"] for frame in ("world", "target")
    )
    m, start = problem.measurements, p.copy()
    read = None if min(target) < 0 else m.orientation
    given = np.flatnonzero([] if read is None else np.isfinite(read[:, 0]))
    for turn in _cube_orientations() if min(world) >= 0 else (None,):
        if turn is not None:
            start[world] = rotation_vector_from_quaternion(turn)
        if read is not None and len(given):
            start[target] = 0.0
            seen = problem.model.poses(z[given], m.joints[given], start)[:, 3:].T
            turns = multiply(conjugate(seen), read[given].T)
            # the mean orientation is the eigenvector of the sum of q q^T (Markley and others 2007)
            mean = np.linalg.eigh(turns @ turns.T)[1][:, -1]
            start[target] = rotation_vector_from_quaternion(mean)
        yield start.copy()


def _cube_orientations() -> Iterator[np.ndarray]:
    """Quaternions of the 24 orientations of a cube."""
    for q in product((-1.0, 0.0, 1.0), repeat=4):
        if q.count(0.0) != 1 and q > tuple(-v for v in q):
            yield np.array(q) / np.linalg.norm(q)
