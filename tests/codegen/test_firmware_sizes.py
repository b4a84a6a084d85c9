"""The generated folder of the same machine, tiny or huge, passes its own tests: nothing in it is
small or large but beside its size.
"""

from __future__ import annotations

import subprocess
from functools import cache
from itertools import product
from pathlib import Path

import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options, can_run, folder_files, run_own_test, scaled
from helpers.samples import readme_five_bar, three_rrr

MACHINES = Path(__file__).parents[2] / "codegen" / "bench" / "machines"
ANKLE = {"given": ("upper_motor", "lower_motor"), "find": ("ankle.1", "ankle.2")}
CASES = {
    "five_bar": (lambda: symkin.load(MACHINES / "five_bar.toml"), {}),
    "five_bar in space": (readme_five_bar, {}),
    "three_rrr": (lambda: three_rrr("planar"), {}),
    "links": (lambda: symkin.load("zhao2000_links"), {}),
    "delta": (lambda: symkin.load("delta"), {}),
    "six rods": (lambda: symkin.load("zhang2009"), {"home": (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)}),
    "scara": (lambda: symkin.load("scara"), {}),
    "ur5e": (lambda: symkin.load("ur5e"), {}),
    "map": (lambda: symkin.load("ankle"), ANKLE),
}
"""Machine and options of the code, by name."""
SIZES = [1e-8, 1e-4, 1e3, 1e6]
TINY = 3e-11
"""Share of a platform of some 500 mm that is about 1e-8 long."""
KEPT = [
    ("five_bar", 1e-8, "float"),
    ("three_rrr", 1e6, "double"),
    ("scara", 1e-8, "float"),
]
"""What the gate runs: a platform by formulas, an iterated one, an arm, at sizes of which each was
refused once by a scale that was absolute.
"""


@cache
def told(case: str, size: float, real: str) -> dict[str, str]:
    """The folder of the machine of this size; it fails where the own test of another size does."""
    mechanism, options = CASES[case][0](), dict(CASES[case][1])
    if "home" in options:
        x, y, z, *turn = options["home"]
        options["home"] = (size * x, size * y, size * z, *turn)
    mechanism = mechanism if size == 1.0 else scaled(mechanism, size)
    files = folder_files(mechanism, Options(real, **options))
    if size != 1.0:
        run_own_test(mechanism.name, files)
    return {name.removeprefix(mechanism.name): text for name, text in files.items()}


@pytest.mark.slow
@pytest.mark.skipif(not can_run(), reason="no C compiler")
@pytest.mark.parametrize(
    ("case", "size", "real"), in_gate(product(CASES, SIZES, ["double", "float"]), KEPT)
)
def test_the_same_machine_of_any_size_passes_its_own_tests(case, size, real):
    """Its vectors are as many as those at its own size, and statements of its code differ by fewer
    than one in fifty.
    """
    here, there = told(case, size, real), told(case, 1.0, real)
    counts = [files["_vectors.h"].count(" },") for files in (here, there)]
    assert counts[0] == counts[1]
    lines = [files[".c"].count(";") for files in (here, there)]
    assert abs(lines[0] - lines[1]) <= 0.02 * lines[1]


def test_a_tiny_platform_in_float_divides_by_no_square_that_vanishes(tmp_path):
    """Six rods of a size of 1e-8: the fourth power of a step is less than the least float, and code
    that divided by it would stop where divisions by zero are trapped.
    """
    pose = (0.0, 0.0, 420.0 * TINY, 1.0, 0.0, 0.0, 0.0)
    mechanism = scaled(symkin.load("zhang2009"), TINY)
    tools.write_untested(mechanism, tmp_path, Options("float", home=pose))
    trapped = ("-fsanitize=float-divide-by-zero", "-fno-sanitize-recover=all")
    sources = [f"{mechanism.name}.c", f"{mechanism.name}_test.c"]
    program = tools.built("gcc", tmp_path, sources, "own", "-O0", *trapped)
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
