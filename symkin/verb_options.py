"""The options of a verb as one record: a TypedDict whose fields say their default, their words and
what they are. The verb's signature and the options of its command are made from it.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, get_type_hints

from symkin.errors import InputError
from symkin.text import not_among

Verb = TypeVar("Verb", bound=Callable[..., Any])


@dataclass(frozen=True)
class Option:
    """An option: its default, the words that it may be, and for a command what its help says and
    how its value is written; without help it is no option of a command.
    """

    default: Any
    help: str = ""
    metavar: str | None = None
    words: Sequence[str] = ()


def options_of(record: type) -> dict[str, tuple[Any, Option]]:
    """List the options of a record by name, with their types."""
    hints = get_type_hints(record, include_extras=True)
    return {name: (hint.__origin__, hint.__metadata__[0]) for name, hint in hints.items()}


def takes(record: type) -> Callable[[Verb], Verb]:
    """Give a verb the options of a record in place of its `**options`: all of them reach it, those
    left out by their default. Raises TypeError for a name that is none, and InputError for a word
    that is not allowed.
    """
    options = options_of(record)

    def decorate(verb: Verb) -> Verb:
        signature = inspect.signature(verb)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        added = [
            inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, default=option.default, annotation=kind
            )
            for name, (kind, option) in options.items()
        ]
        whole = signature.replace(parameters=[*own, *added])

        @functools.wraps(verb)
        def call(*values: Any, **named: Any) -> Any:
            bound = whole.bind(*values, **named)
            bound.apply_defaults()
            for name, (_, option) in options.items():
                word = bound.arguments[name]
                if option.words and word not in option.words:
                    raise InputError(f"{name} = {not_among(word, option.words)}")
            return verb(*bound.args, **bound.kwargs)

        call.__signature__ = whole  # type: ignore[attr-defined]
        return call  # type: ignore[return-value]

    return decorate
