"""`symkin.sweep`: a sweep from its options to its folder."""

from __future__ import annotations

import operator
import os
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.assembly.search import DEFAULT_SEED
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import Joints
from symkin.position.multistart import DEFAULT_STARTS
from symkin.position.problem import build_problem
from symkin.spatial.pose import Pose
from symkin.sweeps.damage import mend
from symkin.sweeps.executors import Crew, dask_crew, given_crew, local_crew
from symkin.sweeps.plan import Job, Plan, compute_chunk, make_plan
from symkin.sweeps.pose_points import pose_units
from symkin.sweeps.space import Space, Values, make_space
from symkin.sweeps.store import Store, locked, open_store, read_attributes, require_zarr

OVER = ("inputs", "poses")
"""What a sweep's points are: values of the actuated joints, or poses."""

if TYPE_CHECKING:
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

Progress = Callable[[int, int], None]
"""Called with the count of points that are done, and of all."""


@dataclass(frozen=True)
class Swept:
    """A finished sweep: its folder, how many points and chunks it has, how many chunks this run computed, the most modes of
    any point, how many points have each count of real modes, and how many chunks of the folder were lost or damaged and are
    computed again."""

    folder: Path
    points: int
    chunks: int
    computed: int
    most_modes: int
    points_by_count: Mapping[int, int]
    damaged: int = 0

    def open(self) -> Any:
        """The labelled arrays, an `xarray.Dataset`."""
        import xarray

        return xarray.open_zarr(self.folder)

    def __str__(self) -> str:
        counts = ", ".join(f"{count}: {points}" for count, points in self.points_by_count.items())
        kept = "" if self.computed == self.chunks else f", {self.chunks - self.computed} of them kept from before"
        none = "" if self.most_modes else " (no point has a solution)"
        one = self.damaged == 1
        what = f"{self.damaged} chunk{'' if one else 's'} {'was' if one else 'were'} lost or damaged and {'is' if one else 'are'}"
        again = f"\n{what} computed again" if self.damaged else ""
        return f"{self.points} points in {self.chunks} chunks{kept}; real modes: points: {counts}{none}{again}\n{self.folder}"


def sweep(
    mechanism: Mechanism,
    grid: Mapping[str, Values],
    directory: Path | str,
    *,
    over: str = "inputs",
    poses: bool = False,
    at: Joints | Pose | None = None,
    random: int | None = None,
    seed: int | None = None,
    quantity: str = "modes",
    certify: bool = False,
    starts: int | None = None,
    chunk: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    dask: str | None = None,
    progress: Progress | None = None,
) -> Swept:
    """Every mode at all points of a grid, or of a random sample, as labelled arrays in the folder `directory`.

    The keywords are the options of `symkin sweep`. What is swept:

    - `grid` maps names to rising values in the mechanism's units; with `random` = N points, to (least, largest).
    - `over` = "inputs": the names are actuated joints. "poses": they are coordinates of the platform's motion, x, y, z, gamma (about
      z, from the reference) or the rotation vector rx, ry, rz (base frame, before the orientation of `at`); poses of which the
      joints allow hardly any are refused. `poses` = True is the same.
    - `at` gives what is not swept: all actuated joints, or a pose (default: the example's, else the reference's).

    What is stored: `quantity` "modes", "conditioning" or "reach"; `certify` proves modes, at many times the cost; `seed`
    (default 0) is that of the sample and of random starts, `starts` (default 2000) their number where paths do not decide.

    Who computes: `chunk` points are computed and written at a time, by `executor` (of `concurrent.futures`), by the Dask scheduler
    at the address `dask`, or by `workers` local processes (0: this one); `progress` is called with the points done and all.
    The same call goes on where an interrupted or killed one stopped; its arrays are the same bit for bit.

    Raises InputError for what does not fit, options that would be ignored, another sweep in the folder, and a folder that
    cannot be written.

        swept = symkin.sweep(symkin.load("zhang2009"), {"leg1": [100.0, 140.0], "leg2": [330.0, 370.0]}, "legs.zarr", workers=0)
        swept.open()["count"]           # xarray: real modes over leg1 and leg2
    """
    others = {"poses": poses, "certify": certify, "at": at, "executor": executor, "dask": dask, "progress": progress}
    _check_types(mechanism, grid, directory, **others)
    if over not in OVER:
        raise InputError(f"over = {over!r} is unknown; allowed: {', '.join(OVER)}")
    counts = {"random": random, "chunk": chunk, "workers": workers, "seed": seed, "starts": starts}
    random, chunk, workers, seed, starts = (None if value is None else _whole(value, name) for name, value in counts.items())
    folder = Path(directory)
    require_zarr()
    read_attributes(folder)
    if (executor is not None) + (workers is not None) + (dask is not None) > 1:
        raise InputError("executor, workers and dask are given together; one of them is needed, or none")
    space = make_space(
        mechanism, grid, poses=poses or over == "poses", at=at, sample=random, seed=DEFAULT_SEED if seed is None else seed
    )
    _refuse_unread(space, at=at, seed=seed, starts=starts)
    count = DEFAULT_STARTS if starts is None else starts
    plan = make_plan(space, quantity=quantity, certify=certify, starts=count, chunk=chunk)
    finder = plan.finder()
    pinned = plan.pinned(finder)
    with _crew(executor, workers, dask) as crew:
        store = open_store(folder, plan, pinned, finder.bound)
        with locked(folder):
            damaged = mend(store)
            return replace(_run(store, crew, Job(plan, pinned).packed(), progress), damaged=damaged)


