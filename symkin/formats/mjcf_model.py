"""The model that MuJoCo compiled of a file, as numbers and names, and where its parts stand in the
file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from symkin.formats.robot import Mesh
from symkin.formats.xml_text import Element
from symkin.spatial.pose import Pose

_NO_NAME = "MuJoCo Model"
"""What the compiler calls a model without a name."""


@dataclass(frozen=True, eq=False)
class CompiledModel:
    """What `formats/mujoco_worker.py` tells of a model: its numbers and arrays under MuJoCo's names
    (`model`); bodies and joints as they are `placed`; words for kinds, and names, of its joints,
    equalities, actuators and so on, by their numbers; the file's root element and path; and meshes
    by the number of their geom (their poses in the geom's frame).
    """

    model: SimpleNamespace
    placed: SimpleNamespace
    kinds: Mapping[str, Sequence[str]]
    names: Mapping[str, Sequence[str]]
    by_sites: Sequence[bool]
    texts: Mapping[str, str]
    told_name: str
    root: Element
    path: Path
    meshes: Mapping[int, Mesh]

    @property
    def name(self) -> str | None:
        """The model's name; None where the file tells none."""
        return None if self.told_name == _NO_NAME else self.told_name

    def joint_type(self, joint: int) -> str:
        """free, ball, slide or hinge."""
        return self.kinds["joint"][joint]

    def joint_name(self, joint: int) -> str:
        """The name in the file; empty where there is none."""
        return self.names["joint"][joint]

    def body_name(self, body: int) -> str:
        """The name in the file, or one by its number."""
        return self.names["body"][body] or f"body{body}"

    def text(self, name: str) -> str:
        """The custom text of a name; empty where there is none."""
        return self.texts.get(name, "")

    def at_qpos0(self, joint: int) -> float:
        """The value of a hinge or slide at the file's own configuration."""
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])

    def tendon(self, number: int) -> list[tuple[int, float]] | None:
        """Joints and factors of a fixed tendon; None of a spatial one."""
        model = self.model
        first, count = int(model.tendon_adr[number]), int(model.tendon_num[number])
        if any(self.kinds["wrap"][k] != "joint" for k in range(first, first + count)):
            return None
        return [
            (int(model.wrap_objid[k]), float(model.wrap_prm[k]))
            for k in range(first, first + count)
        ]

    def geom_pose(self, geom: int) -> Pose:
        """A geom's frame in its body's."""
        return Pose(self.model.geom_pos[geom].copy(), self.model.geom_quat[geom].copy())

    def site_pose(self, site: int) -> Pose:
        """A site's frame in its body's."""
        return Pose(self.model.site_pos[site].copy(), self.model.site_quat[site].copy())


def compiled_model(
    told: Mapping[str, Any], root: Element, path: Path, meshes: Mapping[int, Mesh]
) -> CompiledModel:
    """The model of a worker's answer."""
    return CompiledModel(
        model=SimpleNamespace(
            **told["numbers"], **{key: np.array(values) for key, values in told["arrays"].items()}
        ),
        placed=SimpleNamespace(**{key: np.array(values) for key, values in told["placed"].items()}),
        kinds=told["kinds"],
        names=told["names"],
        by_sites=told["by_sites"],
        texts=told["texts"],
        told_name=told["name"],
        root=root,
        path=path,
        meshes=meshes,
    )
