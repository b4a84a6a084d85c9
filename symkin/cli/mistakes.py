"""What is wrong with the words of a command line, as one sentence with what is meant or allowed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from symkin.errors import InputError
from symkin.text import meant, not_among, shown

_VALUE = re.compile(r"[-+]?[\d.].*|,.*|.*=.*|.*,")
"""A word that looks like a part of a list: a number, NAME=VALUE, or what a comma follows."""


def sentence(error: Any, ctx: Any, words: Sequence[str]) -> InputError:
    """Say what Click found wrong with the words of a command."""
    too_many = "unexpected extra argument" in str(error.message)
    split = _list_in_pieces(ctx, words, names_too=too_many)
    if split is not None:
        return split
    kind = type(error).__name__
    if kind == "NoSuchOption":
        return _unknown_option(error.option_name, ctx)
    if kind == "BadOptionUsage":
        return _no_value(error.option_name, ctx)
    if kind == "MissingParameter":
        return _missing(error.param, ctx)
    if too_many:
        return _too_many(ctx, words)
    return InputError(error.format_message().replace("Value error, ", "").rstrip("."))


def refuse_empty_files(ctx: Any, words: Sequence[str]) -> None:
    """Raise InputError for a file or folder whose name is empty, as of a variable that is not set:
    it would be the current folder.
    """
    files = [p for p in ctx.command.params if re.match("FILE|DIR|FOLDER", p.metavar or "")]
    names = {name for p in files for name in p.opts if name.startswith("-")}
    for k, word in enumerate(words):
        name, equals, value = word.partition("=") if word.startswith("--") else (word, "", "")
        if (
            name in names
            and not (value if equals else words[k + 1] if k + 1 < len(words) else "-").strip()
        ):
            raise InputError(f"{name} is empty; the name of a file or folder is needed")


def unknown_command(word: str, path: str, commands: Sequence[str]) -> InputError:
    """A word where a command is needed: one that no command has, or a mechanism before its
    command.
    """
    if word.startswith("-"):
        return InputError(
            f"option {shown(word)} is unknown, or stands before its command: {path} COMMAND {word} "
            f"..."
        )
    if word in ("help", "version"):
        return InputError(
            f"{shown(word)} is an option here: {path} --{word}, or {path} COMMAND --help for one "
            f"command"
        )
    if Path(word).exists() or _is_shipped(word):
        first = "modes" if "modes" in commands else commands[-1]
        return InputError(
            f"{shown(word)} is a mechanism, and the command comes first: {path} {first} {word}"
        )
    return InputError(f"command {not_among(word, commands)}")


def _is_shipped(word: str) -> bool:
    from symkin.model.shipped import shipped_names

    return word in shipped_names()


def _list_in_pieces(ctx: Any, words: Sequence[str], *, names_too: bool) -> InputError | None:
    """Values of a list that spaces part: `--joints 1 2 3`; with `names_too` also `--plane x y`."""
    lists = {name for p in ctx.command.params for name in p.opts if "," in (p.metavar or "")}
    names = {name for p in ctx.command.params for name in p.opts}
    for k, word in enumerate(words):
        if word not in lists:
            continue
        values: list[str] = []
        for value in words[k + 1 :]:
            more = (
                not values
                or _VALUE.fullmatch(value)
                or values[-1].endswith(",")
                or (names_too and "," not in values[0])
            )
            if value in names or not more:
                break
            values.append(value)
        if len(values) > 1:
            joined = re.sub(",+", ",", ",".join(values)).strip(",")
            return InputError(
                f"{word} {' '.join(values)}: separate values by commas, without spaces: {word} "
                f"{joined}"
            )
    return None


def _unknown_option(name: str, ctx: Any) -> InputError:
    known = [opt for p in ctx.command.params for opt in p.opts if opt.startswith("--")]
    # the file that a command writes where others write by -o
    files = [
        p.opts[0] for p in ctx.command.params if re.match(r"FILE\.(png|html)", p.metavar or "")
    ]
    like = files[0] if files and name in ("-o", "--output") else name
    return InputError(
        f"option {shown(name)} is unknown{meant(like, known)}; `{ctx.command_path} -h` lists the "
        f"options"
    )


def _no_value(name: str, ctx: Any) -> InputError:
    if (
        any(name in p.opts and getattr(p, "is_flag", False) for p in ctx.command.params)
        or name == "--help"
    ):
        return InputError(f"{name} takes no value; write {name} alone")
    return InputError(f"{name} has no value; {_written(ctx, name)} is needed")


def _written(ctx: Any, name: str) -> str:
    """An option with its value as help writes it."""
    found = next((p.metavar for p in ctx.command.params if name in p.opts), None)
    return f"{name} {found or 'VALUE'}"


def _missing(parameter: Any, ctx: Any) -> InputError:
    if parameter is None:
        return InputError(f"a word is missing; `{ctx.command_path} -h` shows what is needed")
    named = (
        parameter.metavar
        if parameter.param_type_name == "argument"
        else _written(ctx, parameter.opts[0])
    )
    text = parameter.told.help
    hint = f": {text[0].lower()}{text[1:].rstrip('.')}"
    return InputError(f"{named} is missing{hint}; `{ctx.command_path} -h` shows examples")


def _too_many(ctx: Any, words: Sequence[str]) -> InputError:
    """Words that belong to nothing."""
    options = {
        name for p in ctx.command.params if not getattr(p, "is_flag", False) for name in p.opts
    }
    alone = [
        w
        for k, w in enumerate(words)
        if not w.startswith("--") and w not in options and (k == 0 or words[k - 1] not in options)
    ]
    places = [p.metavar for p in ctx.command.params if p.param_type_name == "argument"]
    extra = alone[len(places)] if len(alone) > len(places) else ""
    taken = f"{' and '.join(places)}, and options" if places else "options only"
    hint = ""
    if _VALUE.fullmatch(extra) and "--joints" in options:
        hint = f"; joint values are given by --joints {extra}"
    elif _VALUE.fullmatch(extra) and "--from" in options:
        hint = f"; a path is --from {extra} --to ..."
    return InputError(f"{shown(extra)} stands alone: `{ctx.command_path}` takes {taken}{hint}")
