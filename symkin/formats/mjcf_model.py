"""The model that MuJoCo compiled of a file, as records by their numbers in it, and where its parts
stand in the file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from symkin.formats.robot import Mesh
from symkin.formats.xml_text import Element
from symkin.spatial.pose import Pose

_NO_NAME = "MuJoCo Model"
"""What the compiler calls a model without a name."""
_RECORDS = ("bodies", "joints", "equalities", "tendons", "actuators")
Record = Any
"""A body, joint, equality, tendon or actuator as `formats/mujoco_worker.py` tells it."""


@dataclass(frozen=True, eq=False)
class CompiledModel:
    """What `formats/mujoco_worker.py` tells of a model, the file's root element and path, and
    meshes with the numbers of their bodies, in whose frames they stand.
    """

    bodies: Sequence[Record]
    joints: Sequence[Record]
    equalities: Sequence[Record]
    tendons: Sequence[Record]
    actuators: Sequence[Record]
    qpos: Sequence[float]
    idle: Mapping[str, int]
    finite: bool
    texts: Mapping[str, str]
    name: str | None
    root: Element
    path: Path
    meshes: Sequence[tuple[int, Mesh]]


def compiled_model(
    told: Mapping[str, Any], root: Element, path: Path, meshes: Mapping[str, Mesh]
) -> CompiledModel:
    """The model of a worker's answer; `meshes` by their names, in the frames of their geoms."""
    records: dict[str, Any] = {
        key: [SimpleNamespace(**entry) for entry in told[key]] for key in _RECORDS
    }
    return CompiledModel(
        **records,
        qpos=told["qpos"],
        idle=told["idle"],
        finite=told["finite"],
        texts=told["texts"],
        name=None if told["name"] == _NO_NAME else told["name"],
        root=root,
        path=path,
        meshes=[(geom["body"], _moved(meshes[geom["mesh"]], geom)) for geom in told["shown"]],
    )


def _moved(mesh: Mesh, geom: Mapping[str, Any]) -> Mesh:
    return replace(mesh, pose=pose_of(geom["position"], geom["quaternion"]) @ mesh.pose)


def pose_of(position: Sequence[float], quaternion: Sequence[float]) -> Pose:
    """A pose of a record's numbers."""
    return Pose(np.array(position), np.array(quaternion))
