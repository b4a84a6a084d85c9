"""The folder of a sweep: a Zarr group that `xarray.open_zarr` reads, written chunk by chunk.

A chunk of points is one chunk of each array, whose files have checksums. The array `done` has one
number a chunk, written after the chunk's data, so that whatever a killed run left is computed
again; lost and damaged files are told by their absence and their checksums (see `mend`). The
dimension `mode` grows to the most modes met, whatever the order.
"""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.sweeps.interrupts import interrupts_held
from symkin.sweeps.layout import consolidate, create_arrays, expected_coordinates, wrongly_described
from symkin.sweeps.plan import Plan, difference
from symkin.sweeps.quantities import Variable

_PART = ".part"
"""Suffix of what is made beside or within a folder before it is a sweep's."""
MISSING = "sweeps need xarray, zarr and dask: pip install 'symkin[sweep]'"


@dataclass(frozen=True, eq=False)
class Store:
    """An open folder; `group` is its Zarr group, which this run made if it `is_new`."""

    folder: Path
    plan: Plan
    group: Any
    is_new: bool = False

    @cached_property
    def arrays(self) -> dict[str, Any]:
        """The arrays over the points, and `done`; what they hold is written even where it is
        nothing, so that lost files are told.
        """
        import zarr

        with zarr.config.set({"array.write_empty_chunks": True}):
            names = (*(v.name for v in self.plan.variables), "done")
            return {name: self.group[name] for name in names}

    @property
    def per_mode(self) -> list[Variable]:
        return [v for v in self.plan.variables if v.per_mode]

    @property
    def is_untouched(self) -> bool:
        """Whether this run has made the folder, and none has let it grow since."""
        return self.is_new and self.lengths() <= {1}

    @interrupts_held()
    def done(self) -> np.ndarray:
        """Which chunks are written."""
        return np.asarray(np.asarray(self.arrays["done"][:]) == 1)

    def lengths(self) -> set[int]:
        """Lengths of the dimension `mode`: one, unless a run was killed while it grew; none where
        no array has it.
        """
        return {self.arrays[v.name].shape[len(self.plan.space.shape)] for v in self.per_mode}

    @interrupts_held()
    def counts(self, index: int) -> np.ndarray:
        """How many real modes each point of a chunk has."""
        return np.asarray(self.arrays["count"][self.plan.blocks[index]])

    @interrupts_held()
    def write(self, index: int, arrays: Mapping[str, np.ndarray]) -> None:
        """One chunk, its mark last. Raises InputError where the folder cannot be written."""
        block = self.plan.blocks[index]
        shape = tuple(side.stop - side.start for side in block)
        with refused_writing(self.folder):
            needed = max((arrays[v.name].shape[1] for v in self.per_mode), default=0)
            if needed > max(self.lengths(), default=needed):
                self.grow(needed)
            self.forget(index)
            for v in self.plan.variables:
                values = arrays[v.name]
                place = (*block, slice(0, values.shape[1])) if v.per_mode else block
                if values.size:
                    self.arrays[v.name][place] = values.reshape(*shape, *values.shape[1:])
            self.arrays["done"][index] = 1

    def forget(self, index: int) -> None:
        """Remove the files of a chunk of points and, before them, its mark."""
        for name in ("done", *(v.name for v in self.plan.variables)):
            for path in self._files(name, index):
                path.unlink()

    @interrupts_held()
    def is_whole(self, index: int) -> bool:
        """Whether all files of a chunk of points are there and hold what was written."""
        block, modes = self.plan.blocks[index], 0
        for v in sorted(self.plan.variables, key=lambda v: v.name != "count"):
            array, place, files = self.arrays[v.name], block, 1
            if v.per_mode:
                side = (array.shards or array.chunks)[len(block)]
                place, files = (*block, slice(0, modes)), -(-modes // side)
            if len(list(self._files(v.name, index))) != files:
                return False
            values = readable(array, place)
            if values is None:
                return False
            modes = max(0, int(values.max())) if v.name == "count" else modes
        return True

    def _files(self, name: str, index: int) -> Iterator[Path]:
        """The files of an array that hold a chunk of points."""
        grid = self.plan.blocks.grid
        place = (index,) if name == "done" else np.unravel_index(index, grid)
        path = self.folder.joinpath(name, "c", *(str(int(i)) for i in place))
        if path.is_file():
            yield path
        elif path.is_dir():
            yield from sorted(p for p in path.rglob("*") if p.is_file())

    def grow(self, modes: int) -> None:
        """Make the dimension `mode` of all arrays `modes` long."""
        dimensions = len(self.plan.space.shape)
        for v in self.per_mode:
            array = self.arrays[v.name]
            array.resize((*array.shape[:dimensions], modes, *array.shape[dimensions + 1 :]))
        consolidate(self.folder)


def readable(array: Any, place: Any) -> Any:
    """What Zarr reads at a place of an array, None where a file cannot be decoded: decoders raise
    errors of many kinds.
    """
    try:
        return array[place]
    except FileNotFoundError:
        return None
    except (OSError, MemoryError):
        raise
    except Exception:
        return None


@interrupts_held()
def open_store(folder: Path, plan: Plan, pinned: Mapping[str, Any], bound: int | None) -> Store:
    """The folder of a new sweep, or that of the same sweep begun before, as it was left. Raises
    InputError for another sweep's folder, for one that holds something else, and for one that
    cannot be written.
    """
    kept = read_attributes(folder)
    is_new = kept is None
    if kept is None:
        with refused_writing(folder, begun=False):
            _create(folder, plan, pinned, bound)
        kept = read_attributes(folder) or {}
    reason = difference(kept, pinned)
    if reason is not None:
        raise InputError(
            f"{folder}: another sweep is in this folder: {reason}; choose another folder, or the "
            f"same options"
        )
    if not os.access(folder, os.W_OK):
        raise InputError(f"{folder}: cannot be written (permission denied)")
    return Store(folder, plan, _group(folder), is_new)


@interrupts_held()
def read_attributes(folder: Path) -> dict[str, Any] | None:
    """What a sweep's folder has pinned; None for a folder that is not there or empty. Raises
    InputError for others.
    """
    if not folder.exists():
        return None
    if not folder.is_dir():
        raise InputError(f"{folder}: is a file; the name of a folder is needed")
    try:
        if not others_in(folder):
            return None
        attributes = _attributes(folder)
        if attributes is None:
            with locked(folder):  # another run, which begins here, holds the lock
                attributes = _attributes(folder)
    except PermissionError:
        raise InputError(f"{folder}: cannot be read (permission denied)") from None
    if attributes is None:
        raise InputError(
            f"{folder}: holds something that is no sweep, and is left alone; choose another folder"
        )
    return attributes


def others_in(folder: Path) -> list[Path]:
    """What a folder holds, but what runs that begin a sweep make in it first."""
    return [
        path
        for path in folder.iterdir()
        if not (path.name.startswith(f".{folder.name}.") and path.suffix == _PART)
    ]


def _attributes(folder: Path) -> dict[str, Any] | None:
    """What a folder has pinned; None where it is no sweep's. Raises PermissionError."""
    try:
        attributes = dict(_group(folder).attrs)
    except PermissionError:
        raise
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return attributes if "symkin_sweep" in attributes else None


@contextmanager
def refused_writing(folder: Path, *, begun: bool = True) -> Iterator[None]:
    """OSError as a sentence."""
    try:
        yield
    except OSError as error:
        kept = "; what is done is kept, and the same command goes on from there" if begun else ""
        raise InputError(f"{folder}: cannot be written ({error.strerror or error}){kept}") from None


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep a second run away from a folder; ends with the process, however it ends."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{folder}: another run is writing into this folder; wait for it or stop it"
            ) from None
        except OSError:
            pass
        yield
    finally:
        os.close(handle)


