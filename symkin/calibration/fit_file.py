"""Fit a mechanism to a data file, and judge the fit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from symkin.calibration.calibrate import calibrate
from symkin.calibration.data.files import DataFile
from symkin.calibration.data.measurements import Distance, Measurements
from symkin.calibration.data.parameters import MEASURING_FRAMES, bound_by_motion, joint_frames, parameter_names
from symkin.calibration.estimate.problem import default_parameters
from symkin.calibration.judge.diagnoses import diagnose, nominal_misfit
from symkin.calibration.judge.euler_sequence import describe_sequence, find_sequence
from symkin.calibration.judge.group_labels import diagnose_groups
from symkin.calibration.judge.holdout import draw_held_out, held_out_count, predict_held_out
from symkin.calibration.judge.plausibility import is_beyond_noise, is_noticeable, measure_departure, rejection_reason
from symkin.calibration.judge.pose_accuracy import predict_pose_sigma
from symkin.calibration.judge.result import Calibration
from symkin.calibration.report import FitReport
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import Mechanism
from symkin.text import first_of, printable

ALL_PARAMETERS = "all"
"""The pattern that stands for every parameter that moves poses."""
_MAX_LISTED_NAMES = 12
"""Most names that a message lists."""
_READING_NAMES = {
    "group": "groups", "inclination": "inclinations", "position": "positions", "orientation": "orientations",
    "distance": "distances",
}  # fmt: skip
"""Readings by the keys of their standard deviations."""
LEAST_CHANGE = "least"
"""Frames held by the least change from nominal."""


class NotFittedError(InputError):
    """Readings that nothing can be fitted to, and the slips (`diagnose`) that would explain it."""

    def __init__(self, message: str, diagnose: tuple[str, ...]) -> None:
        super().__init__(f"NOT BELIEVABLE, nothing was fitted: {diagnose[0]} ({message})")
        self.message = message
        self.suspicions = diagnose

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle with both arguments, so that a process pool hands the error on."""
        return type(self), (self.message, self.suspicions)


def fit_file(
    mechanism: Mechanism, data: DataFile, *, parameters: str | None = None, hold: str | None = None, frames: str = LEAST_CHANGE,
    sigmas: Mapping[str, np.ndarray | float] | None = None, command: str = "", seed: int = 0, hold_out: str | None = None,
    any_machine: bool = False, **options: Any,
) -> FitReport:  # fmt: skip
    """Fit and judge. `parameters` and `hold` are patterns separated by commas, `frames` is "least" or "joints:..." (see
    `frame_names`), `sigmas` standard deviations by kind for what the file leaves out; `hold_out` is how many
    postures (`20`, `20%`) are only predicted; with `any_machine` a geometry far from the file's is not refused for that;
    `options` are those of `calibrate`.

    Raises InputError, and NotFittedError with what may be wrong in the file where nothing can be fitted."""
    names = default_parameters(mechanism) if parameters is None else match_parameters(mechanism, parameters)
    held = dict.fromkeys((*(() if hold is None else _match_patterns(mechanism, hold)), *frame_names(mechanism, frames)))
    fixed = tuple(name for name in held if name in names)
    data = replace(data, notes=(*data.notes, *_note_left_out(mechanism, parameters or ALL_PARAMETERS, names))).without_copies()
    data = replace(data, measurements=with_sigmas(data, sigmas or {}))
    data, kept_back = _hold_out(data, hold_out, seed)
    options = {**options, "parameters": names, "fixed": fixed}
    choice = find_sequence(mechanism, data, **options) if data.open_euler is not None else None
    measurements = data.measurements if choice is None else data.with_sequence(choice.sequence)
    fit = _fit_measurements(mechanism, data, measurements, seed, options)
    frames_sought = _unknown_frames(options)
    gone = measure_departure(fit.problem, fit.state)
    plain = fit.believable and fit.p_value is not None and not is_noticeable(fit, gone)
    slips = () if plain else diagnose(mechanism, measurements, frames_sought)
    if not slips and not fit.believable:
        slips = diagnose_groups(mechanism, measurements)
        if not slips and (fit.status != "ok" or is_beyond_noise(fit)):
            slips = _diagnose_sequence(mechanism, data, options)
    at_nominal = 0.0 if fit.believable else nominal_misfit(mechanism, measurements, frames_sought)
    refused = rejection_reason(fit, at_nominal, slips, gone, any_machine=any_machine)
    held_out = (
        None
        if kept_back is None
        else predict_held_out(fit, kept_back.with_sequence("" if choice is None else choice.sequence), seed)
    )
    return FitReport(fit, data.path, command, choice, slips, data.notes, predict_pose_sigma(fit, seed), gone, refused, held_out)