def _crew(executor: Executor | None, workers: int | None, dask: str | None) -> AbstractContextManager[Crew]:
    if executor is not None:
        return given_crew(executor)
    return local_crew(workers) if dask is None else dask_crew(dask)


def _run(store: Store, crew: Crew, job: bytes, progress: Progress | None) -> Swept:
    plan = store.plan
    done_before = store.done()
    left = np.flatnonzero(~done_before)
    counts = _counts(store, np.flatnonzero(done_before))
    total = plan.space.size
    done = total - sum(_points(plan, int(i)) for i in left)
    if progress is not None:
        progress(done, total)
    for index, arrays in crew.results(compute_chunk, job, (int(i) for i in left)):
        store.write(index, arrays)
        counts.update(arrays["count"].tolist())
        done += _points(plan, index)
        if progress is not None:
            progress(done, total)
    by_count = dict(sorted(counts.items()))
    return Swept(store.folder, total, len(plan.blocks), len(left), max([0, *by_count]), by_count)


def _points(plan: Plan, index: int) -> int:
    return int(np.prod([place.stop - place.start for place in plan.blocks[index]]))


def _counts(store: Store, chunks: np.ndarray) -> Counter[int]:
    """How many points of some chunks have each count, read chunk by chunk."""
    counts: Counter[int] = Counter()
    for index in chunks.tolist():
        counts.update(store.counts(index).ravel().tolist())
    return counts


# --- arguments ---------------------------------------------------------------------------------------------------


def _check_types(mechanism: Any, grid: Any, directory: Any, **others: Any) -> None:
    """Raises InputError for arguments that are plainly of a wrong type; `others` are some of `sweep`'s keywords."""
    require_mechanism(mechanism)
    wanted = "a mapping of names to values is needed, such as {'NAME': [0.0, 0.5, 1.0]}"
    _need(isinstance(grid, Mapping), "grid", grid, wanted)
    _need(isinstance(directory, str | os.PathLike), "directory", directory, "the path of a folder is needed")
    for name in ("poses", "certify"):
        _need(isinstance(others[name], bool), name, others[name], "True or False is needed")
    _need(not isinstance(others["at"], str | bytes), "at", others["at"], "a list of numbers, a mapping or a Pose is needed")
    executor, dask, progress = (others[name] for name in ("executor", "dask", "progress"))
    _need(executor is None or hasattr(executor, "submit"), "executor", executor, "a concurrent.futures.Executor is needed")
    _need(dask is None or isinstance(dask, str), "dask", dask, "the address of a scheduler is needed, a string")
    _need(progress is None or callable(progress), "progress", progress, "a function of two counts is needed")


def _refuse_unread(space: Space, *, at: Any, seed: int | None, starts: int | None) -> None:
    """Refuse what the user gives and no point of the sweep reads: values of `at` that are all swept, random starts of a
    formula."""
    if not _reads_base(space):
        refuse_ignored({"at": at}, "all that it would give is swept")
    if not space.poses and build_problem(space.mechanism, "direct").is_explicit:
        unread = {"starts": starts, "seed": None if space.sample is not None else seed}
        refuse_ignored(unread, "the direct problem of a serial arm is a function of its joints, and nothing is random")


def _reads_base(space: Space) -> bool:
    """Whether something is not swept: a joint, a position, or the orientation before a rotation vector."""
    swept = {axis.name for axis in space.axes}
    if not space.poses:
        return not {c.name for c in space.mechanism.actuated} <= swept
    turns = "gamma" not in swept and space.mechanism.motion != "translation"
    return turns or not {name for name in pose_units(space.mechanism) if name in "xyz"} <= swept


def _whole(value: Any, name: str) -> int:
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
