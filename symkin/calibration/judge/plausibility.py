"""Decide whether a converged fit is a calibration, or a geometry bent until wrong readings fit as
well as they can.

Noise that is stated too small or a model that lacks something leaves residuals some times as large
as expected; such a fit is not believable, and yet nearer to the truth than nominal. Readings that
mean something else (columns exchanged, a sign, another sequence) leave residuals far beyond any
noise, and move the geometry by a large share of its size to reach even these.

How far a geometry went from the file's, its departure, is measured by poses. Parameters tell it
badly: frames are free, nearly parallel axes move by hundreds of metres, and a small change of one
parameter may matter more than a large one of another. What counts is the map from joint readings to
poses: the poses of both geometries at the joint readings measured, after the best constant frames W
and T of base and tool,

    departure = rms |X_fit - W X_file T| / rms |X_fit - mean|,

angles times the lever of the platform's joint points, over the better four fifths of the
configurations: near a singularity of either geometry poses are far apart for nothing. A machine as
it is built differs from its drawing by some per mille, and its poses by about that share of their
spread. With columns exchanged, a sign turned, or the file of another machine it is a share that can
be seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    newton_configurations,
)
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State
from symkin.calibration.estimate.workspace import lever, platform_points
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.spatial.rotation import (
    conjugate,
    multiply,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    rotate,
    rotation_vector_from_quaternion,
)

if TYPE_CHECKING:
    from symkin.calibration.judge.result import Calibration, Parameter, Residual


LARGE_CHANGE = 0.2
"""A change of a parameter by more than this share of the size (angles: radians) is no correction of
a nominal geometry.
"""
OTHER_MACHINE_DEPARTURE, NOTICEABLE_DEPARTURE = 0.08, 0.02
"""A departure (see `departure`) by more than the first share is no correction of the machine that
the file describes, but another machine; one by more than the second is, where a mistake in the
columns would explain it. Tolerances of some per mille of the size leave some per mille, a nominal
geometry measured with a ruler two or three per cent.
"""
_NEGLIGIBLE_CHANGE = 0.03
"""Changes of all parameters below this share of the size (angles: radians) are the same machine,
although near singularities its poses may differ by much.
"""
_EXPECTED_TOLERANCES = 6.0
"""Changes within so many of the tolerances stated are what the user expects, however far they
go.
"""
MAX_NOISE_RATIO = 30.0
"""Residuals larger than so many times the noise stated do not come from noise: an instrument's is
known better than to a factor of ten.
"""
_MAX_RESIDUAL_SHARE = 1e-3
"""Where no noise is stated, residuals above this share of the size are coarser than any instrument
that calibrates.
"""
_UNEXPLAINED_SHARE = 0.5
"""Residuals above this share of the nominal geometry's say that the parameters do not explain the
readings.
"""
_NAMED_CHANGES = 3
"""Largest changes that a sentence names."""

_COMPARED_CONFIGURATIONS = 80
"""Configurations that are compared, spread evenly over those used."""
_MAX_ALIGNMENT_STEPS = 30
"""Most Gauss-Newton steps of the frames."""


def rejection_reason(
    fit: Calibration,
    at_nominal: float,
    suspicions: Sequence[str],
) -> str | None:
    """Say why a converged fit is not to be used, None where nothing speaks against it; `at_nominal`
    is the misfit of the nominal geometry (see `residual_misfit`).
    """
    beyond = _noise_excess(fit)
    misplaced = is_other_machine(fit) or (bool(suspicions) and is_noticeable(fit))
    if beyond is not None:
        why = _misfit_reason(fit, beyond, at_nominal, suspicions)
        if why is not None:
            return why
    return describe_other_machine(fit, suspicions) if misplaced and not fit.any_machine else None


def _misfit_reason(
    fit: Calibration, beyond: str, at_nominal: float, suspicions: Sequence[str]
) -> str | None:
    """Say why residuals beyond any noise fit no geometry, None where they may fit one that the
    model does not know.
    """
    moved = large_changes(fit)
    if moved:
        largest = max(moved, key=lambda p: _relative_change(fit, p))
        how = (
            "of the size"
            if largest.kind == "length"
            else "of a radian"
            if largest.kind == "angle"
            else "of one"
        )
        return (
            f"{beyond}, although {largest.name} moved by "
            f"{100 * _relative_change(fit, largest):.0f} % {how}: no geometry near the nominal one "
            f"fits "
            "these readings"
        )
    misfit = residual_misfit(fit.residuals, fit.mechanism.characteristic_length)
    if misfit > _UNEXPLAINED_SHARE * at_nominal:
        unit = fit.mechanism.length_unit
        return (
            f"{beyond}, hardly less than those of the nominal geometry ({misfit:.3g} {unit} after "
            f"{at_nominal:.3g} {unit}, angles times "
            "the size): the parameters do not explain the readings"
        )
    return beyond if suspicions else None


def is_other_machine(fit: Calibration) -> bool:
    """Tell whether the fit is of another machine than the file describes, and further away than the
    tolerances stated let expect.
    """
    within = (
        fit.problem.is_stated
        and max((abs(z) for _, z in changes_over_tolerances(fit)), default=0.0)
        <= _EXPECTED_TOLERANCES
    )
    return fit.departure.share > OTHER_MACHINE_DEPARTURE and not within and is_noticeable(fit)


def is_noticeable(fit: Calibration) -> bool:
    """Tell whether the geometry went so far that mistakes in the file are worth a search although
    it fits.
    """
    return fit.departure.share > NOTICEABLE_DEPARTURE and any(
        _relative_change(fit, p) > _NEGLIGIBLE_CHANGE for p in fit.parameters if not p.held
    )


def beyond_tolerances(fit: Calibration) -> list[tuple[str, float]]:
    """List parameters that moved by more tolerances than expected, largest first, with how many."""
    found = [
        (name, abs(z)) for name, z in changes_over_tolerances(fit) if abs(z) > _EXPECTED_TOLERANCES
    ]
    return sorted(found, key=lambda pair: -pair[1])


def changes_over_tolerances(fit: Calibration) -> list[tuple[str, float]]:
    """Return the changes of free parameters over the tolerances stated."""
    prior, model = fit.problem.prior, fit.problem.model
    if not fit.problem.is_stated:
        return []
    changes = (fit.state.p - model.nominal) / model.scales / prior
    return [
        (name, float(z))
        for name, z, s in zip(model.names, changes, prior, strict=True)
        if np.isfinite(s)
    ]


def describe_other_machine(fit: Calibration, suspicions: Sequence[str] = ()) -> str:
    """Describe a geometry far from the file's, first what would explain it."""
    m, departure = fit.mechanism, fit.departure
    size, free = m.characteristic_length, [p for p in fit.parameters if not p.held]
    largest = sorted(free, key=lambda p: -abs(p.change) * (1.0 if p.kind == "length" else size))[
        :_NAMED_CHANGES
    ]
    changes = ", ".join(
        f"{p.name} {m.angle_out(p.change):+.3g} {m.angle_unit}"
        if p.kind == "angle"
        else f"{p.name} {p.change:+.3g}{f' {m.length_unit}' if p.kind == 'length' else ''}"
        for p in largest
    )
    unclosed = (
        f"; {departure.unclosed} of {departure.configurations} postures the file's geometry cannot "
        f"take there"
        if departure.unclosed
        else ""
    )
    cause = f"{suspicions[0]}; its" if suspicions else "its"
    return (
        f"another machine than {m.name} describes: {cause} poses are {100 * departure.share:.2g} % "
        f"of their spread away from the file's at the same "
        f"joint readings ({departure.position:.3g} {m.length_unit} and "
        f"{m.angle_out(departure.angle):.3g} {m.angle_unit} rms, frames aligned{unclosed}); "
        f"largest changes: {changes}; for a machine that is so, state --tolerance or --any-machine"
    )


