"""The worst case that generated folders state: bounds by the code's text, and figures of
processors.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options, WorstCase, bounds, build_program, readme_of

CODEGEN = tools.CODEGEN
MEASURED = json.loads((CODEGEN / "measured.json").read_text())
OPERATIONS = ("additions", "multiplications", "divisions", "sqrt", "sin", "cos", "atan2")
ANOTHER_COMPILER = 1.25
"""Another release of GCC unrolls and spills otherwise: a quarter more instructions, stack or bytes
are no other code.
"""


def _bound(body: str, iterations: int = 100):
    """The bound of a function `f` with this body, other functions before it."""
    return bounds(body, [iterations])[0]["f"]


# --- bounds by the text ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "counted"),
    [
        ("double f(double x) { return x * x + 1.0 - -x; }", {"multiplications": 1, "additions": 2}),
        (
            "double f(double x) { return (x > 0.0) ? sqrt(x) : sin(x) / x; }",
            {"sqrt": 1, "sin": 1, "divisions": 1},
        ),
        (
            "void f(double *x) { for (int i = 0; i < 4; ++i) { for (int j = i + 1; j < 4; ++j) { "
            "x[4 * i + j] *= x[i]; } } }",
            {"multiplications": 6},
        ),
        (
            "void f(double *x) { for (int i = 3; (i >= 0) && (x[i] > 0.0); --i) { x[i] += 1.0; } }",
            {"additions": 4},
        ),
        (
            "void f(double *x) { if (x[0] > 0.0) { x[0] = x[1] * x[2]; } else { x[0] = x[1] + "
            "x[2] + x[3]; } }",
            {"multiplications": 1, "additions": 2},
        ),
        (
            "static double g(double x) { return x / 3.0; }\n"
            "double f(double x) { return g(g(x)) * (double)(int)x; }",
            {"divisions": 2, "multiplications": 1},
        ),
        (
            "static void g(double *x, int count) { for (int i = 0; i < count; ++i) { x[i] -= 1.0; "
            "} }\nvoid f(double *x) { g(x, 5); g(x, 2); }",
            {"additions": 7},
        ),
    ],
)
def test_operations_are_counted_by_hand(body, counted):
    assert _bound(body).operations == counted


def test_a_config_bounds_iterations():
    """A loop that breaks at its config's iterations evaluates its head once more; a config of its
    own has its own number.
    """
    driver = """static void g(double *x, const a_config *config) { unsigned int count = 0U;
        for (;;) { x[0] += 1.0; if (count >= (unsigned int)config->max_iterations) { break;
          } ++count; } }"""
    outer = (
        "void f(double *x, const a_config *config) { static const a_config once = { 1.0, 1U, 2.0 "
        "}; g(x, config); g(x, &once); }"
    )
    for iterations in (100, 255):
        bound = _bound(f"{driver}\n{outer}", iterations)
        assert (bound.iterations, bound.operations) == (
            iterations + 1,
            {"additions": iterations + 3},
        )


@pytest.mark.parametrize(
    "body",
    [
        "void f(double *x) { while (x[0] > 1.0) { x[0] = x[0] / 2.0; } }",
        "void f(double *x, int count) { for (int i = 0; i < count; ++i) { x[i] += 1.0; } }",
        "double f(double x) { return (x > 1.0) ? f(x / 2.0) : x; }",
        "double f(double x) { return tgamma(x); }",
        "void f(double *x) { for (;;) { x[0] += 1.0; } }",
    ],
)
def test_what_the_text_does_not_tell_has_no_bound(body):
    assert _bound(body) is None


def _counted(folder: str, place: Path, inputs: int) -> dict[str, dict[str, int]]:
    """The most operations of a call of each function, counted while a folder's C runs with numbers
    that count (C++).
    """
    manifest = tools.manifest(folder)
    name, real = manifest["mechanism"], manifest["options"]["real"]
    for file in (f"{name}.c", f"{name}.h", f"{name}_vectors.h"):
        text = (tools.folder(folder) / file).read_text().replace('extern "C" {', 'extern "C++" {')
        (place / file).write_text(
            text.replace(f"typedef {real} {name}_real;", f"typedef number {name}_real;")
        )
    processors, calls = tools.bench_module("processors"), tools.bench_module("calls")
    helpers = Path(tools.__file__).parent
    driver = calls.driver(tools.folder(folder), helpers / "count_hooks.h", place)
    called = (place / "calls.h").read_text()
    counting = f'#include "{helpers / "counted.h"}"\n#include "{name}.c"\n'
    (place / "calls.h").write_text(counting + called)
    flags = f"-x c++ -std=gnu++17 -w -O1 -DNUMBER={real} -DCOUNT={inputs}L -DSEED=3"
    tools.compiler("g++")
    said = processors.said("host", processors.linked("host", f"{flags} {driver}", place, "g++"))
    rows = [line.split() for line in said.splitlines()]
    return {row[0]: dict(zip(OPERATIONS, map(int, row[1:]), strict=True)) for row in rows}


@pytest.mark.parametrize(
    "folder",
    [
        "ankle_float",
        *(
            pytest.param(f, marks=pytest.mark.long)
            for f in ("delta_double", "ren2008_float", "zhao2000_links_float")
        ),
        pytest.param("scara_float", marks=pytest.mark.slow),
    ],
)
def test_no_call_does_more_than_its_bound(folder, tmp_path):
    """An independent count, of operations that are carried out."""
    bound = tools.manifest(folder)["worst_case"]["bound"]
    met = _counted(folder, tmp_path, 5000)
    assert set(met) == set(bound)
    for function, counts in met.items():
        assert counts["multiplications"] > 0
        for operation, count in counts.items():
            assert count <= bound[function]["usual"]["operations"].get(operation, 0), (
                function,
                operation,
            )


# --- what folders say -----------------------------------------------------------------------------


@pytest.mark.parametrize("folder", tools.at_hand(tools.FOLDERS))
def test_header_and_readme_have_the_numbers_of_the_manifest(folder):
    manifest = tools.manifest(folder)
    worst, name = manifest["worst_case"], manifest["mechanism"]
    header = (tools.folder(folder) / f"{name}.h").read_text()
    declared = set(re.findall(rf"^(?:int|{name}_status) {name}_(\w+)\(", header, re.M))
    assert set(worst["bound"]) == declared
    words = " ".join(re.sub(r"^ \*", "", header, flags=re.M).split())
    readme = (tools.folder(folder) / "README.md").read_text()
    for function, bound in worst["bound"].items():
        for case in ("usual", "largest"):
            assert bound[case] is not None
            row = " | ".join(
                f"{bound[case]['operations'].get(operation, 0):,}" for operation in OPERATIONS
            )
            assert re.search(
                rf"\| `{function}` \| .* \| {bound[case]['iterations']} \| {re.escape(row)} \|",
                readme,
            )
        assert re.search(
            rf" {function}: .*?\b{bound['usual']['operations']['multiplications']} mul\b", words
        )
    if worst["measured"]:
        for function, f in worst["measured"]["functions"].items():
            assert (
                f" {function}: {f['instructions']} instructions, {f['stack']} stack, {f['bytes']} "
                f"code" in words
            )
            assert (
                f"| `{function}` | {f['instructions']:,} | {f['stack']:,} | {f['bytes']:,} |"
                in readme
            )


def test_figures_of_another_code_are_left_out():
    """They are kept where the digest is that of the code."""
    figures = MEASURED["ur5e_double"]
    code = (tools.folder("ur5e_double") / "ur5e.c").read_text()
    program = build_program(symkin.load("ur5e"), Options("double"))
    for digest, kept in ((hashlib.sha256(code.encode()).hexdigest(), True), ("0" * 64, False)):
        worst = WorstCase.of("ur5e", code, {**figures, "code": digest})
        assert (worst.manifest()["measured"] is not None) is kept
        assert any("bytes of stack" in line for line in worst.header_lines()) is kept
        assert ("worst.py FOLDER" in readme_of(replace(program, worst=worst))) is not kept


@pytest.mark.slow
@pytest.mark.parametrize("folder", tools.at_hand(tools.FOLDERS))
def test_figures_are_measured_of_this_code(folder):
    """Else the code has changed: run codegen/bench/worst.py --write, then codegen/generate.py.
    Committed folders state them.
    """
    manifest, measured = tools.manifest(folder), MEASURED[folder]
    code = manifest["files"][f"{manifest['mechanism']}.c"]
    assert measured["code"] == code, (
        "run python codegen/bench/worst.py --write, then python codegen/generate.py"
    )
    assert folder not in tools.COMMITTED or manifest["worst_case"]["measured"] == measured
    assert measured["inputs"] > 500
    for f in measured["functions"].values():
        assert f["bytes"] <= f["bytes_with_library"]
        # painted memory tells the same of the inputs that were tried; 64 bytes beside the caller's
        # frame are not looked at
        assert f["stack_touched"] <= max(f["stack"], 64) + 64


@pytest.mark.slow
@pytest.mark.parametrize("folder", in_gate(["scara_float", "delta_double"], ["delta_double"]))
def test_measured_again_nothing_is_exceeded(folder):
    """On M4F and M7, other inputs than the ones that the figures are of."""
    tools.compiler("arm-none-eabi-gcc"), tools.compiler("qemu-system-arm")
    stated = MEASURED[folder]
    again = tools.bench_module("worst").measured(
        tools.folder(folder), seed=2, most_inputs=2000, most_ticks=6_000_000
    )
    assert set(again["functions"]) == set(stated["functions"])
    assert again["library"] == stated["library"]
    for function, f in again["functions"].items():
        for key in ("instructions", "stack", "bytes", "bytes_with_library"):
            assert 0 < f[key] <= ANOTHER_COMPILER * stated["functions"][function][key], (
                function,
                key,
            )


def test_the_dearest_input_of_a_code_is_not_forgotten():
    """Searches of the same code, one luckier than the other; those of another code say nothing."""
    remembered = tools.bench_module("worst").remembered
    lucky, other = (
        {"code": "a", "compiler": "c", "processor": "p", "functions": {"f": {"instructions": n}}}
        for n in (90, 40)
    )
    for first, second in ((lucky, other), (other, lucky)):
        assert remembered(first, second)["functions"]["f"]["instructions"] == 90
    assert remembered({**lucky, "code": "b"}, other) == remembered(None, other) == other


# --- sums of stacks -------------------------------------------------------------------------------


def test_stacks_follow_callees():
    """f calls g and h; the deeper way counts, once."""
    footprint = tools.bench_module("footprint")
    frames, calls = {"f": 8, "g": 24, "h": 16, "k": 40}, {"f": {"g", "h"}, "h": {"k"}}
    assert footprint.depth("f", frames, calls) == 8 + 16 + 40
    assert footprint.depth("g", frames, calls) == 24
    with pytest.raises(ValueError, match=r"h -> k -> h: a recursion"):
        footprint.depth("h", frames, {**calls, "k": {"h"}})
    with pytest.raises(ValueError, match="cosf: its stack is not known"):
        footprint.depth("g", frames, {"g": {"cosf"}})


def test_pushes_are_summed():
    """Registers of 4 and 8 bytes, and what is taken off the stack pointer."""
    text = """
00000000 <sinf>:
   0:\tpush\t{r4, r5, r6-r8, lr}
   2:\tvpush\t{d8-d9}
   6:\tsub\tsp, #20
   8:\tbl\t20 <reduce>
   a:\tb.n\t4 <sinf+0x4>
00000020 <reduce>:
  20:\tstr.w\tlr, [sp, #-4]!
  24:\tsub.w\tsp, sp, #512\t@ 0x200
  28:\tadd\tr0, r1
"""
    footprint = tools.bench_module("footprint")
    frames, jumps = footprint.disassembled(text)
    assert frames == {"sinf": 6 * 4 + 2 * 8 + 20, "reduce": 516}
    assert footprint.depth("sinf", frames, jumps) == 60 + 516
    with pytest.raises(ValueError, match="no fixed size"):
        footprint.disassembled(text.replace("#512", "r3"))
