"""LaTeX of expressions and closures: balanced, complete, and equal in value to what it was written from."""

import re
import shutil
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from latex_reader import evaluated

import symkin
from symkin.export.latex import distinct, document, equations, letter_of_values, symbol_name, write
from symkin.model.closure import build_closure


@pytest.mark.parametrize("name", symkin.shipped_names())
def test_equations_are_balanced_and_complete(name: str) -> None:
    """Braces and \\left, \\right balance; there is one equation for each row and one for each unit quaternion."""
    mechanism = symkin.load(name)
    text, closure = equations(mechanism), build_closure(mechanism)
    assert text.count("{") == text.count("}")
    assert text.count(r"\left") == text.count(r"\right")
    quaternions = sum(c.kind == "quaternion" for c in closure.coordinates)
    assert len(re.findall(r"^0 &=", text, re.M)) == closure.rows.shape[0] + quaternions


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("name", ["zhang2009", "zhao2000_links", "gluon_6l3"])
def test_equations_compile(name: str, tmp_path: Path) -> None:
    """A document around the equations compiles."""
    (tmp_path / "closure.tex").write_text(document(equations(symkin.load(name))))
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "closure.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode(errors="replace")[-2000:]


def test_text_has_the_value_of_the_expression() -> None:
    """Read back as arithmetic, the text gives the expression's values (sums, signs, products, powers, quotients)."""
    x = ca.SX.sym("x", 3)
    a, b, c = x[0], x[1], x[2]
    shared = a * b - 2
    entries = [
        a - (b - c),
        -(a + b) * c,
        a - (-3) * b,
        shared**2 + shared / c,
        -a - (-b),
        1 / (a + b) - 4 * -c,
        -(a * a) * (b - 1),
    ]
    definitions, results = write(ca.vertcat(*entries), x, ["a", "b", "c"])
    values = {"a": 1.3, "b": -0.7, "c": 2.1}
    expected = ca.Function("f", [x], [ca.vertcat(*entries)])([1.3, -0.7, 2.1])
    np.testing.assert_allclose(evaluated(definitions, results, values), np.asarray(expected).ravel(), rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "symbol"),
    [("theta1", r"\theta_{1}"), ("leg12", r"\mathrm{leg}_{12}"), ("pose.x", "x"), ("pose.gamma", r"\gamma"), ("q_3", "q_{3}")],
)
def test_symbol_names(name: str, symbol: str) -> None:
    """Greek names and trailing numbers become symbols and subscripts."""
    assert symbol_name(name) == symbol


def test_names_that_look_alike_have_symbols_of_their_own() -> None:
    """Symbols are told apart without their braces, and numbered values have a letter that no joint has."""
    names = ["theta1", "theta_1", "v1", "e0"]
    symbols = distinct([*(symbol_name(n) for n in names), symbol_name("pose.quaternion", 0)], [*names, "quaternion"])
    assert symbols[:4] == [r"\theta_{1}", r"\mathrm{theta\_1}", "v_{1}", "e_{0}"]
    assert len({s.replace("{", "").replace("}", "") for s in symbols}) == 5
    assert letter_of_values(symbols) != "v"
    assert letter_of_values(symbols[:2]) == "v"
