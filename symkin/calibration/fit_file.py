"""Fit a mechanism to a data file, and judge the fit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any, Unpack

import numpy as np

from symkin.calibration.calibrate import calibrate
from symkin.calibration.data.files import DataFile
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import Observable
from symkin.calibration.data.parameters import (
    MEASURING_FRAMES,
    bound_by_motion,
    geometry_parameters,
    joint_frames,
    parameter_names,
)
from symkin.calibration.estimate.problem import default_parameters
from symkin.calibration.judge.accuracy import (
    draw_held_out,
    held_out_count,
    predict_held_out,
    predict_pose_sigma,
)
from symkin.calibration.judge.case import Case
from symkin.calibration.judge.mistakes import diagnose, diagnose_labels
from symkin.calibration.judge.outliers import MAX_OUTLIER_SHARE
from symkin.calibration.judge.result import Calibration
from symkin.calibration.judge.trials import find_sequence
from symkin.calibration.judge.verdict import noise_excess
from symkin.calibration.options import LEAST_CHANGE, FileOptions, FitOptions
from symkin.calibration.report import FitReport
from symkin.errors import InputError
from symkin.files.euler_columns import SEQUENCES
from symkin.model.mechanism import Mechanism
from symkin.text import first_of, meant, printable
from symkin.verb import verb
from symkin.verb_options import check_seed, refuse_ignored

ALL_PARAMETERS = "all"
"""The pattern that stands for every parameter that moves poses."""
_MAX_LISTED_NAMES = 12
"""Most names that a message lists."""
_OPTION_OF = {"point": "position"}
"""Kinds of readings whose standard deviations are given as those of another."""


class NotFittedError(InputError):
    """Readings that nothing can be fitted to, and the mistakes (see `diagnose`) that would explain
    it.
    """

    def __init__(self, message: str, suspicions: tuple[str, ...]) -> None:
        super().__init__(f"NOT BELIEVABLE, nothing was fitted: {suspicions[0]} ({message})")
        self.message, self.suspicions = message, suspicions

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle with both arguments, so that a process pool hands the error on."""
        return type(self), (self.message, self.suspicions)


@verb(FileOptions)
def fit_file(
    mechanism: Mechanism,
    data: DataFile,
    *,
    sigmas: Mapping[str, np.ndarray | float] | None = None,
    command: str = "",
    **options: Unpack[FileOptions],
) -> FitReport:
    """Fit a data file and judge the fit.

    `parameters` are patterns of what is identified, separated by commas, by default all; those that
    `hold` matches keep their nominal values. `frames` is "least" or "joints:..." (see
    `frame_names`). `sigmas` are standard deviations by kind of reading, for what the file leaves
    out; `hold_out` is how many configurations (`20`, `20%`) are only predicted. `command` is what
    the report says was run; other `options` are those of `calibrate`.

    Raises InputError, and NotFittedError with what may be wrong in the file where nothing can be
    fitted.
    """
    try:
        data.measurements.check(mechanism)
    except InputError as error:
        raise InputError(f"{data.path}: {error}") from None
    read, seed, hold = data.measurements.observed, options["seed"], options["hold"]
    check_seed(seed)
    patterns = ALL_PARAMETERS if options["parameters"] is None else options["parameters"]
    names = match_parameters(mechanism, patterns, read)
    held = () if hold is None else _match_patterns(mechanism, hold, read)
    kept = dict.fromkeys((*held, *frame_names(mechanism, options["frames"])))
    fixed = tuple(name for name in kept if name in names)
    notes = (*data.notes, *_note_left_out(mechanism, patterns, names, read))
    data = replace(data, notes=notes).without_copies()
    data = replace(data, measurements=with_sigmas(mechanism, data, sigmas or {}))
    kept_back = None
    if options["hold_out"] is not None:
        most = int(data.measurements.is_read.sum())
        drawn = draw_held_out(data.measurements, held_out_count(options["hold_out"], most), seed)
        data, kept_back = (data.subset(np.flatnonzero(some)) for some in (~drawn, drawn))
    placed = [n for n in names if n in MEASURING_FRAMES and n not in fixed]
    choice, case = None, Case.of(mechanism, data, SEQUENCES[0], placed)
    every: dict[str, Any] = {key: options[key] for key in FitOptions.__annotations__}  # type: ignore[literal-required]
    try:
        if data.open_euler is not None:
            form = options["residual"]
            choice = find_sequence(mechanism, data, parameters=names, fixed=fixed, residual=form)
            case = Case.of(mechanism, data, choice.sequence, placed)
        fit = calibrate(mechanism, case.measurements, parameters=names, fixed=fixed, **every)
    except InputError as error:
        if mistakes := diagnose(case):
            raise NotFittedError(f"{data.path}: {error}", mistakes) from None
        raise InputError(f"{data.path}: {error}") from None
    held_out = None
    if kept_back is not None:
        held_out = predict_held_out(fit, kept_back.with_sequence(case.sequence), seed)
    suspicions = _mistakes(case, fit)
    start = case.examined.start() if noise_excess(fit) else None
    strays = not suspicions and any(o.kind == "group" for o in fit.outliers)
    return FitReport(
        fit=fit,
        data=data.path,
        command=command,
        sequence=choice,
        suspicions=suspicions,
        notes=(*(diagnose_labels(case) if strays else ()), *data.notes),
        sigma=predict_pose_sigma(fit, seed),
        at_nominal={} if start is None else start.misfits,
        held_out=held_out,
    )


