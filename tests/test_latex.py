"""LaTeX of expressions and closures: balanced, complete, and equal in value to what it was written from."""

import re
import shutil
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from symkin.export.latex import document, equations, symbol_name, write
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
    for name, text in definitions:
        values[_plain(name)] = eval(_python(text), {}, values)
    expected = ca.Function("f", [x], [ca.vertcat(*entries)])([1.3, -0.7, 2.1])
    np.testing.assert_allclose([eval(_python(t), {}, values) for t in results], np.asarray(expected).ravel(), rtol=1e-12)


def _plain(name: str) -> str:
    return re.sub(r"[_{}]", "", name)


def _python(text: str) -> str:
    text = re.sub(r"v_\{(\d+)\}", r"v\1", text)
    while r"\frac" in text:
        text = re.sub(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", r"((\1)/(\2))", text)
    for old, new in ((r"\left(", "("), (r"\right)", ")"), (r"\,", "*"), (r"\cdot", "*"), ("^", "**")):
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    ("name", "symbol"),
    [("theta1", r"\theta_{1}"), ("leg12", r"\mathrm{leg}_{12}"), ("pose.x", "x"), ("pose.gamma", r"\gamma"), ("q_3", "q_{3}")],
)
def test_symbol_names(name: str, symbol: str) -> None:
    """Greek names and trailing numbers become symbols and subscripts."""
    assert symbol_name(name) == symbol
