"""Exported Jacobians: each file, run in its own language, gives the same matrix; names, heads,
bytes and refusals.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import symkin
from helpers import inside, samples
from helpers import jacobian_cases as cases
from helpers.exported_jacobians import module_of, run_c, run_latex
from helpers.gate import in_gate
from helpers.inside import FORMATS, jacobian_text, main
from helpers.shipped import LIMBS
from symkin import InputError, jacobian

CASES = [
    *((name, "direct") for name in LIMBS),
    ("zhang2009", "inverse"),
    ("zhao2000", "inverse"),
    ("gluon_6l3", "inverse"),
    ("yao2020", "analytic"),
    ("zhao2000", "analytic"),
    ("zhao2000", "passive"),
    ("three_rps", "inverse"),
    ("helical_actuated", "passive"),
    ("cylindrical", "passive"),
    ("delta", "direct"),
    ("planar RUS", "passive"),
    ("arm RRP", "inverse"),
]


def _inputs(symbolic, values):
    return [float(values[v.index]) for v in symbolic.inputs] + [
        float(symbolic.closure.parameter_values[v.index]) for v in symbolic.parameters
    ]


_LOADER = """
import json, sys
import casadi
for line in sys.stdin:
    path, inputs = json.loads(line)
    function = casadi.Function.load(path)
    matrix = casadi.DM(function(**dict(zip(function.name_in(), inputs)))["jacobian"]).full()
    assert "symkin" not in sys.modules
    print(json.dumps(matrix.tolist()), flush=True)
