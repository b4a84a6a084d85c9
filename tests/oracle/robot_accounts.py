"""MuJoCo and Pinocchio as independent accounts of the machines of `made_robots`: poses, constraint
ranks, motion on the closed set.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from helpers.equality_rows import equality_rows
from helpers.made_robots import FREEDOMS, GROUND, Machine
from helpers.robot_texts import mjcf

RANK_SHARE = 1e-8
"""Of the largest singular value."""
Values = Mapping[str, Any]
"""Joint values by the names of coordinates, and quaternions (w, x, y, z) of balls by the names of
their joints, in the child's frame.
"""


def rank(jacobian: np.ndarray) -> int:
    s = np.linalg.svd(jacobian, compute_uv=False)
    return int(np.sum(s > RANK_SHARE * s[0])) if s.size else 0


class MuJoCo:
    """The machine's own MJCF text, compiled; contacts and limits off."""

    def __init__(self, machine: Machine) -> None:
        import mujoco

        self.mujoco, self.machine = mujoco, machine
        self.model = mujoco.MjModel.from_xml_string(mjcf(machine))
        flags = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(flags.mjDSBL_CONTACT) | int(flags.mjDSBL_LIMIT)
        self.data = mujoco.MjData(self.model)

    def place(self, values: Values) -> np.ndarray:
        """qpos for joint values."""
        found = np.array(self.model.qpos0)
        for part in self.machine.parts:
            for name in part.coordinates:
                found[self._address(name)] = values[name]
            if part.joint == "H":
                found[self._address(f"{part.joint_name}_advance")] = (
                    values[part.joint_name] * part.pitch / (2 * np.pi)
                )
            if part.joint == "S":
                start = self._address(part.joint_name)
                found[start : start + 4] = values[part.joint_name]
        return found

    def poses(self, qpos: np.ndarray) -> dict[str, np.ndarray]:
        """The frames of all parts, by `mj_kinematics`."""
        self.data.qpos[:] = qpos
        self.mujoco.mj_kinematics(self.model, self.data)
        found = {}
        for part in self.machine.parts:
            pose, body = np.eye(4), self.data.body(part.name)
            pose[:3, :3], pose[:3, 3] = np.array(body.xmat).reshape(3, 3), body.xpos
            found[part.name] = pose
        return found

    def rows(self, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Violations and Jacobian of the equality constraints."""
        self.data.qpos[:] = qpos
        self.mujoco.mj_forward(self.model, self.data)
        return equality_rows(self.mujoco, self.model, self.data)

    def closed(self, qpos: np.ndarray, held: Mapping[str, float]) -> np.ndarray:
        """The closed configuration near one, joints `held` at values: Newton's method on MuJoCo's
        own constraints.
        """
        found = np.array(qpos)
        for name, value in held.items():
            found[self._address(name)] = value
        free = np.array(
            [k for k in range(self.model.nv) if k not in {self._freedom(name) for name in held}]
        )
        for _ in range(20):
            values, jacobian = self.rows(found)
            step = np.zeros(self.model.nv)
            step[free] = np.linalg.lstsq(jacobian[:, free], -values, rcond=1e-10)[0]
            self.mujoco.mj_integratePos(self.model, found, step, 1.0)
            if np.abs(step).max() < 1e-13:
                break
        assert np.abs(self.rows(found)[0]).max() < 1e-11
        return found

    def value(self, qpos: np.ndarray, name: str) -> float:
        return float(qpos[self._address(name)])

    def _address(self, joint: str) -> int:
        return int(self.model.joint(joint).qposadr[0])

    def _freedom(self, joint: str) -> int:
        return int(self.model.joint(joint).dofadr[0])


class Pinocchio:
    """The machine's tree joint by joint, and its closures as constraint models, made by hand."""

    def __init__(self, machine: Machine) -> None:
        import pinocchio as pin

        self.pin, self.machine = pin, machine
        self.model = pin.Model()
        self.number = {GROUND: 0}
        self.columns: dict[str, int] = {}
        for part in machine.parts:
            self._add(part)
        self.data = self.model.createData()
        self.constraints = [c for closure in machine.pins for c in self._constraints(closure)]

    def _add(self, part: Any) -> None:
        pin, machine = self.pin, self.machine
        at, parent = pin.SE3(machine.in_parent(part)), self.number[part.parent]
        axis = machine.direction(part.name, part.axis)
        kinds = {
            "R": [pin.JointModelRevoluteUnaligned(axis)],
            "P": [pin.JointModelPrismaticUnaligned(axis)],
            "H": [pin.JointModelRevoluteUnaligned(axis), pin.JointModelPrismaticUnaligned(axis)],
            "U": [pin.JointModelRX(), pin.JointModelRY()],
            "S": [pin.JointModelSpherical()],
        }[part.joint]
        for k, kind in enumerate(kinds):
            parent = self.model.addJoint(parent, kind, at, f"{part.joint_name}/{k}")
            self.columns[f"{part.joint_name}/{k}"] = self.model.joints[parent].idx_v
            at = pin.SE3.Identity()
        self.number[part.name] = parent

    def _constraints(self, closure: Any) -> list[Any]:
        """Points of a ball, two points of a hinge, all of a weld."""
        pin = self.pin
        points = [np.array(closure.at)]
        if closure.kind == "R":
            points.append(points[0] + 0.1 * np.array(closure.axis))
        kind = pin.ContactType.CONTACT_6D if closure.kind == "weld" else pin.ContactType.CONTACT_3D
        (a, b) = closure.parts
        return [
            pin.RigidConstraintModel(
                kind,
                self.model,
                self.number[a],
                pin.SE3(self.machine.frame(a, at)),
                self.number[b],
                pin.SE3(self.machine.frame(b, at)),
                pin.LOCAL,
            )
            for at in points
        ]

    def place(self, values: Values) -> np.ndarray:
        q = self.pin.neutral(self.model)
        for part in self.machine.parts:
            name = part.joint_name
            numbers = [values[c] for c in part.coordinates]
            if part.joint == "H":
                numbers.append(values[name] * part.pitch / (2 * np.pi))
            if part.joint == "S":
                w, x, y, z = values[name]
                start = self.model.joints[self.model.getJointId(f"{name}/0")].idx_q
                q[start : start + 4] = (x, y, z, w)
            for k, number in enumerate(numbers):
                joint = self.model.joints[self.model.getJointId(f"{name}/{k}")]
                q[joint.idx_q : joint.idx_q + joint.nq] = (
                    number if joint.nq == 1 else (np.cos(number), np.sin(number))
                )
        return np.asarray(q)

    def poses(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """The frames of all parts, by `forwardKinematics`."""
        self.pin.forwardKinematics(self.model, self.data, q)
        return {
            part.name: np.array(self.data.oMi[self.number[part.name]].homogeneous)
            for part in self.machine.parts
        }

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Constraint Jacobians, with a row for each coupling and screw."""
        pin = self.pin
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        rows = [
            pin.getConstraintJacobian(self.model, self.data, c, c.createData())
            for c in self.constraints
        ]
        for follower in self.machine.followers:
            row = np.zeros((1, self.model.nv))
            row[0, self.columns[f"q_{follower.part}/0"]] = 1.0
            row[0, self.columns[f"q_{follower.leader}/0"]] = -follower.factor
            rows.append(row)
        for part in self.machine.parts:
            if part.joint == "H":
                row = np.zeros((1, self.model.nv))
                row[0, self.columns[f"{part.joint_name}/1"]] = 1.0
                row[0, self.columns[f"{part.joint_name}/0"]] = -part.pitch / (2 * np.pi)
                rows.append(row)
        return np.concatenate(rows)


def ball_values(machine: Machine, poses: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The quaternion of every ball for poses of parts: what turns the child from where it stands on
    its parent.
    """
    from scipy.spatial.transform import Rotation

    found = {}
    for part in machine.parts:
        if part.joint == "S":
            parent = poses.get(part.parent, np.eye(4))
            turn = (parent @ machine.in_parent(part))[:3, :3].T @ poses[part.name][:3, :3]
            x, y, z, w = Rotation.from_matrix(turn).as_quat()
            found[part.joint_name] = np.array([w, x, y, z])
    return found


def freedom(machine: Machine) -> int:
    """Freedoms of the tree's joints."""
    return sum(FREEDOMS[part.joint] for part in machine.parts)
