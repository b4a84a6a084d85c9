"""Generated C under sanitizers, bit for bit across compilers, and against fine continuation."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from helpers import firmware_tools as tools
from symkin import load
from symkin.codegen.options import Options

CODEGEN = Path(__file__).parent.parent / "codegen"

FUZZ = """
#include "NAME.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
static unsigned long long state = 88172645463325252ULL;
static unsigned long long next(void) { state ^= state << 13; state ^= state >> 7; state ^= state << 17; return state; }
static NAME_real any(NAME_real scale)
{
    const unsigned long long kind = next() % 16ULL;
    const double u = (double)(next() >> 11) * 0x1p-53 * 2.0 - 1.0;
    if (kind == 0ULL) { return (NAME_real)NAN; }
    if (kind == 1ULL) { return (NAME_real)INFINITY; }
    if (kind == 2ULL) { return (NAME_real)0; }
    if (kind == 3ULL) { return (NAME_real)(u * 1e30); }
    if (kind == 4ULL) { return (NAME_real)(u * 1e-30); }
    return (NAME_real)(u * (double)scale);
}
int main(void)
{
    unsigned int counts[8] = { 0 };
    for (int k = 0; k < COUNT; ++k) {
        NAME_pose guess, pose;
        NAME_info info;
        NAME_real joints[NAME_N];
        NAME_real out[NAME_N];
        NAME_real matrix[6 * NAME_N];
        int status;
        for (int i = 0; i < NAME_N; ++i) { joints[i] = any((NAME_real)SCALE); out[i] = joints[i]; }
        for (int i = 0; i < 3; ++i) { guess.position[i] = any((NAME_real)SCALE); }
        for (int i = 0; i < 4; ++i) { guess.quaternion[i] = (k % 3 == 0) ? any((NAME_real)1) : (NAME_real)(i == 0); }
        memset(&pose, 0, sizeof pose);
        CALLS
        if (status < 0 || status > 5) { return 1; }
        ++counts[status];
    }
    printf("%u %u %u %u %u %u\\n", counts[0], counts[1], counts[2], counts[3], counts[4], counts[5]);
    return 0;
}
"""
PARALLEL = """status = (int)NAME_direct(NULL, joints, &guess, &pose, &info);
        for (int i = 0; i < 3; ++i) { if (status == 0 && !isfinite(pose.position[i])) { return 2; } }
        (void)NAME_track(joints, &guess, &info); (void)NAME_inverse(&guess, out); (void)NAME_jacobian(&guess, matrix);"""
SERIAL = """status = (int)NAME_inverse(NULL, &guess, joints, out, &info);
        for (int i = 0; i < NAME_N; ++i) { if (status == 0 && !isfinite(out[i])) { return 2; } }
        (void)NAME_direct(joints, &pose); (void)NAME_jacobian(joints, matrix);"""


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
@pytest.mark.parametrize(
    ("name", "count", "scale"),
    [
        ("zhang2009", 20000, 600),
        ("zhao2000", 20000, 200),
        ("gluon_6l3", 20000, 3),
        ("yao2020", 20000, 3),
        ("zhao2000_links", 2000, 3),
    ],
)
def test_fuzz_under_sanitizers(name, count, scale, real, tmp_path):
    """NaN, infinity, zero, huge, tiny and ordinary inputs: a status, finite results when it is OK, no undefined behaviour.
    SYMKIN_FUZZ sets the count of inputs."""
    count = int(os.environ.get("SYMKIN_FUZZ", count))
    header = (CODEGEN / f"{name}_{real}" / f"{name}.h").read_text()
    joints = re.search(r"_JOINTS \((\d+)\)", header)
    assert joints is not None
    text = FUZZ.replace("CALLS", SERIAL if name in ("gluon_6l3", "yao2020") else PARALLEL)
    text = text.replace("NAME_N", joints.group(1)).replace("NAME", name).replace("COUNT", str(count)).replace("SCALE", str(scale))
    (tmp_path / "fuzz.c").write_text(text)
    folder = CODEGEN / f"{name}_{real}"
    sanitize = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    sources = [str(tmp_path / "fuzz.c"), str(folder / f"{name}.c")]
    counts = tools.passed(tools.built("gcc", tmp_path, sources, "fuzz", *sanitize, f"-I{folder}"))
    assert sum(int(c) for c in counts.split()) == count


WIDE = [("zhang2009", 300, "double", 93.0), ("ren2008", 300, "float", 93.0), ("zhao2000", 150, "double", 50.0)]
"""Mechanism, goals, type, and how many of the regular lines must succeed (%)."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "count", "real", "least"), WIDE)
def test_not_one_ok_on_another_branch(name, count, real, least):
    """Goals far from home: what is OK is what fine continuation reaches; most regular lines succeed."""
    tools.compiler("gcc")
    branches = tools.bench_module("branches")
    found = branches.study(load(name), Options(real, home=branches.HOMES.get(name)), count, seed=4)
    assert found.wrong == 0
    assert found.ok_of_regular > least


@pytest.mark.slow
def test_all_near_goals_are_ok():
    """Within 60 mm and 0.25 rad of home every answer is OK and right."""
    tools.compiler("gcc")
    branches = tools.bench_module("branches")
    near = branches.study(
        load("zhang2009"), Options("float", home=branches.HOME), 200, branches.Reach(60.0 / 531.2592, 0.25), seed=5
    )
    assert near.ok == 200
    assert near.wrong == 0
