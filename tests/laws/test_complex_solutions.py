"""Complex solutions that a page follows: the real ones among them are the modes."""

from __future__ import annotations

import numpy as np
import pytest

import symkin
from helpers.inside import complex_solutions
from helpers.laws import evaluated


@pytest.mark.parametrize("name", ["zhang2009"])
def test_the_real_ones_are_the_modes_and_close(name):
    """Rows vanish at all real ones; each mode is one of them, up to the sign of its quaternion; the
    others come in conjugate pairs."""
    modes = symkin.modes(symkin.load(name))
    problem = modes.problem
    found = complex_solutions(problem, modes[0])
    size = problem.closure.characteristic_length
    place = problem.closure.slices["pose.quaternion"]
    real = found[np.max(np.abs(found.imag), axis=1) < 1e-8 * size].real
    assert len(real) == len(modes)
    for values in real:
        rows, errors = evaluated(problem.closure, values)
        assert max(np.max(np.abs(rows)), np.max(np.abs(errors))) < 1e-9
    for mode in modes:
        gaps = np.abs(real - mode.variables)
        gaps[:, place] = np.minimum(gaps[:, place], np.abs(real + mode.variables)[:, place])
        assert np.min(np.max(gaps, axis=1)) < 1e-6 * size
    positions = found[:, [problem.closure.slices[f"pose.{k}"].start for k in "xyz"]]
    gaps = np.max(np.abs(positions[:, None] - positions.conj()[None]), axis=2)
    assert np.max(np.min(gaps, axis=1)) < 1e-6 * size