"""


@pytest.fixture(scope="module")
def run_casadi(tmp_path_factory):
    """A process without symkin that loads what it is given the name of and evaluates it."""
    folder = tmp_path_factory.mktemp("casadi")
    process = subprocess.Popen(
        [sys.executable, "-c", _LOADER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=folder,
    )

    def run(symbolic, inputs):
        (folder / "j.casadi").write_text(jacobian_text(symbolic, "casadi"))
        process.stdin.write(json.dumps([str(folder / "j.casadi"), inputs]) + "\n")
        process.stdin.flush()
        return np.array(json.loads(process.stdout.readline())).reshape(symbolic.shape)

    yield run
    process.stdin.close()
    process.stdout.close()
    assert process.wait(timeout=60) == 0


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), in_gate(CASES, CASES[1::6]))
def test_formats_agree_to_thirteen_digits(name, kind, tmp_path, run_casadi):
    """NumPy, SymPy, C, CasADi and LaTeX files give the expression's matrix to 1e-13 of the largest
    entry.
    """
    case = cases.case(name)
    symbolic = jacobian(case.mechanism, kind)
    inputs, expected = _inputs(symbolic, case.values), symbolic.at(case.values)
    found = {"numpy": module_of(jacobian_text(symbolic, "numpy"))["jacobian"](*inputs)}
    if shutil.which("gcc"):
        found["c"] = run_c(symbolic, inputs, tmp_path)
    found["casadi"] = run_casadi(symbolic, inputs)
    found["latex"] = run_latex(symbolic, inputs)
    pytest.importorskip("sympy")
    found["sympy"] = module_of(jacobian_text(symbolic, "sympy"))["lambdified"]()(*inputs)
    for language, matrix in found.items():
        matrix = np.array(matrix, dtype=float).reshape(symbolic.shape)
        np.testing.assert_allclose(
            matrix, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)), err_msg=language
        )


@pytest.mark.parametrize("name", ["zhang2009", "arm RRP"])
def test_geometry_symbols_are_inputs_after_the_variables(name, tmp_path, run_casadi):
    """With the geometry as symbols every format takes it after the variables."""
    case = cases.case(name)
    symbolic = jacobian(case.mechanism, "inverse", parameters=True)
    inputs, expected = _inputs(symbolic, case.values), symbolic.at(case.values)
    found = [
        module_of(jacobian_text(symbolic, "numpy"))["jacobian"](*inputs),
        run_casadi(symbolic, inputs),
        run_latex(symbolic, inputs),
    ]
    if shutil.which("gcc"):
        found.append(run_c(symbolic, inputs, tmp_path))
    for matrix in found:
        np.testing.assert_allclose(matrix, expected, rtol=0, atol=1e-12 * np.max(np.abs(expected)))


def test_sympy_expands_to_the_inputs_alone():
    """The expanded matrix holds input symbols only, with their names, and evaluates to the same
    numbers.
    """
    pytest.importorskip("sympy")
    case = cases.case("delta")
    symbolic = jacobian(case.mechanism, "inverse")
    module = module_of(jacobian_text(symbolic, "sympy"))
    expanded = module["expanded"]()
    assert {str(s) for s in expanded.free_symbols} <= {v.name for v in symbolic.inputs}
    numbers = expanded.evalf(
        17, subs=dict(zip(module["inputs"], _inputs(symbolic, case.values), strict=True))
    )
    np.testing.assert_allclose(
        np.array(numbers, dtype=float), symbolic.at(case.values), rtol=0, atol=1e-12
    )


def test_numpy_takes_arrays():
    """Arrays of inputs (shapes broadcast) give an array of matrices, each that of its inputs."""
    case = cases.case("zhao2000")
    symbolic = jacobian(case.mechanism, "inverse")
    function = module_of(jacobian_text(symbolic, "numpy"))["jacobian"]
    inputs = _inputs(symbolic, case.values)
    shifts = np.array([[0.0, 0.1, 0.2], [0.3, 0.4, 0.5]])
    many = function(inputs[0] + shifts, *inputs[1:])
    assert many.shape == (2, 3, *symbolic.shape)
    for place in np.ndindex(2, 3):
        np.testing.assert_allclose(
            many[place], function(inputs[0] + shifts[place], *inputs[1:]), rtol=1e-14
        )


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("zhang2009", "direct"),
        pytest.param("zhao2000", "passive", marks=pytest.mark.long),
        ("gluon_6l3", "inverse"),
        pytest.param("cylindrical", "passive", marks=pytest.mark.long),
    ],
)
def test_latex_compiles(name, kind, tmp_path):
    """The document compiles on its own, and no line runs over the margin."""
    symbolic = jacobian(cases.case(name).mechanism, kind)
    (tmp_path / "j.tex").write_text(jacobian_text(symbolic, "latex"))
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "j.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode(errors="replace")[-2000:]
    assert "Overfull \\hbox" not in (tmp_path / "j.log").read_text(errors="replace")


@pytest.mark.parametrize("language", FORMATS)
def test_heads_say_what_the_file_is(language):
    """Mechanism, kind, units, frame, every input in order, version and the model's digest."""
    mechanism = symkin.load("zhao2000")
    text = jacobian_text(jacobian(mechanism, "inverse"), language)
    for part in (
        "zhao2000: inverse Jacobian, 4 x 6",
        "mm",
        "rad",
        "base frame",
        symkin.__version__,
        "SHA-256",
    ):
        assert part in text
    flat = " ".join(text.replace("\n * ", " ").replace("\n# ", " ").replace("\n% ", " ").split())
    assert (
        "Inputs, in this order: theta1 [rad], theta2 [rad], theta3 [rad], op [mm], radial1 [mm]"
        in flat
    )


_HASHES = f"""
import hashlib
import symkin
from {inside.where("jacobian_text")} import FORMATS, jacobian_text
for name, kind in (("zhao2000", "direct"), ("zhang2009", "inverse")):
    for language in FORMATS:
        print(hashlib.sha256(jacobian_text(symkin.jacobian(symkin.load(name), kind),
          language).encode()).hexdigest())
"""


@pytest.mark.slow
def test_bytes_do_not_depend_on_the_process():
    """Another process, with a hash seed of its own, writes the same bytes."""
    here = io.StringIO()
    with contextlib.redirect_stdout(here):
        exec(_HASHES, {})
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    there = subprocess.run(
        [sys.executable, "-c", _HASHES],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONHASHSEED": seed},
    ).stdout
    assert here.getvalue() == there
    assert there.count("\n") == 2 * len(FORMATS)


