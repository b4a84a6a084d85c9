"""Pinocchio as an independent account of a mechanism that is written as URDF: its links and loops
at symkin's configurations.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

import symkin
from helpers.inside import matrix_from_quaternion
from helpers.written_moves import configurations
from symkin import Pose

POSE = 1e-10
"""Metres, and components of rotation matrices."""


class PinocchioAccount:
    """Pinocchio's tree of a file, and the file's loops, beside the mechanism of which it was
    written.
    """

    def __init__(self, mechanism: symkin.Mechanism, path: Path) -> None:
        import pinocchio

        self.pin, self.mechanism = pinocchio, mechanism
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.root = ElementTree.parse(path).getroot()

    def check(self) -> None:
        """At the reference and at closed configurations; where all joints are 0, frames are
        parallel to the base's.
        """
        for pose in self._poses({}).values():
            np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-12)
        start: dict[str, np.ndarray] = {}
        for links, values, balls in configurations(self.mechanism):
            found = self._poses(self._values(values, balls))
            start = start or {link: found[link] for link in links}
            for link, pose in links.items():
                np.testing.assert_allclose(
                    found[link], _matrix(pose) @ start[link], atol=POSE, err_msg=link
                )
            for loop in self.root.iter("loop"):
                self._check_loop(loop, found)

    def _values(self, values: dict[str, float], balls: dict[str, np.ndarray]) -> dict[str, float]:
        """Values of the URDF's joints: three turns about x, y, z for a ball."""
        found = dict(values)
        for name, quaternion in balls.items():
            turn = matrix_from_quaternion(quaternion)
            found[f"{name}.x"] = np.arctan2(-turn[1, 2], turn[2, 2])
            found[f"{name}.y"] = np.arcsin(turn[0, 2])
            found[f"{name}.z"] = np.arctan2(-turn[0, 1], turn[0, 0])
        return found

    def _poses(self, values: dict[str, float]) -> dict[str, np.ndarray]:
        q = self.pin.neutral(self.model)
        for number, name in enumerate(self.model.names):
            if number and values:
                joint = self.model.joints[number]
                angle = values[name]
                q[joint.idx_q : joint.idx_q + joint.nq] = (
                    [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
                )
        data = self.model.createData()
        self.pin.framesForwardKinematics(self.model, data, q)
        frames = [
            (k, f) for k, f in enumerate(self.model.frames) if f.type == self.pin.FrameType.BODY
        ]
        return {frame.name: data.oMf[k].homogeneous.copy() for k, frame in frames}

    def _check_loop(self, loop: ElementTree.Element, found: dict[str, np.ndarray]) -> None:
        """The frames of a closure coincide as its type says."""
        ends = []
        for tag in ("predecessor", "successor"):
            end = loop.find(tag)
            origin = end.find("origin")
            xyz, rpy = (
                np.array([float(v) for v in origin.get(key, "0 0 0").split()])
                for key in ("xyz", "rpy")
            )
            ends.append(
                found[end.get("link")]
                @ self.pin.SE3(self.pin.rpy.rpyToMatrix(rpy), xyz).homogeneous
            )
        away = np.linalg.inv(ends[0]) @ ends[1]
        kind, name = loop.get("type"), loop.get("name")
        if kind in ("ball", "revolute", "fixed"):
            np.testing.assert_allclose(away[:3, 3], 0.0, atol=POSE, err_msg=name)
        if kind in ("revolute", "cylindrical"):
            np.testing.assert_allclose(away[:3, 2], [0, 0, 1], atol=POSE, err_msg=name)
        if kind in ("cylindrical", "prismatic"):
            np.testing.assert_allclose(away[:2, 3], 0.0, atol=POSE, err_msg=name)
        if kind in ("fixed", "prismatic"):
            np.testing.assert_allclose(away[:3, :3], np.eye(3), atol=POSE, err_msg=name)


def _matrix(pose: Pose) -> np.ndarray:
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = pose.rotation, pose.position
    return found
