"""Triangles of mesh files, for pictures: STL (binary and text), OBJ, and COLLADA by pycollada
(`symkin[meshes]`).
"""

from __future__ import annotations

import base64
import importlib.util
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from symkin.formats.child import ChildError, answer_of
from symkin.model.mesh import LinkMesh

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
"""Bytes of a binary STL file before its triangles; the last four count them."""
_LARGEST = 40e6
"""Bytes of a mesh file that a page takes at most."""
_FARTHEST = 1e18
"""Largest coordinate of a corner: the page has floats, whose largest is 3e38."""
_COLLADA = ".dae"
_WORKER = Path(__file__).with_name("collada_worker.py")
_NOTHING = (
    "no triangles could be read there: empty, cut short, or not of the kind that the suffix tells"
)
_STEPS = 65535
"""Steps of a mesh's box along an axis: its places are numbers of two bytes, 15 um apart on a
metre.
"""


class UnreadMeshError(Exception):
    """A mesh that is not shown; the text says why, as the words of a note."""


def mesh_item(mesh: LinkMesh, link: int) -> dict[str, object]:
    """A mesh as an item of a scene, its triangles in the base frame at the reference. Raises
    UnreadMeshError where the file is not there, cannot be read or has no bounds.
    """
    triangles = read_triangles(Path(mesh.file))
    with np.errstate(over="ignore", invalid="ignore"):
        placed = (
            np.asarray(mesh.pose.rotation) @ (triangles * np.array(mesh.scale)).reshape(-1, 3).T
        )
    if not (np.abs(placed) < _FARTHEST).all():
        raise UnreadMeshError(_NOTHING)
    return {
        "kind": "mesh",
        "link": link,
        "name": mesh.link,
        **_packed(placed.T + np.array(mesh.position)),
    }


def _packed(corners: np.ndarray) -> dict[str, object]:
    """Corners (3 n, 3) of triangles in few bytes: each place once, in steps of the box that holds
    them all, and triangles as its numbers.
    """
    low = corners.min(axis=0)
    span = np.maximum(corners.max(axis=0) - low, np.finfo(float).tiny)
    steps = np.round((corners - low) / span * _STEPS).astype(np.uint64)
    keys, numbers = np.unique(
        steps[:, 0] << 32 | steps[:, 1] << 16 | steps[:, 2], return_inverse=True
    )
    places = np.column_stack([keys >> 32, keys >> 16 & _STEPS, keys & _STEPS]).astype("<u2")
    faces = numbers.reshape(-1, 3)
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    triangles = faces[~flat].astype("<u2" if len(places) <= _STEPS else "<u4")
    return {
        "low": low.tolist(),
        "span": span.tolist(),
        "places": _text(places),
        "triangles": _text(triangles),
    }


def _text(numbers: np.ndarray) -> str:
    return base64.b64encode(numbers.tobytes()).decode("ascii")


def read_triangles(path: Path) -> np.ndarray:
    """Corners (n, 3, 3) of a mesh file's triangles in its own numbers. Raises UnreadMeshError where
    it cannot be read as one.
    """
    reader = _READERS.get(path.suffix.lower())
    if not path.is_file():
        raise UnreadMeshError("there is no such file, also in folders named by --packages")
    if path.suffix.lower() == _COLLADA and importlib.util.find_spec("collada") is None:
        raise UnreadMeshError(
            "COLLADA takes the package pycollada: pip install 'symkin[meshes]' installs it"
        )
    if reader is None:
        raise UnreadMeshError(f"read are {', '.join(_READERS)}")
    if path.stat().st_size > _LARGEST:
        raise UnreadMeshError(f"files up to {_LARGEST / 1e6:g} MB are read")
    triangles = reader(path)
    if not len(triangles) or not np.isfinite(triangles).all():
        raise UnreadMeshError(_NOTHING)
    return triangles


def _stl(path: Path) -> np.ndarray:
    content = path.read_bytes()
    count = int.from_bytes(content[_HEADER - 4 : _HEADER], "little")
    if len(content) == _HEADER + count * _TRIANGLE.itemsize:
        return np.asarray(np.frombuffer(content, _TRIANGLE, offset=_HEADER)["corners"], dtype=float)
    numbers = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", content)
    return _rows(numbers[: len(numbers) // 3 * 3])


def _rows(numbers: list[tuple[bytes, ...]]) -> np.ndarray:
    try:
        return np.array(numbers, dtype=float).reshape(-1, 3, 3)
    except ValueError:
        return np.zeros((0, 3, 3))


def _obj(path: Path) -> np.ndarray:
    lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    try:
        points = np.array(
            [[float(v) for v in line.split()[1:4]] for line in lines if line.startswith("v ")]
        )
        triangles = [
            corners
            for line in lines
            if line.startswith("f ")
            for corners in _fan(line, len(points))
        ]
        return points[np.array(triangles, dtype=int)] if triangles else np.zeros((0, 3, 3))
    except (ValueError, IndexError):
        return np.zeros((0, 3, 3))


def _fan(line: str, count: int) -> Iterator[tuple[int, int, int]]:
    """Triangles of a face; its numbers count from 1, negative ones from the end."""
    corners = [int(part.split("/")[0]) for part in line.split()[1:]]
    places = [k - 1 if k > 0 else count + k for k in corners]
    return ((places[0], a, b) for a, b in pairwise(places[1:]))


def _collada(path: Path) -> np.ndarray:
    """Triangles of the file's scene in metres, which pycollada reads in a process of its own."""
    try:
        told = answer_of(_WORKER, {"path": str(path)})
    except ChildError as error:
        raise UnreadMeshError(f"pycollada {error}") from None
    return np.frombuffer(base64.b64decode(told["corners"]), "<f4").reshape(-1, 3, 3).astype(
        float
    ) * float(told["unit"])


_READERS: dict[str, Callable[[Path], np.ndarray]] = {".stl": _stl, ".obj": _obj, _COLLADA: _collada}
