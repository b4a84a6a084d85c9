"""The border of a verb: what every verb does with its arguments before it looks at them."""

from __future__ import annotations

import functools
import inspect
import numbers
import operator
import os
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ForwardRef, TypeVar

import numpy as np

from symkin.errors import InputError
from symkin.text import not_among, shown
from symkin.verb_options import options_of, words_of

Verb = TypeVar("Verb", bound=Callable[..., Any])
_MODULES = re.compile(r"\b(typing|collections\.abc)\.")
"""Modules from which types are imported by name."""


def verb(record: type | None = None) -> Callable[[Verb], Verb]:
    """Read the arguments of a verb: rows of a table with names, such as a pandas Series or
    DataFrame, become mappings, iterators lists; what is annotated as a number, a text or a path is
    one. The options of a `record`, if it has one, stand in place of its `**options`: all of them
    reach it, those left out by their default. NumPy's warnings and errors are off: a verb judges
    its numbers itself. Raises TypeError for a name that is none, and InputError for values and
    words that are not allowed.
    """
    options = {} if record is None else options_of(record)
    added = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=option.default, annotation=_written(kind)
        )
        for name, (kind, option) in options.items()
    ]
    defaults = {name: option.default for name, (_, option) in options.items()}
    words = {name: words_of(kind) for name, (kind, _) in options.items()}

    def decorate(function: Verb) -> Verb:
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        whole = signature.replace(parameters=[*own, *added])
        kinds = {p.name: str(p.annotation) for p in whole.parameters.values()}

        @functools.wraps(function)
        def called(*values: Any, **named: Any) -> Any:
            values = tuple(map(read_as, kinds.values(), kinds, values)) + values[len(kinds) :]
            for name, value in named.items():
                if name not in kinds:
                    raise TypeError(f"{function.__name__} has no argument {name!r}")
                if kinds[name] in _KINDS or isinstance(value, Iterator) or _has_names(value):
                    named[name] = read_as(kinds[name], name, value)
                if words.get(name) and named[name] not in (*words[name], defaults[name]):
                    raise InputError(f"{name} = {not_among(named[name], words[name])}")
            with np.errstate(all="ignore"):
                return function(*values, **(defaults | named))

        called.__signature__ = whole  # type: ignore[attr-defined]
        return called  # type: ignore[return-value]

    return decorate


def _written(kind: Any) -> str:
    """A type as it is written where its names are imported."""
    if isinstance(kind, ForwardRef):
        return kind.__forward_arg__
    return kind.__name__ if type(kind) is type else _MODULES.sub("", str(kind))


def read_as(kind: str, name: str, value: Any) -> Any:
    """The value of an argument whose annotation is `kind`. Raises InputError where it is of another
    kind.
    """
    if kind not in _KINDS:
        return _named(value)
    wanted, read = _KINDS[kind.removesuffix(" | None")]
    if value is None and kind.endswith(" | None"):
        return value
    try:
        return read(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {shown(value)}; {wanted} is needed") from None


def real(value: Any) -> float:
    """A real number as a float. Raises TypeError for text, bytes and complex numbers, which
    `float` takes or shortens.
    """
    if not isinstance(value, (float, int)) and (
        isinstance(value, (str, bytes, bytearray))
        or (isinstance(value, numbers.Complex) and not isinstance(value, numbers.Real))
    ):
        raise TypeError("no real number")
    return float(value)


def _truth(value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError("no truth value")
    return bool(value)


def _whole(value: Any) -> int:
    if isinstance(value, bool):
        raise TypeError("no number")
    return operator.index(value)


def _text(value: Any) -> Any:
    if not isinstance(value, str):
        raise TypeError("no text")
    return value


def _text_or_list(value: Any) -> Any:
    return value if isinstance(value, str) else list(value)


def _path(value: Any) -> Any:
    if not isinstance(os.fspath(value), str):
        raise TypeError("no path of text")
    return value if isinstance(value, str) else Path(value)


_READ: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "bool": ("True or False", _truth),
    "int": ("a whole number", _whole),
    "float": ("a number", real),
    "str": ("a text", _text),
    "str | Sequence[str]": ("a text or a list of texts", _text_or_list),
    "str | Sequence[int]": ("a text or a list of whole numbers", _text_or_list),
    "str | Path": ("a path or a name", _path),
    "Path | str": ("a path", _path),
}
_KINDS = _READ | {f"{kind} | None": reader for kind, reader in _READ.items()}


def _named(value: Any) -> Any:
    """A mapping of what has keys and values, in a list too; a list of what can be read only once.
    Keys that are no names are places: their values are a list.
    """
    if isinstance(value, Iterator):
        value = list(value)
    if not _has_names(value) or isinstance(value, Mapping):
        return value
    if isinstance(value, (list, tuple)):
        return [_named(one) for one in value]
    keys = list(value.keys())
    if all(isinstance(key, str) for key in keys):
        return {key: value[key] for key in keys}
    return [value[key] for key in keys]


def _has_names(value: Any) -> bool:
    """Whether a value has keys, or the first one of a list."""
    return hasattr(value[0] if isinstance(value, (list, tuple)) and value else value, "keys")
