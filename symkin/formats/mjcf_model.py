"""MuJoCo's compiled model, and where its parts stand in the file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from symkin.formats.robot import Mesh
from symkin.formats.xml_text import Element
from symkin.spatial.pose import Pose

_NO_NAME = "MuJoCo Model"
"""What the compiler calls a model without a name."""


@dataclass(frozen=True, eq=False)
class CompiledModel:
    """The package `mujoco`, the model that it compiled, the file's root element and path, and meshes by the number of their geom
    (their poses in the geom's frame)."""

    mujoco: ModuleType
    model: Any
    root: Element
    path: Path
    meshes: dict[int, Mesh]

    @property
    def name(self) -> str | None:
        """The model's name; None where the file tells none."""
        found = bytes(self.model.names).split(b"\0", 1)[0].decode("utf-8", "replace")
        return None if found == _NO_NAME else found

    def joint_type(self, joint: int) -> str:
        """free, ball, slide or hinge."""
        return str(self.mujoco.mjtJoint(int(self.model.jnt_type[joint])).name).removeprefix("mjJNT_").lower()

    def joint_name(self, joint: int) -> str:
        """The name in the file; empty where there is none."""
        return str(self.model.joint(joint).name)

    def body_name(self, body: int) -> str:
        """The name in the file, or one by its number."""
        return str(self.model.body(body).name) or f"body{body}"

    def text(self, name: str) -> str:
        """The custom text of a name; empty where there is none."""
        model = self.model
        for place, first, size in zip(model.name_textadr, model.text_adr, model.text_size, strict=True):
            if bytes(model.names)[int(place) :].split(b"\0", 1)[0] == name.encode():
                data = bytes(model.text_data)[int(first) : int(first) + int(size)]
                return data.rstrip(b"\0").decode("utf-8", "replace")
        return ""

    def at_qpos0(self, joint: int) -> float:
        """The value of a hinge or slide at the file's own configuration."""
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])

    def tendon(self, number: int) -> list[tuple[int, float]] | None:
        """Joints and factors of a fixed tendon; None of a spatial one."""
        model = self.model
        first, count = int(model.tendon_adr[number]), int(model.tendon_num[number])
        if any(int(model.wrap_type[k]) != int(self.mujoco.mjtWrap.mjWRAP_JOINT) for k in range(first, first + count)):
            return None
        return [(int(model.wrap_objid[k]), float(model.wrap_prm[k])) for k in range(first, first + count)]

    def geom_pose(self, geom: int) -> Pose:
        """A geom's frame in its body's."""
        return Pose(self.model.geom_pos[geom].copy(), np.array(self.model.geom_quat[geom]))

    def site_pose(self, site: int) -> Pose:
        """A site's frame in its body's."""
        return Pose(self.model.site_pos[site].copy(), self.model.site_quat[site].copy())
