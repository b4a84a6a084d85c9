"""Lost and damaged files of a sweep's folder: every chunk that is marked as done is read.

Zarr reads a chunk without a file as fill values, so that files are counted too; what a file holds
its checksum tells.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.sweeps.interrupts import interrupts_held
from symkin.sweeps.layout import consolidate, expected_coordinates, wrongly_described
from symkin.sweeps.store import Store, others_in, readable, refused_writing


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
        if not _is_equal(store.group[name], values):
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


def _is_equal(array: Any, values: np.ndarray) -> bool:
    found = readable(array, slice(None))
    return found is not None and np.array_equal(np.asarray(found), values)
