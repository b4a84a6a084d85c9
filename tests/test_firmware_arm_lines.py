"""Lines of tool poses that the closed form of generated arms calls OK, followed finely by codegen/bench/arm_lines.c."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.arms import structures
from symkin.codegen.folder import write_folder
from symkin.codegen.options import Options

CODE = Path(__file__).parent.parent / "codegen" / "bench" / "arm_lines.c"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5e", "scara", *list(structures(np.random.default_rng(3)))[:3]])
@pytest.mark.parametrize("reach", [0.2, 1.0, 3.1])
def test_lines_that_are_ok_have_their_branch_everywhere(name, reach, tmp_path):
    """Each of a thousand points of a line has the guess's branch, and its joints end at the answer, whole turns included; and
    enough lines are answered for that to say something."""
    made = structures(np.random.default_rng(3))
    arm = made.get(name) or symkin.load(name)
    write_folder(arm, tmp_path, Options("double"))
    angular = ",".join(str(int(c.is_angular)) for c in arm.actuated)
    macros = [f"-DNAME={arm.name}", f"-DUPPER={arm.name.upper()}", f'-DSOURCE="{arm.name}.c"', f"-DANGULAR={{{angular}}}"]
    command = [tools.compiler("gcc"), "-O2", *macros, f"-I{tmp_path}", str(CODE), "-lm", "-o", str(tmp_path / "lines")]
    subprocess.run(command, check=True)
    done = subprocess.run([str(tmp_path / "lines"), "1500", "1", "1000", str(reach)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    count, answered = (int(n) for n in re.search(r"(\d+) lines, (\d+) OK", done.stdout).groups())
    assert answered > 0.05 * count
