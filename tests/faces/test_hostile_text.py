"""Text of files on its way through every output: it stays text, whatever it holds, and what no
output can hold is refused.
"""

from __future__ import annotations

import ast
import csv
import ctypes
import io
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

import symkin
from helpers.firmware_tools import STRICT, built, compiler, passed
from helpers.gate import each_once, in_gate
from helpers.inside import (
    Options,
    c_comment,
    docstring_line,
    document,
    equations,
    folder_files,
    identifier,
    identifiers,
    jacobian_text,
    labels,
    latex_text,
    main,
    markdown,
    markdown_block,
    markdown_code,
    matplotlib_text,
    parse,
    write_folder,
)
from symkin import Joint, Limb, Mechanism, MechanismError, RodLimb, jacobian

Z = (0.0, 0.0, 1.0)
TITLE = (
    r"""*/ __attribute__((constructor)) static void """
    r"""injected(void) { __builtin_abort(); } /* ??/ */ // \ """
    r'''""" + injected() + """ \N{BULLET} \x \u12 #{x} $(shell injected) '''
    r"""`injected` ${injected} $x^$ \input{injected} % & ~ ^ _ """
    r"""<script>injected()</script> <!-- -- --> [injected](http://x) ![i](x) | """
    r"""**b** __i__ [red]injected[/red] @{p} %s {0} &amp; é θ 中 ??/"""
)
"""A title that attacks every output by its own means, and ends in what joins lines of C."""
SOURCE = TITLE + "\\"
NAMES = [
    "int",
    "_x",
    "__x",
    "1",
    "leg 1",
    "leg_1",
    "leg-1",
    'a"b',
    "a\\b",
    "l'x//",
    "None",
    "np",
    "θ1",
    "x.y",
    "CON",
    'jac*/"""\\',
]
"""Names that the grammar allows and no language takes as they are."""
REFUSED = [
    "\x00",
    "\x1b",
    "\x7f",
    "\x85",
    "\u061c",
    "\u200e",
    "\u202e",
    "\u2066",
    "\u2028",
    "\u2029",
    "\ufdd0",
    "\uffff",
    "\U0001fffe",
]


def named(mechanism: Mechanism, names: list[str]) -> Mechanism:
    """The mechanism with hostile title and source, and names for its joints, then its limbs."""
    given = iter(names)
    limbs = []
    for limb in mechanism.limbs:
        if isinstance(limb, Limb):
            limb = replace(limb, joints=[replace(joint, name=next(given)) for joint in limb.joints])
        limbs.append(replace(limb, name=limb.name if mechanism.serial else next(given)))
    return replace(mechanism, limbs=limbs, dh=None, title=TITLE, source=SOURCE)


def three_legs() -> Mechanism:
    """A planar platform on two rods and a limb RRR."""
    crank = [
        Joint("crank", "R", (100.0, 0.0, 0.0), Z, actuated=True),
        Joint("elbow", "R", (130.0, 60.0, 0.0), Z),
    ]
    limb = Limb("limb", [*crank, Joint("wrist", "R", (60.0, 90.0, 0.0), Z)])
    rods = [
        RodLimb("rod1", (0.0, 0.0, 0.0), (-30.0, 0.0, 0.0)),
        RodLimb("rod2", (-50.0, 40.0, 0.0), (-20.0, 25.0, 0.0)),
    ]
    return Mechanism("legs", [*rods, limb], platform_position=(40.0, 80.0, 0.0), motion="planar")


def arm() -> Mechanism:
    joints = [Joint(f"q{k}", "R", (100.0 * k, 0.0, 0.0), Z, actuated=True) for k in range(2)]
    return Mechanism(
        "arm", [Limb("arm", joints)], platform_position=(200.0, 20.0, 0.0), serial=True
    )


LEGS = [named(three_legs(), NAMES[k : k + 6]) for k in (0, 4, 10)]
MECHANISMS = [*LEGS, named(arm(), NAMES[7:9])]


