"""The border of a verb: what every verb does with its arguments before it looks at them."""

from __future__ import annotations

import functools
import inspect
import numbers
import operator
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np

from symkin.errors import InputError
from symkin.text import shown

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def verb(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Read the arguments of a verb: rows of a table with names, such as a pandas Series or
    DataFrame, become mappings, iterators lists; what is annotated as a number, a text or a path is
    one. NumPy's warnings and errors are off: a verb judges its numbers itself. Raises InputError.
    """
    kinds = {p.name: str(p.annotation) for p in inspect.signature(function).parameters.values()}
    names = tuple(kinds)

    @functools.wraps(function)
    def called(*values: Any, **named: Any) -> Result:
        told = [read_as(kinds.get(n, ""), n, v) for n, v in zip(names, values, strict=False)]
        options = {name: read_as(kinds.get(name, ""), name, v) for name, v in named.items()}
        with np.errstate(all="ignore"):
            return function(*told, *values[len(told) :], **options)

    return called


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
    if isinstance(value, (list, tuple)) and value and hasattr(value[0], "keys"):
        return [_named(one) for one in value]
    if not hasattr(value, "keys") or isinstance(value, Mapping):
        return value
    keys = list(value.keys())
    if all(isinstance(key, str) for key in keys):
        return {key: value[key] for key in keys}
    return [value[key] for key in keys]
