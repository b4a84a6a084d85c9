"""MuJoCo as an independent account of a mechanism that is written as MJCF: its links, loops and freedoms at symkin's configurations."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import symkin
from symkin.closure.closure import build_closure
from symkin.closure.link_poses import joint_readings, link_poses
from symkin.formats.graph_form import as_graph
from symkin.position.closed_configurations import closed_configurations
from symkin.spatial.pose import Pose

POSE = 1e-10
"""Metres, and quaternions."""


class MujocoAccount:
    """MuJoCo's model of a file, beside the mechanism of which it was written."""

    def __init__(self, mechanism: symkin.Mechanism, path: Path) -> None:
        import mujoco

        self.mujoco, self.mechanism = mujoco, mechanism
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
        self.metres = 1e-3 if mechanism.length_unit == "mm" else 1.0
        self.reference = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.reference, 0)
        mujoco.mj_forward(self.model, self.reference)
        np.testing.assert_array_equal(self.reference.qpos, self.model.qpos0)

    def check(self, count: int = 2, seed: int = 5) -> None:
        """At the reference and at random closed configurations."""
        closure = build_closure(self.mechanism)
        configurations = closed_configurations(closure, seed)[:count]
        for values in [closure.reference, *configurations]:
            poses = link_poses(closure, np.array([values])).at(0)
            links = {n: Pose(self.metres * np.asarray(p.position), p.quaternion) for n, p in poses.items()}
            read = joint_readings(closure, link_poses(closure, np.array([values])))
            data = self.data_at({name: np.asarray(value)[..., 0] for name, value in read.items()}, links)
            self._check_links(data, {link: pose for link, pose in links.items() if link in poses})
            errors, jacobian = self._rows(data)
            assert np.abs(errors).max(initial=0.0) <= POSE
            self.rank = int(np.linalg.matrix_rank(jacobian, tol=1e-8 * np.linalg.norm(jacobian, 2))) if jacobian.size else 0
        account = symkin.mobility(self.mechanism)
        assert self.model.nv - self.rank == account.mobility + len(self.mechanism.bars)

    def data_at(self, read: dict[str, np.ndarray], links: dict[str, Pose]) -> object:
        """MuJoCo's data for readings of joints by name, rods turned by the shortest way."""
        graph, data = as_graph(self.mechanism), self.mujoco.MjData(self.model)
        lengths = {c.name for c in self.mechanism.coordinates if c.kind == "length"}
        values = {name: (self.metres if name in lengths else 1.0) * value for name, value in read.items()}
        for rod in graph.link_rods:
            start, end = np.array(rod.start), np.array(rod.end)
            now = np.asarray((links[rod.links[0]].inverse() @ links[rod.links[1]]).apply(end)) - start
            turn = Pose(np.zeros(3), _shortest_turn(end - start, now))
            for link in (rod.name, f"{rod.name}.cylinder", f"{rod.name}.piston"):
                links[link] = links[rod.links[0]] @ turn
            values[rod.name] = np.linalg.norm(now) - rod.offset
        for entry in graph.link_joints:
            if entry.joint.name.startswith("platform.") and entry.joint.name not in values:
                between = links[graph.platform_link]
                at = np.asarray(between.apply(np.array(graph.platform_position)))
                key = entry.joint.name.removeprefix("platform.")
                turn = 2.0 * np.arctan2(between.quaternion[3], between.quaternion[0])
                values[entry.joint.name] = (
                    between.quaternion if key == "turn" else turn if key == "gamma" else at["xyz".index(key)]
                )
        for j in range(self.model.njnt):
            joint, body = self.model.joint(j), int(self.model.jnt_bodyid[j])
            value = values.get(joint.name)
            if int(self.model.jnt_type[j]) == int(self.mujoco.mjtJoint.mjJNT_BALL):
                names = (self.model.body(b).name for b in (int(self.model.body_parentid[body]), body))
                first, second = (links.get(name, Pose.identity()) for name in names)
                value = (first.inverse() @ second).quaternion
            data.qpos[joint.qposadr[0] : joint.qposadr[0] + np.size(value)] = value
        self.mujoco.mj_forward(self.model, data)
        return data

    def _check_links(self, data: object, links: dict[str, Pose]) -> None:
        names = [self.model.body(b).name for b in range(self.model.nbody)]
        for link, pose in links.items():
            if link != "base":
                assert link in names
                expected = pose @ Pose(self.reference.body(link).xpos, self.reference.body(link).xquat)
                np.testing.assert_allclose(data.body(link).xpos, expected.position, atol=POSE, err_msg=link)
                turn = min(np.abs(data.body(link).xquat - sign * expected.quaternion).max() for sign in (1, -1))
                assert turn <= POSE, link

    def _rows(self, data: object) -> tuple[np.ndarray, np.ndarray]:
        count, nv = int(data.nefc), self.model.nv
        rows = np.asarray(data.efc_type[:count]) == int(self.mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        if self.mujoco.mj_isSparse(self.model):
            jacobian = np.zeros((count, nv))
            self.mujoco.mju_sparse2dense(jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
        else:
            jacobian = np.asarray(data.efc_J)[: count * nv].reshape(count, nv)
        return np.asarray(data.efc_pos[:count])[rows], jacobian[rows]


def _shortest_turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    quaternion = np.concatenate([[1.0 + start @ end], np.cross(start, end)])
    return quaternion / np.linalg.norm(quaternion)
