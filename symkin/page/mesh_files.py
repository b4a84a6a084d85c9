"""Triangles of mesh files, for pictures: STL (binary and text), OBJ, and COLLADA by pycollada (`symkin[meshes]`)."""

from __future__ import annotations

import base64
import importlib.util
import io
import re
import warnings
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from symkin.model.mesh import LinkMesh

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
"""Bytes of a binary STL file before its triangles; the last four count them."""
_LARGEST = 40e6
"""Bytes of a mesh file that a page takes at most."""
_FARTHEST = 1e18
"""Largest coordinate of a corner: the page has floats, whose largest is 3e38."""
_COLLADA = ".dae"
_STEPS = 65535
"""Steps of a mesh's box along an axis: its places are numbers of two bytes, 15 um apart on a metre."""


def mesh_item(mesh: LinkMesh, link: int) -> dict[str, object] | None:
    """A mesh as an item of a scene, its triangles in the base frame at the reference; None where the file is not there, of another
    kind or without bounds."""
    triangles = read_triangles(Path(mesh.file))
    if triangles is None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        placed = np.asarray(mesh.pose.rotation) @ (triangles * np.array(mesh.scale)).reshape(-1, 3).T
    if not (np.abs(placed) < _FARTHEST).all():
        return None
    return {"kind": "mesh", "link": link, "name": mesh.link, **_packed(placed.T + np.array(mesh.position))}


def _packed(corners: np.ndarray) -> dict[str, object]:
    """Corners (3 n, 3) of triangles in few bytes: each place once, in steps of the box that holds them all, and triangles as its numbers."""
    low = corners.min(axis=0)
    span = np.maximum(corners.max(axis=0) - low, np.finfo(float).tiny)
    steps = np.round((corners - low) / span * _STEPS).astype(np.uint64)
    keys, numbers = np.unique(steps[:, 0] << 32 | steps[:, 1] << 16 | steps[:, 2], return_inverse=True)
    places = np.column_stack([keys >> 32, keys >> 16 & _STEPS, keys & _STEPS]).astype("<u2")
    faces = numbers.reshape(-1, 3)
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    triangles = faces[~flat].astype("<u2" if len(places) <= _STEPS else "<u4")
    return {"low": low.tolist(), "span": span.tolist(), "places": _text(places), "triangles": _text(triangles)}


def _text(numbers: np.ndarray) -> str:
    return base64.b64encode(numbers.tobytes()).decode("ascii")


def read_triangles(path: Path) -> np.ndarray | None:
    """Corners (n, 3, 3) of a mesh file's triangles in its own numbers; None where it cannot be read as one."""
    reader = _readers().get(path.suffix.lower())
    if reader is None or not path.is_file() or path.stat().st_size > _LARGEST:
        return None
    triangles = reader(path.read_bytes())
    return triangles if len(triangles) and np.isfinite(triangles).all() else None


def why_unread(path: Path) -> str:
    """What a note says of mesh files that `read_triangles` does not read."""
    if not path.is_file():
        return "there is no such file, also in folders named by --packages"
    if path.suffix.lower() == _COLLADA and importlib.util.find_spec("collada") is None:
        return "COLLADA takes the package pycollada: pip install 'symkin[meshes]' installs it"
    if path.suffix.lower() not in _readers():
        return f"read are {', '.join(_readers())}"
    if path.stat().st_size > _LARGEST:
        return f"files up to {_LARGEST / 1e6:g} MB are read"
    return "no triangles could be read there: empty, cut short, or not of the kind that the suffix tells"


def _readers() -> dict[str, Callable[[bytes], np.ndarray]]:
    return {".stl": _stl, ".obj": _obj, _COLLADA: _collada}


def _stl(content: bytes) -> np.ndarray:
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


def _obj(content: bytes) -> np.ndarray:
    lines = content.decode("utf-8", "replace").splitlines()
    try:
        points = np.array([[float(v) for v in line.split()[1:4]] for line in lines if line.startswith("v ")])
        triangles = [corners for line in lines if line.startswith("f ") for corners in _fan(line, len(points))]
        return points[np.array(triangles, dtype=int)] if triangles else np.zeros((0, 3, 3))
    except (ValueError, IndexError):
        return np.zeros((0, 3, 3))


def _fan(line: str, count: int) -> Iterator[tuple[int, int, int]]:
    """Triangles of a face; its numbers count from 1, negative ones from the end."""
    corners = [int(part.split("/")[0]) for part in line.split()[1:]]
    places = [k - 1 if k > 0 else count + k for k in corners]
    return ((places[0], a, b) for a, b in pairwise(places[1:]))


def _collada(content: bytes) -> np.ndarray:
    """Triangles of the file's scene in metres. `up_axis` is not heeded, as RViz and Gazebo do not: robots' files are written for them."""
    try:
        import collada
    except ImportError:
        return np.zeros((0, 3, 3))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NumPy's about `matrix`, which pycollada uses
            document = collada.Collada(io.BytesIO(content), ignore=[collada.DaeError])
            shapes = list(document.scene.objects("geometry")) if document.scene else []
            sets = [
                part.triangleset() if hasattr(part, "triangleset") else part for shape in shapes for part in shape.primitives()
            ]
            triangles = [part.vertex[part.vertex_index] for part in sets if part.vertex_index is not None]
    except Exception:  # pycollada does not list what foreign files raise; the picture goes without this one, and a note tells it
        return np.zeros((0, 3, 3))
    found = [corners for corners in triangles if corners.shape[1:] == (3, 3)]
    return np.concatenate(found).astype(float) * (document.assetInfo.unitmeter or 1.0) if found else np.zeros((0, 3, 3))