def require_zarr() -> None:
    """Raises InputError where what reads and writes the arrays is not installed. Only what
    writes them is loaded: a sweep has no need of xarray, which takes a second.
    """
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise InputError(MISSING) from None
    if find_spec("xarray") is None:
        raise InputError(MISSING)


def _group(folder: Path) -> Any:
    import zarr

    return zarr.open_group(
        folder, mode="r+" if os.access(folder, os.W_OK) else "r", use_consolidated=False
    )


def _create(folder: Path, plan: Plan, pinned: Mapping[str, Any], bound: int | None) -> None:
    """All arrays, empty: made beside the folder, so that it is there as a whole or not at all; or
    within an empty one, whose description is moved up last. Where another run is first, nothing.
    """
    there = folder.exists()
    folder.parent.mkdir(parents=True, exist_ok=True)
    beside = (folder if there else folder.parent) / f".{folder.name}.{uuid.uuid4().hex}{_PART}"
    try:
        create_arrays(beside, plan, pinned, bound)
        if there:
            with locked(folder):
                _move_up(beside, folder)
        else:
            _rename(beside, folder)
    except BaseException:
        shutil.rmtree(beside, ignore_errors=True)
        raise


def _rename(beside: Path, folder: Path) -> None:
    """Rename a folder, unless another one of that name has come meanwhile."""
    try:
        beside.rename(folder)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
            raise
        shutil.rmtree(beside, ignore_errors=True)


