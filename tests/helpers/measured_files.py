"""Readings as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from helpers.inside import measurements_text
from symkin import Measurements, Mechanism


def write_measurements(
    path: str | Path, mechanism: Mechanism, measurements: Measurements, **options: Any
) -> None:
    """Write readings to a file; `options` are those of `measurements_text`."""
    Path(path).write_text(measurements_text(mechanism, measurements, **options))
