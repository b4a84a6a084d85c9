"""LaTeX of expressions and closures: balanced, complete, and equal in value to what it was written
from.
"""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import symkin
from helpers.exported_jacobians import run_latex
from helpers.gate import in_gate
from helpers.inside import (
    build_closure,
    closed_configurations,
    coordinate_symbols,
    document,
    equations,
    gathered,
    jacobian_text,
    letter_of_values,
    random_values,
    snap,
    snapped_expression,
    symbol_name,
    write,
)
from helpers.inside import distinct_in_latex as distinct
from helpers.latex_reader import evaluated
from helpers.samples import delta, five_bar, pieper, three_rps, three_rrr
from helpers.shipped import TWELVE

OWN = {
    "five_bar": five_bar,
    "3-RRR": three_rrr,
    "3-RPS": three_rps,
    "delta": delta,
    "pieper": pieper,
}
EVERY = [*symkin.shipped_names(), *OWN]


def mechanism_of(name: str) -> symkin.Mechanism:
    return OWN[name]() if name in OWN else symkin.load(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_equations_are_balanced_and_complete(name: str) -> None:
    """Braces and \\left, \\right balance; there is one equation for each row and one for each unit
    quaternion.
    """
    mechanism = symkin.load(name)
    text, closure = equations(mechanism), build_closure(mechanism)
    assert text.count("{") == text.count("}")
    assert text.count(r"\left") == text.count(r"\right")
    quaternions = sum(c.kind == "quaternion" for c in closure.coordinates)
    assert len(re.findall(r"^0 &=", text, re.M)) == closure.rows.shape[0] + quaternions


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("name", ["zhang2009", "zhao2000_links", "gluon_6l3"])
def test_equations_compile(name: str, tmp_path: Path) -> None:
    """A document around the equations compiles."""
    (tmp_path / "closure.tex").write_text(document(equations(symkin.load(name))))
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "closure.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode(errors="replace")[-2000:]


def test_text_has_the_value_of_the_expression() -> None:
    """Read back as arithmetic, the text gives the expression's values (sums, signs, products,
    powers, quotients).
    """
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
    lines, results = write(ca.vertcat(*entries), x, ["a", "b", "c"])
    definitions = [line.removesuffix(r" \\").split(" &= ") for line in lines]
    values = {"a": 1.3, "b": -0.7, "c": 2.1}
    expected = ca.Function("f", [x], [ca.vertcat(*entries)])([1.3, -0.7, 2.1])
    np.testing.assert_allclose(
        evaluated(definitions, results, values), np.asarray(expected).ravel(), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("name", "symbol"),
    [
        ("theta1", r"\theta_{1}"),
        ("leg12", r"\mathrm{leg}_{12}"),
        ("pose.x", "x"),
        ("pose.gamma", r"\gamma"),
        ("q_3", "q_{3}"),
    ],
)
def test_symbol_names(name: str, symbol: str) -> None:
    """Greek names and trailing numbers become symbols and subscripts."""
    assert symbol_name(name) == symbol


def test_names_that_look_alike_have_symbols_of_their_own() -> None:
    """Symbols are told apart without their braces, and numbered values have a letter that no joint
    has.
    """
    names = ["theta1", "theta_1", "v1", "e0"]
    symbols = distinct(
        [*(symbol_name(n) for n in names), symbol_name("pose.quaternion", 0)],
        [*names, "quaternion"],
    )
    assert symbols[:4] == [r"\theta_{1}", r"\mathrm{theta\_1}", "v_{1}", "e_{0}"]
    assert len({s.replace("{", "").replace("}", "") for s in symbols}) == 5
    assert letter_of_values(symbols) != "v"
    assert letter_of_values(symbols[:2]) == "v"


NAMES_ALIKE = Path(__file__).parents[1] / "data" / "names_alike.toml"
"""Joints c1.angle and c1_angle, u.1 and u_1, and Greek ones."""


def _spelled_alike() -> symkin.Mechanism:
    """Names of which signs, capitals, letters or only the place of an index differ."""
    names = ["theta1", "theta_1", "θ1", "a-b", "a_b", "a b", "e0", "v1", "x", "J1"]
    joints = [
        symkin.Joint(
            name, "R", (0.1 * k, 0.05 * k * k, 0.02 * k), (1.0, 0.3 * k - 1.0, 0.5), actuated=True
        )
        for k, name in enumerate(names)
    ]
    return symkin.Mechanism("alike", limbs=[symkin.Limb("arm", joints)], serial=True)


@pytest.mark.parametrize(
    "mechanism", [symkin.load(NAMES_ALIKE), _spelled_alike()], ids=["file", "arm"]
)
@pytest.mark.parametrize("kind", ["direct", "inverse", "passive"])
def test_no_two_coordinates_have_one_symbol(mechanism: symkin.Mechanism, kind: str) -> None:
    """Nor two names of rows, columns and actuated joints in a Jacobian's text; with its symbols
    it has the expression's values."""
    closure = build_closure(mechanism)
    symbols = [re.sub("[{}]", "", symbol) for symbol in coordinate_symbols(closure)]
    assert len(set(symbols)) == len(symbols)
    if kind == "passive" and not closure.role("passive"):
        return
    made = symkin.jacobian(mechanism, kind)
    prose = jacobian_text(made, "latex").split(r"\noindent")[1].split("Entries")[0]
    for text, names in zip(
        re.split("actuated joints|Rows:|columns:", prose)[1:],
        ([c.name for c in closure.role("actuated")], made.rows, made.columns),
        strict=True,
    ):
        listed = re.findall(r"\$([^$]+)\$", text)
        assert len(set(listed)) == len(names)
    values = closed_configurations(closure, 1)[0]
    inputs = [float(values[v.index]) for v in made.inputs]
    expected = made.at(values)
    np.testing.assert_allclose(
        run_latex(made, inputs), expected, rtol=0, atol=1e-9 * np.abs(expected).max()
    )


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_names_that_look_alike_compile(tmp_path: Path) -> None:
    """Equations and a Jacobian, with what the symbols stand for."""
    for k, mechanism in enumerate((symkin.load(NAMES_ALIKE), _spelled_alike())):
        for name, text in (
            (f"closure{k}", document(equations(mechanism))),
            (f"jacobian{k}", jacobian_text(symkin.jacobian(mechanism, "inverse"), "latex")),
        ):
            (tmp_path / f"{name}.tex").write_text(text, encoding="utf-8")
            command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", f"{name}.tex"]
            done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
            assert done.returncode == 0, done.stdout.decode(errors="replace")[-2000:]


# --- no rounding noise, and short -----------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(EVERY, [*TWELVE, *OWN]))
def test_equations_have_the_values_of_the_closure(name: str) -> None:
    """Read back as arithmetic at random values, each printed row is the closure's, in lengths and
    without its factors.
    """
    mechanism = mechanism_of(name)
    closure = build_closure(mechanism)
    lines = [
        line.removesuffix(r" \\").split(" &= ", 1)
        for line in equations(mechanism).splitlines()
        if " &= " in line
    ]
    definitions = [(name, text) for name, text in lines if name != "0"]
    rows = [text.split(" && ")[0] for name, text in lines if name == "0"][: closure.rows.shape[0]]
    values = random_values(
        closure.coordinates, closure.characteristic_length, np.random.default_rng(3)
    )
    parts = [
        (c.name, k if c.width > 1 else None) for c in closure.coordinates for k in range(c.width)
    ]
    full = [name if k is None else f"{name}.{k}" for name, k in parts]
    symbols = distinct([symbol_name(*part) for part in parts], full)
    found = np.array(evaluated(definitions, rows, dict(zip(symbols, values, strict=True))))
    plain = ca.Function("rows", [closure.variables], [closure.bound(closure.rows)])
    expected = np.asarray(plain(values)).ravel()
    scale = {"distance": (2 * closure.characteristic_length,), "point": (1.0,), "line": (1.0,)}
    for row, one, other in zip(closure.row_sources, found, expected, strict=True):
        factors = scale.get(row.relation, (1.0, 1 / closure.characteristic_length))
        error = min(abs(one - factor * other) for factor in factors)
        assert error < 1e-9 * closure.characteristic_length ** (
            2 if row.relation == "distance" else 1
        ), row


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(EVERY, TWELVE))
def test_equations_hold_no_rounding_noise(name: str) -> None:
    """No power of ten, and no number that rounding has made: none below 1e-9, none within 1e-11 of
    0, 1 or a half but these.
    """
    text = equations(mechanism_of(name))
    assert r"\cdot 10^" not in text
    numbers = [float(n) for n in re.findall(r"(?<![_{\d.])\d+\.\d+", text)]
    for number in numbers:
        assert number > 1e-9
        assert number in (0.5, 1.0) or min(abs(number - simple) for simple in (0.5, 1.0)) > 1e-11