def code_of(text: str) -> str:
    """C without comments and strings, after trigraphs and spliced lines, as a compiler sees it (C99
    5.1.1.2).
    """
    for mark, character in zip("=/'()!<>-", "#\\^[]|{}~", strict=True):
        text = text.replace("??" + mark, character)
    text = re.sub(r"\\[ \t]*\n", "", text)
    return re.sub(r'/\*.*?\*/|//[^\n]*|"(?:[^"\\\n]|\\.)*"', " ", text, flags=re.DOTALL)


# --- escapes --------------------------------------------------------------------------------------

attacks = st.text(
    st.sampled_from("*/\\?=!<>()'\"-`$#%&_{}[]~^|@ abé1.+:")
    | st.characters(exclude_categories=["Cs", "Cc"]),
    max_size=24,
)


@given(attacks, attacks)
def test_comments_of_c_hold_any_text(first, second):
    """Of a comment around two lines nothing is left for the compiler."""
    assert code_of(f"a /* {c_comment(first)}\n * {c_comment(second)}\n */ b").split() == ["a", "b"]


@given(attacks, attacks)
def test_docstrings_hold_any_text(first, second):
    """Two lines in a docstring are one string, and its text is theirs but for quotation marks."""
    module = ast.parse("\n".join(['"""' + docstring_line(first), docstring_line(second), '"""']))
    (statement,) = module.body
    value = ast.literal_eval(statement.value)
    if first.isprintable() and second.isprintable():
        assert value == f"{first}\n{second}\n".replace('"', "'")


@given(attacks)
def test_markdown_renders_the_text_itself(text):
    """A heading, an item and a paragraph are one text each: no markup, link, image, code or HTML,
    and nothing lost.
    """
    text = " ".join(text.split())
    for before in ("# a: ", "- a: ", "a: ", ""):
        inline = [
            token for token in MarkdownIt().parse(before + markdown(text)) if token.type == "inline"
        ]
        children = [child for token in inline for child in token.children or []]
        assert {child.type for child in children} <= {"text", "text_special"}
        if text.isprintable():
            assert (
                "".join(child.content for child in children) == before.lstrip("#- ") + text
                or not text
            )


@given(attacks)
def test_code_in_markdown_renders_the_text_itself(text):
    """A span is one piece of code, a block of three lines another."""
    (paragraph,) = [
        token
        for token in MarkdownIt().parse("a " + markdown_code(f"x{text}x"))
        if token.type == "inline"
    ]
    assert [child.type for child in paragraph.children or []] == ["text", "code_inline"]
    blocks = MarkdownIt().parse("\n".join([*markdown_block("text", f"```\n{text}\n```"), "end"]))
    assert [token.type for token in blocks] == [
        "fence",
        "paragraph_open",
        "inline",
        "paragraph_close",
    ]


@given(attacks)
def test_latex_has_no_active_character(text):
    """After the known escapes, letters, digits and harmless signs are left, all in ASCII."""
    rest = re.sub(
        r"\\(?:[{}$&#%_]|text(?:backslash|asciicircum|asciitilde)\{\})", "", latex_text(text)
    )
    assert rest.isascii()
    assert not set(rest) & set("\\{}$&#%_^~")


@given(attacks)
def test_pictures_show_dollars(text):
    """Matplotlib finds no mathematics in the text."""
    from matplotlib import cbook

    assert not cbook.is_math_text(matplotlib_text(text))


@given(st.lists(attacks, max_size=6))
def test_identifiers_are_valid_and_different(names):
    """A C identifier that no standard reserves for each name, whatever is put before or after it
    with a single _.
    """
    found = identifiers(names)
    assert len(set(found)) == len(names)
    for name in found:
        assert re.fullmatch("[A-Za-z](?:_?[0-9A-Za-z])*", name)
    assert identifier("leg1.base.x") == "leg1_base_x"


