"""The model that MuJoCo compiled of a file, as records by their numbers in it, and where its parts
stand in the file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from symkin.formats.packages import Packages
from symkin.formats.robot import Mesh
from symkin.formats.xml_text import Element
from symkin.spatial.pose import Pose

_NO_NAME = "MuJoCo Model"
"""What the compiler calls a model without a name."""
_RECORDS = ("bodies", "joints", "equalities", "tendons", "actuators", "meshes", "shown")
Record = Any
"""A body, joint, equality, tendon or actuator as `formats/mujoco_worker.py` tells it."""
CompiledModel = Any
"""All that `formats/mujoco_worker.py` tells of a model, by its keys: lists of records, `qpos`,
`idle`, `finite`, `texts`, `name`; with the file's `root` element and `path`.
"""


def compiled_model(told: Mapping[str, Any], root: Element, path: Path) -> CompiledModel:
    """The model of a worker's answer."""
    records = {key: [SimpleNamespace(**entry) for entry in told[key]] for key in _RECORDS}
    name = None if told["name"] == _NO_NAME else told["name"]
    return SimpleNamespace(**{**told, **records, "name": name}, root=root, path=path)


def meshes_of(compiled: CompiledModel) -> list[tuple[int, Mesh]]:
    """The meshes that geoms show, by the numbers of their bodies, in whose frames they stand:
    refpos and refquat move them before their scale. Raises MechanismError for a scale of 0.
    """
    packages, found = Packages(compiled.path), {}
    for mesh in compiled.meshes:
        x, y, z = scale = np.array(mesh.scale)
        if not np.all(np.isfinite(scale)) or 0.0 in scale:
            raise _written(compiled.root, mesh).error(
                f"scale = {scale.tolist()} makes nothing of the mesh; numbers other than 0 are "
                f"needed"
            )
        turn = np.array(mesh.refquat)
        back = Pose(np.zeros(3), turn / np.linalg.norm(turn)).inverse()
        at = Pose(-scale * back.turn(np.array(mesh.refpos)), back.quaternion)
        found[mesh.name] = packages.written(mesh.file), at, (float(x), float(y), float(z))
    shown = ((g, *found[g.mesh]) for g in compiled.shown)
    return [
        (g.body, Mesh(file, pose_of(g.position, g.quaternion) @ at, scale))
        for g, file, at, scale in shown
    ]


def _written(root: Element, mesh: Record) -> Element:
    """The element of a mesh that tells its scale, as far as it can be told from others."""
    elements = [e for e in root.walk() if e.tag == "mesh" and "scale" in e.attributes]
    named = (e for e in elements if mesh.named and mesh.name == e.attributes.get("name"))
    return next(named, elements[0] if elements else root)


def pose_of(position: Sequence[float], quaternion: Sequence[float]) -> Pose:
    """A pose of a record's numbers."""
    return Pose(np.array(position), np.array(quaternion))
