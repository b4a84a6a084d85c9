"""Machines as they are built: off the file's geometry at random, and their random postures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import symkin
from helpers.inside import (
    WELL_TOLD,
    ClosedConfigurations,
    Noise,
    Workspace,
    default_parameters,
    nominal_parameters,
    predict_readings,
    random_configurations,
    told_directions,
    whitening,
    with_parameters,
    workspace_home_pose,
)


def built(nominal: symkin.Mechanism, off: float, rng: np.random.Generator) -> symkin.Mechanism:
    """A machine whose parameters are off those of the file by normal errors of `off` sizes (angles
    and directions: `off`).
    """
    size, table = nominal.characteristic_length, nominal_parameters(nominal)
    values = {
        n: table[n][0] + off * rng.normal() * (size if table[n][1] == "length" else 1.0)
        for n in default_parameters(nominal)
    }
    return with_parameters(replace(nominal, example=None), values)


def random_postures(
    nominal: symkin.Mechanism, true: symkin.Mechanism, count: int, rng: np.random.Generator
) -> ClosedConfigurations:
    """Postures of the machine about the file's home."""
    workspace = Workspace.about(true, start=workspace_home_pose(nominal))
    return random_configurations(workspace, np.full(count, -1), Noise(), rng)


def explained_errors(fit: symkin.Calibration, exact: symkin.Measurements) -> np.ndarray:
    """What the fit's geometry gives for its readings less what they are without errors, along the
    directions that the readings tell, over the standard deviation that the fit states there.

    A change of the geometry along a direction moves the whitened readings by W J c, at right angles
    to what the others do. In the readings the laws of linear fits hold where combinations of
    parameters do not: these lie along curves that bend by more than their width.
    """
    told = told_directions(fit.problem, fit.state)
    directions = told.columns[:, told.ratios > WELL_TOLD]
    there = replace(fit.problem, measurements=exact).of(np.array(fit.used))
    made = predict_readings(there, fit.state.p, fit.state.z, directions)
    whiten = whitening(there.readings, made.noise)
    along = (whiten @ made.spread).reshape(-1, directions.shape[1])
    errors = (whiten @ made.errors[:, :, None]).reshape(-1)
    return np.asarray(along.T @ errors / np.linalg.norm(along, axis=0))