def _hold_out(data: DataFile, hold_out: str | None, seed: int) -> tuple[DataFile, DataFile | None]:
    """What is fitted, and what is held out of it (None where nothing is)."""
    if hold_out is None:
        return data, None
    held = draw_held_out(data.measurements, held_out_count(hold_out, int(np.sum(data.measurements.read))), seed)
    return data.subset(np.flatnonzero(~held)), data.subset(np.flatnonzero(held))


def _diagnose_sequence(mechanism: Mechanism, data: DataFile, options: dict[str, Any]) -> tuple[str, ...]:
    """Whether the Euler angles fit another sequence than the one that the header names; a sentence or none."""
    if data.sequence is None or data.euler is None:
        return ()
    try:
        choice = find_sequence(mechanism, replace(data, open_euler=data.euler), **options)
    except InputError:
        return ()
    if not choice.clear or data.sequence in (choice.sequence, *choice.same) or choice.is_beyond:
        return ()
    return (
        f"the Euler angles look to be of another sequence than {data.sequence}, which the header names: {describe_sequence(choice.sequence)} fits, with "
        f"chi-square {choice.chi_square:.4g} at {choice.best.degrees} degrees of freedom",
    )


def _fit_measurements(
    mechanism: Mechanism, data: DataFile, measurements: Measurements, seed: int, options: dict[str, Any]
) -> Calibration:
    try:
        return calibrate(mechanism, measurements, seed=seed, **options)
    except InputError as error:
        slips = diagnose(mechanism, measurements, _unknown_frames(options)) or _diagnose_sequence(mechanism, data, options)
        if not slips:
            raise InputError(f"{data.path}: {error}") from None
        raise NotFittedError(f"{data.path}: {error}", slips) from None


def _unknown_frames(options: Mapping[str, Any]) -> tuple[str, ...]:
    """Parameters to identify that are measuring frames."""
    return tuple(name for name in options["parameters"] if name in MEASURING_FRAMES and name not in options["fixed"])


def with_sigmas(data: DataFile, sigmas: Mapping[str, np.ndarray | float]) -> Measurements:
    """The measurements with standard deviations (keys joint, group, ...) that the file does not give."""
    m = data.measurements
    for key, value in sigmas.items():
        if key != "joint" and not _is_read(data, key):
            refuse_ignored({f"--sigma-{key}": value}, f"{data.path} holds no {_READING_NAMES[key]}")
        if key == "distance":
            m = replace(m, distances=[_with_sigma(data, d, float(value)) for d in m.distances])
            continue
        if m.sigma(key) is not None:
            raise InputError(f"{data.path}: the standard deviation of {key} readings stands in the file; leave the option out")
        m = replace(m, **{f"{key}_sigma": value})  # type: ignore[arg-type]
    return m


def _is_read(data: DataFile, key: str) -> bool:
    """Whether the file holds readings of a kind (group, inclination, position, orientation, distance)."""
    m = data.measurements
    if key == "distance":
        return bool(m.distances)
    angles = key == "orientation" and (data.euler is not None or data.open_euler is not None)
    return angles or getattr(m, "groups" if key == "group" else key) is not None


def _with_sigma(data: DataFile, d: Distance, value: float) -> Distance:
    if d.sigma is not None:
        raise InputError(f"{data.path}: the standard deviation of {d.name} stands in the file; leave the option out")
    return replace(d, sigma=value)