def is_beyond_noise(fit: Calibration) -> bool:
    """Tell whether residuals are larger than any noise would make them."""
    return _noise_excess(fit) is not None


def large_changes(fit: Calibration) -> list[Parameter]:
    """List free parameters that moved by more than `LARGE_CHANGE`; measuring frames have no nominal
    place.
    """
    return [
        p
        for p in fit.parameters
        if not p.held and p.name not in MEASURING_FRAMES and _relative_change(fit, p) > LARGE_CHANGE
    ]


def residual_misfit(residuals: Iterable[Residual], size: float) -> float:
    """Return the root mean square of a configuration's residuals, angles times the size (length
    unit), over the better four fifths.
    """
    squares: dict[int, float] = {}
    for r in residuals:
        squares[r.configuration] = (
            squares.get(r.configuration, 0.0) + (r.value * (size if r.angular else 1.0)) ** 2
        )
    return rms_of_better_part(np.array(list(squares.values())))


def _noise_excess(fit: Calibration) -> str | None:
    """Say how far residuals are beyond noise, None where they are not."""
    if fit.p_value is not None and fit.degrees > 0:
        times = math.sqrt(fit.chi_square / fit.degrees)
        return (
            f"the residuals are {times:.3g} times as large as the noise stated"
            if times > MAX_NOISE_RATIO
            else None
        )
    share = (
        residual_misfit(fit.residuals, fit.mechanism.characteristic_length)
        / fit.mechanism.characteristic_length
    )
    return (
        f"the residuals are {100 * share:.2g} % of the size"
        if share > _MAX_RESIDUAL_SHARE
        else None
    )


