"""Sweep a grid or a sample, from its options to its folder: `symkin.sweep`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from symkin.assembly.search import DEFAULT_SEED
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.multistart import DEFAULT_STARTS
from symkin.result import Result, Summary, json_fields
from symkin.sweeps.executors import Crew, dask_crew, given_crew, local_crew
from symkin.sweeps.options import SweepOptions
from symkin.sweeps.plan import Job, Plan, compute_chunk, make_plan
from symkin.sweeps.pose_points import pose_units
from symkin.sweeps.space import Space, Values, make_space
from symkin.sweeps.store import Store, locked, mend, open_store, read_attributes, require_zarr
from symkin.sweeps.table import write_csv
from symkin.verb import verb
from symkin.verb_options import refuse_ignored

if TYPE_CHECKING:
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

Progress = Callable[[int, int], None]
"""Called with the count of points that are done, and of all."""


@dataclass(frozen=True, repr=False)
class Swept(Result):
    """A finished sweep: its folder, how many points and chunks it has, how many chunks this run
    computed, the most modes of any point, how many points have each count of real modes, and how
    many chunks of the folder were lost or damaged and are computed again. `open()` gives the
    labelled arrays, `plot()` draws a map of them.
    """

    folder: Path
    points: int
    chunks: int
    computed: int
    most_modes: int
    points_by_count: Mapping[int, int]
    damaged: int = 0

    def open(self) -> Any:
        """Open the labelled arrays, an `xarray.Dataset`."""
        import xarray

        return xarray.open_zarr(self.folder)

    def write_csv(self, path: Path | str) -> int:
        """Write a table, a row for each mode (for each point where nothing is stored of single
        modes), as a CSV file; return the number of its rows. Raises InputError for more than a
        million.
        """
        attributes = read_attributes(self.folder) or {}
        return write_csv(self.open(), list(attributes.get("axes", ())), path)

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - there is no table
        """Say how many points have how many modes, what was computed, and the folder."""
        named = {
            "too many to list" if count < 0 else str(count): points
            for count, points in self.points_by_count.items()
        }
        counts = ", ".join(f"{count}: {points}" for count, points in named.items())
        kept = (
            ""
            if self.computed == self.chunks
            else f", {self.chunks - self.computed} of them kept from before"
        )
        none = " (no point has a solution)" if set(self.points_by_count) <= {0} else ""
        one = self.damaged == 1
        what = (
            f"{self.damaged} chunk{'' if one else 's'} {'was' if one else 'were'} lost or damaged "
            f"and {'is' if one else 'are'}"
        )
        again = [f"{what} computed again"] if self.damaged else []
        head = (
            f"{self.points} points in {self.chunks} chunk{'s' * (self.chunks != 1)}{kept}; real "
            f"modes: points: "
            f"{counts}{none}"
        )
        return Summary([head, *again, str(self.folder)])

    def to_dict(self) -> dict[str, Any]:
        """Return the counts and the folder, which has the arrays."""
        return {
            "folder": str(self.folder),
            **json_fields(self, "points", "chunks", "computed", "most_modes"),
            "points_by_count": {
                str(count): points for count, points in self.points_by_count.items()
            },
            "damaged": self.damaged,
        }


@verb(SweepOptions)
def sweep(
    mechanism: Mechanism,
    grid: Mapping[str, Values] | None = None,
    directory: Path | str | None = None,
    **options: Unpack[SweepOptions],
) -> Swept:
    """Find every mode at all points of a grid, or of a random sample, as labelled arrays in the
    folder `directory`.

    `grid` maps names to rising values in the mechanism's units: actuated joints, or, `over` =
    "poses", coordinates of the platform's motion: x, y, z, gamma (about z, from the reference) or
    the rotation vector rx, ry, rz (base frame, before the orientation of `at`); `poses` = True says
    the same. Poses of which the joints allow hardly any are refused. `at` gives what is not swept:
    all actuated joints, in file order or by name, or a pose. In place of `grid`, `given` maps any
    coordinates, as many as the mobility, to rising values, or to one number where they stand still:
    joints, passive ones too, and x, y, z, azimuth, tilt and torsion of the platform. `random`
    points of a sample take the place of a grid, whose names then map to (least, largest).

    `quantity` is what is stored: "modes", "conditioning" or "reach"; `certify` proves each mode.
    `seed` (default 0) is that of the sample and of the random `starts` (default 2000) where paths
    do not decide. Points are computed and written `chunk` at a time (by default as many as fill
    some seconds), by local processes, `workers` of them (by default one a processor; 0: this one),
    by an `executor` of `concurrent.futures`, or by the Dask scheduler at the address `dask`.
    `progress` is called with the count of points that are done, and of all.

    The same call goes on where an interrupted or killed one stopped; its arrays are the same bit
    for bit. Raises InputError for what does not fit, options that would be ignored, another sweep
    in the folder, and a folder that cannot be written. Needs `pip install 'symkin[sweep]'`.

    >>> import symkin, tempfile
    >>> platform, ankle = symkin.load("zhao2000"), symkin.load("ankle")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = symkin.sweep(platform, {"theta1": [80.0, 81.0]}, folder, workers=0)
    >>> found.points, found.points_by_count
    (2, {4: 2})
    >>> angles = {"ankle.1": [0.0, 5.0], "ankle.2": 3.0}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = symkin.sweep(ankle, directory=folder, given=angles, workers=0)
    >>> found.points_by_count
    {4: 2}
    """
    given, at, sample = options["given"], options["at"], options["random"]
    executor, progress = options["executor"], options["progress"]
    _check_types(mechanism, grid, given, directory, at=at, executor=executor, progress=progress)
    assert directory is not None  # noqa: S101 - checked
    folder, starts = Path(directory), options["starts"]
    require_zarr()
    read_attributes(folder)
    workers, dask = options["workers"], options["dask"]
    if (executor is not None) + (workers is not None) + (dask is not None) > 1:
        raise InputError(
            "executor, workers and dask are given together; one of them is needed, or none"
        )
    seed = DEFAULT_SEED if options["seed"] is None else options["seed"]
    poses = options["poses"] or options["over"] == "poses"
    if given is not None and poses:
        raise InputError(
            "given tells coordinates by name, and poses (--poses) takes a grid; give x, y, z, "
            "azimuth, tilt and torsion by name, or a grid"
        )
    space = make_space(
        mechanism,
        grid if grid is not None else given or {},
        over="coordinates" if given is not None else "poses" if poses else "inputs",
        at=at,
        sample=sample,
        seed=seed,
    )
    _refuse_unread(space, at=at, seed=options["seed"], starts=starts)
    plan = make_plan(
        space,
        quantity=options["quantity"],
        certify=options["certify"],
        starts=DEFAULT_STARTS if starts is None else starts,
        chunk=options["chunk"],
    )
    finder = plan.finder()
    pinned = plan.pinned(finder)
    with _crew(executor, workers, dask) as crew:
        store = open_store(folder, plan, pinned, finder.bound)
        with locked(folder):
            damaged = 0 if store.is_untouched else mend(store)
            return replace(_run(store, crew, Job(plan, pinned).packed(), progress), damaged=damaged)


def _crew(
    executor: Executor | None, workers: int | None, dask: str | None
) -> AbstractContextManager[Crew]:
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
    """Count the points of some chunks by their number of modes, chunk by chunk."""
    counts: Counter[int] = Counter()
    for index in chunks.tolist():
        counts.update(store.counts(index).ravel().tolist())
    return counts


# --- arguments ------------------------------------------------------------------------------------


def _check_types(mechanism: Any, grid: Any, given: Any, directory: Any, **others: Any) -> None:
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
    executor, progress = others["executor"], others["progress"]
    needs = {
        "grid": (grid is None or isinstance(grid, Mapping), wanted),
        "given": (given is None or isinstance(given, Mapping), wanted),
        "directory": (directory is not None, "the path of a folder is needed"),
        "at": (
            not isinstance(others["at"], str | bytes),
            "a list of numbers, a mapping or a Pose is needed",
        ),
        "executor": (
            executor is None or hasattr(executor, "submit"),
            "a concurrent.futures.Executor is needed",
        ),
        "progress": (progress is None or callable(progress), "a function of two counts is needed"),
    }
    told = {"grid": grid, "given": given, "directory": directory, **others}
    for name, (good, what) in needs.items():
        if not good:
            value = told[name]
            raise InputError(f"{name} = {value!r} is of type {type(value).__name__}; {what}")


def _refuse_unread(space: Space, *, at: Any, seed: int | None, starts: int | None) -> None:
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
