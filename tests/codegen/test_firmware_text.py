"""How generated C reads: its lines, its constants, and the words of its comments."""

from __future__ import annotations

import re

import casadi as ca
import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers.inside import WIDTH, Emitter, Real, narrowed, rounded_up, signature
from symkin import InputError

DECLARED = {
    "platforms": (*signature.PLATFORM, signature.LINE, *signature.PLATFORM_SPEEDS),
    "arms": (*signature.ARM, *signature.CLOSED_ARM, *signature.ARM_SPEEDS),
    "maps": signature.MAP,
}
"""The functions of each kind of machine."""


@pytest.mark.parametrize("folder", tools.at_hand(tools.FOLDERS))
def test_lines_and_constants(folder):
    """No line is longer than a hundred characters; nothing is added to or divided by a negative
    constant, no constant computed.
    """
    number = r"\d[\d.]*(?:e[+-]?\d+)?f?"
    for path in tools.folder(folder).glob("*.[ch]"):
        text = path.read_text()
        code = re.sub(r"/\*.*?\*/|#define.*|\{{[^;]*\}};", "", text, flags=re.S)
        assert max(map(len, text.split("\n"))) <= WIDTH, path.name
        assert not re.search(rf"[-+/] \(?-{number}\)?(?![\w.])", code), path.name
        assert not re.search(rf"= -?{number} [-+*/] -?{number};", text), path.name


def test_c_of_doubles_becomes_that_of_a_machine():
    """Names, numbers and functions of math.h are given their type once; comments, whole numbers and
    what has a type already stay, and a number that the type does not hold is refused.
    """
    said = "const real a = name_b(GEOMETRY x, 0.1, 1e-05, 2.5f, 3) * sqrt(atan2(b, NAME_C));"
    comment = " /* 0.1 real of name_b */"
    in_float = "const m_real a = m_b(geometry, x, 0.1f, 1e-05f, 2.5f, 3) * sqrtf(m_angle(b, M_C));"
    in_double = "const m_real a = m_b(x, 0.1, 1e-05, 2.5f, 3) * sqrt(atan2(b, M_C));"
    typed = Real("float", "m_real").typed(said + comment, "m", struct=True)
    assert typed == in_float + comment
    typed = Real("double", "m_real").typed(said + comment, "m", struct=False)
    assert typed == in_double + comment
    for name in ("real", "nan", "name", "name_name", "geometry"):
        begin = f'#include "{name}.h"'
        said = f"{begin}\nreal name_x({name}_y, NAME_C);"
        typed = Real("float", "m_real").typed(said, name, struct=True)
        assert typed == f"{begin}\nm_real {name}_x({name}_y, {name.upper()}_C);"
    for real, number in (("float", "inf"), ("double", "-inf"), ("float", "1e60")):
        with pytest.raises(InputError, match="no finite"):
            Real(real).typed(f"x = {number};", "m", struct=False)


@pytest.mark.parametrize("folder", ["zhang2009_float", "zhao2000_double"])
def test_rows_are_named_as_in_the_model(folder):
    """A comment before each row says which limb or which coordinates it is about."""
    name = folder.split("_")[0]
    text = (tools.folder(folder) / f"{name}.c").read_text()
    wanted = ["leg1", "leg6"] if name == "zhang2009" else ["theta1", "op"]
    assert all(re.search(rf"/\* [^*]*\b{word}\b", text) for word in wanted)


def test_the_page_on_generated_c_has_every_function():
    """The page's list names each function of each kind of machine with its arguments in order."""
    page = (tools.CODEGEN.parent / "docs" / "reference" / "generated-c.md").read_text()
    listed = page[page.index("/* platforms */") : page.index("## Less code")]
    _, platforms, arms, closed, maps = re.split(r"(?m)^ *\/\* .*\*/", "    " + listed)
    told = {"platforms": platforms, "arms": arms + closed, "maps": maps}
    for kind, functions in DECLARED.items():
        calls = re.findall(r"NAME_(\w+)\(([^()]*)\)", told[kind].replace("NAME_BRANCHES", "B"))
        found = {name: re.sub(r"\[.*?\]", "", words).split(", ") for name, words in calls}
        found.pop("inverse_all", None)
        wanted = {}
        for function in functions:
            arguments = [*function.takes, *function.gives]
            wanted[function.name] = [
                *(["config"] if function.config else []),
                *(value.name for value in arguments),
                *(["info"] if function.info else []),
            ]
        assert found == wanted, kind


@pytest.mark.parametrize(
    ("folder", "motion"), [("delta_double", "translation"), ("zhang2009_float", "")]
)
def test_the_header_says_what_of_a_twist_is_left_out(folder, motion):
    """A platform that turns nowhere takes no angular velocity, and says so; one that moves freely
    has nothing to say.
    """
    (header,) = tools.folder(folder).glob(f"{folder.split('_')[0]}.h")
    told = " ".join(re.sub(r"\n \*", " ", header.read_text()).split())
    words = f"platform's motion is {motion}: what else a twist has it cannot take, and is left out"
    assert (words in told) == bool(motion)
    assert ("what else a twist has" in told) == bool(motion)


