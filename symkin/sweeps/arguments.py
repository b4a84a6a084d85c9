"""Arguments of `symkin.sweep` that are plainly of a wrong type or that a sweep would ignore,
refused in a sentence.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import require_mechanism
from symkin.sweeps.pose_points import pose_units

if TYPE_CHECKING:
    from symkin.sweeps.space import Space


def check_types(mechanism: Any, grid: Any, given: Any, directory: Any, **others: Any) -> None:
    """Raises InputError; `others` are the arguments `at`, `executor` and `progress`."""
    require_mechanism(mechanism)
    wanted = "a mapping of names to values is needed, such as {'NAME': [0.0, 0.5, 1.0]}"
    if grid is None and given is None:
        raise InputError(
            "nothing is swept; give grid (--grid), values of actuated joints or of poses, or given "
            "(--given), values of any coordinates"
        )
    if grid is not None and given is not None:
        raise InputError(
            "grid and given are both there; given (--given) alone tells all values, grid (--grid) "
            "those of inputs or poses"
        )
    _need(grid is None or isinstance(grid, Mapping), "grid", grid, wanted)
    _need(given is None or isinstance(given, Mapping), "given", given, wanted)
    _need(directory is not None, "directory", directory, "the path of a folder is needed")
    _need(
        not isinstance(others["at"], str | bytes),
        "at",
        others["at"],
        "a list of numbers, a mapping or a Pose is needed",
    )
    executor, progress = others["executor"], others["progress"]
    _need(
        executor is None or hasattr(executor, "submit"),
        "executor",
        executor,
        "a concurrent.futures.Executor is needed",
    )
    _need(
        progress is None or callable(progress),
        "progress",
        progress,
        "a function of two counts is needed",
    )


def refuse_unread(space: Space, *, at: Any, seed: int | None, starts: int | None) -> None:
    """Refuse what the user gives and no point of the sweep reads: values of `at` that are all swept
    or told by name, random starts of a formula.
    """
    if space.over == "coordinates":
        refuse_ignored(
            {"at": at}, "given tells every value by name, what is not swept as NAME=VALUE"
        )
    elif not _reads_base(space):
        refuse_ignored({"at": at}, "all that it would give is swept")
    if space.problem.is_explicit:
        unread = {"starts": starts, "seed": None if space.sample is not None else seed}
        refuse_ignored(
            unread,
            "the direct problem of a serial arm is a function of its joints, and nothing is random",
        )


def _reads_base(space: Space) -> bool:
    """Whether something is not swept: a joint, a position, or the orientation before a rotation
    vector.
    """
    swept = {axis.name for axis in space.axes}
    if space.over == "inputs":
        return not {c.name for c in space.mechanism.actuated} <= swept
    turns = "gamma" not in swept and space.mechanism.motion != "translation"
    return turns or not {name for name in pose_units(space.mechanism) if name in "xyz"} <= swept


def _need(good: bool, name: str, value: Any, wanted: str) -> None:
    if not good:
        raise InputError(f"{name} = {value!r} is of type {type(value).__name__}; {wanted}")
