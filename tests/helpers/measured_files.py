"""What readings tell at the nominal geometry, and readings as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from helpers.inside import (
    Identifiability,
    build_calibration,
    evaluate_state,
    identifiability_at,
    measurements_text,
    solve_configurations,
)
from symkin import InputError, Measurements, Mechanism


def write_measurements(
    path: str | Path, mechanism: Mechanism, measurements: Measurements, **options: Any
) -> None:
    """Write readings to a file; `options` are those of `measurements_text`."""
    Path(path).write_text(measurements_text(mechanism, measurements, **options))


def identifiability(
    mechanism: Mechanism,
    measurements: Measurements,
    *,
    parameters: Sequence[str] | None = None,
    fixed: Sequence[str] = (),
    residual: str = "means",
) -> Identifiability:
    """Determine the identifiability at the nominal geometry, over the configurations whose direct
    problem is solved there. Where standard deviations are known, what the readings tell ten times
    worse than the prior (see `estimate.linear`) counts as not told.
    """
    chosen: dict[str, Any] = {"parameters": parameters, "fixed": fixed, "residual": residual}
    problem = build_calibration(mechanism, measurements, **chosen)
    nominal = problem.model.nominal
    configurations = solve_configurations(problem.model, measurements, nominal)
    solved = configurations.solved
    if not solved.any():
        raise InputError(
            f"{mechanism.name}: the direct problem of no posture has a solution at the nominal "
            f"geometry"
        )
    if not solved.all():
        problem = build_calibration(mechanism, measurements.subset(solved), **chosen)
    state = evaluate_state(problem, nominal, configurations.z[solved], "means")
    return identifiability_at(problem, state, 1.0 if problem.readings.known else 0.0)