def test_narrow_text_is_the_same_program(tmp_path):
    """Long calls, conditions, strings, macros and comments: the compiler prints the same, the words
    stay in their order.
    """
    text = """#include <stdio.h>
/* A comment of very many words that goes on and on over more than a \
hundred characters, so that it must be broken somewhere in it
 * and continues on a next line of its own with few words.
 *
 * joints[0] begins a line of its own. */
#define NUMBERS { 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, \
11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0, 20.0, 21.0, 22.0 }
#define LIMIT (12) /* a comment behind a definition, \
long enough that both together are too long for one line of a hundred */
static double sum_of_many_numbers(const double numbers_with_a_long_name[22], \
int count_of_the_numbers, double what_is_added_first, int unused)
{
    double sum = what_is_added_first; /* what a comment at the end of a line of code \
says, which makes the line too long for the page */
    for (int i = 0; (i < count_of_the_numbers) && (i < LIMIT) && \
(numbers_with_a_long_name[i] > 0.0) && (unused == 0) && (sum < 1e30); ++i) {
        sum += numbers_with_a_long_name[i] * numbers_with_a_long_name[i] \
+ numbers_with_a_long_name[i] - 0.5 * numbers_with_a_long_name[i];
    }
    return sum;
}
int main(void)
{
    static const double numbers[22] = NUMBERS;
    (void)printf("%s %g\\n", "a string, with a comma, that must not be \
broken: && || = + - * however long it may be, and it is long", \
sum_of_many_numbers(numbers, 22, 1.0, 0));
    return 0;
}
"""
    narrow = narrowed(
        text.replace("18.0, 19.0, 20.0, 21.0, 22.0 }", "18.0, \\\n    19.0, 20.0, 21.0, 22.0 }")
    )
    words = [re.sub(r"[\s\\*/]+", "", t) for t in (text, narrow)]
    assert sorted(words[0]) == sorted(words[1])
    outputs = []
    for version in (text, narrow):
        (tmp_path / "program.c").write_text(version)
        outputs.append(tools.passed(tools.built("gcc", tmp_path, ["program.c"], "program")))
    assert outputs[0] == outputs[1]
    assert all(
        len(line) <= WIDTH or "a string" in line or "NUMBERS" in line for line in narrow.split("\n")
    )
    assert " * joints[0] begins" in narrow


def test_bounds_are_rounded_up_alike_on_every_processor():
    """Never below the bound but for its own rounding; a bound that three digits state has no
    further step because its last bits are high.
    """
    for exact in (5.0, 4.0, 216000.0, 0.125, -7.5e-9):
        for last_bits in (-4e-16, 0.0, 4e-16, 1e-14):
            assert rounded_up(exact * (1.0 + last_bits)) == exact
    rng = np.random.default_rng(2)
    for value in rng.normal(size=300) * 10.0 ** rng.integers(-12, 12, 300):
        stated = rounded_up(float(value))
        assert stated == float(f"{stated:.3g}")
        assert abs(value) * (1.0 - 1e-11) <= abs(stated) <= 1.0101 * abs(value)


def test_constants_are_folded():
    """Sums with several constants, negative ones, products with 1 and -1, and what is constant
    throughout.
    """
    x = ca.SX.sym("x", 2)
    one = ca.SX(1.0 + 1e-15)
    values = ca.vertcat(
        x[0] - 69.25 - 69.25 + 138.5,
        x[0] - ca.SX(-275.0),
        -3.0 + x[1],
        x[0] * one,
        x[1] / ca.SX(-1.0),
        one / -one + x[0],
        4.0 - x[0],
    )
    function = ca.Function("f", [x], [values])
    emitter = Emitter(function, [["x0", "x1"]], Real("double"))
    texts = [emitter.value(0, i) for i in range(7)]
    named = {
        line.split(" = ")[0].split()[-1]: line.split(" = ")[1].rstrip(";") for line in emitter.lines
    }
    written = [named.get(text, text) for text in texts]
    assert written == ["x0", "x0 + 275.0", "x1 - 3.0", "x0", "-x1", "x0 - 1.0", "4.0 - x0"]
    at = np.array([0.3, -1.7])
    assert np.allclose(
        [eval(text, {"x0": at[0], "x1": at[1]}) for text in written],
        function(at).full().ravel(),
        atol=1e-12,
    )


def test_a_root_that_nothing_reads_is_only_asked_for():
    """The rates of zhao2000_links declared one that they did not read: C with warnings as errors
    was refused.
    """
    x, roots = ca.SX.sym("x"), ca.SX.sym("r", 2)
    inputs = [(x, ["x"]), (roots, ["r1", "r2"])]
    emitter = Emitter.of(Real("double"), inputs, x * x, roots[0] - x, roots[0] * x)
    above = [emitter.root(k + 1, emitter.value(k, 0), "0.1", "1.0") for k in range(2)]
    written = "\n".join(emitter.stored(["found"], 2))
    assert above == ["(d1 > 0.1)", "(d2 > 0.1)"]
    assert "const real d2 = " in written
    assert "r1 = (d1 > 0.1) ? sqrt(d1) : 1.0" in written
    assert "r2" not in written