# --- generated C ----------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=["words", "spaces", "marks", "arm"])
@pytest.mark.parametrize("geometry", ["fixed", "struct"])
def test_firmware_of_hostile_files_compiles_and_passes(mechanism, geometry, tmp_path):
    """No word of title or source reaches the compiler; the folder builds without a warning and its
    test passes.
    """
    files = folder_files(mechanism, Options(geometry=geometry))
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        if name.endswith((".c", ".h")):
            assert "injected" not in code_of(text)
        if name in ("Makefile", "CMakeLists.txt"):
            assert "injected" not in text
    name = mechanism.name
    passed(
        built(
            "gcc",
            tmp_path,
            [f"{name}_test.c", f"{name}.c"],
            "run",
            "-Wtrigraphs",
            "-trigraphs",
            "-Wcomment",
        )
    )
    source = f'#include "{name}.h"\nint main() {{ return 0; }}\n'
    command = [compiler("g++"), "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++", "-"]
    subprocess.run(command, input=source, text=True, cwd=tmp_path, check=True)


@pytest.mark.slow
def test_the_readme_of_firmware_is_text():
    """Title and source stand in it as they are: no HTML, image or link of theirs."""
    text = folder_files(MECHANISMS[3], Options())["README.md"]
    tokens = MarkdownIt().parse(text.split("## Equations")[0])
    inline = [child for token in tokens for child in token.children or []]
    assert not any(
        "html" in token.type or token.type in ("image", "link_open") for token in [*tokens, *inline]
    )
    assert TITLE in "".join(child.content for child in tokens[1].children or [])


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(["m", "test", "example", "int"], ["int"]))
def test_reserved_words_as_names_build(name, tmp_path):
    """Words of C, C++ and CMake make no name of their own in C, and another target in CMake."""
    mechanism = replace(arm(), name=name)
    write_folder(mechanism, tmp_path, Options())  # which builds the code and runs its test
    targets = re.findall(
        r"(?:add_library|add_executable)\((\w+)", (tmp_path / "CMakeLists.txt").read_text()
    )
    assert len(set(targets)) == 3
    assert not set(targets) & {"m", "test"}


@pytest.mark.parametrize("name", ["math", "Stdint", "_robot", "a__b", "robot_", "example_main"])
def test_names_that_c_reserves_are_refused_where_c_is_written(name, tmp_path):
    """Firmware refuses the name with a reason."""
    mechanism = replace(arm(), name=name)
    with pytest.raises(symkin.InputError, match=rf"{name}.*(reserve|header|file).*rename"):
        write_folder(mechanism, tmp_path, Options())


@pytest.mark.parametrize("name", ["con", "PRN", "aux", "nul", "COM1", "lpt9"])
def test_devices_of_windows_are_no_names_of_mechanisms(name):
    """Nor of the folders of a sweep's arrays, which joints are called after."""
    assert labels([name, f"{name}.1", "conrod"]) == [f"joint.{name}", f"joint.{name}.1", "conrod"]
    with pytest.raises(MechanismError, match=f"{name}.*Windows"):
        replace(arm(), name=name)


# --- Jacobians and equations ----------------------------------------------------------------------


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=["words", "spaces", "marks", "arm"])
def test_jacobians_of_hostile_files_are_the_same_in_every_language(mechanism, tmp_path):
    """Each file runs in its language, holds no code of the title, and gives the expression's
    matrix.
    """
    import casadi

    symbolic = jacobian(mechanism, "direct")
    inputs = [0.1 + 0.2 * k for k in range(len(symbolic.inputs))]
    files = {
        language: jacobian_text(symbolic, language)
        for language in ("numpy", "sympy", "c", "casadi", "latex")
    }
    scope: dict = {}
    for language in ("numpy", "sympy"):
        module = ast.parse(files[language])
        assert "injected" in ast.get_docstring(module, clean=False)
        assert not any("injected" in ast.dump(statement) for statement in module.body[1:])
    exec(compile(files["numpy"], "exported", "exec"), scope)
    expected = scope["jacobian"](*inputs)
    assert expected.shape == symbolic.shape
    assert "injected" not in code_of(files["c"])
    (tmp_path / "j.c").write_text(files["c"], encoding="utf-8")
    subprocess.run(
        [compiler("gcc"), *STRICT, "-Wtrigraphs", "-shared", "-fPIC", "-o", "j.so", "j.c", "-lm"],
        cwd=tmp_path,
        check=True,
    )
    matrix = np.zeros(symbolic.shape)
    function = getattr(ctypes.CDLL(str(tmp_path / "j.so")), f"{mechanism.name}_direct_jacobian")
    function(
        (ctypes.c_double * len(inputs))(*inputs),
        matrix.ctypes.data_as(ctypes.POINTER(ctypes.c_double)),
    )
    np.testing.assert_allclose(matrix, expected, rtol=1e-9, atol=1e-9)
    (tmp_path / "j.casadi").write_text(files["casadi"], encoding="utf-8")
    loaded = casadi.Function.load(str(tmp_path / "j.casadi"))
    np.testing.assert_allclose(np.array(loaded(*inputs)), expected, rtol=1e-9, atol=1e-9)
    assert all(line.startswith("%") for line in files["latex"].splitlines() if "injected" in line)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("k", [0, 1, 2])
