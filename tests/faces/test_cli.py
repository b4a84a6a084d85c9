"""The command line: what it prints, its JSON, its exit status, and that every mistake is one
line.
"""

import json
import math
import signal
import subprocess
import sys
from itertools import cycle, product
from pathlib import Path

import pytest

import symkin
from helpers import inside
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.shipped import TWELVE, UNDRIVEN

MODES_KEYS = {
    "mechanism",
    "problem",
    "given",
    "length_unit",
    "angle_unit",
    "modes",
    "poses",
    "complex_count",
    "completeness",
    "unresolved_paths",
    "smallest_residual",
    "method",
    "seed",
    "elapsed_s",
}
MODE_KEYS = {
    "pose",
    "joints",
    "points",
    "residual",
    "condition",
    "certified",
    "radius",
    "ground",
    "within_limits",
    "notes",
}


def test_list_names_all(capsys: pytest.CaptureFixture[str]) -> None:
    """`list` has a line for each shipped mechanism."""
    status, out, _ = run(capsys, "list")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == symkin.shipped_names()


def imported_by(*words: str) -> set[str]:
    """The modules that a command imports, in a process of its own."""
    command = [sys.executable, "-X", "importtime", "-m", "symkin", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {line.split()[-1] for line in done.stderr.splitlines()}


@pytest.mark.parametrize("word", ["--help", "--version", "list"])
def test_what_computes_nothing_starts_without_numbers(word: str) -> None:
    """Neither NumPy nor CasADi is imported, which take longer than all else."""
    imported = imported_by(word)
    assert "click" in imported
    assert not {"numpy", "casadi"} & imported


def test_an_account_starts_without_what_it_does_not_need() -> None:
    """`show` of a mechanism file: no pictures, no paths of solutions, no readers of robots' files,
    no masked arrays.
    """
    imported = imported_by("show", "zhao2000")
    inner = {name.removeprefix("symkin.") for name in imported}
    heavy = ("matplotlib", "rich", "tomlkit", "flint", "numpy.ma.", "homotopy", "plots")
    assert {"casadi", "position.mobility"} <= inner
    assert [name for name in inner if name.startswith((*heavy, "formats.parts"))] == []


@pytest.mark.parametrize(
    "name",
    in_gate(
        [name for name in symkin.shipped_names() if name not in UNDRIVEN],
        ["ankle", "scara", "slider_crank", "ur5e", "zhang2009"],
    ),
)
def test_modes_json_has_the_contract(capsys: pytest.CaptureFixture[str], name: str) -> None:
    """Contract 3: keys, quaternion w >= 0, rotation matrix of the quaternion, residual small, JSON
    without NaN.
    """
    status, data = run_json(capsys, "modes", name)
    assert status == 0
    assert set(data) >= MODES_KEYS
    for mode in data["modes"]:
        assert set(mode) == MODE_KEYS
        assert mode["residual"] < 1e-9 * symkin.load(name).characteristic_length
        assert (mode["pose"] is None) == (symkin.load(name).platform_link is None)
        if mode["pose"] is not None:
            assert mode["pose"]["quaternion"][0] >= 0
            assert len(mode["pose"]["matrix"]) == 3


@pytest.mark.parametrize(
    ("name", "solver"),
    in_gate(
        product(symkin.shipped_names(), ["newton", "ipopt"]),
        list(zip(TWELVE, cycle(["newton", "ipopt"]), strict=False)),
    ),
)
def test_solve_json_has_the_contract(
    capsys: pytest.CaptureFixture[str], name: str, solver: str
) -> None:
    """The worked example of each mechanism is solved by both solvers; `solve` has solution, status,
    iterations.
    """
    status, data = run_json(capsys, "solve", name, "--solver", solver)
    assert (status, data["status"]) == (0, "ok")
    assert set(data["solution"]) == MODE_KEYS
    assert isinstance(data["iterations"], int)


def test_table_says_what_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    """The table counts modes and states completeness, starts and seed."""
    _, out, _ = run(
        capsys, "modes", "zhao2000", "--method", "multistart", "--seed", "7", "--starts", "300"
    )
    assert "4 modes" in out
    assert "sampled" in out
    assert "seed 7" in out


def test_same_seed_same_answer(capsys: pytest.CaptureFixture[str]) -> None:
    """Same input, same output, but for the time."""
    answers = [
        run_json(
            capsys, "modes", "zhang2009", "--method", "multistart", "--starts", "300", "--seed", "5"
        )[1]
        for _ in range(2)
    ]
    for answer in answers:
        del answer["elapsed_s"]
    assert answers[0] == answers[1]


def test_infeasible_joints_exit_3_with_the_least_error(capsys: pytest.CaptureFixture[str]) -> None:
    """Joint values that no pose satisfies: status 3, no mode, the smallest closure error that was
    reached.
    """
    joints = "100,2000,100,100,100,100"
    status, data = run_json(capsys, "modes", "zhang2009", "--joints", joints)
    assert (status, data["modes"]) == (3, [])
    assert data["smallest_residual"] > 100
    status, data = run_json(capsys, "solve", "zhang2009", "--joints", joints)
    assert status == 3
    assert data["solution"] is None
    assert data["status"] in ("infeasible", "singular", "max_iterations")


def test_pose_off_the_motion(capsys: pytest.CaptureFixture[str]) -> None:
    """Off a restricted motion by under 1e-6: projected, with a note; beyond: no solution."""
    near, far = "0,0,100,1,1e-9,0,0", "0,0,100,0.9998,0.02,0,0"
    status, data = run_json(capsys, "modes", "zhao2000", "--pose", near)
    assert status == 0
    assert any("projected" in note for note in data["notes"])
    status, data = run_json(capsys, "modes", "zhao2000", "--pose", far)
    assert (status, data["modes"]) == (3, [])
    assert data["smallest_residual"] > 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["modes", "nowhere"], ["nowhere", "zhao2000"]),
        (["modes", "nowhere.toml"], ["nowhere.toml", "no such file"]),
        (["modes"], ["MECH"]),
        (["frobnicate"], ["frobnicate"]),
        (["modes", "zhao2000", "--joints="], ["joints", "empty"]),
        (["modes", "zhao2000", "--joints", "1,2"], ["2 values", "4 actuated", "theta1"]),
        (["modes", "zhao2000", "--joints", "1,2,3,nan"], ["value 4", "not finite"]),
        (["modes", "zhao2000", "--joints", "1,2,3,inf"], ["value 4", "not finite"]),
        (["modes", "zhao2000", "--joints", "1,2,3,x"], ["value 4", "'x'", "not a number"]),
        (["modes", "zhao2000", "--joints", "1,2,3,1/0"], ["value 4", "'1/0' has no value"]),
        (["solve", "zhao2000", "--joints", "1,2,3,sin(2"], ["value 4", "'sin(2'"]),
        (
            ["track", "zhao2000", "--from", "1,2,3,4", "--to", "1,2,3,5", "-o", "x.toml"],
            ["x.toml", "mechanism file"],
        ),
        (["jacobian", "zhao2000", "--format", "c", "-o", "no/such/j.c"], ["no/such/j.c", "folder"]),
        (["modes", "zhao2000", "--joints", "1,2,3,-4"], ["op = -4", "length"]),
        (["modes", "zhao2000", "--joints", "1,2,3,4", "--pose", "0,0,0,1,0,0,0"], ["both"]),
        (["modes", "zhao2000", "--pose", "0,0,0,1,0,0"], ["6 values", "7"]),
        (["modes", "zhao2000", "--pose", "0,0,0,1,0,0,0.5"], ["norm"]),
        (["modes", "zhao2000", "--starts", "0"], ["starts", "1"]),
        (["modes", "zhao2000", "--starts", "100000000000"], ["starts", "1000000"]),
        (["modes", "zhao2000", "--starts", "many"], ["starts", "many"]),
        (["modes", "zhao2000", "--plot", "no/such/folder/x.png"], ["no/such/folder"]),
        (["modes", "zhao2000", "--plot", "picture.xyz"], ["xyz"]),
        (["solve", "zhang2009", "--start", "1,2,3"], ["start", "3 values", "7"]),
        (["solve", "zhang2009", "--solver", "magic"], ["solver", "magic", "newton"]),
        (["solve", "zhao2000", "--start", "0,0,100,0.99,0.14,0,0"], ["start", "schoenflies"]),
    ],
    ids=" ".join,
)
def test_mistakes_are_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: list[str]
) -> None:
    """Exit status 2, nothing on stdout, one line on stderr that names the offender and what is
    allowed.
    """
    status, out, err = run(capsys, *arguments)
    assert (status, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert all(word in err for word in words), err


@pytest.mark.parametrize(
    "arguments",
    [
        ["modes", "gluon_6l3", "--joints", "1e150,1e150,1e150,1e150,1e150,1e150"],
        ["modes", "gluon_6l3", "--joints", "1e15,0,0,0,0,0"],
        [
            "modes",
            "zhang2009",
            "--joints",
            "1e7,1e7,1e7,1e7,1e7,1e7",
            "--method",
            "multistart",
            "--starts",
            "200",
        ],
        pytest.param(
            ["modes", "zhang2009", "--pose", "1e150,0,100,1,0,0,0"], marks=pytest.mark.long
        ),
        ["solve", "zhang2009", "--start", "1e150,0,100,1,0,0,0"],
    ],
    ids=" ".join,
)
def test_numbers_beyond_reason_end_in_a_verdict(
    capsys: pytest.CaptureFixture[str], arguments: list[str]
) -> None:
    """Status 0 or 3 and valid JSON; what is listed satisfies the closure, and nothing else is
    called a solution.
    """
    status, data = run_json(capsys, *arguments)
    assert status in (0, 3)
    found = data["modes"] if "modes" in data else [data["solution"]] if data["solution"] else []
    size = symkin.load(data["mechanism"]).characteristic_length
    assert all(mode["residual"] <= 1e-9 * size for mode in found)
    assert data.get("smallest_residual") is None or math.isfinite(data["smallest_residual"])


@pytest.mark.parametrize(
    ("command", "option", "text"),
    [
        ("solve", "--pose", "1e200,0,0,1,0,0,0"),
        ("modes", "--pose", "0,0,-1e151,1,0,0,0"),
        ("modes", "--joints", "1,1,1,1,1,1e300"),
        ("solve", "--start", "1e155,0,0,1,0,0,0"),
        ("singularities", "--joints", "1e200,1,1,1,1,1"),
    ],
)
def test_numbers_whose_squares_overflow_are_refused(
    capsys: pytest.CaptureFixture[str], command: str, option: str, text: str
) -> None:
    """Beyond 1e150 nothing can be computed: one sentence with the value and what is allowed, never
    "inf".
    """
    status, out, err = run(capsys, command, "zhang2009", option, text)
    assert (status, out) == (2, "")
    assert "too large to compute with; allowed: magnitudes up to 1e+150" in err
    assert "inf" not in err.split(":")[-1]


def test_numbers_may_be_arithmetic(capsys: pytest.CaptureFixture[str]) -> None:
    """The same joints, written as arithmetic, have the same solution."""
    plain, written = "81,202,330,105", "9^2,2*101,330*sin(90),100+sqrt(25)"
    answers = [
        run_json(capsys, "solve", "zhao2000", "--joints", joints)[1]["solution"]
        for joints in (plain, written)
    ]
    assert answers[0] == answers[1] is not None


@pytest.mark.parametrize("name", ["load", "_run"])
def test_ctrl_c_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Ctrl-C within a command or outside ends with status 130, nothing on stdout and one line on
    stderr.
    """

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr({"load": inside.load_file, "_run": inside.cli_app}[name], name, interrupted)
    assert run(capsys, "solve", "zhao2000") == (130, "", "symkin: interrupted\n")


@pytest.mark.usefixtures("heard_interrupts")
def test_ctrl_c_that_another_package_makes_an_error_of_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Code in C may turn the interrupt into an error of its own."""

    def foreign(*_: object, **__: object) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise RuntimeError("error in a callback") from None

    monkeypatch.setattr(inside.load_file, "load", foreign)
    assert run(capsys, "solve", "zhao2000") == (130, "", "symkin: interrupted\n")


@pytest.mark.usefixtures("heard_interrupts")
def test_ctrl_c_in_text_that_python_runs_has_its_status(tmp_path: Path) -> None:
    """Classes of data and named tuples are text when they are loaded: pressed within it the process
    ended by the signal, not with 130.
    """
    (tmp_path / "press.py").write_text(
        f"""
import importlib, signal
app = importlib.import_module("{inside.cli_app.__name__}")
app._run = lambda *_: exec("signal.raise_signal(signal.SIGINT)")
app.main(["list"])
"""
    )
    done = subprocess.run(
        [sys.executable, "-m", "press"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "symkin: interrupted\n")


@pytest.mark.usefixtures("heard_interrupts")
def test_ctrl_c_while_modules_are_loaded_is_one_line() -> None:
    """Pressed when the first module of the command line is looked for."""
    code = """
import runpy, signal, sys
class Finder:
    def find_spec(self, name, *_):
        if name.endswith(".cli.app"):
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Finder())
runpy.run_module("symkin", run_name="__main__")
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "symkin: interrupted\n")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    """`--version` prints the version of the package."""
    status, out, _ = run(capsys, "--version")
    assert (status, out.strip()) == (0, symkin.__version__)


def test_bad_input_leaves_files_alone(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A refused command does not touch the picture that it was to write."""
    picture = tmp_path / "picture.png"
    picture.write_bytes(b"kept")
    status, _, _ = run(capsys, "modes", "zhao2000", "--joints", "1,2", "--plot", str(picture))
    assert status == 2
    assert picture.read_bytes() == b"kept"


def test_plot_writes_a_picture(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """`--plot` writes a PNG, `--json` still writes nothing but JSON."""
    picture = tmp_path / "modes.png"
    status, out, _ = run(capsys, "modes", "zhao2000", "--plot", str(picture), "--json")
    assert status == 0
    assert json.loads(out)["poses"] == 4
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_show_latex(capsys: pytest.CaptureFixture[str]) -> None:
    """`show --latex` prints equations, `show` an account."""
    assert r"\begin{align*}" in run(capsys, "show", "zhao2000", "--latex")[1]
    assert "mobility" in run(capsys, "show", "zhao2000")[1]


@pytest.mark.slow
def test_module_runs_and_imports_stay_light() -> None:
    """`python -m symkin` is the command; `import symkin` loads neither matplotlib nor click."""
    done = subprocess.run(
        [sys.executable, "-m", "symkin", "list"], capture_output=True, text=True, check=True
    )
    assert "zhao2000" in done.stdout
    code = (
        "import symkin, sys; print(sorted({'matplotlib', 'click', 'rich', 'numpy'} & "
        "set(sys.modules)))"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert loaded.strip() == "[]"


def test_outputs_do_not_replace_inputs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """`-o` with the name of the mechanism or of the trajectory that the command reads: a sentence,
    and both files stay.
    """
    mechanism, trajectory = tmp_path / "m.toml", tmp_path / "in.csv"
    mechanism.write_text(symkin.load("zhao2000").to_toml())
    trajectory.write_text(
        "theta1[deg],theta2[deg],theta3[deg],op[mm]\n81.6,202.8,330.6,105.2\n82,202.8,330.6,105.2\n"
    )
    before = mechanism.read_text(), trajectory.read_text()
    for arguments in (
        ["track", str(mechanism), "--csv", str(trajectory), "-o", str(trajectory)],
        ["track", str(mechanism), "--csv", str(trajectory), "-o", str(mechanism)],
        [
            "jacobian",
            str(mechanism),
            "--format",
            "c",
            "-o",
            str(tmp_path / ".." / tmp_path.name / "m.toml"),
        ],
    ):
        status, out, err = run(capsys, *arguments)
        assert (status, out) == (2, "")
        assert "is read by this command" in err
    assert (mechanism.read_text(), trajectory.read_text()) == before
