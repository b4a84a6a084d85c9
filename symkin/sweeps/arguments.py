"""Arguments of `symkin.sweep` that are plainly of a wrong type, refused in a sentence."""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping
from typing import Any

from symkin.errors import InputError
from symkin.model.mechanism import require_mechanism


def check_types(mechanism: Any, grid: Any, directory: Any, **others: Any) -> None:
    """Raises InputError; `others` are the arguments `poses`, `certify`, `at`, `executor`, `dask` and `progress`."""
    require_mechanism(mechanism)
    wanted = "a mapping of names to values is needed, such as {'NAME': [0.0, 0.5, 1.0]}"
    _need(isinstance(grid, Mapping), "grid", grid, wanted)
    _need(isinstance(directory, str | os.PathLike), "directory", directory, "the path of a folder is needed")
    for name in ("poses", "certify"):
        _need(isinstance(others[name], bool), name, others[name], "True or False is needed")
    _need(not isinstance(others["at"], str | bytes | Mapping), "at", others["at"], "a list of numbers or a Pose is needed")
    executor, dask, progress = (others[name] for name in ("executor", "dask", "progress"))
    _need(executor is None or hasattr(executor, "submit"), "executor", executor, "a concurrent.futures.Executor is needed")
    _need(dask is None or isinstance(dask, str), "dask", dask, "the address of a scheduler is needed, a string")
    _need(progress is None or callable(progress), "progress", progress, "a function of two counts is needed")


def whole(value: Any, name: str) -> int:
    """An integer of any type. Raises InputError."""
    try:
        if not isinstance(value, bool):
            return operator.index(value)
    except TypeError:
        pass
    raise InputError(f"{name} = {value!r}; a whole number is needed")


def _need(good: bool, name: str, value: Any, wanted: str) -> None:
    if not good:
        raise InputError(f"{name} = {value!r} is of type {type(value).__name__}; {wanted}")
