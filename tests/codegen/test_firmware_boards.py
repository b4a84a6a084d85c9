"""The same bits on x86-64, Cortex-M4F and Cortex-M7, and no symbol of a library, no data, no
bss.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from helpers import firmware_tools as tools

CODEGEN = tools.CODEGEN
TARGETS = CODEGEN / "targets"
BOARDS = {
    "M4F": ("mps2-an386", ["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"]),
    "M7": ("mps2-an500", ["-mcpu=cortex-m7", "-mfpu=fpv5-d16"]),
}
FLAGS = ["-O2", "-std=c99", "-ffp-contract=off", "-fno-math-errno"]
ARM = ["-mthumb", "-mfloat-abi=hard", "-nostartfiles"]

DIGEST = """
#include "NAME.h"
#include "NAME_vectors.h"
#include "board.h"
#include <math.h>
#include <stddef.h>
static uint32_t digest = 2166136261u;
static void add(const void *bytes, size_t count)
{
    const unsigned char *b = bytes;
    for (size_t i = 0; i < count; ++i) { digest = (digest ^ b[i]) * 16777619u; }
}
static NAME_pose from(const NAME_real *v)
{
    NAME_pose p;
    for (int i = 0; i < 3; ++i) { p.position[i] = v[i]; }
    for (int i = 0; i < 4; ++i) { p.quaternion[i] = v[3 + i]; }
    return p;
}
static void solve(const NAME_real *joints, NAME_pose guess)
{
    NAME_info info;
    NAME_real back[6];
    NAME_real jacobian[36];
    int status = (int)NAME_direct(NULL, joints, &guess, &guess, &info);
    add(&status, sizeof status); add(&info.iterations, 1);
      add(&info.residual, sizeof info.residual); add(&info.step, sizeof info.step);
    add(&info.min_pivot, sizeof info.min_pivot); add(&guess, sizeof guess);
    status = (int)NAME_track(joints, &guess, &info);
    add(&status, sizeof status); add(&guess, sizeof guess);
      add(&info.residual, sizeof info.residual);
    for (int i = 0; i < 6; ++i) { back[i] = (NAME_real)0; }
    for (int i = 0; i < 36; ++i) { jacobian[i] = (NAME_real)0; }
    status = (int)NAME_inverse(&guess, back);
    add(&status, sizeof status); add(back, sizeof back);
    (void)NAME_jacobian(&guess, jacobian);
    add(jacobian, sizeof jacobian);
}
int main(void)
{
    for (int k = 0; k < NAME_VECTORS_; ++k) {
        NAME_real joints[6];
        for (int i = 0; i < 6; ++i) { joints[i] = NAME_vector_joints[k][i]; }
        solve(joints, from(NAME_vector_guesses[k]));
        solve(joints, from(NAME_vector_poses[(k + 5) % NAME_VECTORS_]));
        joints[k % 6] *= (NAME_real)3;
        solve(joints, from(NAME_vector_home));
        joints[k % 6] = (NAME_real)(k % 2 ? 0 : 1e30);
        solve(joints, from(NAME_vector_guesses[k]));
    }
    board_number(digest);
    board_text("\\n");
    return 0;
}
"""
HOST = """
#include "board.h"
#include <stdio.h>
void board_text(const char *text) { (void)fputs(text, stderr); }
void board_number(uint32_t value) { (void)fprintf(stderr, "%u", (unsigned)value); }
"""


def _digest_source(name: str, tmp_path: Path) -> Path:
    text = DIGEST.replace("NAME_VECTORS_", f"{name.upper()}_VECTORS").replace("NAME", name)
    (tmp_path / "digest.c").write_text(text)
    (tmp_path / "host.c").write_text(HOST)
    return tmp_path / "digest.c"


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
@pytest.mark.parametrize("name", ["zhang2009", "ren2008"])
def test_the_same_bits_everywhere(name, real, tmp_path):
    """Cold, warm, far and failing calls of solvers without trigonometry: host, M4F and M7 agree in
    every bit.
    """
    arm, qemu = tools.compiler("arm-none-eabi-gcc"), tools.compiler("qemu-system-arm")
    folder, main = tools.folder(f"{name}_{real}"), _digest_source(name, tmp_path)
    sources = [str(main), str(folder / f"{name}.c"), f"-I{folder}", f"-I{TARGETS}"]
    digests = {}
    for cc in ("gcc", "clang"):
        command = [
            tools.compiler(cc),
            *FLAGS,
            *sources,
            str(tmp_path / "host.c"),
            "-lm",
            "-o",
            str(tmp_path / cc),
        ]
        subprocess.run(command, check=True)
        digests[cc] = subprocess.run(
            [str(tmp_path / cc)], check=True, capture_output=True, text=True
        ).stderr.strip()
    for board, (machine, flags) in BOARDS.items():
        elf = str(tmp_path / f"{board}.elf")
        link = [
            "-T",
            str(TARGETS / "mps2.ld"),
            str(TARGETS / "board.c"),
            "-lm",
            "-lc",
            "-lgcc",
            "-o",
            elf,
        ]
        subprocess.run([arm, *FLAGS, *ARM, *flags, *sources, *link], check=True)
        run = [
            qemu,
            "-M",
            machine,
            "-nographic",
            "-semihosting-config",
            "enable=on,target=native",
            "-kernel",
            elf,
        ]
        digests[board] = subprocess.run(
            run, check=True, capture_output=True, text=True, timeout=120
        ).stderr.strip()
    assert len(set(digests.values())) == 1, digests


@pytest.mark.parametrize("real", ["float", "double"])
def test_no_library_symbol_no_data_no_bss(real, tmp_path):
    arm = tools.compiler("arm-none-eabi-gcc")
    flags = BOARDS["M4F" if real == "float" else "M7"][1]
    folder = tools.folder(f"zhang2009_{real}")
    subprocess.run(
        [
            arm,
            *FLAGS,
            *ARM[:2],
            *flags,
            "-c",
            str(folder / "zhang2009.c"),
            "-o",
            str(tmp_path / "z.o"),
        ],
        check=True,
    )
    undefined = subprocess.run(
        ["arm-none-eabi-nm", "-u", "z.o"], cwd=tmp_path, check=True, capture_output=True, text=True
    ).stdout
    assert undefined.strip() == ""
    sizes = subprocess.run(
        ["arm-none-eabi-size", "z.o"], cwd=tmp_path, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    assert sizes[1].split()[1:3] == ["0", "0"]


def test_float_code_is_small(tmp_path):
    """Direct, inverse and track linked alone, without libraries, at -O2: code and constants within
    5,650 bytes, of which 40 let a line that is rounding stand still, 20 let parts of a line grow
    after such steps and 40 let one elimination serve all that is solved.
    """
    arm = tools.compiler("arm-none-eabi-gcc")
    roots = [
        "-Wl,--gc-sections",
        "-Wl,-e,zhang2009_direct",
        "-Wl,-u,zhang2009_inverse",
        "-Wl,-u,zhang2009_track",
    ]
    source = [
        str(tools.folder("zhang2009_float") / "zhang2009.c"),
        "-nostdlib",
        "-ffunction-sections",
        "-fdata-sections",
    ]
    subprocess.run(
        [arm, *FLAGS, *ARM[:2], *BOARDS["M4F"][1], *source, *roots, "-o", str(tmp_path / "z.elf")],
        check=True,
    )
    sizes = subprocess.run(
        ["arm-none-eabi-size", "z.elf"], cwd=tmp_path, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    text, data, bss = (int(number) for number in sizes[1].split()[:3])
    assert text <= 5650
    assert (data, bss) == (0, 0)