def test_latex_of_hostile_files_compiles(k, tmp_path):
    """The closure equations and the Jacobian go through pdflatex, and each joint has a symbol of
    its own.
    """
    body = document(equations(LEGS[k]))
    for name, text in (
        ("closure", body),
        ("jacobian", jacobian_text(jacobian(LEGS[k], "direct"), "latex")),
    ):
        (tmp_path / f"{name}.tex").write_text(text, encoding="utf-8")
        command = [
            "pdflatex",
            "-interaction=nonstopmode",
            "-halt-on-error",
            "-no-shell-escape",
            f"{name}.tex",
        ]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False, timeout=60)
        assert done.returncode == 0, done.stdout.decode(errors="replace")[-800:]


# --- terminal, pictures, tables -------------------------------------------------------------------


@pytest.fixture
def hostile(tmp_path):
    """A file of the platform on rods with hostile text, which comes back as it was."""
    path = tmp_path / "legs.toml"
    path.write_text(LEGS[1].to_toml(), encoding="utf-8")
    assert symkin.load(path) == LEGS[1]
    return path


def run(capsys, *arguments: str) -> str:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    said = capsys.readouterr()
    assert stop.value.code == 0, said.err
    return said.out


def test_terminal_text_is_the_files(hostile, capsys):
    """Titles, limbs and joints are printed as they are: no markup is taken out, no emoji put in, no
    control character made.
    """
    shown = run(capsys, "show", str(hostile))
    assert TITLE in shown
    assert SOURCE in shown
    modes = run(capsys, "modes", str(hostile), "--all")
    assert TITLE in modes
    assert LEGS[1].limbs[2].joints[1].name in modes
    assert "\x1b" not in shown + modes


def test_pictures_show_the_title(hostile, tmp_path, capsys):
    """A track and the modes are drawn; the picture is XML, and its title the file's."""
    joints = ",".join(f"{c.reference[0]:.12g}" for c in LEGS[1].actuated)
    moved = ",".join(f"{c.reference[0] + 0.01:.12g}" for c in LEGS[1].actuated)
    run(capsys, "modes", str(hostile), "--plot", str(tmp_path / "modes.svg"))
    run(
        capsys,
        "track",
        str(hostile),
        "--from",
        joints,
        "--to",
        moved,
        "--samples",
        "3",
        "--plot",
        str(tmp_path / "track.svg"),
        "-o",
        str(tmp_path / "track.csv"),
    )
    for name in ("modes.svg", "track.svg"):
        root = ElementTree.parse(tmp_path / name).getroot()
        assert not [e for e in root.iter() if e.tag.endswith("script")]
        assert TITLE.split(" ")[0] in (tmp_path / name).read_text(encoding="utf-8")
    rows = list(csv.reader(io.StringIO((tmp_path / "track.csv").read_text(encoding="utf-8"))))
    assert not [cell for row in rows for cell in row if re.match(r"[=+@\t]|-[^0-9]", cell)]
    assert [cell.split("[")[0] for cell in rows[0][: len(LEGS[1].actuated)]] == [
        c.name for c in LEGS[1].actuated
    ]


