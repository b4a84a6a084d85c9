"""A posture in the wrong group, found by its inclination at the nominal geometry."""

from __future__ import annotations

import numpy as np

from symkin.calibration.direct import newton_postures, start_points
from symkin.calibration.measurements import Measurements
from symkin.calibration.problem import build_calibration
from symkin.calibration.residuals import deviations
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism

_WORSE = 10.0
"""A posture stands out when it is so many times further from its group than nine tenths of the others are."""
_MOST = 0.9
"""Share of the other postures that it is measured by: errors of the nominal geometry spread them too."""
_LEAST = 3
"""Postures of a group from which one can be told from the others."""


def wrong_groups(mechanism: Mechanism, measurements: Measurements) -> tuple[str, ...]:
    """The posture whose inclination at the nominal geometry is furthest from the median of its group, where it stands out; a
    sentence or none."""
    if measurements.groups is None:
        return ()
    try:
        inclination, group = _inclinations(mechanism, measurements)
    except SymkinError:
        return ()
    numbers, counts = np.unique(group[group >= 0], return_counts=True)
    kept = numbers[counts >= _LEAST]
    if not len(kept):
        return ()
    medians = np.array([np.median(inclination[group == g], axis=0) for g in kept])
    members = np.flatnonzero(np.isin(group, kept))
    places = np.searchsorted(kept, group[members])
    away = np.linalg.norm(_turn(inclination[members] - medians[places]), axis=1)
    worst = int(np.argmax(away))
    usual = float(np.quantile(np.delete(away, worst), _MOST))
    if not away[worst] > _WORSE * usual:
        return ()
    return (_sentence(mechanism, measurements, members[worst], away[worst], usual),)


def _sentence(mechanism: Mechanism, m: Measurements, posture: int, away: float, usual: float) -> str:
    shown = [f"{mechanism.angle_out(float(a)):.3g} {mechanism.angle_unit}" for a in (away, usual)]
    return (
        f"posture {m.labels[posture]} looks to be in the wrong group: at the nominal geometry its inclination is {shown[0]} from the "
        f"others of its group, where nine tenths of the postures are within {shown[1]}"
    )


def _inclinations(mechanism: Mechanism, measurements: Measurements) -> tuple[np.ndarray, np.ndarray]:
    """Inclinations (n, 2) at the nominal geometry and groups (n,), -1 for postures that do not close."""
    problem = build_calibration(mechanism, measurements)
    model, m = problem.model, problem.measurements
    with np.errstate(all="ignore"):
        z, solved = newton_postures(model, start_points(model, m), m.joints, model.nominal)
        e = model.evaluate(np.nan_to_num(z), m.joints, model.nominal, problem.quaternions)
    gap = deviations(problem.readings, np.nan_to_num(e.readings))[:, problem.readings.columns]
    return gap, np.where(solved, problem.readings.group, -1)


def _turn(angles: np.ndarray) -> np.ndarray:
    """Angles by the shorter way."""
    return np.asarray(np.remainder(angles + np.pi, 2 * np.pi) - np.pi)
