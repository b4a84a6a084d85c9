"""Arithmetic in mechanism files: values by Python's own, and what is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.inside import evaluate, whole_number, written_number
from symkin import InputError, MechanismError

VALUES = {
    "240/sqrt(3)": 240 / math.sqrt(3),
    "pi/6": math.pi / 6,
    "1 + 2*3": 7.0,
    "(1 + 2)*3": 9.0,
    "7 - 4 - 2": 1.0,
    "8/4/2": 1.0,
    "2^3^2": 2.0**9,
    "(2^3)^2": 2.0**6,
    "-2^2": -4.0,
    "(-2)^2": 4.0,
    "2^-1": 0.5,
    "4^0.5": 2.0,
    "2*3^2": 18.0,
    "--1": 1.0,
    "+1.5e3": 1500.0,
    "  1 ": 1.0,
    ".5": 0.5,
    "sqrt(2)^2": math.sqrt(2) ** 2,
    "sqrt(sqrt(16))": 2.0,
    "1e-3": 0.001,
}


@pytest.mark.parametrize("text", VALUES)
def test_values_and_precedence(text):
    """^ binds tightest and from the right, then signs, * /, + - from the left."""
    assert evaluate(text, "rad") == pytest.approx(VALUES[text], rel=1e-15)
    assert evaluate(text, "deg") == pytest.approx(VALUES[text], rel=1e-15)


def has_value_or_message(text, angle_unit):
    """A finite number, or MechanismError in one line; any other exception leaves."""
    try:
        return math.isfinite(evaluate(text, angle_unit))
    except MechanismError as error:
        return "\n" not in str(error)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
@given(angle=st.floats(-80, 80))
def test_trigonometry_is_in_the_angle_unit(name, angle):
    """f(x deg) = f(x pi / 180 rad)."""
    expected = getattr(math, name)(math.radians(angle))
    assert evaluate(f"{name}({angle!r})", "deg") == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert evaluate(f"{name}({angle!r})", "rad") == pytest.approx(
        getattr(math, name)(angle), rel=1e-12
    )


numbers = st.floats(-1e6, 1e6, allow_subnormal=False).map(lambda v: f"({v!r})")
expressions = st.recursive(
    numbers,
    lambda inner: st.tuples(inner, st.sampled_from("+-*"), inner).map(
        lambda t: f"({t[0]}{t[1]}{t[2]})"
    ),
    max_leaves=5,
)


@given(expressions.filter(lambda text: len(text) <= 200))
def test_sums_and_products_are_pythons(text):
    """The same numbers as Python's parser and floats."""
    assert evaluate(text, "deg") == eval(text)


REFUSED = """x|e|inf|nan|abs(1)|sqrt|sqrt()|
sqrt(1, 2)|sqrt(x=4)|__import__('os')|().__class__|pi.real|(1).real|[1]|1, 2|
1 if 1 else 2|1 < 2|not 1|~1|1 % 2|7 // 2|1 << 2|1 @ 2|2**3|
2 ** 3|1_000|True|False|None|'1'|"1"|1j|lambda: 1|x := 1|
(x := 1)|1 +|(|)|1 2||   |sin|sin 30|cos[0]|*[1]|f'{1}'|1;2|
print(1)|exp(1)|sqrt(*[4])|π|1e|0x|0x10|0b1|
1e1_0|PI|Sqrt(4)|sqrt(2,)|(1,)|007|1.2.3|1 .5|1. 5|1#2|2^|2^*3|
infinity|-inf|+nan|2pi|pi2|2(3)|(2)(3)|sqrt4|1if 1else 2""".replace("\n", "").split("|")


OTHER_SCRIPTS = ["\u0661", "\uff11", "1e\u0661", "\uff50\uff49", "\U0001d429\U0001d422"]
"""Digits and letters that Python takes for 1 and pi: Arabic, wide and bold ones."""


@pytest.mark.parametrize("text", [*REFUSED, *OTHER_SCRIPTS])
def test_anything_else_is_refused(text):
    """Names, calls, attributes, '**', booleans, empty text: one line that quotes the text and says
    what is allowed.
    """
    with pytest.raises(MechanismError) as error:
        evaluate(text, "deg")
    assert repr(text) in str(error.value)
    assert "sqrt, sin, cos, tan, pi" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "1/0",
        "0^-1",
        "sqrt(-1)",
        "(-8)^(1/3)",
        "10^400",
        "9^9^9^9",
        "1e308*10",
        "1e999",
        "1e308 + 1e308",
        "1/1e400",
        "1/(1e308*10)",
        "1e400*0",
        "1e308*10/1e308",
    ],
)
def test_what_has_no_finite_value_is_refused(text):
    """Division by zero, roots of negative numbers, overflow, huge powers: refused at once, no
    wait.
    """
    with pytest.raises(MechanismError) as error:
        evaluate(text, "deg")
    assert repr(text) in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 90 + "1" + ")" * 90,
        "-" * 199 + "1",
        "1" * 5000,
        "(" * 5000,
        "9" * 200,
        "\x00",
        "1\n+1",
        "1#2",
    ],
)
def test_odd_texts_have_a_value_or_a_message(text):
    """Deep nesting, long numbers, control characters: a number or MechanismError, nothing else."""
    assert has_value_or_message(text, "deg")


@pytest.mark.parametrize(
    "text", ["1_000", "1e1_0", "0x10", "infinit", "", " ", "1,5", *OTHER_SCRIPTS]
)
def test_numbers_of_the_command_line_are_those_of_files(text):
    """Python's own spellings of numbers (digits of other scripts, _) are refused as they are in
    files.
    """
    with pytest.raises(InputError, match="is not a number"):
        written_number(text, "deg")
    with pytest.raises(InputError):
        whole_number(text)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_written_numbers_are_pythons(number):
    """What Python prints of a float is read back as the same float; a spaced one too."""
    assert written_number(repr(number), "deg") == number
    assert written_number(f" {number!r} ", "rad") == number


@pytest.mark.slow
@given(st.text(max_size=30) | st.text("0123456789.+-*/^() sincota", max_size=30))
def test_any_text_has_a_value_or_a_message(text):
    """No other exception leaves, whatever the text."""
    assert has_value_or_message(text, "rad")