def test_json_holds_the_names(hostile, capsys):
    """Names are keys of `joints`, in ASCII."""
    text = run(capsys, "solve", str(hostile), "--json")
    assert text.isascii()
    assert list(json.loads(text)["solution"]["joints"]) == NAMES[4:9]


# --- what is refused ------------------------------------------------------------------------------

FILE = three_legs().to_toml()
PLACES = {
    "title": (
        lambda text: FILE.replace('name = "legs"', f'name = "legs"\ntitle = "a{text}b"'),
        "title",
    ),
    "source": (
        lambda text: FILE.replace('name = "legs"', f'name = "legs"\nsource = "a{text}b"'),
        "source",
    ),
    "name": (lambda text: FILE.replace('"legs"', f'"a{text}b"'), "name"),
    "rod": (lambda text: FILE.replace('"rod2"', f'"a{text}b"'), r"limb\[1\]\.name"),
    "joint": (
        lambda text: FILE.replace('"elbow"', f'"a{text}b"'),
        r"limb\[2\] \(limb\)\.joint\[1\]\.name",
    ),
}


@pytest.mark.parametrize(("place", "character"), each_once(PLACES, REFUSED))
def test_control_and_bidirectional_characters_are_refused(place, character):
    """In one line that names the key path and the character by its number, and does not hold it."""
    make, path = PLACES[place]
    with pytest.raises(MechanismError, match=f"mechanism: {path} = .*") as caught:
        parse(make(f"\\U{ord(character):08x}"))
    assert character not in str(caught.value)
    assert place == "name" or f"U+{ord(character):04X}" in str(caught.value)


@pytest.mark.parametrize(
    "name",
    [
        "",
        " a",
        "a ",
        "*a",
        "=1+1",
        "+a",
        "-a",
        "@a",
        "a$b",
        "a%b",
        "a{b",
        "a[b]",
        "a`b",
        "a<b",
        "a|b",
        "a,b",
        "a=b",
        "a:b",
        "a;b",
        "a?b",
        "a\nb",
        "a\tb",
        "x" * 101,
    ],
)
def test_names_outside_the_grammar_are_refused(name):
    """From Python too, with the grammar."""
    for limb in (Limb("a", [Joint(name, "R", axis=Z)]), RodLimb(name, (0, 0, 0), (1, 0, 0))):
        with pytest.raises(MechanismError, match=r"name = .*allowed: letters, digits"):
            Mechanism("m", [limb])


@pytest.mark.parametrize(
    "name", ["leg 1", "Ärm.", "θ1", "q'", "hip (left)", "motor #2", "l/r", "a+b", "脚1", "क्षि", "1"]
)
def test_names_that_people_use_are_allowed(name):
    assert Mechanism("m", [Limb("a", [Joint(name, "R", axis=Z)])]).limbs[0].joints[0].name == name


def test_line_breaks_and_tabs_in_titles_are_spaces():
    """A title over several lines of a file is one line."""
    made = replace(three_legs(), title=" a\n  b\r\nc\td ")
    assert made.title == "a b c d"
    assert parse(made.to_toml()) == made


def test_headers_and_labels_of_csv_files_are_text(tmp_path):
    """A control character in a header, a label or a cell is refused by line and cell."""
    from helpers.inside import read_table

    for text, place in (
        ("a\x1b[31m,b\n1,2\n", "line 1: cell 1"),
        ('a,group\n1,"x\n=1"\n', "line 3: cell 2"),
    ):
        (tmp_path / "data.csv").write_text(text, encoding="utf-8")
        with pytest.raises(symkin.InputError, match=place):
            read_table(tmp_path / "data.csv")


LONG = "x" * 100_000
MESSAGES = {
    "name": FILE.replace('"legs"', f'"{LONG} "'),
    "joint": FILE.replace('"elbow"', f'"{LONG}"'),
    "type": FILE.replace('"SPS"', f'"{LONG}"'),
    "key": FILE.replace("point", LONG),
    "arithmetic": FILE.replace("100.0", f'"{LONG}"', 1),
    "words": FILE.replace("100.0", '"' + "a b " * 25_000 + '"', 1),
    "unit": FILE.replace('"mm"', f'"{LONG}"'),
    "broken": f"{LONG} {LONG} = 1",
    "array": FILE.replace("100.0", str([LONG]), 1),
}


