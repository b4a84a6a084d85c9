"""Warnings of other packages, kept from the user; and the garbage collector, from what is none."""

from __future__ import annotations

import functools
import gc
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

import numpy as np

from symkin.locks import Lock

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

_filters = Lock()
"""Held while the filters are changed, which belong to the process: two threads would restore each
other's.
"""


@contextmanager
def warnings_ignored(message: str = "") -> Iterator[None]:
    """Ignore warnings whose text matches the regular expression `message`, all by default."""
    with _filters, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message)
        yield


@contextmanager
def collector_at_rest() -> Iterator[None]:
    """Do not look for garbage while thousands of results are made, of which none is: each look goes
    through all that the process holds.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def without_float_warnings(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Call a function with NumPy's warnings and errors off: it judges its numbers itself. (NumPy's
    own errstate is no decorator for threads before version 2.)
    """

    @functools.wraps(function)
    def quiet(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        with np.errstate(all="ignore"):
            return function(*args, **kwargs)

    return quiet