def _relative_change(fit: Calibration, p: Parameter) -> float:
    """Return the change of a parameter over the size (lengths), in radians or plain."""
    return abs(p.change) / (fit.mechanism.characteristic_length if p.kind == "length" else 1.0)


@dataclass(frozen=True)
class Departure:
    """`share` is the departure, `position` (length unit) and `angle` (radians) the root mean
    squares of its parts, `unclosed` the number of configurations, of `configurations`, that the
    file's geometry cannot take near the fitted pose; these count as one spread.
    """

    share: float
    position: float
    angle: float
    unclosed: int
    configurations: int


def measure_departure(problem: CalibrationProblem, state: State) -> Departure:
    """Measure the departure of a fit from the nominal geometry, over the configurations fitted."""
    model = problem.model
    rows = spread_rows(len(state.z), _COMPARED_CONFIGURATIONS)
    joints = problem.measurements.joints
    fitted = judged_poses(problem, state.p, state.z[rows], joints[rows])
    whole = np.all(np.isfinite(fitted), axis=1)
    rows, fitted = rows[whole], fitted[whole]
    if not len(rows):
        return Departure(share=1.0, position=0.0, angle=0.0, unclosed=0, configurations=0)
    joints = joints[rows]
    with np.errstate(all="ignore"):
        z, closed = newton_configurations(
            model, state.z[rows], joints, model.nominal, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )
    length, centre = lever(problem.mechanism), np.mean(platform_points(problem.mechanism), axis=0)
    here = _PoseSet.at(fitted, centre, length)
    spread = here.spread
    if not np.any(closed) or not spread > 0.0:
        return Departure(
            share=0.0 if np.any(closed) else 1.0,
            position=0.0,
            angle=0.0,
            unclosed=int(np.sum(~closed)),
            configurations=len(rows),
        )
    there = _PoseSet.at(
        judged_poses(problem, model.nominal, z[closed], joints[closed]), centre, length
    )
    off = _aligned_difference(here.take(closed), there)
    squares = np.concatenate([np.sum(off**2, axis=1), np.full(int(np.sum(~closed)), spread**2)])
    return Departure(
        share=rms_of_better_part(squares) / spread,
        position=float(np.sqrt(np.mean(np.sum(off[:, :3] ** 2, axis=1)))),
        angle=float(np.sqrt(np.mean(np.sum(off[:, 3:] ** 2, axis=1)))) / length,
        unclosed=int(np.sum(~closed)),
        configurations=len(rows),
    )


def judged_poses(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, joints: np.ndarray
) -> np.ndarray:
    """Return the poses (n, 7) of the platform, or of the link judged in its place, in the base
    frame; measuring frames among the parameters are left out.
    """
    measuring = np.array(
        [name.startswith(("world.", "target.")) for name in problem.names], dtype=bool
    )
    return problem.model.poses(z, joints, np.where(measuring, 0.0, p))


