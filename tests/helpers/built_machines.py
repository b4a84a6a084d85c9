"""Machines as they are built: off the file's geometry at random, and their random postures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import symkin
from helpers.inside import (
    ClosedConfigurations,
    Noise,
    Workspace,
    default_parameters,
    nominal_parameters,
    random_configurations,
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