def test_parallel_axes_of_an_arm_leave_short_equations() -> None:
    """The Gluon arm, whose DH angles are quarter turns: the position rows are products of sines and
    cosines with its lengths.
    """
    text = equations(symkin.load("gluon_6l3"))
    lengths = {"44.36", "75.66", "80.09", "105.03", "174.42"}
    # of half angles, and of the quarter turn of the tool at the reference
    halves = {
        "0.5",
        "0.707106781187",
    }
    assert set(re.findall(r"\d+\.\d+", text)) == lengths | halves
    assert len(text) < 3500


def test_the_text_and_the_firmware_share_their_snapping() -> None:
    """Rounding noise of quarter turns and square roots folds away beside the size that made it;
    what is no noise stays, and without a size nothing is zero: the square of a tiny machine's
    length is as small.
    """
    x = ca.SX.sym("x")
    assert str(snapped_expression(6e-17 * x + (1 + 2e-16) * x, [x], 1.0)) == "x"
    assert [snap(v) for v in (1e-16, -4e-16, 1 - 1e-16)] == [1e-16, -4e-16, 1]
    assert [snap(v, 1.0) for v in (1e-48, -3e-16, 1 - 1e-16, 0.49999999999999994, 1e-9, 1 / 3)] == [
        0,
        0,
        1,
        0.5,
        1e-9,
        1 / 3,
    ]


