"""Random smooth paths of a hexapod, each checked at both ends against all modes and against an
independent continuation.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import symkin

BENCHMARK = Path(__file__).resolve().parents[2] / "benchmarks" / "tracking.py"


def benchmark() -> ModuleType:
    spec = spec_from_file_location("tracking_benchmark", BENCHMARK)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_no_random_path_changes_its_mode_unnoticed() -> None:
    """Each path is certified and reaches its end or stops at a singular configuration; at both ends
    the complete enumeration holds the followed mode, and small Newton steps come to the same one.
    """
    tracking = benchmark()
    counts, _ = tracking.run(symkin.load("zhang2009"), 6, 8, 20.0, np.random.default_rng(0))
    assert counts["certified"] == 6
    assert counts["reached"] + counts["turning point"] == 6
    assert counts["reached"] > 0
    assert all(counts[fault] == 0 for fault in tracking.FAULTS)


def test_the_check_notices_a_changed_mode() -> None:
    """A track that is said to end on another mode than it does is found out."""
    tracking = benchmark()
    mechanism = symkin.load("zhang2009")
    rng = np.random.default_rng(2)
    every = symkin.modes(mechanism)
    path = np.array(every[0].actuated_values) + np.linspace(0.0, 2.0, 3)[:, None] * rng.normal(
        size=6
    )
    found = tracking.track(mechanism, joints=path, start=every[0], name_modes=False)
    other = tracking.track(mechanism, joints=path, start=every[1], name_modes=False)
    assert tracking.faults(found, path) == []
    swapped = replace(found, samples=(*found.samples[:-1], other.samples[-1]))
    assert tracking.faults(swapped, path) == ["unnoticed"]
