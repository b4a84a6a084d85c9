"""Every command with its streams closed, broken or in another encoding: no traceback, and the
status that the contract says.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import symkin
from helpers.gate import in_gate

TITLE = "Ärm θ 中"
ENVIRONMENT = {
    "PYTHONIOENCODING": "ascii",
    "PYTHONUTF8": "0",
    "LC_ALL": "C",
    "MPLBACKEND": "module://nowhere",
}
"""Streams that hold ASCII only, and a wrong backend of matplotlib."""


WHEELS = """format = 1
name = "wheels"
length_unit = "m"
angle_unit = "rad"
joint = [
  { name = "x", type = "R", links = ["base", "a"], point = [0, 0, 0], axis = [0, 0, 1] },
  { name = "y", type = "R", links = ["base", "b"], point = [1, 0, 0], axis = [0, 0, 1] },
]
coupling = [{ joint = "y", of = { x = -1.5 } }]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three revolute joints in space with a title that ASCII cannot hold, and two wheels."""
    folder = tmp_path_factory.mktemp("streams")
    places = ((0.0, 0.0, 0.0), (0.3, 0.0, 0.1), (0.5, 0.2, 0.0))
    axes = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.2), (1.0, 0.3, 0.0))
    joints = [
        symkin.Joint(f"q{k}", "R", p, a, actuated=True)
        for k, (p, a) in enumerate(zip(places, axes, strict=True))
    ]
    arm = symkin.Mechanism(
        "arm",
        [symkin.Limb("arm", joints)],
        (0.7, 0.1, 0.3),
        serial=True,
        length_unit="m",
        angle_unit="deg",
        title=TITLE,
    )
    (folder / "arm.toml").write_text(arm.to_toml(), encoding="utf-8")
    (folder / "wheels.toml").write_text(WHEELS, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def measured(folder):
    """The folder with measurements of the arm."""
    simulated = [
        "calibrate",
        "simulate",
        "arm.toml",
        "--postures",
        "8",
        "--readings",
        "pose",
        "-o",
        "data.csv",
    ]
    assert run(simulated, folder).returncode == 0
    return folder


COMMANDS = {
    "list": ["list"],
    "help": ["--help"],
    "show": ["show", "arm.toml"],
    "latex": ["show", "arm.toml", "--latex"],
    "modes": ["modes", "arm.toml", "--plot", "modes.png"],
    "solve": ["solve", "arm.toml"],
    "singularities": ["singularities", "arm.toml"],
    "firmware": ["firmware", "arm.toml", "-o", "c"],
    "map": ["firmware", "wheels.toml", "--given", "x", "--find", "y", "-o", "map_c"],
    "jacobian": ["jacobian", "arm.toml", "--format", "numpy"],
    "track": [
        "track",
        "arm.toml",
        "--from",
        "0,0,0",
        "--to",
        "1,1,1",
        "--samples",
        "2",
        "--plot",
        "track.png",
    ],
    "sweep": [
        "sweep",
        "arm.toml",
        "--grid",
        "q0=0:1:2",
        "-o",
        "map",
        "--workers",
        "0",
        "--plot",
        "map.png",
    ],
    "fit": ["calibrate", "fit", "arm.toml", "data.csv", "-o", "fit", "--parameters", "q2.point.*"],
    "plan": [
        "calibrate",
        "plan",
        "arm.toml",
        "--postures",
        "12",
        "--groups",
        "0",
        "--readings",
        "position",
        "-o",
        "plan.csv",
    ],
    "simulate": [
        "calibrate",
        "simulate",
        "arm.toml",
        "--postures",
        "3",
        "--readings",
        "pose",
        "-o",
        "simulated.csv",
    ],
}


def run(arguments, folder, *, shell="", environment=None, **options):
    """A command, through a shell where its streams are to be closed."""
    command = [sys.executable, "-m", "symkin", *arguments]
    if shell:
        command = ["sh", "-c", f'exec "$@" {shell}', "sh", *command]
    options = {"capture_output": True} | options
    return subprocess.run(
        command,
        cwd=folder,
        env=os.environ | (environment or {}),
        check=False,
        timeout=300,
        **options,
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(COMMANDS, ["map", "modes"]))
def test_closed_streams_are_as_the_null_device(name, folder, request):
    """With all three closed, and a wrong MPLBACKEND, the command does its work and ends with 0;
    what it opens, a compiler or a picture, is not taken for its streams.
    """
    if name == "fit":
        request.getfixturevalue("measured")
    done = run(COMMANDS[name], folder, shell="<&- >&- 2>&-", environment={"MPLBACKEND": "nonsense"})
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    for path in Path(folder).rglob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    in_gate(
        ["list", "help", "show", "modes", "solve", "jacobian", "track", "simulate"],
        ["list", "show"],
    ),
)
def test_a_reader_that_has_enough_is_no_fault(name, folder):
    """A closed pipe at the other end: quiet, status 0."""
    reading, writing = os.pipe()
    os.close(reading)
    done = run(COMMANDS[name], folder, capture_output=False, stdout=writing, stderr=subprocess.PIPE)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    in_gate(["list", "show", "latex", "modes", "jacobian", "sweep", "fit"], ["show"]),
)
def test_other_encodings_get_escapes(name, folder, request):
    """With streams in ASCII and a wrong MPLBACKEND the command ends with 0, and what ASCII cannot
    hold is escaped.
    """
    if name == "fit":
        request.getfixturevalue("measured")
    done = run(COMMANDS[name], folder, environment=ENVIRONMENT)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.isascii()
    if name in ("show", "modes"):
        assert TITLE.encode("ascii", "backslashreplace") in done.stdout


@pytest.mark.slow
def test_closed_stderr_keeps_stdout_clean(folder):
    """A message that nobody can read does not get into the output; the status tells."""
    done = run(["solve", "arm.toml", "--json", "--joints", "1"], folder, shell="2>&-")
    assert (done.returncode, done.stdout) == (2, b"")
    done = run(["solve", "arm.toml", "--json"], folder, shell="2>&-")
    assert json.loads(done.stdout)["status"] == "ok"


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("name", in_gate(["list", "help", "solve"], ["help", "list"]))
def test_a_full_device_is_one_line(name, folder):
    """What cannot be written is said, with status 2; where the messages go there too, the status is
    left.
    """
    with open("/dev/full", "wb") as full:
        done = run(
            COMMANDS[name], folder, capture_output=False, stdout=full, stderr=subprocess.PIPE
        )
        assert done.returncode == 2
        assert done.stderr == b"symkin: the output cannot be written (No space left on device)\n"
        assert (
            run(COMMANDS[name], folder, capture_output=False, stdout=full, stderr=full).returncode
            == 2
        )


@pytest.mark.slow
def test_file_names_of_other_encodings_are_escaped(folder):
    """A name that is no UTF-8 is refused, found and printed without a traceback."""
    path = os.fsencode(folder) + b"/\xff.toml"
    done = run(["show", path], folder)
    assert done.returncode == 2
    assert b"\\udcff.toml: there is no such file" in done.stderr
    with open(path, "wb") as file:
        file.write((folder / "arm.toml").read_bytes())
    simulated = [
        "calibrate",
        "simulate",
        path,
        "--postures",
        "3",
        "--readings",
        "pose",
        "-o",
        b"\xfe",
    ]
    done = run(simulated, folder)
    assert done.returncode == 0
    assert b"\\udcfe" in done.stdout
