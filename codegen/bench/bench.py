"""Instructions per solve, size and stack of the generated C on Cortex-M boards under QEMU; writes the table of README.md.

    python codegen/bench/bench.py [--write]

Cold: from home. Warm: within 0.2 mm and 1 mrad of the answer. Boards count instructions by SysTick under -icount
shift=0. Beside it, in the same run, CasADi's own C of a fast_newton rootfinder for the same poses.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import tempfile
from collections import defaultdict
from pathlib import Path

import casadi as ca
import numpy as np

from symkin.firmware.emit import Real
from symkin.firmware.folder import write_folder
from symkin.firmware.options import Options
from symkin.firmware.program import build_program
from symkin.firmware.rods import RodPlatform, sample_poses
from symkin.firmware.vectors import build_vectors, rounded_to
from symkin.model.file import load
from symkin.position.newton import flat_rows
from symkin.position.problem import build_problem
from symkin.spatial.rotation import multiply

HERE = Path(__file__).parent
TARGETS = HERE.parent / "targets"
HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
BOARDS = {
    "M4F": ("mps2-an386", ["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"], "float"),
    "M7": ("mps2-an500", ["-mcpu=cortex-m7", "-mfpu=fpv5-d16"], "double"),
}
COMMON = ["-O2", "-std=c99", "-mthumb", "-mfloat-abi=hard", "-ffp-contract=off", "-fno-math-errno"]

MAIN = """
#include "board.h"
#include <math.h>
@include@
@tables@
static uint32_t measured(int kind, int k, double *error)
{
    uint32_t total = 0u;
    for (int r = 0; r < 16; ++r) {
        for (volatile int shift = 0; shift < r; ++shift) { }
        @prepare@
        const uint32_t begin = board_ticks();
        @call@
        total += (board_ticks() - begin) & 0xFFFFFFu;
        *error = 0.0;
        for (int i = 0; i < @checked@; ++i) { *error = fmax(*error, fabs((double)result[i] - expected[k][i])); }
        if (status != 0) { *error = 4e9; }
    }
    return total * board_tick_instructions() / 16u;
}
int main(void)
{
    board_start_counter();
    for (int kind = 0; kind < @kinds@; ++kind) {
        for (int k = 0; k < @count@; ++k) {
            double error;
            const uint32_t instructions = measured(kind, k, &error);
            board_number((uint32_t)kind); board_text(" "); board_number(instructions); board_text(" ");
            board_number((uint32_t)fmin(error * 1e12, 4e9)); board_text(" "); board_number((uint32_t)fmin(error * 1e6, 4e9)); board_text("\\n");
        }
    }
    return 0;
}
"""


def table(kind: str, name: str, rows: np.ndarray, real: Real) -> str:
    lines = ", ".join("{ " + ", ".join(real.hexadecimal(float(v)) for v in row) + " }" for row in rows)
    return f"static const {kind} {name}[{rows.shape[0]}][{rows.shape[1]}] = {{ {lines} }};"


def run(board: str, folder: Path, sources: list[str]) -> np.ndarray:
    """Rows (kind, instructions, error)."""
    machine, flags, _ = BOARDS[board]
    command = ["arm-none-eabi-gcc", *COMMON, *flags, "-nostartfiles", "-T", str(TARGETS / "mps2.ld"), "-I", str(TARGETS), "-I.",
               str(TARGETS / "board.c"), *sources, "-lm", "-lc", "-lgcc", "-o", "bench.elf"]  # fmt: skip
    subprocess.run(command, cwd=folder, check=True)
    qemu = [
        "qemu-system-arm",
        "-M",
        machine,
        "-nographic",
        "-icount",
        "shift=0",
        "-semihosting-config",
        "enable=on,target=native",
        "-kernel",
        "bench.elf",
    ]
    done = subprocess.run(qemu, cwd=folder, check=True, capture_output=True, text=True, timeout=300)
    values = [[int(v) for v in line.split()] for line in done.stderr.splitlines() if re.fullmatch(r"\d+( \d+){3}", line)]
    found = np.array(values, dtype=float)
    fine = np.where(found[:, 2] < 4e9, found[:, 2] * 1e-12, found[:, 3] * 1e-6)
    return np.column_stack([found[:, :2], fine])


def platform_cases(platform: RodPlatform) -> dict[str, np.ndarray]:
    """64 poses within 60 mm and 0.25 rad of home: joints as the code reads them, starts, answers to those joints."""
    system = build_problem(platform.mechanism, "direct").system
    rng = np.random.default_rng(3)
    zero = platform.lengths(platform.home) if platform.options.home_relative else 0.0
    joints, warm, answers = [], [], []
    for pose in sample_poses(platform.home, 64, 60.0, 0.25, 7):
        given = rounded_to(platform.real, platform.joint_values(pose))
        z = np.array([*pose.position, *pose.quaternion])
        for _ in range(2):
            z = system.polish(z, given + zero, 8)
        origin = np.array(platform.home.position) if platform.options.home_relative else np.zeros(3)
        q = multiply(np.array([1.0, *(0.5 * rng.uniform(-1e-3, 1e-3, 3))]), z[3:])
        joints.append(given)
        warm.append([*(z[:3] + rng.uniform(-0.2, 0.2, 3) - origin), *(q / np.linalg.norm(q))])
        answers.append([*(z[:3] - origin), *z[3:]])
    home = np.tile(platform.stated(platform.home), (64, 1))
    return {"joints": np.array(joints), "cold": home, "warm": np.array(warm), "expected": np.array(answers)}


def measure_platform(
    name: str, board: str, options: Options, cases: dict[str, np.ndarray] | None = None
) -> dict[str, list[float]]:
    """Mean, largest and error of cold, warm and track."""
    mechanism = load(name)
    folder = Path(tempfile.mkdtemp())
    write_folder(mechanism, folder, options)
    kind = build_program(mechanism, options).kind
    if cases is None:
        if isinstance(kind, RodPlatform) and name == "zhang2009":
            cases = platform_cases(kind)
        else:
            v = build_vectors(kind)
            odd, n = np.arange(len(v.joints)) % 2 == 1, len(v.joints)
            cases = {
                "joints": v.joints[odd],
                "cold": np.tile(v.home, (n // 2, 1)),
                "warm": v.guesses[odd],
                "expected": v.poses[odd],
            }
    text = MAIN.replace("@include@", f'#include "{name}.h"')
    real, exact = Real(options.real, f"{name}_real"), Real("double")
    tables = [table(real.type, key, cases[key], real) for key in ("joints", "cold", "warm")] + [
        table("double", "expected", cases["expected"], exact)
    ]
    prepare = f"""const {real.type} *const start = (kind == 0) ? cold[k] : warm[k];
        {name}_pose pose; {name}_info info; int status; const {real.type} *const result = pose.position;
        for (int i = 0; i < 3; ++i) {{ pose.position[i] = start[i]; }}
        for (int i = 0; i < 4; ++i) {{ pose.quaternion[i] = start[3 + i]; }}"""
    first = "&nominal, " if options.geometry == "struct" else ""
    if first:
        tables.append(f"static const {name}_geometry nominal = {name.upper()}_NOMINAL;")
    direct, track = (
        f"(int){name}_direct({first}0, joints[k], &pose, &pose, &info)",
        f"(int){name}_track({first}joints[k], &pose, &info)",
    )
    call = f"status = (kind < 2) ? {direct} : {track};"
    for key, value in {
        "tables": "\n".join(tables),
        "prepare": prepare,
        "call": call,
        "checked": "3",
        "kinds": "3",
        "count": str(len(cases["joints"])),
    }.items():
        text = text.replace(f"@{key}@", value)
    (folder / "bench.c").write_text(text)
    return summary(run(board, folder, ["bench.c", f"{name}.c"]), ("cold", "warm", "track"))


def measure_serial(name: str, board: str, real_name: str) -> dict[str, list[float]]:
    mechanism, options = load(name), Options(real_name)  # type: ignore[arg-type]
    folder = Path(tempfile.mkdtemp())
    write_folder(mechanism, folder, options)
    v, n = build_vectors(build_program(mechanism, options).kind), len(mechanism.actuated)
    real = Real(real_name, f"{name}_real")
    tables = [
        table(real.type, "guesses", v.guesses, real),
        table(real.type, "poses", v.poses, real),
        table("double", "expected", v.inverse, Real("double")),
    ]
    prepare = f"""{name}_pose pose; {name}_info info; {real.type} result[{n}]; int status; (void)kind;
        for (int i = 0; i < 3; ++i) {{ pose.position[i] = poses[k][i]; }}
        for (int i = 0; i < 4; ++i) {{ pose.quaternion[i] = poses[k][3 + i]; }}"""
    text = MAIN.replace("@include@", f'#include "{name}.h"')
    call = f"status = (int){name}_inverse(0, &pose, guesses[k], result, &info);"
    for key, value in {
        "tables": "\n".join(tables),
        "prepare": prepare,
        "call": call,
        "checked": str(n),
        "kinds": "1",
        "count": str(len(v.poses)),
    }.items():
        text = text.replace(f"@{key}@", value)
    (folder / "bench.c").write_text(text)
    return summary(run(board, folder, ["bench.c", f"{name}.c"]), ("inverse",))


def measure_casadi(board: str) -> dict[str, list[float]]:
    """CasADi's fast_newton C, double, tolerance 1e-9, on the same 64 poses."""
    folder = Path(tempfile.mkdtemp())
    mechanism = load("zhang2009")
    platform = build_program(mechanism, Options("double", home=HOME)).kind
    if not isinstance(platform, RodPlatform):
        raise TypeError("zhang2009 is a platform on six rods")
    cases = platform_cases(platform)
    system = build_problem(mechanism, "direct").system
    solver = ca.rootfinder(
        "solver",
        "fast_newton",
        {"x": system.unknown, "p": system.known, "g": flat_rows(system)},
        {"abstol": 1e-9, "abstolStep": 1e-9},
    )
    generator = ca.CodeGenerator("newton.c", {"with_header": True})
    generator.add(solver)
    generator.generate(f"{folder}/")
    sizes = [solver.sz_arg(), solver.sz_res(), solver.sz_iw(), solver.sz_w()]
    exact = Real("double")
    tables = [table("double", key, cases[key], exact) for key in ("joints", "cold", "warm", "expected")]
    prepare = f"""static double w[{sizes[3] + 1}]; static casadi_int iw[{sizes[2] + 1}]; double result[7]; int status;
        const double *arg[{sizes[0] + 1}] = {{ (kind == 0) ? cold[k] : warm[k], joints[k] }}; double *res[{sizes[1] + 1}] = {{ result }};"""
    text = MAIN.replace("@include@", '#include "newton.h"')
    for key, value in {
        "tables": "\n".join(tables),
        "prepare": prepare,
        "call": "status = solver(arg, res, iw, w, 0);",
        "checked": "3",
        "kinds": "2",
        "count": "64",
    }.items():
        text = text.replace(f"@{key}@", value)
    (folder / "bench.c").write_text(text)
    return summary(run(board, folder, ["bench.c", "newton.c"]), ("cold", "warm"))