def test_names_that_a_language_reserves_are_changed():
    """A joint named as a keyword or as the module's own names is an input with another name, and
    the head says so.
    """
    limbs = [
        symkin.Limb(
            "a",
            [samples.turning("lambda", 0.0, 0.0, actuated=True), samples.turning("np", 0.0, 60.0)],
        ),
        symkin.Limb(
            "b",
            [
                samples.turning("v1", 100.0, 0.0, actuated=True),
                samples.turning("matrix", 100.0, 60.0),
                samples.turning("sp", 50.0, 120.0),
            ],
        ),
    ]
    mechanism = symkin.Mechanism(
        "odd", limbs, platform_position=(50.0, 120.0, 0.0), motion="planar"
    )
    symbolic = jacobian(mechanism, "inverse")
    values = symbolic.closure.reference
    for language, run in (
        ("numpy", lambda m: m["jacobian"]),
        ("sympy", lambda m: m["lambdified"]()),
    ):
        text = jacobian_text(symbolic, language)
        matrix = np.array(run(module_of(text))(*_inputs(symbolic, values)), dtype=float)
        np.testing.assert_allclose(
            matrix, symbolic.at(values), atol=1e-12 * np.max(np.abs(symbolic.at(values)))
        )
        assert "lambda_ is lambda" in text
    matrix = run_latex(symbolic, _inputs(symbolic, values))
    np.testing.assert_allclose(
        matrix, symbolic.at(values), atol=1e-12 * np.max(np.abs(symbolic.at(values)))
    )


@pytest.mark.parametrize("serial", [True, False])
def test_constant_jacobians_and_odd_names_are_legal_everywhere(serial, tmp_path, run_casadi):
    """A Cartesian robot's Jacobian reads nothing; names and titles that would end comments and
    strings do not.
    """
    x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    p1, p2 = (
        symkin.Joint('jac*/"""\\', "P", axis=x, actuated=True),
        symkin.Joint("null", "P", axis=y, actuated=True),
    )
    limbs = [symkin.Limb("a", [p1, p2] if serial else [p1, symkin.Joint("b", "P", axis=y)])]
    if not serial:
        limbs.append(symkin.Limb("b", [p2, symkin.Joint("c", "P", axis=x)]))
    mechanism = symkin.Mechanism(
        "_cart__robot", limbs, serial=serial, title='a "quoted" */ /* \\ title\nof two lines'
    )
    symbolic = jacobian(mechanism, "direct")
    inputs, expected = _inputs(symbolic, symbolic.closure.reference), np.eye(6, 2)
    found = [
        module_of(jacobian_text(symbolic, "numpy"))["jacobian"](*inputs),
        module_of(jacobian_text(symbolic, "sympy"))["lambdified"]()(*inputs),
        run_casadi(symbolic, inputs),
        run_latex(symbolic, inputs),
    ]
    if shutil.which("gcc"):
        found.append(run_c(symbolic, inputs, tmp_path))
    for matrix in found:
        np.testing.assert_allclose(np.array(matrix, dtype=float), expected, atol=1e-15)


def test_command_writes_the_file_or_stdout(tmp_path, capsys):
    """Without -o the text goes to stdout; with it to the file, whose name is printed."""
    with pytest.raises(SystemExit) as status:
        main(["jacobian", "zhang2009", "--format", "numpy", "--kind", "inverse"])
    printed = capsys.readouterr().out
    assert status.value.code == 0
    assert printed == jacobian_text(jacobian(symkin.load("zhang2009"), "inverse"), "numpy")
    with pytest.raises(SystemExit):
        main(
            [
                "jacobian",
                "zhang2009",
                "--format",
                "numpy",
                "--kind",
                "inverse",
                "-o",
                str(tmp_path / "j.py"),
            ]
        )
    assert (tmp_path / "j.py").read_text() == printed


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["zhang2009", "--format", "fortran"], "fortran"),
        (["zhang2009", "--format", "c", "--kind", "sideways"], "sideways"),
        (["zhang2009", "--format", "c", "--kind", "passive"], "no passive joint"),
        (["zhang2009", "--format", "c", "-o", "/nowhere/at/all.c"], "/nowhere/at/all.c"),
        (["nothing", "--format", "c"], "nothing"),
        (["zhang2009"], "--format"),
    ],
)
def test_wrong_input_is_one_sentence(arguments, said, capsys):
    """Exit status 2 and one line on stderr that names the offender."""
    with pytest.raises(SystemExit) as status:
        main(["jacobian", *arguments])
    error = capsys.readouterr().err
    assert status.value.code == 2
    assert said in error
    assert error.count("\n") == 1


def test_an_unknown_format_is_refused():
    with pytest.raises(InputError, match="allowed: casadi, c, numpy, sympy, latex"):
        jacobian_text(jacobian(symkin.load("zhang2009"), "inverse"), "fortran")