@pytest.mark.parametrize("what", MESSAGES)
def test_long_values_are_not_echoed(what):
    """A message of a file with 100 kB in one place is short."""
    with pytest.raises(MechanismError) as caught:
        parse(MESSAGES[what])
    assert len(str(caught.value)) < 1200


@pytest.mark.parametrize(
    "arguments",
    [
        ["show", LONG],
        ["show", f"{LONG}.toml"],
        ["solve", "arm", "--joints", LONG],
        ["modes", "zhang2009", "--starts", LONG],
        ["modes", "zhang2009", "--method", LONG],
        [LONG],
    ],
    ids=["name", "path", "numbers", "count", "choice", "command"],
)
def test_long_arguments_are_not_echoed(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert len(capsys.readouterr().err) < 1200


def test_messages_hold_no_control_characters(tmp_path, capsys):
    """An unknown key with a terminal's escape sequence is printed as its escape."""
    path = tmp_path / "legs.toml"
    path.write_text(FILE + '"\\u001b[2J\\u202e" = 1\n', encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["show", str(path)])
    said = capsys.readouterr().err
    assert said[:-1].isprintable()
    assert "\\x1b[2J" in said


# --- calibration ----------------------------------------------------------------------------------

LABELS = [
    "<script>injected()</script>",
    "![i](http://x)",
    "a|b `c` **d**",
    "=1+1",
    "[red]e[/red] $x^$",
]
"""Labels of groups that attack a report's Markdown."""


@pytest.mark.long
@pytest.mark.slow
def test_reports_of_calibrations_are_text(tmp_path, capsys):
    """Labels, paths and titles from users stand in report.md as they are, and the mechanism file
    written is read again.
    """
    folder = tmp_path / "a`b <b>"
    folder.mkdir()
    joints = [
        Joint(f"q{k}", "R", (0.3 * k, 0.1 * k, 0.0), a, actuated=True)
        for k, a in enumerate([Z, (0.0, 1.0, 0.2)])
    ]
    arm = Mechanism(
        "arm",
        [Limb("arm", joints)],
        (0.7, 0.1, 0.3),
        serial=True,
        length_unit="m",
        title=TITLE,
        source=SOURCE,
    )
    (folder / "arm.toml").write_text(arm.to_toml(), encoding="utf-8")
    data = folder / "d``a.csv"
    simulated = [
        "simulate",
        str(folder / "arm.toml"),
        "--postures",
        "15",
        "--readings",
        "pose",
        "-o",
        str(data),
    ]
    run(capsys, "calibrate", *simulated)
    rows = list(csv.reader(io.StringIO(data.read_text(encoding="utf-8"))))
    rows[3][rows[0].index("x[m]")] = "5.0"  # an outlier, which the report names
    rows = [
        [label, *row]
        for label, row in zip(
            ["group", *(f"{LABELS[k % 5]}{k}" for k in range(15))], rows, strict=True
        )
    ]
    with data.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
    run(
        capsys,
        "calibrate",
        "fit",
        str(folder / "arm.toml"),
        str(data),
        "-o",
        str(folder / "out"),
        "--pictures",
        "--parameters",
        "q1.point.*",
    )
    text = (folder / "out" / "report.md").read_text(encoding="utf-8")
    tokens = MarkdownIt("commonmark").enable("table").parse(text)
    inline = [child for token in tokens for child in token.children or []]
    assert not [
        token for token in [*tokens, *inline] if "html" in token.type or token.type == "link_open"
    ]
    assert {str(token.attrs["src"]) for token in inline if token.type == "image"} == {
        "residuals.png",
        "parameters.png",
        "pose_sigma.png",
    }
    assert str(data) in [token.content for token in inline if token.type == "code_inline"]
    written = symkin.load(folder / "out" / "arm.toml")
    assert written.title.startswith(TITLE)
    assert json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))["data"] == str(
        data
    )