@dataclass(frozen=True, eq=False)
class _PoseSet:
    """Places (3, n) of the middle of the platform's joint points and orientations (4, n), with the
    length that angles count.
    """

    places: np.ndarray
    turns: np.ndarray
    length: float

    @staticmethod
    def at(poses: np.ndarray, centre: np.ndarray, length: float) -> _PoseSet:
        turns = poses[:, 3:].T
        return _PoseSet(
            poses[:, :3].T + np.asarray(rotate(turns, np.tile(centre[:, None], len(poses)))),
            turns,
            length,
        )

    def take(self, index: np.ndarray) -> _PoseSet:
        return _PoseSet(self.places[:, index], self.turns[:, index], self.length)

    def framed(self, step: np.ndarray) -> _PoseSet:
        """W X T for a step (12): translations (length unit) and rotation vectors (times the length)
        of W, then of T; W turns about the middle of the places.
        """
        world, tool = (
            _repeated_quaternion(step[k : k + 3] / self.length, self.places.shape[1])
            for k in (3, 9)
        )
        middle = np.mean(self.places, axis=1, keepdims=True)
        moved = self.places + np.asarray(
            rotate(self.turns, np.tile(step[6:9, None], self.places.shape[1]))
        )
        places = middle + np.asarray(rotate(world, moved - middle)) + step[:3, None]
        return _PoseSet(
            places, np.asarray(multiply(multiply(world, self.turns), tool)), self.length
        )

    def off(self, other: _PoseSet) -> np.ndarray:
        """These poses less others (n, 6), angles times the length."""
        turn = np.asarray(multiply(conjugate(other.turns), self.turns))
        return np.vstack(
            [
                self.places - other.places,
                self.length * np.asarray(rotation_vector_from_quaternion(turn)),
            ]
        ).T

    @property
    def spread(self) -> float:
        """Root mean square distance from the middle, orientations from the one nearest to all."""
        central = self.turns[:, int(np.argmax(np.sum((self.turns.T @ self.turns) ** 2, axis=1)))]
        middle = _PoseSet(
            np.tile(np.mean(self.places, axis=1, keepdims=True), self.places.shape[1]),
            np.tile(central[:, None], self.places.shape[1]),
            self.length,
        )
        return float(np.sqrt(np.mean(np.sum(self.off(middle) ** 2, axis=1))))


def _repeated_quaternion(vector: np.ndarray, count: int) -> np.ndarray:
    return np.tile(np.asarray(quaternion_from_rotation_vector(vector)).reshape(4, 1), count)


def _aligned_difference(here: _PoseSet, there: _PoseSet) -> np.ndarray:
    """Return here less W there T (n, 6) with the best constant frames."""
    best, cost = here.off(there), np.inf
    for begun in (there, there.framed(_frames_by_kabsch(here, there))):
        off = here.off(begun)
        for _ in range(_MAX_ALIGNMENT_STEPS):
            slopes = np.array(
                [(here.off(begun.framed(1e-6 * here.length * e)) - off).ravel() for e in np.eye(12)]
            ).T
            step = np.linalg.lstsq(slopes / (1e-6 * here.length), -off.ravel(), rcond=1e-9)[0]
            moved = begun.framed(step)
            trial = here.off(moved)
            if not np.sum(trial**2) < (1 - 1e-6) * np.sum(off**2):
                break
            begun, off = moved, trial
        if np.sum(off**2) < cost:
            best, cost = off, float(np.sum(off**2))
    return best


def _frames_by_kabsch(here: _PoseSet, there: _PoseSet) -> np.ndarray:
    """Find frames (12) that bring the middles of the places together and turn the places onto each
    other (Kabsch).
    """
    a, b = (p.places - np.mean(p.places, axis=1, keepdims=True) for p in (here, there))
    left, _, right = np.linalg.svd(a @ b.T)
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    step = np.zeros(12)
    step[:3] = np.mean(here.places, axis=1) - np.mean(there.places, axis=1)
    step[3:6] = here.length * np.asarray(
        rotation_vector_from_quaternion(np.asarray(quaternion_from_matrix(turn)))
    )
    return step
