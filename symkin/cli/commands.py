"""Commands made of functions, whose parameters say by `Option` what they are: arguments, options in
groups, help with examples as they are typed, mistakes in a sentence.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, is_dataclass
from importlib import import_module
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints, is_typeddict

import click

from symkin.cli.mistakes import refuse_empty_files, sentence, unknown_command
from symkin.cli.reading import record_of
from symkin.errors import InputError
from symkin.model.shipped import shipped_examples
from symkin.model.written_number import whole
from symkin.text import not_among, shown
from symkin.verb_options import FILES, OUTPUT, ROBOT_FILES, Argument, Option, options_of, words_of

_OTHERS = "Options"
"""The heading of options that every command has."""
_HELP_NAMES = {"help_option_names": ["-h", "--help"]}


class _Helped(click.Command):
    """A command whose help ends with examples, and whose mistakes are sentences."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        given = list(args)  # the parser empties its own list
        refuse_empty_files(ctx, given)
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            raise sentence(error, ctx, given) from None

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        _write_parameters(self.get_params(ctx), ctx, formatter)

    def format_epilog(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        _write_examples(self.epilog, formatter)


class Command(_Helped):
    """A command whose help has options in groups."""

    def collect_usage_pieces(self, ctx: click.Context) -> list[str]:
        return [*map(_usage, (p for p in self.get_params(ctx) if p.required)), "[OPTIONS]"]


class Group(_Helped, click.Group):
    """Commands in groups, each of which is imported when it is asked for; alone, it prints its
    help.
    """

    def __init__(self, name: str, entries: Sequence[Entry], **options: Any) -> None:
        super().__init__(name, context_settings=_HELP_NAMES, **options)
        self.entries = {entry.name: entry for entry in entries}

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        return super().parse_args(ctx, args if args or ctx.resilient_parsing else ["--help"])

    def list_commands(self, _ctx: click.Context) -> list[str]:
        return list(self.entries)

    def get_command(self, _ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name in self.entries and cmd_name not in self.commands:
            self.commands[cmd_name] = self.entries[cmd_name].command()
        return self.commands.get(cmd_name)

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        if self.get_command(ctx, args[0]) is None and not ctx.resilient_parsing:
            raise unknown_command(args[0], ctx.command_path, self.list_commands(ctx))
        return super().resolve_command(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        width = max(map(len, self.entries))
        for group in dict.fromkeys(entry.group for entry in self.entries.values()):
            with formatter.section(group):
                formatter.write_dl(
                    [
                        (f"{entry.name:{width}}", entry.short)
                        for entry in self.entries.values()
                        if entry.group == group
                    ]
                )
        super().format_options(ctx, formatter)


@dataclass(frozen=True)
class Entry:
    """A command in the list of commands: where its function is written ("module:name"), its group
    and a line on it; or the commands `below` it, and what its help says.
    """

    name: str
    place: str
    group: str
    short: str
    below: Sequence[Entry] = ()
    help: str = ""
    path: str = "symkin"

    def command(self) -> click.Command:
        """The command itself."""
        if self.below:
            return Group(self.name, self.below, help=self.help)
        module, _, name = self.place.partition(":")
        function = getattr(import_module(module), name)
        examples = shipped_examples(f"{self.path} {self.name}")
        return command_of(function, self.name, epilog="\n".join(examples))


def command_of(function: Callable[..., Any], name: str, **options: Any) -> Command:
    """The command that calls a function, of whose parameters each is an argument or an option, or a
    record of options. Its exit status is what the function returns.
    """
    hints = get_type_hints(function, include_extras=True)
    parameters: list[click.Parameter] = []
    records: dict[str, dict[str, Option]] = {}
    for key, own in inspect.signature(function).parameters.items():
        hint = hints[key]
        if is_typeddict(hint) or is_dataclass(hint):
            offered = {n: (k, o) for n, (k, o) in options_of(hint).items() if o.help}
            records[key] = {n: option for n, (_, option) in offered.items()}
            parameters += [
                _parameter(n, k, o, None if o.read else o.default) for n, (k, o) in offered.items()
            ]
        else:
            parameters.append(_parameter(key, hint.__origin__, hint.__metadata__[0], own.default))

    def call(**values: Any) -> Any:
        for key, record in records.items():
            told = {n: values.pop(n) for n in record}
            values[key] = record_of(hints[key], told) if is_dataclass(hints[key]) else told
        return function(**values)

    return Command(
        name,
        callback=call,
        params=parameters,
        help=function.__doc__,
        context_settings=_HELP_NAMES,
        **options,
    )


class _Offered(click.Option):
    """An option with what it says of itself."""

    def __init__(self, names: Sequence[str], told: Option, **options: Any) -> None:
        super().__init__(names, help=told.help, **options)
        self.told = told


class _Placed(click.Argument):
    """An argument with what it says of itself."""

    def __init__(self, name: str, told: Option, **options: Any) -> None:
        super().__init__([name], **options)
        self.told = told


def _parameter(name: str, kind: Any, told: Option, default: Any) -> click.Parameter:
    base = next((k for k in get_args(kind) if NoneType in get_args(kind)), kind)
    several = get_origin(base) is list
    value = get_args(base)[0] if several else base
    allowed = told.words or words_of(value)
    words = "|".join(map(_as_typed, allowed))
    read = _Word(allowed) if allowed else _type(value)
    options: dict[str, Any] = {"metavar": told.metavar or words or None, "type": read}
    if told.complete is not None:
        complete = told.complete
        options["shell_complete"] = lambda _ctx, _parameter, word: complete(word)
    if default is inspect.Parameter.empty:
        options["required"] = True
    else:
        options |= {"default": default}
    if isinstance(told, Argument):
        return _Placed(name, told, **options)
    if value is bool:
        options = {"is_flag": True, "default": default}
    else:
        options |= {"multiple": several, "show_default": default not in (None, "")}
    flags = told.flags or (f"--{name.replace('_', '-')}",)
    return _Offered([*flags, name], told, **options)


def _type(kind: Any) -> click.ParamType[Any]:
    if kind is int:
        return _Whole()
    return click.Path(path_type=Path) if kind is Path else click.STRING


class _Whole(click.ParamType):  # type: ignore[type-arg]  # no generic type in older versions
    """A whole number; another text is refused with its value."""

    name = "number"

    def convert(self, value: Any, _param: Any, _ctx: Any) -> int:
        return whole_number(str(value))  # defaults pass through here too


class _Word(click.ParamType):  # type: ignore[type-arg]
    """One of some words, blanks written as dashes; others are refused with the nearest one."""

    name = "word"

    def __init__(self, words: Sequence[str]) -> None:
        self.words = {_as_typed(word): word for word in words}

    def convert(self, value: Any, param: Any, _ctx: Any) -> str:
        word = _as_typed(value)
        if word not in self.words:
            raise InputError(f"{param.opts[-1]} {not_among(word, list(self.words))}")
        return self.words[word]

    def shell_complete(self, _ctx: Any, _param: Any, incomplete: str) -> list[Any]:
        from click.shell_completion import CompletionItem

        return [CompletionItem(word) for word in self.words if word.startswith(incomplete)]


def whole_number(text: str) -> int:
    """An integer option, refused with its value."""
    number = whole(text)
    if number is None:
        raise InputError(
            f"{shown(text)} is not a whole number; --starts, --seed and other counts take whole "
            f"numbers from 0"
        )
    return number


def _as_typed(word: str) -> str:
    return word.replace(" ", "-")


def _usage(parameter: Any) -> str:
    """A required parameter in the line of usage: `MECH`, `-o DIR`."""
    value = parameter.metavar or parameter.name.upper()
    return value if parameter.param_type_name == "argument" else f"{parameter.opts[0]} {value}"


def _write_parameters(
    parameters: Sequence[Any], ctx: click.Context, formatter: click.HelpFormatter
) -> None:
    """Arguments, then options by their groups; outputs, those of robots' files and the general ones
    last.
    """
    arguments = [(_usage(p), p.told.help) for p in parameters if isinstance(p, _Placed)]
    if arguments:
        with formatter.section("Arguments"):
            formatter.write_dl(arguments)
    groups: dict[str, list[Any]] = {}
    for p in parameters:
        record = p.get_help_record(ctx) if p.param_type_name == "option" else None
        if record is not None:
            text = record[1].removesuffix("  [required]")  # the usage says it
            heading = p.told.group if isinstance(p, _Offered) else _OTHERS
            groups.setdefault(heading, []).append((record[0], text))
    last = [heading for heading in (OUTPUT, FILES, ROBOT_FILES, _OTHERS) if heading in groups]
    for heading in [*(heading for heading in groups if heading not in last), *last]:
        with formatter.section(heading):
            formatter.write_dl(groups[heading])


def _write_examples(examples: str | None, formatter: click.HelpFormatter) -> None:
    if examples:
        lines = "".join(f"  {line}\n" for line in examples.splitlines())
        formatter.write(f"\nExamples:\n{lines}")
