"""Help as the commands print it: commands and options in groups, examples as they are typed,
mistakes in a sentence.

Typer's classes are a version of Click's, and which one depends on Typer's version: nothing here
imports Click.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from symkin.cli.mistakes import refuse_empty_files, sentence, unknown_command

GIVEN, HOW, OUTPUT, ROBOT_FILES = "What is given", "How it is found", "Output", "Robot files"
ASKED, READINGS, POSTURES = "What is asked", "Readings and their noise", "Postures"
"""Headings of options that several commands have."""
_OTHERS = "Options"
HELP_NAMES = {"help_option_names": ["-h", "--help"]}


class Command(TyperCommand):
    """A command whose help has options in groups and examples, and whose mistakes are sentences."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        given = list(args)  # the parser empties its own list
        refuse_empty_files(ctx, given)
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter.__base__ as error:  # type: ignore[misc]  # Click's UsageError, in either version
            raise sentence(error, ctx, given) from None

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [*map(_usage, (p for p in self.get_params(ctx) if p.required)), "[OPTIONS]"]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        _write_parameters(self.get_params(ctx), ctx, formatter)

    def format_epilog(self, _ctx: Any, formatter: Any) -> None:
        _write_examples(self.epilog, formatter)


class Group(TyperGroup):
    """Commands in groups; alone, it prints its help."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        given = list(args)
        try:
            return super().parse_args(ctx, args if args or ctx.resilient_parsing else ["--help"])
        except typer.BadParameter.__base__ as error:  # type: ignore[misc]
            raise sentence(error, ctx, given) from None

    def list_commands(self, _ctx: Any) -> list[str]:
        return list(self.commands)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if self.get_command(ctx, args[0]) is None and not ctx.resilient_parsing:
            raise unknown_command(args[0], ctx.command_path, self.list_commands(ctx))
        return super().resolve_command(ctx, args)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        self.format_commands(ctx, formatter)
        _write_parameters(self.get_params(ctx), ctx, formatter)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        entries = getattr(self.commands, "entries", {})
        listed = [
            (e.name, e.group, e.short)
            if (e := entries.get(name)) is not None
            else (name, "Commands", self.commands[name].get_short_help_str(formatter.width))
            for name in self.list_commands(ctx)
        ]
        width = max(len(name) for name, _, _ in listed)
        for group in dict.fromkeys(group for _, group, _ in listed):
            with formatter.section(group):
                formatter.write_dl(
                    [(f"{name:{width}}", short) for name, its, short in listed if its == group]
                )

    def format_epilog(self, _ctx: Any, formatter: Any) -> None:
        _write_examples(self.epilog, formatter)


@dataclass(frozen=True)
class Entry:
    """A command in the list of commands: where it is written ("module:name", a function or a group
    of commands), its group, a line on it, and examples as they are typed.
    """

    name: str
    place: str
    group: str
    short: str
    examples: Sequence[str] = ()

    def command(self) -> Any:
        """The command itself."""
        module, _, name = self.place.partition(":")
        written = getattr(import_module(module), name)
        if isinstance(written, typer.Typer):
            return typer.main.get_command(written)
        alone = typer.Typer(
            add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None
        )
        add_command(alone, written, self.short, self.examples, group=self.group, name=self.name)
        return typer.main.get_command(alone)


class LazyCommands(dict[str, Any]):
    """Commands by name, which are imported when they are asked for."""

    def __init__(self, entries: Sequence[Entry]) -> None:
        super().__init__((entry.name, None) for entry in entries)
        self.entries = {entry.name: entry for entry in entries}

    def __getitem__(self, name: str) -> Any:
        if super().__getitem__(name) is None:
            self[name] = self.entries[name].command()
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        try:
            return self[name]
        except KeyError:
            return default

    def items(self) -> Any:
        return [(name, self[name]) for name in self]

    def values(self) -> Any:
        return [self[name] for name in self]


def add_command(
    app: typer.Typer,
    command: Callable[..., Any],
    short: str,
    examples: Sequence[str],
    *,
    group: str | None = None,
    name: str | None = None,
) -> None:
    """Give `app` a command, with a line for the list of commands and examples, as they are typed,
    for its own help.
    """
    app.command(
        name,
        cls=Command,
        short_help=short,
        epilog="\n".join(examples),
        rich_help_panel=group,
        context_settings=HELP_NAMES,
    )(command)


def _usage(parameter: Any) -> str:
    """A required parameter in the line of usage: `MECH`, `-o DIR`."""
    value = parameter.metavar or parameter.name.upper()
    return value if parameter.param_type_name == "argument" else f"{parameter.opts[0]} {value}"


def _write_parameters(parameters: Sequence[Any], ctx: Any, formatter: Any) -> None:
    """Arguments, then options by their groups; outputs, those of robots' files and the general ones
    last.
    """
    arguments = [(_usage(p), p.help or "") for p in parameters if p.param_type_name == "argument"]
    if arguments:
        with formatter.section("Arguments"):
            formatter.write_dl(arguments)
    groups: dict[str, list[Any]] = {}
    for p in parameters:
        record = p.get_help_record(ctx) if p.param_type_name == "option" else None
        if record is not None:
            # escapes of older versions; the usage says it
            text = record[1].replace(r"\[", "[").removesuffix("  [required]")
            groups.setdefault(getattr(p, "rich_help_panel", None) or _OTHERS, []).append(
                (record[0], text)
            )
    last = [panel for panel in (OUTPUT, ROBOT_FILES, _OTHERS) if panel in groups]
    for panel in [*(panel for panel in groups if panel not in last), *last]:
        with formatter.section(panel):
            formatter.write_dl(groups[panel])


def _write_examples(examples: str | None, formatter: Any) -> None:
    if examples:
        lines = "".join(f"  {line}\n" for line in examples.splitlines())
        formatter.write(f"\nExamples:\n{lines}")
