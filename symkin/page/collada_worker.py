"""Read a COLLADA file by pycollada, in a child process (`formats/child.py`): the triangles of its
scene as text of floats.

This file imports nothing of symkin, so that the child starts quickly.
"""

import base64
from importlib import import_module
from typing import Any

import numpy as np


def work(task: dict[str, Any]) -> dict[str, Any]:
    """Corners of the triangles of the file `task["path"]`, and its unit in metres; none where
    pycollada cannot read it.
    """
    try:
        corners, unit = _read(task["path"])
    except MemoryError:
        raise
    # pycollada does not list what foreign files raise; the picture goes without this one, and a
    # note tells it
    except Exception:
        corners, unit = np.zeros((0, 3, 3)), 1.0
    return {
        "corners": base64.b64encode(corners.astype("<f4").tobytes()).decode("ascii"),
        "unit": unit,
    }


def _read(path: str) -> tuple[np.ndarray, float]:
    """`up_axis` is not heeded, as RViz and Gazebo do not: robots' files are written for them."""
    collada = import_module("collada")
    with open(path, "rb") as file:
        document = collada.Collada(file, ignore=[collada.DaeError])
    shapes = list(document.scene.objects("geometry")) if document.scene else []
    parts = [part for shape in shapes for part in shape.primitives()]
    sets = [part.triangleset() if hasattr(part, "triangleset") else part for part in parts]
    triangles = [part.vertex[part.vertex_index] for part in sets if part.vertex_index is not None]
    found = [corners for corners in triangles if corners.shape[1:] == (3, 3)]
    unit = float(document.assetInfo.unitmeter or 1.0)
    return np.concatenate(found) if found else np.zeros((0, 3, 3)), unit
