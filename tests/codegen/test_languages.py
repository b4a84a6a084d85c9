"""Expressions printed in each language have the values of the expressions."""

from __future__ import annotations

import cmath
import json
import math
import shutil
import subprocess

import casadi as ca
import numpy as np
import pytest

from helpers.inside import (
    NUMPY_NAMES,
    Emitter,
    Printer,
    Real,
    complex_parts,
    javascript,
    python_language,
)

X = ca.SX.sym("x", 3)
A, B, C = X[0], X[1], X[2]
SHARED = A * B - 2
ENTRIES = [
    A - (B - C),
    -(A + B) * C,
    A - (-3) * B,
    SHARED**2 + SHARED / C,
    -A - (-B),
    1 / (A + B) - 4 * -C,
    -(A * A) * (B - 1),
    (-A) * (-B) / (-C),
    A + (B - A * 2.5) - 7.25,
    2 * (-(A * B)) - (-(C + B)),
    ca.sin(A - B) * ca.cos(-C) + ca.sqrt(A * A + B * B),
    ca.sqrt(C) / (A * C) - SHARED / (A * C),
]
FURTHER = [ca.atan2(A, B), ca.fabs(-B), ca.tan(A), ca.asin(0.3 * A), ca.exp(-B), ca.log(C)]
AT = [1.3, -0.7, 2.1]


def _expected(entries: list[ca.SX]) -> np.ndarray:
    return np.asarray(ca.Function("f", [X], [ca.vertcat(*entries)])(AT)).ravel()


def test_python_has_the_values() -> None:
    """What is read twice is computed once, and no line is much longer than the language likes."""
    entries = [*ENTRIES, *FURTHER, sum(ENTRIES, ca.SX(0))]
    function = ca.Function("f", [X], [ca.vertcat(*entries)], {"cse": True})
    language = python_language("np", NUMPY_NAMES, "v")
    printer = Printer(function, [["a", "b", "c"]], language)
    texts = printer.entries()
    scope = {"np": np} | dict(zip("abc", AT, strict=True))
    exec("\n".join(printer.lines), scope)
    found = [eval(texts[k, 0], scope) for k in range(len(entries))]
    np.testing.assert_allclose(found, _expected(entries), rtol=1e-13)
    written = [*printer.lines, *texts.values()]
    assert max(map(len, written)) < language.longest + 10
    assert sum(text.count("a * b") for text in written) == 1


def test_c_divides_once_by_what_divides_twice() -> None:
    """The statements have the values, constants and repeated divisors are multiplied by."""
    entries = [*ENTRIES, A / 4]
    function = ca.Function("f", [X], [ca.vertcat(*entries)], {"cse": True})
    emitter = Emitter(function, [["a", "b", "c"]], Real("double", "double"))
    lines = emitter.stored([f"out[{k}]" for k in range(len(entries))])
    scope = {"sqrt": math.sqrt, "sin": math.sin, "cos": math.cos, "out": [0.0] * len(entries)}
    scope |= dict(zip("abc", AT, strict=True))
    exec("\n".join(line.removeprefix("const double ").rstrip(";") for line in lines), scope)
    np.testing.assert_allclose(scope["out"], _expected(entries), rtol=1e-13)
    divisions = [line for line in lines if " / " in line]
    assert emitter.operations["divisions"] == len(divisions) == len(emitter.divisions)
    assert len(divisions) == 3  # by c, a + b and a c, none by 4
    kept = [lines[place].split(" / ")[1].rstrip(";") for place, _ in emitter.divisions]
    assert kept == [divisor for _, divisor in emitter.divisions]


