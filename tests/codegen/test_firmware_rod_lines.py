"""Limits of rods along straight lines of poses: what the generated C says, against a dense walk by
the lengths' own formula.
"""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.inside import Options, folder_files

ARM = symkin.load("ren2008")
POINTS = 2000
MANY = """
#include "ren2008.h"
void many(int count, const double *lines, int *said);
void many(int count, const double *lines, int *said)
{
    for (int k = 0; k < count; ++k) {
        ren2008_pose ends[2];
        ren2008_info info;
        for (int e = 0; e < 2; ++e) {
            const double *const x = lines + 14 * k + 7 * e;
            for (int i = 0; i < 3; ++i) { ends[e].position[i] = (ren2008_real)x[i]; }
            for (int i = 0; i < 4; ++i) { ends[e].quaternion[i] = (ren2008_real)x[3 + i]; }
        }
        said[3 * k] = (int)ren2008_line(FIRST 0, &ends[0], &ends[1], &info);
        said[3 * k + 1] = info.joint;
        said[3 * k + 2] = info.iterations;
    }
}
"""


def _asked(folder, options, lines):
    """Status, joint and iterations for lines (n, 2, 7)."""
    tools.write_code(ARM, folder, options)
    struct = options.geometry == "struct"
    nominal = (
        "static const ren2008_geometry nominal = REN2008_NOMINAL;\n#define FIRST &nominal,\n"
        if struct
        else "#define FIRST\n"
    )
    (folder / "many.c").write_text(MANY.replace("void many", nominal + "void many", 1))
    command = [
        tools.compiler("gcc"),
        *tools.STRICT,
        "-O2",
        "-shared",
        "-fPIC",
        "ren2008.c",
        "many.c",
        "-o",
        "code.so",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    said, given = np.zeros((len(lines), 3), np.int32), np.ascontiguousarray(lines)
    ctypes.CDLL(str(folder / "code.so")).many(
        len(lines), given.ctypes.data_as(ctypes.c_void_p), said.ctypes.data_as(ctypes.c_void_p)
    )
    return said


def _turned(q, v):
    """Vectors v (3,) turned by unit quaternions (n, 4): v + 2 w u x v + 2 u x (u x v)."""
    u, w = q[:, 1:], q[:, :1]
    across = np.cross(u, v)
    return v + 2 * w * across + 2 * np.cross(u, across)


def _joints_at(poses):
    """Joint values (n, 6) of poses (n, 7)."""
    rods = [
        poses[:, :3] + _turned(poses[:, 3:], np.array(bar.end.point)) - np.array(bar.start.point)
        for bar in ARM.bars
    ]
    return np.stack(
        [np.linalg.norm(d, axis=1) - bar.offset for d, bar in zip(rods, ARM.bars, strict=True)],
        axis=1,
    )


def _joints_along(ends):
    """Joint values (POINTS + 1, 6) along one line of poses."""
    t = np.linspace(0.0, 1.0, POINTS + 1)[:, None]
    first, last = (
        ends[0],
        ends[1] * np.where(np.arange(7) > 2, np.sign(ends[0, 3:] @ ends[1, 3:]), 1.0),
    )
    x = (1 - t) * first + t * last
    x[:, 3:] /= np.linalg.norm(x[:, 3:], axis=1)[:, None]
    return _joints_at(x)


@cache
def _lines(count):
    """Lines between poses with a rod next to a limit and none outside, large turns among them, as a
    float holds them; and how far each rod is outside (negative: inside) at the worst of 2,000
    points.
    """
    rng, tries = np.random.default_rng(1), 60000
    home = symkin.solve(ARM, joints=[0.27] * 6).solution.pose
    turns = np.column_stack(
        [np.ones(tries), rng.choice([0.0, 0.1, 0.4], (tries, 1)) * rng.uniform(-1, 1, (tries, 3))]
    )
    w, u, s, v = (
        turns[:, :1],
        turns[:, 1:],
        float(home.quaternion[0]),
        np.asarray(home.quaternion[1:]),
    )
    q = np.column_stack([w * s - (u @ v)[:, None], w * v + s * u + np.cross(u, v)])
    poses = np.column_stack(
        [
            np.asarray(home.position) + rng.uniform(-0.7, 0.7, (tries, 3)),
            q / np.linalg.norm(q, axis=1)[:, None],
        ]
    )
    joints = _joints_at(poses)
    spare = np.minimum(joints, 0.55 - joints).min(axis=1)
    chosen = poses[(spare > 1e-4) & (spare < 0.03)][: 2 * count]
    lines = chosen.reshape(-1, 2, 7).astype(np.float32).astype(float)
    return lines, np.array(
        [np.maximum(0.0 - q.min(axis=0), q.max(axis=0) - 0.55) for q in map(_joints_along, lines)]
    )


@pytest.mark.parametrize(
    "options",
    [
        pytest.param(Options("double"), marks=pytest.mark.long),
        Options("float"),
        Options("double", geometry="struct"),
    ],
    ids=["double", "float", "struct"],
)
def test_a_line_is_ok_where_a_dense_walk_stays_within_the_limits(options, tmp_path):
    """No OK where one of 2,000 points is outside, all OK where all are inside by a thousandth of
    the stroke; a refusal names a rod that leaves its limits, and takes few looks.
    """
    lines, outside = _lines(300)
    said = _asked(tmp_path, options, lines)
    near = 4e-5 if options.real == "float" else 1e-8
    ok, worst = said[:, 0] == 0, outside.max(axis=1)
    assert np.mean(worst > near) > 0.05
    assert not np.any(ok & (worst > near))
    assert np.all(ok[worst < -0.55e-3])
    assert set(said[:, 0]) == {0, 4}
    blamed = outside[np.flatnonzero(~ok), said[~ok, 1]]
    assert np.all(blamed > -0.55e-3)
    assert np.all(said[ok, 1] == 6)
    assert np.max(said[:, 2]) < 60


def test_a_line_from_or_to_a_pose_outside_is_refused(tmp_path):
    """Backwards too, with the joint; and no number is NONFINITE wherever it stands."""
    inside = _lines(300)[0][0, 0]
    outside = inside + np.array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0])
    first = int(np.flatnonzero(_joints_at(outside[None])[0] > 0.55)[0])
    nothing = np.where(np.arange(7) == 5, np.nan, inside)
    far = inside + np.array([1e9, 0, 0, 0, 0, 0, 0])
    pairs = [
        (inside, outside),
        (outside, inside),
        (inside, nothing),
        (nothing, inside),
        (far, nothing),
        (far, inside),
        (inside, inside),
    ]
    said = _asked(tmp_path, Options("double"), np.array(pairs))
    assert said[:, 0].tolist() == [4, 4, 3, 3, 3, 4, 0]
    assert said[:, 1].tolist()[:2] == [first, first]
    assert said[2:, 1].tolist() == [6] * 5


def test_machines_without_limits_have_no_such_function():
    files = folder_files(
        symkin.load("zhang2009"), Options("double", home=(0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0))
    )
    assert "_line(" not in files["zhang2009.h"]
