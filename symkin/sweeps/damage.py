"""Lost and damaged files of a sweep's folder: what is marked as done is compared with what was
written.

Zarr reads a chunk without a file as fill values, which is right for one that holds nothing else and
wrong for one that was lost. So the array `digest` has a number for each chunk of points, made of
the names and bytes of its files. A folder without that array (from an earlier version) gets it
once: there a chunk counts as good that can be read and has as many modes as its counts say.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.sweeps.chunk_files import digest_of
from symkin.sweeps.interrupts import interrupts_held
from symkin.sweeps.layout import consolidate, create_digest, expected_coordinates, wrongly_described
from symkin.sweeps.store import Store, others_in, refused_writing

_SOMETIMES_NAN = ("distance_type_1", "distance_type_2")
"""Numbers of a mode that are not there where the mechanism has no such kind of singularity."""


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
    """Take the mark of chunks whose files are not those that were written, and remove these files;
    how many there are.
    """
    _remove_unreadable(store, "done")
    found = _adopt(store) if "digest" not in store.group else 0
    _remove_unreadable(store, "digest")
    digests = np.asarray(store.group["digest"][:])
    damaged = [
        int(i)
        for i in np.flatnonzero(store.done())
        if int(digests[i]) != digest_of(store.folder, store.files(int(i)))
    ]
    for index in damaged:
        _forget(store, index)
    return found + len(damaged)


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


def _forget(store: Store, index: int) -> None:
    store.mark(index, done=False)
    for path in store.files(index):
        path.unlink()


def _adopt(store: Store) -> int:
    """Give a folder that has none its digests, for the chunks that are good as far as can be told;
    how many are not.
    """
    create_digest(store.group, len(store.plan.blocks))
    damaged = 0
    for index in (int(i) for i in np.flatnonzero(store.done())):
        if _is_plausible(store, index):
            store.note(index, digest_of(store.folder, store.files(index)))
        else:
            _forget(store, index)
            damaged += 1
    return damaged


def _is_plausible(store: Store, index: int) -> bool:
    """Whether every array of a chunk can be read, the counts are there, and each mode has its
    numbers.
    """
    block = store.plan.blocks[index]
    arrays = {
        v.name: _readable(store.arrays[v.name].__getitem__, block) for v in store.plan.variables
    }
    if any(values is None for values in arrays.values()):
        return False
    counts = np.maximum(arrays["count"], 0)
    there = any(path.is_relative_to(store.folder / "count") for path in store.files(index))
    told = [
        v for v in store.per_mode if np.dtype(v.dtype).kind == "f" and v.name not in _SOMETIMES_NAN
    ]
    return there and all(
        np.array_equal(_modes_stored(arrays[v.name], counts.ndim), counts) for v in told
    )


def _modes_stored(values: np.ndarray, dimensions: int) -> np.ndarray:
    """How many modes of each point have numbers; infinite conditions count."""
    per_mode = ~np.isnan(values).reshape(*values.shape[: dimensions + 1], -1).all(axis=-1)
    return np.asarray(per_mode.sum(axis=-1))


def _remove_unreadable(store: Store, name: str) -> None:
    """Remove the files of a per-chunk array that cannot be read: their chunks are computed
    again.
    """
    array = store.group[name]
    if _readable(array.__getitem__, slice(None)) is not None:
        return
    for path in (store.folder / name / "c").iterdir():
        if _readable(array.__getitem__, int(path.name)) is None:
            path.unlink()


def _is_equal(array: Any, values: np.ndarray) -> bool:
    found = _readable(array.__getitem__, slice(None))
    return found is not None and np.array_equal(np.asarray(found), values)


def _readable(read: Any, key: Any) -> Any:
    """What a call of Zarr reads, None where the file cannot be decoded: decoders raise errors of
    many kinds.
    """
    try:
        return read(key)
    except FileNotFoundError:
        return None
    except (OSError, MemoryError):
        raise
    except Exception:
        return None