def _expressions(x: ca.SX) -> st.SearchStrategy[ca.SX]:
    leaves = st.sampled_from(
        [*(x[k] for k in range(3)), ca.SX(2.0), ca.SX(-1.0), ca.SX(0.5), ca.SX(-3.25)]
    )
    c = ca.cos(x[0])
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.tuples(inner, inner).map(lambda p: p[0] + p[1]),
            st.tuples(inner, inner).map(lambda p: p[0] - p[1]),
            st.tuples(inner, inner).map(lambda p: p[0] * p[1]),
            inner.map(lambda a: -a),
            inner.map(lambda a: 2 * a),
            inner.map(lambda a: a * a),
            inner.map(ca.sin),
            inner.map(lambda a: c * a + (1 - c) * a),
        ),
        max_leaves=12,
    )


_X = ca.SX.sym("x", 3)


def _read(expression: ca.SX) -> tuple[list[str], str]:
    """Definitions and text of an expression as the equations of a closure are written."""
    lines, (text,) = write(gathered([expression], [_X], [])[0], _X, ["a", "b", "c"])
    return lines, text


@given(_expressions(_X))
def test_gathered_expressions_keep_their_values(expression: ca.SX) -> None:
    """Signs, factors, constants and turned axes drawn out of random expressions change no value."""
    lines, text = _read(expression)
    definitions = [line.removesuffix(r" \\").split(" &= ") for line in lines]
    (found,) = evaluated(definitions, [text], {"a": 0.7, "b": -1.3, "c": 0.4})
    expected = float(ca.Function("f", [_X], [expression])([0.7, -1.3, 0.4]))
    assert abs(found - expected) <= 1e-11 * max(1.0, abs(expected))


_A, _B, _C = _X[0], _X[1], ca.cos(_X[2])


@pytest.mark.parametrize(
    ("untidy", "tidy"),
    [
        (_C * _A + (1 - _C) * _A, "a"),
        ((1 - _C) * (-_A) + -(_A * _C), "-a"),
        (-5 * _C + -5 * (1 - _C), "-5"),
        (-4 + _A - 3 + 7, "a"),
        (_A + (3 - _B) - 5, "a - b - 2"),
        (2 * (-(_A * _B)), r"-2 \, a \, b"),
        ((3 * _A) * (-0.5 * _B), r"-1.5 \, a \, b"),
        (_A - (-_B), "a + b"),
        (
            _A - 5 - ca.sin(3 + _B) - (_C - 4),
            r"a - \left(\cos\left(c\right) + \sin\left(b + 3\right)\right) - 1",
        ),
        (ca.sin(-_A) * (_B - _C), r"-\sin\left(a\right) \, \left(b - \cos\left(c\right)\right)"),
    ],
    ids=str,
)
def test_what_a_reader_would_leave_out_is_left_out(untidy: ca.SX, tidy: str) -> None:
    """What a turn about an axis leaves of what lies along it, constants of nested sums, signs and
    factors of products.
    """
    assert _read(untidy) == ([], tidy)


def test_factors_that_make_one_are_left_out() -> None:
    """Of Jacobians, which are printed as they are found, too: 0.5 a times 2 b was 1 a b."""
    for product, sign in ((0.5 * _A) * (2 * _B), ""), ((-0.5 * _A) * (2 * _B), "-"):
        assert write(product, _X, ["a", "b", "c"]) == ([], [rf"{sign}a \, b"])


@pytest.mark.long
@pytest.mark.slow
def test_equations_stay_the_same_when_many_closures_were_built_since():
    """No cache keeps rows over the symbols of a closure that another one has thrown out."""
    mechanism = symkin.load("zhao2000")
    before = equations(mechanism)
    for k in range(140):
        build_closure(replace(mechanism, name=f"other{k}"))
    assert equations(mechanism) == before
