"""Generated code says from which size of its machine on it holds: a machine just above passes its
own test, one well below is refused.
"""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import samples
from helpers.gate import in_gate
from helpers.inside import Options, folder_files, scaled

HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
CASES = {
    "five_bar": (samples.readme_five_bar, {}),
    "three_rrr": (lambda: samples.three_rrr("planar"), {}),
    "three_rps": (samples.three_rps, {}),
    "delta": (lambda: symkin.load("delta"), {}),
    "six rods": (lambda: symkin.load("zhang2009"), {"home": HOME}),
    "scara": (lambda: symkin.load("scara"), {}),
    "ur5e": (lambda: symkin.load("ur5e"), {}),
    "arm by iteration": (lambda: symkin.load("yao2020"), {}),
    "map": (
        lambda: symkin.load("ankle"),
        {"given": ("upper_motor", "lower_motor"), "find": ("ankle.1", "ankle.2")},
    ),
}
KEPT = [("scara", "float"), ("six rods", "float"), ("scara", "double")]
"""What the gate runs."""
FLUSHED = """#include <xmmintrin.h>
__attribute__((constructor)) static void flush(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
"""
"""Takes what is less than the least normal number for 0, as some processors do."""


def sized(case, size, real):
    """A machine of a size, with the options of its code."""
    made, options = CASES[case][0](), dict(CASES[case][1])
    factor = size / made.characteristic_length
    if "home" in options:
        *place, w, x, y, z = options["home"]
        options["home"] = (*(factor * v for v in place), w, x, y, z)
    return scaled(made, factor), Options(real, **options)


def told(readme):
    """The smallest size that a folder's README tells, and its unit."""
    number, unit = re.search(r"holds from (\S+) (\w+) on", " ".join(readme.split())).groups()
    return float(number), unit


def program_of(mechanism, options):
    """The program of a machine."""
    return tools.inside.codegen_program.build_program(mechanism, options)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "real"), in_gate([(c, r) for c in CASES for r in ("float", "double")], KEPT)
)
def test_a_machine_just_above_the_smallest_size_passes_and_half_of_it_is_refused(
    case, real, tmp_path
):
    """With numbers below the least normal one as they are, and as 0."""
    least = program_of(*sized(case, 300.0, real)).smallest.value
    mechanism, options = sized(case, 1.01 * least, real)
    files = folder_files(mechanism, options)
    for name, text in {**files, "flushed.c": FLUSHED}.items():
        (tmp_path / name).write_text(text)
    sources = [f"{mechanism.name}.c", f"{mechanism.name}_test.c"]
    for number, more in enumerate(([], ["flushed.c"])):
        tools.passed(tools.built("gcc", tmp_path, sources + more, f"test{number}", "-O0", "-w"))
    assert told(files["README.md"]) == (float(f"{least:.3g}"), mechanism.length_unit)
    with pytest.raises(symkin.InputError, match=r"its size.* holds from .* on, because"):
        folder_files(*sized(case, 0.5 * least, real))


@pytest.mark.parametrize("real", ["float", "double"])
def test_spellings_tell_one_smallest_size_in_their_unit(real):
    """An arm by its table and by joints, a delta without its motion, each in millimetres and
    metres.
    """
    arm, delta = symkin.load("scara"), symkin.load("delta")
    for spellings in ([arm, scaled(arm, 1.0)], [delta, replace(delta, motion="spatial")]):
        spellings += [replace(scaled(m, 1e-3), length_unit="m") for m in spellings]
        found = [program_of(m, Options(real)) for m in spellings]
        assert [p.mechanism.length_unit for p in found] == ["mm", "mm", "m", "m"]
        assert len({p.smallest.value for p in found}) == 1