def _move_up(beside: Path, folder: Path) -> None:
    """Move what is in a folder within another one up into that, unless something has come there
    meanwhile.
    """
    if others_in(folder):
        shutil.rmtree(beside, ignore_errors=True)
        return
    for child in sorted(beside.iterdir(), key=lambda path: path.name == "zarr.json"):
        child.rename(folder / child.name)
    beside.rmdir()


# --- lost and damaged files -----------------------------------------------------------------------


@interrupts_held()
def mend(store: Store) -> int:
    """Remove what a killed run left half written, and what was lost or damaged since; how many
    chunks these were. To be called by the only run in the folder.
    """
    with refused_writing(store.folder):
        for kept in others_in(store.folder):
            for rest in (kept, *kept.rglob("*.partial")):
                if rest.suffix == ".partial":
                    rest.unlink(missing_ok=True)
        _check_descriptions(store)
        if len(store.lengths()) > 1:
            store.grow(max(store.lengths()))
        damaged = _mend_chunks(store)
        _mend_coordinates(store)
        consolidate(store.folder)
    return damaged


def _mend_chunks(store: Store) -> int:
    """Remove the files and marks of chunks that are not whole; how many these are."""
    _remove_unreadable(store)
    damaged = [int(i) for i in np.flatnonzero(store.done()) if not store.is_whole(int(i))]
    for index in damaged:
        store.forget(index)
    return len(damaged)


def _mend_coordinates(store: Store) -> None:
    """Write anew the names and coordinates that are not those of the plan."""
    for name, values in expected_coordinates(store.plan).items():
        # what cannot be read is None, which has no values' shape
        found = np.asarray(readable(store.group[name], slice(None)))
        if not np.array_equal(found, values):
            for path in (store.folder / name / "c").rglob("*"):
                if path.is_file():
                    path.unlink()
            store.group[name][:] = values


def _check_descriptions(store: Store) -> None:
    """Raises InputError where the description of an array is lost, cannot be read or is that of
    another one.
    """
    name = wrongly_described(store.group, store.plan)
    if name is not None:
        raise InputError(
            f"{store.folder}: {name}/zarr.json, the description of an array, is lost or damaged, "
            f"and its numbers cannot be told; "
            "restore it, or sweep into another folder"
        )


def _remove_unreadable(store: Store) -> None:
    """Remove the marks that cannot be read: their chunks are computed again."""
    marks = store.arrays["done"]
    if readable(marks, slice(None)) is not None:
        return
    for path in (store.folder / "done" / "c").iterdir():
        if readable(marks, int(path.name)) is None:
            path.unlink()