def summary(found: np.ndarray, names: tuple[str, ...]) -> dict[str, list[float]]:
    parts = {name: found[found[:, 0] == k] for k, name in enumerate(names)}
    return {name: [float(p[:, 1].mean()), float(p[:, 1].max()), float(p[:, 2].max())] for name, p in parts.items()}


def footprint(board: str, optimise: str = "-O2") -> tuple[int, dict[str, int]]:
    """Bytes of code and constants of direct, inverse and track, and the stack of each by the summed call graph."""
    _, flags, real = BOARDS[board]
    folder = Path(tempfile.mkdtemp())
    write_folder(load("zhang2009"), folder, Options(real, home=HOME))  # type: ignore[arg-type]
    options = [*COMMON, optimise, "-ffunction-sections", "-fdata-sections", "-fcallgraph-info=su"]
    subprocess.run(["arm-none-eabi-gcc", *options, *flags, "-c", "zhang2009.c", "-o", "z.o"], cwd=folder, check=True)
    listed = subprocess.run(["arm-none-eabi-size", "-A", "z.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    lines = [line.split() for line in listed.splitlines() if line.startswith((".text", ".rodata")) and "jacobian" not in line]
    graph = next(folder.glob("*.ci")).read_text()
    own = {m[0]: int(m[1]) for m in re.findall(r'title: "([^"]+)" label: "[^"]*\\n(\d+) bytes', graph)}
    calls: dict[str, set[str]] = defaultdict(set)
    for caller, callee in re.findall(r'sourcename: "([^"]+)" targetname: "([^"]+)"', graph):
        calls[caller].add(callee)

    def depth(function: str) -> int:
        return own.get(function, 0) + max((depth(c) for c in calls[function]), default=0)

    return sum(int(line[1]) for line in lines), {f: depth(f"zhang2009_{f}") for f in ("direct", "track", "inverse", "jacobian")}


def report() -> str:
    lines = ["| solver | board | case | mean | largest | largest error |", "|---|---|---|---|---|---|"]

    def add(what: str, board: str, result: dict[str, list[float]], unit: str) -> None:
        for case, (mean, largest, error) in result.items():
            lines.append(f"| {what} | {board} | {case} | {mean:,.0f} | {largest:,.0f} | {error:.2g} {unit} |")

    for board, (_, _, real) in BOARDS.items():
        add(f"zhang2009 {real}", board, measure_platform("zhang2009", board, Options(real, home=HOME)), "mm")  # type: ignore[arg-type]
    add(
        "zhang2009 float, home-relative",
        "M4F",
        measure_platform("zhang2009", "M4F", Options("float", home_relative=True, home=HOME)),
        "mm",
    )
    add(
        "zhang2009 double, struct geometry",
        "M7",
        measure_platform("zhang2009", "M7", Options("double", geometry="struct", home=HOME)),
        "mm",
    )
    for board in BOARDS:
        add("CasADi fast_newton, double", board, measure_casadi(board), "mm")
    for board, (_, _, real) in BOARDS.items():
        for name, unit in (("ren2008", "m"), ("zhao2000", "mm"), ("zhao2000_links", "mm")):
            add(f"{name} {real}", board, measure_platform(name, board, Options(real)), unit)  # type: ignore[arg-type]
        for name in ("gluon_6l3", "yao2020"):
            add(f"{name} {real}", board, measure_serial(name, board, real), "rad or mm")
    lines += [
        "",
        "| zhang2009 | bytes of direct, inverse, track | stack of direct / track / inverse / jacobian |",
        "|---|---|---|",
    ]
    for board, (_, _, real) in BOARDS.items():
        for optimise in ("-O2", "-Os"):
            size, stack = footprint(board, optimise)
            lines.append(f"| {real} {board} {optimise} | {size:,} | {' / '.join(str(v) for v in stack.values())} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Measure the generated C on QEMU boards.")
    parser.add_argument("--write", action="store_true", help="write the table into codegen/README.md")
    measured = report()
    print(measured)
    if parser.parse_args().write:
        readme = HERE.parent / "README.md"
        head, _, rest = readme.read_text().partition("<!-- bench -->")
        readme.write_text(f"{head}<!-- bench -->\n{measured}\n<!-- end -->{rest.partition('<!-- end -->')[2]}")
