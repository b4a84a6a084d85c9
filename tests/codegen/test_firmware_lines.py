"""Lines of joint values that leave what the closure can take: not one is OK, by a formula of its
own.
"""

from __future__ import annotations

import ctypes
import math
import subprocess

import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options
from helpers.wide_five_bar import COUPLER, HOME, passes_dead_centre, slack_of, tip_of, wide_five_bar

MANY = """
#include "wide_five_bar.h"
void many(int count, const wide_five_bar_real *goals, const wide_five_bar_pose *guesses,
  wide_five_bar_pose *poses, int *statuses)
{
    for (int k = 0; k < count; ++k) {
      statuses[k] = (int)wide_five_bar_direct(0, goals + 2 * k, &guesses[k], &poses[k], 0); }
}
"""


def _direct(real, motion, folder):
    """The generated direct problem for many goals and guesses (positions x, y and turns) at once:
    statuses and tips.
    """
    mechanism = wide_five_bar(motion)
    tools.write_code(mechanism, folder, Options(real))
    (folder / "many.c").write_text(MANY)
    command = [
        tools.compiler("gcc"),
        "-O2",
        "-shared",
        "-fPIC",
        "wide_five_bar.c",
        "many.c",
        "-o",
        "code.so",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    library, kind = (
        ctypes.CDLL(str(folder / "code.so")),
        np.float32 if real == "float" else np.float64,
    )

    def answers(goals, guesses):
        given, starts = (np.ascontiguousarray(array, kind) for array in (goals, guesses))
        poses, statuses = np.zeros((len(given), 7), kind), np.zeros(len(given), np.int32)
        arrays = (
            array.ctypes.data_as(ctypes.c_void_p) for array in (given, starts, poses, statuses)
        )
        library.many(len(given), *arrays)
        return statuses, poses[:, :2].astype(float)

    return answers


def _guesses(angles):
    """Poses (n, 7) of the left coupler at crank angles (n, 2), by circles."""
    pins, tips = tip_of(np.concatenate([np.array([HOME]), angles]))
    along = tips - pins[0]
    turned = np.arctan2(along[:, 1], along[:, 0])
    half = 0.5 * (turned - turned[0])[1:]
    zero = np.zeros(len(half))
    return np.stack(
        [tips[1:, 0], tips[1:, 1], zero, np.cos(half), zero, zero, np.sin(half)], axis=-1
    )


def _rounded(angles, real):
    """Angles as the generated code reads them."""
    return angles.astype(np.float32).astype(float) if real == "float" else angles


@pytest.mark.slow
@pytest.mark.parametrize("motion", in_gate(["spatial", "planar"], ["planar"]))
@pytest.mark.parametrize("real", in_gate(["double", "float"], ["float"]))
def test_lines_from_home_by_whole_turns(real, motion, tmp_path):
    """Goals up to half a turn away: the couplers must meet along all of an OK line, the tip is that
    of the circles, and most lines on which nothing is singular are OK. The first goal pulls the
    couplers straight on the way and lets them go again.
    """
    rng = np.random.default_rng(7)
    reach = rng.choice([0.6, 1.0, 2.0, math.pi], (8000, 1))
    goals = np.concatenate(
        [[[3.8746, 0.5354]], np.array(HOME) + reach * rng.uniform(-1, 1, (8000, 2))]
    )
    goals = _rounded(goals, real)
    status, tips = _direct(real, motion, tmp_path)(
        goals, np.repeat(_guesses(np.array([HOME])), len(goals), axis=0)
    )
    slack = slack_of(np.array([HOME]), goals)
    ok, near = status == 0, 1e-4 if real == "float" else 1e-9
    assert status[0] != 0
    assert not np.any(ok & (slack < -near))
    assert (
        np.max(np.linalg.norm(tips - tip_of(goals)[1], axis=1)[ok])
        < (0.05 if real == "float" else 1e-6) * COUPLER
    )
    regular = (slack > 1e-3) & ~passes_dead_centre(np.array([HOME]), goals)
    assert np.mean(ok[regular]) > 0.97
    # where joints go by 0.6 rad at most, everything is regular and answered
    assert np.all(ok[1:][reach[:, 0] == 0.6])


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["double", "float"], ["float"]))
def test_lines_from_anywhere(real, tmp_path):
    """Guesses all over the workspace, half of them with couplers that are nearly straight."""
    rng = np.random.default_rng(8)
    starts = np.array(HOME) + rng.uniform(-1.2, 1.2, (60000, 2))
    slack = slack_of(starts, starts, 1)
    starts = np.concatenate(
        [starts[(slack > 3e-3) & (slack < 6e-2)][:5000], starts[slack > 6e-2][:5000]]
    )
    goals = _rounded(
        starts
        + rng.choice([0.1, 0.3, 0.6, 1.0, 2.0], (len(starts), 1))
        * rng.uniform(-1, 1, starts.shape),
        real,
    )
    status, tips = _direct(real, "planar", tmp_path)(goals, _guesses(starts))
    slack, ok = slack_of(starts, goals), status == 0
    assert np.sum(ok) > 5000
    # the guess's own rounding moves the line
    assert not np.any(ok & (slack < (-1e-4 if real == "float" else -1e-9)))
    assert (
        np.max(np.linalg.norm(tips - tip_of(goals)[1], axis=1)[ok])
        < (0.05 if real == "float" else 1e-6) * COUPLER
    )