def test_c_finds_a_value_and_its_negative_once() -> None:
    entries = [A - B, B - A, -2.5 * C, C * 2.5, (-A) * B - 4, 4 + A * B, ca.sin(-C) - A]
    function = ca.Function("f", [X], [ca.vertcat(*entries)], {"cse": True})
    emitter = Emitter(function, [["a", "b", "c"]], Real("double", "double"))
    lines = emitter.stored([f"out[{k}]" for k in range(len(entries))])
    assert dict(emitter.operations) == {"additions": 3, "multiplications": 2, "sin": 1}
    scope = {"sin": math.sin, "out": [0.0] * len(entries)} | dict(zip("abc", AT, strict=True))
    exec("\n".join(line.removeprefix("const double ").rstrip(";") for line in lines), scope)
    np.testing.assert_array_equal(scope["out"], _expected(entries))


def test_c_finds_products_by_numbers_that_rounding_tells_apart_once() -> None:
    """The sine and the cosine of 45 degrees differ by their last digit."""
    numbers = [math.sin(math.pi / 4), math.cos(math.pi / 4), -(0.5**0.5) * (1.0 - 1e-14), 0.7071067]
    entries = [number * A + B for number in numbers]
    function = ca.Function("f", [X], [ca.vertcat(*entries)], {"cse": True})
    emitter = Emitter(function, [["a", "b", "c"]], Real("double", "double"))
    emitter.stored("out")
    assert len(set(numbers)) == 4
    assert dict(emitter.operations) == {"additions": 3, "multiplications": 2}


def _in_turns(matrix: ca.SX) -> tuple[ca.SX, list[ca.SX]]:
    """Parts of its variables, and a matrix of twice the columns with the parts of its entries."""
    parts, [(real, imaginary)] = complex_parts(X, [matrix])
    first, second = (ca.sparsify(ca.DM([row])) for row in ([1, 0], [0, 1]))
    return parts, [ca.kron(real, first) + ca.kron(imaginary, second)]


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize("over_complex", [False, True])
def test_javascript_has_the_values(over_complex: bool) -> None:
    """Over complex numbers those of complex arithmetic, roots with a real part above zero; zeros of
    a matrix are left as they are.
    """
    at = np.array([1.3 + 0.4j, -0.7 - 0.9j, 2.1 - 1.1j]) if over_complex else np.array(AT)
    entries = ENTRIES if over_complex else [*ENTRIES, *FURTHER]
    matrix = ca.SX(len(entries), 2)
    for k, entry in enumerate(entries):
        matrix[k, k % 2] = entry
    width = 2 if over_complex else 1
    numbers = at.view(float).tolist()
    text = javascript("f", *((X, [matrix]) if not over_complex else _in_turns(matrix)))
    program = (
        text.replace("export ", "")
        + f"const out = Array({2 * width * len(entries)}).fill(9);"
        + f"f({json.dumps(numbers)}, out); console.log(JSON.stringify(out));"
    )
    said = subprocess.run(["node", "-e", program], check=True, capture_output=True, text=True)
    out = np.array(json.loads(said.stdout))
    found = (out[0::2] + 1j * out[1::2] if over_complex else out).reshape(-1, 2)
    a, b, c = at.tolist()
    root = cmath.sqrt if over_complex else math.sqrt
    sine, cosine = (cmath.sin, cmath.cos) if over_complex else (math.sin, math.cos)
    shared = a * b - 2
    expected = [
        a - (b - c),
        -(a + b) * c,
        a + 3 * b,
        shared**2 + shared / c,
        b - a,
        1 / (a + b) + 4 * c,
        -(a * a) * (b - 1),
        -a * b / c,
        b - 1.5 * a - 7.25,
        -2 * a * b + c + b,
        sine(a - b) * cosine(c) + root(a * a + b * b),
        root(c) / (a * c) - shared / (a * c),
    ]
    expected += [] if over_complex else _expected(FURTHER).tolist()
    np.testing.assert_allclose([found[k, k % 2] for k in range(len(entries))], expected, rtol=1e-12)
    untouched = 9 + 9j if over_complex else 9
    assert all(found[k, 1 - k % 2] == untouched for k in range(len(entries)))