def _mistakes(case: Case, fit: Calibration) -> tuple[str, ...]:
    """Find mistakes of the file that may explain a fit which is not believable, or which went far
    from the file's geometry.
    """
    spoilt = {o.configuration for o in fit.outliers}
    doubtful = len(spoilt) >= MAX_OUTLIER_SHARE * len(fit.measurements)
    doubtful |= fit.identifiability.drowned.shape[1] > 0
    if fit.believable and not fit.is_noticeable and not doubtful:
        return ()
    placed = fit.status == "ok" and not noise_excess(fit)
    placed &= fit.any_machine or not fit.is_other_machine
    found = diagnose(replace(case, placed=placed))
    return found if fit.sound and not doubtful else found or diagnose_labels(case)


def with_sigmas(
    mechanism: Mechanism, data: DataFile, sigmas: Mapping[str, np.ndarray | float]
) -> Measurements:
    """Add standard deviations (keys joint, group, ...) that the file does not give."""
    m = data.measurements
    for key, value in sigmas.items():
        read = [(o, r) for o, r in m.channels(mechanism) if _OPTION_OF.get(o.kind, o.kind) == key]
        alone = key == "joint" or (key == "orientation" and data.open_euler is not None)
        if not (alone or read):
            left_out = [note for note in data.notes if "left out" in note]
            why = "; ".join([f"{data.path} holds no {key}s", *left_out])
            refuse_ignored({f"--sigma-{key}": value}, why)
        stated = [o.key if o.by_name else f"{key} readings" for o, r in read if r.sigma is not None]
        if stated or (alone and m.sigma(key) is not None):
            raise InputError(
                f"{data.path}: the standard deviation of {[*stated, f'{key} readings'][0]} stands "
                f"in the file; leave the option out"
            )
        m = m.replaced(key, sigma=value) if alone else m
        for o, _ in read:
            own = _like(mechanism, value, o) if o.of else value
            m = m.replaced(o.key, by_name=o.by_name, sigma=own)
    return m


def _like(mechanism: Mechanism, value: np.ndarray | float, o: Observable) -> float:
    """Choose the standard deviation of an observable; of joints it is by kind, as that of the
    actuated ones.
    """
    if np.ndim(value) == 0:
        return float(value)
    each = np.broadcast_to(value, len(mechanism.actuated))
    for v, c in zip(each, mechanism.actuated, strict=True):
        if c.is_angular == o.angular:
            return float(v)
    raise InputError(f"--sigma-joints: it says nothing of {o.name}; give its column sigma_{o.name}")


def match_parameters(
    mechanism: Mechanism, patterns: str, read: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """Name the parameters that match any of the patterns (`leg*.base.*`), in the order of the
    closure; `all` is every parameter that moves poses (see `default_parameters`). What a declared
    motion binds is only matched by its whole name. Raises InputError for a pattern that matches
    nothing.
    """
    bound = bound_by_motion(mechanism, read) - {part.strip() for part in patterns.split(",")}
    return tuple(name for name in _match_patterns(mechanism, patterns, read) if name not in bound)


def _match_patterns(mechanism: Mechanism, patterns: str, read: tuple[str, ...]) -> tuple[str, ...]:
    known, own = parameter_names(mechanism, read), set(default_parameters(mechanism, read))
    wanted: set[str] = set()
    for pattern in (part.strip() for part in patterns.split(",")):
        found = (
            own
            if pattern == ALL_PARAMETERS
            else {name for name in known if fnmatchcase(name, pattern)}
        )
        if not found:
            raise InputError(
                f"parameter {pattern!r} matches nothing of "
                f"{mechanism.name}{meant(pattern, known)}; allowed: {ALL_PARAMETERS}, "
                f"{first_of(known, _MAX_LISTED_NAMES)}, and patterns "
                "such as 'leg*.base.*'"
            )
        wanted |= found
    return tuple(name for name in known if name in wanted)


def _note_left_out(
    mechanism: Mechanism, patterns: str, names: Sequence[str], read: tuple[str, ...]
) -> tuple[str, ...]:
    """Note what the patterns match and the declared motion binds."""
    bound = bound_by_motion(mechanism, read)
    if patterns != ALL_PARAMETERS:
        bound = frozenset(_match_patterns(mechanism, patterns, read))
    geometry = geometry_parameters(mechanism, read)
    missing = [name for name in geometry if name in bound and name not in names]
    if not missing:
        return ()
    if mechanism.motion == "spatial":
        return (
            f"not identified, since a planar or spherical loop could no longer move: "
            f"{first_of(missing)}",
        )
    return (
        f"not identified, bound by the {mechanism.motion} motion of the platform: "
        f"{first_of(missing)}; to identify them, declare the "
        "motion spatial",
    )


def frame_names(mechanism: Mechanism, frames: str) -> tuple[str, ...]:
    """Name the parameters that a choice of frames holds: none for "least"; for
    "joints:leg1,leg2,leg6/leg1,leg2" the platform frame in the first limb's joint, x through the
    second's, the xy plane through the third's; the base frame in the joint of the first limb after
    the slash, x towards the second's, z against gravity.
    """
    if frames == LEAST_CHANGE:
        return ()
    kind, _, limbs = frames.partition(":")
    platform, _, base = limbs.partition("/")
    if kind != "joints" or not base:
        raise InputError(
            f"frames = {frames!r} is unknown; allowed: {LEAST_CHANGE}, or joints:P1,P2,P3/B1,B2 "
            f"with names of rod limbs"
        )
    chosen = ([s.strip() for s in some.split(",")] for some in (platform, base))
    return joint_frames(mechanism, *chosen)


def calibrated_mechanism(report: FitReport) -> Mechanism:
    """Build the corrected mechanism; title and source say what it is."""
    fit, nominal = report.fit, report.fit.mechanism
    how = printable(f"calibrated from {len(fit.used)} postures of {report.data}: {report.verdict}")
    return replace(
        fit.corrected,
        title=f"{nominal.title or nominal.name}, calibrated",
        source="; ".join(s for s in (nominal.source, how) if s),
    )
