"""Fill the C templates of `templates/`, and the statements that all kinds of mechanisms share."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from importlib import resources

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from symkin.codegen.text.c import Real, block
from symkin.computed_once import lru_cache
from symkin.text import markdown

FARTHEST = 1e3
"""Positions and joint values beyond this many times the size are refused: their squares stay far
below the largest float.
"""


_NAMES = re.compile(r"@(?:\{(\w+)\}|(\w+)( ?)|@)?|\b(?:name|NAME|solver)(?=_)")
"""What stands for something in a template: @value or @{value}, @@, and beginnings of words: of the
machine name_ and NAME_, of one of its iterations solver_.
"""
_ALONE = re.compile(r"( *)@\{?(\w+)\}?")
_MACRO = re.compile(r"#define (\w+)(?:\((.*?)\))? ((?:.*\\\n)*.*)")
_ARGUMENTS = r"\(((?:[^()\n]|\([^()\n]*\))*)\)"
_PREFIXES = {"name": "p", "NAME": "P", "solver": "k"}


def fill(template: str, values: Mapping[str, object]) -> str:
    """Read a file of `templates/` and replace its names."""
    return substitute(template_text(template), values)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    """Templates that choose their words: values as in the others, and Jinja's statements."""
    environment = Environment(
        loader=PackageLoader("symkin.codegen"),
        undefined=StrictUndefined,
        extensions=["jinja2.ext.do"],
        variable_start_string="@{",
        variable_end_string="}",
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["markdown"] = markdown
    return environment


def rendered(template: str, **values: object) -> str:
    """Read a file of `templates/` and follow its statements; a name without a value is an error."""
    return _environment().get_template(template).render(values)


@lru_cache(maxsize=256)
def template_text(template: str) -> str:
    """Read a file of `templates/`; into C the macros of macros.h are put, which read those that
    stand before them.
    """
    text = _read(template)
    if template.endswith((".c", ".h")):
        for name, parameters, body in _macros():
            if name not in text:
                continue
            called = rf"^( *)(.*?)\b{name}\b" + (_ARGUMENTS if parameters else "()")
            text = re.sub(called, partial(_put_in, parameters, body), text, flags=re.M)
    return text


@lru_cache(maxsize=1)
def _macros() -> list[tuple[str, str, str]]:
    """Name, parameters and body of each macro of macros.h, the last one first."""
    return _MACRO.findall(_read("macros.h"))[::-1]


def _read(template: str) -> str:
    place = resources.files("symkin.codegen").joinpath("templates", template)
    return place.read_text(encoding="utf-8")


def _put_in(parameters: str, body: str, found: re.Match[str]) -> str:
    """The text of a macro in the place of its name, lines below the first as deep as its own; ##
    joins words.
    """
    given = re.split(r", (?![^(]*\))", found[3])
    names = dict(zip(parameters.split(", "), given, strict=True))
    told = re.sub(r"\w+", lambda word: names.get(word[0], word[0]), body)
    return found[1] + found[2] + told.replace("##", "").replace(" \\\n", f"\n{found[1]}")


def substitute(text: str, values: Mapping[str, object]) -> str:
    """Put values in the places of @value in a text, or of @{value} before a letter, and names in
    those of name_, NAME_ and solver_; @@ is @, what has no value an error. One space behind @value
    goes where the value is nothing or ends in one. Of a tuple all entries are told. A value alone
    on its line, a text or lines, stands as deep as its name. Lines whose names stand for nothing
    are left out.
    """

    def value(found: re.Match[str]) -> str:
        text = found[0]
        if text in ("@@", *_PREFIXES):
            # of names nobody told, `Real.typed` puts those of the machine in
            return "@" if text == "@@" else str(values.get(_PREFIXES[text], text))
        told = _told(values[found[1] or found[2] or text])
        return told + (found[3] or "" if told.rstrip() == told != "" else "")

    filled = list[str]()
    for line in text.split("\n"):
        alone = _ALONE.fullmatch(line)
        given = values[alone[2]] if alone else _NAMES.sub(value, line)
        parts = given if isinstance(given, list) else str(given).rstrip().split("\n")
        depth = alone[1] if alone else ""
        filled += [
            depth + part if part else "" for part in parts if part or parts != [""] or not line
        ]
    return "\n".join(filled)


def _told(value: object) -> str:
    """C text of a value: of a tuple those of all its entries."""
    if isinstance(value, tuple):
        return ", ".join(map(_told, value))
    return str(value).lower() if isinstance(value, bool) else str(value)


def common_values(name: str, real: Real, *, struct: bool) -> dict[str, object]:
    """Values of the names that every template knows; `struct`: the geometry is given with each
    call.
    """
    return {
        "p": name,
        "P": name.upper(),
        "real": real.type,
        "ga": "geometry, " if struct else "",
        "use": "    (void)geometry;" if struct else "",
        "checked": f"{name}_check_geometry(geometry, status)" if struct else "status",
        "zero": real.zero,
        "one": real.one,
        "four": real.literal(4.0),
        "static_own": "",
        "jacobian": f"{name}_jacobian",
        "twist": f"{name}_twist",
    }


def normalise_pose(values: Mapping[str, object]) -> str:
    """NAME_normalise_pose: no square overflows on the way to a refusal (for processors that
    trap).
    """
    near = [f"(fabs(q[{i}]) <= 2.0)" for i in range(4)]
    near += [f"(fabs(pose->position[{i}]) <= {values['farthest']})" for i in range(3)]
    return fill("pose.c", {"taken": "", **values, "bounded": "\n        && ".join(near)})


def farthest(size: float, reference: Sequence[float] | np.ndarray) -> float:
    """How far each coordinate of a position may be from the base's origin, for a platform or tool
    at `reference`.
    """
    return float(f"{FARTHEST * size + float(np.sum(np.abs(reference))):.3g}")


def copy(target: str, source: str, count: int) -> list[str]:
    """Statements that copy an array; short ones without a loop."""
    if count <= 8:
        return [f"{target}[{i}] = {source}[{i}];" for i in range(count)]
    return copy_loop(target, source, count)


def copy_loop(target: str, source: str, count: int) -> list[str]:
    """Statements that copy an array in a loop."""
    return block(f"for (int i = 0; i < {count}; ++i)", [f"{target}[i] = {source}[i];"])
