"""Dynamics of a leg with closed loops by MuJoCo and by Pinocchio, on the exact null space of its
constraints: what reflected inertia and inverse dynamics of transmissions are held against.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import symkin
from helpers.transmissions import G1, G1_RANGES


@dataclass(frozen=True)
class Dynamics:
    """A tree at positions and rates of its joints, and what closes its loops: rows J q'' + c = 0;
    forces M q'' + h. Columns are joints in the order of the names.
    """

    mass: np.ndarray
    bias: np.ndarray
    rows: np.ndarray
    curving: np.ndarray

    def along(self, places: Sequence[int]) -> np.ndarray:
        """The motions (joints, places) that the rows leave free, at unit rates of these joints."""
        free = np.linalg.svd(self.rows)[2][-len(places) :].T
        return np.asarray(free @ np.linalg.inv(free[list(places)]))

    def forces(self, motors: Sequence[int], accelerations: np.ndarray) -> np.ndarray:
        """What motors at these places give for accelerations of theirs."""
        held = np.eye(len(self.mass))[list(motors)]
        sides = np.concatenate([-self.curving, accelerations])
        whole = np.linalg.lstsq(np.vstack([self.rows, held]), sides, rcond=1e-12)[0]
        return np.asarray(self.along(motors).T @ (self.mass @ whole + self.bias))


def of_mujoco(
    path: Path, names: Sequence[str], positions: np.ndarray, rates: np.ndarray
) -> Dynamics:
    """MuJoCo's model of an MJCF file with `connect`, hinges in the order of the names."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    places = [model.joint(name).qposadr[0] for name in names]
    data.qpos[places], data.qvel[places] = positions, rates
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    rows, curving = [], []
    for k in range(model.neq):
        ends = []
        for body, anchor in (
            (model.eq_obj1id[k], model.eq_data[k][:3]),
            (model.eq_obj2id[k], model.eq_data[k][3:6]),
        ):
            point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ anchor
            jacobian, changing = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            mujoco.mj_jac(model, data, jacobian, None, point, body)
            mujoco.mj_jacDot(model, data, changing, None, point, body)
            ends.append((jacobian, changing @ data.qvel))
        rows.append(ends[0][0] - ends[1][0])
        curving.append(ends[0][1] - ends[1][1])
    order = np.ix_(places, places)
    return Dynamics(
        mass[order],
        data.qfrc_bias[places].copy(),
        np.vstack(rows)[:, places],
        np.concatenate(curving),
    )


def of_pinocchio(
    path: Path, names: Sequence[str], positions: np.ndarray, rates: np.ndarray
) -> Dynamics:
    """Pinocchio's model of the same file; where its loops are closed is MuJoCo's word."""
    import mujoco
    import pinocchio

    told, model = mujoco.MjModel.from_xml_path(str(path)), pinocchio.buildModelFromMJCF(str(path))
    places = [model.joints[model.getJointId(name)].idx_v for name in names]
    q, v = np.zeros(model.nq), np.zeros(model.nv)
    q[places], v[places] = positions, rates
    ends = []
    for k in range(told.neq):
        for body, anchor in (
            (told.eq_obj1id[k], told.eq_data[k][:3]),
            (told.eq_obj2id[k], told.eq_data[k][3:6]),
        ):
            frame = model.frames[model.getFrameId(told.body(body).name, pinocchio.BODY)]
            at = frame.placement * pinocchio.SE3(np.eye(3), anchor)
            kind = pinocchio.FrameType.OP_FRAME
            made = pinocchio.Frame(f"end{len(ends)}", frame.parentJoint, 0, at, kind)
            ends.append(model.addFrame(made))
    data = model.createData()
    aligned = pinocchio.LOCAL_WORLD_ALIGNED
    pinocchio.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    jacobians = [pinocchio.getFrameJacobian(model, data, f, aligned)[:3].copy() for f in ends]
    curving = [
        pinocchio.getFrameClassicalAcceleration(model, data, f, aligned).linear.copy() for f in ends
    ]
    mass = pinocchio.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias = pinocchio.nonLinearEffects(model, data, q, v)
    return Dynamics(
        mass[np.ix_(places, places)],
        bias[places],
        np.vstack([a - b for a, b in zip(jacobians[::2], jacobians[1::2], strict=True)])[:, places],
        np.concatenate([a - b for a, b in zip(curving[::2], curving[1::2], strict=True)]),
    )


MOTORS = ("left_motor_joint", "right_motor_joint")
PAIRS = (
    ("pitch_joint", "roll_joint"),
    ("right_u_pitch_joint", "right_connect_joint"),
    ("left_u_pitch_joint", "left_connect_joint"),
)
"""Joints of the G1's ankle, two by two functions of its motors: the foot's, and those of rods."""
ARMATURE = 1e-3
"""Of its motors."""


def g1_maps() -> list[symkin.Transmission]:
    """The transmissions from the motors to each pair of joints."""
    robot = symkin.load(G1)
    return [symkin.transmission(robot, MOTORS, pair, ranges=G1_RANGES) for pair in PAIRS]


def worst(
    engine: Callable[..., Dynamics], maps: Sequence[symkin.Transmission], count: int, seed: int
) -> np.ndarray:
    """The largest relative differences, at random motors, between transmissions and an engine: of
    motions, of the accelerations that the constraints ask for, of the motors' inertia at the
    foot, and of the motors' torques.
    """
    rng, names = np.random.default_rng(seed), [*MOTORS, *(n for pair in PAIRS for n in pair)]
    goals = rng.uniform(-0.3, 0.3, (count, 2))
    reached = goals[np.isfinite(maps[0].joints_of(goals, check=False)).all(axis=1)]
    foot, armatures = [names.index(n) for n in PAIRS[0]], np.array([ARMATURE] * 2 + [0.0] * 6)
    found = np.zeros(4)
    positions = np.hstack([reached, *(m.joints_of(reached) for m in maps)])
    firsts = np.concatenate([m.jacobian(reached) for m in maps], axis=1)
    seconds = np.concatenate([m.second(reached) for m in maps], axis=1)
    inertias = maps[0].inertia(reached)
    for q, first, second, inertia in zip(positions, firsts, seconds, inertias, strict=True):
        first = np.vstack([np.eye(2), first])
        second = np.concatenate([np.zeros((2, 2, 2)), second])
        rate, acceleration = rng.normal(size=(2, 2))
        whole = first @ acceleration + np.einsum("ijk,j,k->i", second, rate, rate)
        leg = engine(G1, names, q, first @ rate)
        free = leg.along(foot)
        pairs = (
            (first, leg.along([0, 1])),
            (leg.rows @ whole, -leg.curving),
            (inertia, free.T @ np.diag(armatures) @ free),
            (first.T @ (leg.mass @ whole + leg.bias), leg.forces([0, 1], acceleration)),
        )
        off = [np.abs(mine - other).max() / np.abs(other).max() for mine, other in pairs]
        found = np.maximum(found, off)
    return found
