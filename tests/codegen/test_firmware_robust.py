"""Generated C under sanitizers, bit for bit across compilers, and against fine continuation."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest

from helpers import firmware_tools as tools
from helpers import joint_types, samples
from helpers.gate import in_gate
from helpers.inside import Options, write_folder
from helpers.wide_five_bar import wide_five_bar

TRAPS = "trap"


FEW = ["ankle_float", "delta_double", "scara_float"]
"""A map, a platform, an arm with a closed form: what the gate feeds with anything."""


def _fuzzed(folder: Path, count: int) -> str:
    """What codegen/bench/fuzz.c prints of a folder; it must find nothing."""
    tools.compiler("gcc")
    clean, said = tools.bench_module("fuzz").fuzzed(folder, count, mode=TRAPS)
    assert clean, said
    return str(said)


@pytest.mark.slow
@pytest.mark.parametrize("folder", in_gate(tools.FOLDERS, FEW))
def test_fuzz_under_sanitizers_and_traps(folder):
    """NaN, infinity, zero, huge, tiny, singular and ordinary inputs: a status, finite results when
    it is OK, no undefined behaviour, no division by zero, and of finite inputs no invalid
    operation. SYMKIN_FUZZ sets the count of inputs.
    """
    said = _fuzzed(tools.folder(folder), int(os.environ.get("SYMKIN_FUZZ", 1000)))
    assert re.search(r"[1-9]\d* answered", said)


def test_a_trap_is_told(tmp_path):
    """Code that divides by zero is found, with its place."""
    folder = shutil.copytree(tools.folder("scara_float"), tmp_path / "folder")
    source = folder / "scara.c"
    source.write_text(
        source.read_text().replace(
            "scara_status status = scara_limit_joints(SCARA_OK, joints);",
            "scara_status status = (1.0f / (joints[0] - joints[0]) > 2.0f) ? SCARA_OK : "
            "SCARA_SINGULAR;",
            1,
        )
    )
    tools.compiler("gcc")
    clean, said = tools.bench_module("fuzz").fuzzed(folder, 100)
    assert not clean
    assert "FPE" in said
    assert "scara.c" in said


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
@pytest.mark.parametrize(
    "made",
    [
        samples.delta,
        samples.three_rps,
        wide_five_bar,
        joint_types.rods_at_the_end,
        samples.pieper,
    ],
)
def test_fresh_code_is_as_careful(made, real, tmp_path):
    """The same of kinds that no committed folder has: deltas, planar and redundant closures,
    cranks, another arm.
    """
    write_folder(made(), tmp_path / "folder", Options(real))
    _fuzzed(tmp_path / "folder", 1000)


WIDE = [
    ("zhang2009", 300, "double", 93.0),
    ("ren2008", 300, "float", 93.0),
    ("zhao2000", 150, "double", 93.0),
]
"""Mechanism, goals, type, and how many of the regular lines must succeed (%)."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "count", "real", "least"), in_gate(WIDE, [row for row in WIDE if row[0] == "ren2008"])
)
def test_not_one_ok_on_another_branch(name, count, real, least):
    """Goals far from home: what is OK is what fine continuation reaches; most regular lines
    succeed.
    """
    tools.compiler("gcc")
    machine = tools.bench_module("subjects").machine_of(name)
    found = tools.study(machine.of(real), count, seed=4)
    assert found.wrong == 0
    assert found.ok_of_regular > least


@pytest.mark.slow
def test_all_near_goals_are_ok():
    """Within 60 mm and 0.25 rad of home every answer is OK and right."""
    tools.compiler("gcc")
    machine = tools.bench_module("subjects").machine_of("zhang2009")
    near = tools.study(
        machine.of("float"),
        200,
        tools.bench_module("ranges").Reach(60.0 / 531.2592, 0.25),
        seed=5,
        folds=False,
    )
    assert near.ok == 200
    assert near.wrong == 0
