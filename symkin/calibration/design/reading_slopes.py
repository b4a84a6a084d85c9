"""Differentiate the readings that would be taken at closed configurations, over their standard
deviations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP
from symkin.calibration.design.simulation import READING_CHOICES, Noise, simulate_readings
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import ClosedConfigurations
from symkin.calibration.estimate.residuals import build_readings, whitening
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.transfer import many_elsewhere


@dataclass(frozen=True, eq=False)
class ReadingSlopes:
    """Readings over their standard deviations, joint noise included: A (n, K, P) by scaled
    parameters, and B (n, K, 2) by the unknown inclination of the configuration's group, zero where
    it has none.
    """

    parameters: np.ndarray
    group: np.ndarray


def reading_slopes(
    mechanism: Mechanism,
    made: ClosedConfigurations,
    readings: Sequence[str],
    noise: Noise,
    names: Sequence[str],
    *,
    grouped: bool,
) -> ReadingSlopes:
    """Differentiate the readings that would be taken at closed configurations. Raises InputError
    where a reading is without a standard deviation.
    """
    quiet = np.random.default_rng(0)
    groups = np.zeros(len(made), dtype=int) if grouped else np.full(len(made), NO_GROUP)
    taken = simulate_readings(mechanism, made, groups, readings, noise, quiet)
    stated = {r.name: r.sigma for r in taken.readings}
    for kind, key in (("group", "groups"), *((k, k) for k in READING_CHOICES[:3])):
        if getattr(taken, key) is not None:
            stated[f"{kind} readings"] = taken.sigma(kind)
    for name, sigma in stated.items():
        if sigma is None:
            raise InputError(
                f"the standard deviation of {name} is zero or not given; a plan needs it"
            )
    model = build_model(mechanism, taken, names)
    values, weights = build_readings(model, taken), noise.joints(mechanism)
    count = len(mechanism.actuated)
    z = np.ascontiguousarray(
        many_elsewhere(model.closure, build_closure(mechanism), made.values)[:, count:]
    )
    quaternions = np.hstack([made.poses[:, 3:], taken.quaternions[:, 4:]])
    e = model.evaluate(z, made.joints, model.nominal, quaternions)
    by_joint = model.joint_slopes(e, z, made.joints, model.nominal, quaternions) * weights
    slopes = e.readings_p + e.readings_z @ e.following
    # two inclinations have no slopes where the platform's z axis lies level: such a configuration
    # is offered as one that tells nothing
    told = np.all(np.isfinite(by_joint), axis=(1, 2)) & np.all(np.isfinite(slopes), axis=(1, 2))
    by_joint, slopes = (np.where(told[:, None, None], values, 0.0) for values in (by_joint, slopes))
    whiten = whitening(values, by_joint @ by_joint.transpose(0, 2, 1))
    basis = whiten[:, :, values.grouped] if grouped else np.zeros((*whiten.shape[:2], 0))
    return ReadingSlopes(whiten @ slopes, basis)
