"""MuJoCo as an independent account of a mechanism that is written as MJCF: its links, loops and
freedoms at symkin's configurations.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import symkin
from helpers.equality_rows import equality_rows
from helpers.inside import as_graph
from helpers.written_moves import configurations
from symkin import Pose

POSE = 1e-10
"""Metres, and quaternions."""


class MujocoAccount:
    """MuJoCo's model of a file, beside the mechanism of which it was written."""

    def __init__(self, mechanism: symkin.Mechanism, path: Path) -> None:
        import mujoco

        self.mujoco, self.mechanism = mujoco, mechanism
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(
            mujoco.mjtDisableBit.mjDSBL_LIMIT
        )
        self.reference = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.reference, 0)
        mujoco.mj_forward(self.model, self.reference)
        np.testing.assert_array_equal(self.reference.qpos, self.model.qpos0)

    def check(self) -> list[int]:
        """At the reference and at closed configurations: links and closed equalities. What the rank
        leaves free at each of them, idle spins among it.
        """
        freedoms = []
        for links, values, balls in configurations(self.mechanism):
            data = self._data_at(values, balls)
            self._check_links(data, links)
            errors, jacobian = equality_rows(self.mujoco, self.model, data)
            assert np.abs(errors).max(initial=0.0) <= POSE
            rank = (
                int(np.linalg.matrix_rank(jacobian, tol=1e-8 * np.linalg.norm(jacobian, 2)))
                if jacobian.size
                else 0
            )
            freedoms.append(self.model.nv - rank)
        return freedoms

    def _data_at(self, values: dict[str, float], balls: dict[str, np.ndarray]) -> object:
        """MuJoCo's data for values of joints by name."""
        data = self.mujoco.MjData(self.model)
        for j in range(self.model.njnt):
            joint, body = self.model.joint(j), self.model.body(int(self.model.jnt_bodyid[j]))
            value = values.get(joint.name)
            if int(self.model.jnt_type[j]) == int(self.mujoco.mjtJoint.mjJNT_BALL):
                value = balls[joint.name] * (
                    1.0 if self._leads_to(joint.name, body.name) else np.array([1.0, -1, -1, -1])
                )
            data.qpos[joint.qposadr[0] : joint.qposadr[0] + np.size(value)] = value
        self.mujoco.mj_forward(self.model, data)
        return data

    def _leads_to(self, joint: str, body: str) -> bool:
        """Whether a spherical joint leads to the body that has it, and not from it."""
        graph = as_graph(self.mechanism)
        ends = {entry.joint.name: entry.links[1] for entry in graph.link_joints}
        ends |= {f"{rod.name}.to": rod.links[1] for rod in graph.link_rods}
        return joint.endswith(".from") if joint not in ends else ends[joint] == body

    def _check_links(self, data: object, links: dict[str, Pose]) -> None:
        names = [self.model.body(b).name for b in range(self.model.nbody)]
        for link, pose in links.items():
            if link != "base":
                assert link in names
                expected = pose @ Pose(
                    self.reference.body(link).xpos, self.reference.body(link).xquat
                )
                np.testing.assert_allclose(
                    data.body(link).xpos, expected.position, atol=POSE, err_msg=link
                )
                turn = min(
                    np.abs(data.body(link).xquat - sign * expected.quaternion).max()
                    for sign in (1, -1)
                )
                assert turn <= POSE, link
