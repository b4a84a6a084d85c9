"""The files of one chunk of points: encoded as Zarr's version 3 encodes them, written, listed and
hashed.

Zarr's own writer takes about a millisecond an array, through the event loop of another thread:
longer than the points of a chunk take to be computed. Its files and these are the same, byte for
byte.
"""

from __future__ import annotations

import hashlib
import importlib
import os
from collections.abc import Iterator, Mapping
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from symkin.computed_once import lru_cache

COMPRESSION_LEVEL = 0
"""Level of Zstandard with which arrays over the points are made and written; 0 is its own
default.
"""
_DIGEST_BYTES = 8


@lru_cache(maxsize=1)
def _codec() -> Any:
    zstd: Any = importlib.import_module("numcodecs.zstd")
    return zstd.Zstd(level=COMPRESSION_LEVEL)


def write_chunk(
    array: Path, place: tuple[int, ...], values: np.ndarray, shape: tuple[int, ...], fill: float
) -> dict[Path, bytes]:
    """Write the chunk of points at `place` of the array in a folder, `shape` that of its files; the
    files with their bytes. Files that would hold nothing but `fill` are left out, as Zarr leaves
    them out, and older ones are removed.
    """
    files = {
        array.joinpath("c", *map(str, key)): content
        for key, content in _encoded(place, values, shape, fill)
    }
    for path in list(chunk_files(array, place)):
        if path not in files:
            path.unlink()
    for path, content in files.items():
        _write(path, content)
    return files


def _encoded(
    place: tuple[int, ...], values: np.ndarray, shape: tuple[int, ...], fill: float
) -> Iterator[tuple[tuple[int, ...], bytes]]:
    """Keys and contents of the files of a chunk: its values, filled up to whole files along each
    dimension.
    """
    counts = [-(-length // side) for length, side in zip(values.shape, shape, strict=True)]
    whole = np.full(
        [count * side for count, side in zip(counts, shape, strict=True)], fill, dtype=values.dtype
    )
    whole[tuple(slice(length) for length in values.shape)] = values
    further = counts[len(place) :]
    for last in np.ndindex(*further):
        first = (0,) * len(place) + last
        part = whole[
            tuple(slice(i * side, (i + 1) * side) for i, side in zip(first, shape, strict=True))
        ]
        if not (np.isnan(part).all() if np.isnan(fill) else (part == fill).all()):
            little = np.ascontiguousarray(part, dtype=part.dtype.newbyteorder("<"))
            yield (*place, *last), _codec().encode(little.reshape(prod(shape)))


def _write(path: Path, content: bytes) -> None:
    """A whole file or none."""
    partial_file = path.with_name(f"{path.name}.partial")
    write = partial(partial_file.write_bytes, content)
    try:
        write()
    except FileNotFoundError:
        path.parent.mkdir(parents=True, exist_ok=True)
        write()
    os.replace(partial_file, path)


def chunk_files(array: Path, place: tuple[int, ...]) -> Iterator[Path]:
    """The files of an array that hold a chunk of points, in order."""
    path = array.joinpath("c", *map(str, place))
    if path.is_file():
        yield path
    elif path.is_dir():
        yield from sorted(p for p in path.rglob("*") if p.is_file())


def digest_of(folder: Path, files: Mapping[Path, bytes]) -> int:
    """A number of 64 bits made of the names and bytes of files in a folder."""
    found = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for path, content in files.items():
        found.update(f"{path.relative_to(folder).as_posix()} {len(content)} ".encode())
        found.update(content)
    return int.from_bytes(found.digest(), "little")