def match_parameters(mechanism: Mechanism, patterns: str) -> tuple[str, ...]:
    """Parameter names that match any of the patterns (`leg*.base.*`), in the order of the closure; `all` is every parameter
    that moves poses (see `minimal`). What a declared motion binds is only matched by its whole name. Raises InputError for a pattern that matches
    nothing."""
    bound = bound_by_motion(mechanism) - {part.strip() for part in patterns.split(",")}
    return tuple(name for name in _match_patterns(mechanism, patterns) if name not in bound)


def _match_patterns(mechanism: Mechanism, patterns: str) -> tuple[str, ...]:
    known, own = parameter_names(mechanism), set(default_parameters(mechanism))
    wanted: set[str] = set()
    for pattern in (part.strip() for part in patterns.split(",")):
        found = own if pattern == ALL_PARAMETERS else {name for name in known if fnmatchcase(name, pattern)}
        if not found:
            raise InputError(
                f"parameter {pattern!r} matches nothing of {mechanism.name}; allowed: {ALL_PARAMETERS}, {_list_names(known)}, and patterns "
                "such as 'leg*.base.*'"
            )
        wanted |= found
    return tuple(name for name in known if name in wanted)


def _note_left_out(mechanism: Mechanism, patterns: str, names: Sequence[str]) -> tuple[str, ...]:
    """A note on what the patterns match and the declared motion binds."""
    bound = bound_by_motion(mechanism) if patterns == ALL_PARAMETERS else frozenset(_match_patterns(mechanism, patterns))
    missing = [name for name in build_closure(mechanism).parameter_names if name in bound and name not in names]
    if not missing:
        return ()
    return (
        f"not identified, bound by the {mechanism.motion} motion of the platform: {first_of(missing)}; to identify them, declare the "
        "motion spatial",
    )


def _list_names(names: Sequence[str]) -> str:
    """Some names of each beginning and end, that the rest can be guessed from."""
    if len(names) <= _MAX_LISTED_NAMES:
        return ", ".join(names)
    endings = dict.fromkeys(".".join(name.split(".")[1:]) for name in names)
    begins = list(dict.fromkeys(name.split(".")[0] for name in names))
    kinds = [next(n for n in names if n.split(".", 1)[1:] == [ending]) for ending in list(endings)[:_MAX_LISTED_NAMES] if ending]
    more = len(begins) - _MAX_LISTED_NAMES
    return f"{', '.join(kinds)}, ... of {', '.join(begins[:_MAX_LISTED_NAMES])}" + (f" and {more} more" if more > 0 else "")


def frame_names(mechanism: Mechanism, frames: str) -> tuple[str, ...]:
    """Parameters that a choice of frames holds: none for "least"; for "joints:leg1,leg2,leg6/leg1,leg2" the platform frame
    in the first limb's joint, x through the second's, the xy plane through the third's; the base frame in the joint of the
    first limb after the slash, x towards the second's, z against gravity."""
    if frames == LEAST_CHANGE:
        return ()
    kind, _, limbs = frames.partition(":")
    platform, _, base = limbs.partition("/")
    if kind != "joints" or not base:
        raise InputError(
            f"frames = {frames!r} is unknown; allowed: {LEAST_CHANGE}, or joints:P1,P2,P3/B1,B2 with names of rod limbs"
        )
    return joint_frames(mechanism, tuple(s.strip() for s in platform.split(",")), tuple(s.strip() for s in base.split(",")))


def calibrated_mechanism(report: FitReport) -> Mechanism:
    """The corrected mechanism; title and source say what it is."""
    fit, nominal = report.fit, report.fit.mechanism
    how = printable(f"calibrated from {len(fit.used)} postures of {report.data}: {report.verdict}")
    return replace(
        fit.corrected,
        title=f"{nominal.title or nominal.name}, calibrated",
        source="; ".join(s for s in (nominal.source, how) if s),
    )
