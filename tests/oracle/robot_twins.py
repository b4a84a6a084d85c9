"""What MuJoCo and Pinocchio say of a file, against what symkin read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from helpers.inside import BASE, FILE_DIGITS, Robot, Tree, nearest_closed
from helpers.robot_files import rank_at
from symkin import Pose

_POSE = 1e-9
"""Of the size, and of turns: what poses may differ by."""
_STEP = 0.3
"""Radians, or share of the size: the random step of each joint of the tree."""


class DisagreementError(Exception):
    """A file that another tool reads otherwise."""


def poses_at(tree: Tree, state: np.ndarray) -> dict[str, Pose]:
    """Links by name, and bodies on fixed joints."""
    placed, robot = tree.displacements(state), tree.robot
    return {name: placed[link] @ frame for name, (link, frame) in robot.frames.items()}


def random_state(tree: Tree) -> np.ndarray:
    """The tree's own state after a random step of every freedom."""
    step = _STEP * tree.size * np.random.default_rng(0).normal(size=(1, tree.freedom))
    return np.asarray(tree.system.move(tree.own[None], step)[0])


def _compare(where: str, size: float, ours: Mapping[str, Pose], theirs: Mapping[str, Pose]) -> int:
    """How many poses were compared. Raises DisagreementError for the first pair that differs."""
    count = 0
    # the root is the link "base" here, whatever it is called in the file
    for name in (ours.keys() & theirs.keys()) - {BASE}:
        away = float(
            np.linalg.norm(np.asarray(ours[name].position) - np.asarray(theirs[name].position))
        )
        turned = float(
            np.linalg.norm(np.asarray(ours[name].rotation) - np.asarray(theirs[name].rotation))
        )
        if away > _POSE * max(size, 1.0) or turned > 10 * _POSE:
            raise DisagreementError(
                f"{where}: {name} is {away:.2g} m and {turned:.2g} rad from where the other tool "
                f"has it"
            )
        count += 1
    return count


# --- MuJoCo ---------------------------------------------------------------------------------------


def mujoco_agreement(path: Path, robot: Robot) -> str:
    """Compare an MJCF file with MuJoCo. Raises DisagreementError."""
    import mujoco

    model = _model(mujoco, path)
    tree = Tree(robot)
    numbers = _tree_joints(mujoco, model, robot)
    qpos0 = _held_at(mujoco, model)
    compared = 0
    for where, state in (
        ("at the file's configuration", tree.own),
        ("at a random configuration", random_state(tree)),
    ):
        data = _data_at(mujoco, model, qpos0, numbers, tree, state)
        compared += _compare(where, tree.size, poses_at(tree, state), _bodies(model, data))
    closed = nearest_closed(robot)
    if not closed.to_digits:
        return f"as MuJoCo: {compared} poses"
    data = _data_at(mujoco, model, qpos0, numbers, tree, closed.state)
    errors, jacobian = _equality_rows(mujoco, model, data)
    columns = _columns(mujoco, model, numbers, robot)
    s = (
        np.linalg.svd(jacobian[:, columns], compute_uv=False)
        if columns and len(errors)
        else np.zeros(0)
    )
    ours = rank_at(closed.tree, closed.state, 1e-8 if closed.closed else FILE_DIGITS)
    theirs = int(np.sum(s > (1e-8 if closed.closed else FILE_DIGITS) * max(s[:1], default=0.0)))
    open_by = float(np.abs(errors).max(initial=0.0))
    if open_by > max(1e-8, 10.0 * closed.residual) * max(closed.tree.size, 1.0):
        raise DisagreementError(
            f"at the closed configuration a constraint of MuJoCo is open by {open_by:.2g}"
        )
    if ours != theirs:
        raise DisagreementError(f"the rank is {ours}, and {theirs} by MuJoCo")
    return f"as MuJoCo: {compared} poses, {len(errors)} rows"


def _model(mujoco: Any, path: Path) -> Any:
    """The compiled model; without geoms, meshes and textures where files of them are missing."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        spec = mujoco.MjSpec.from_file(str(path))
        for geom in spec.geoms:
            geom.type, geom.size, geom.meshname, geom.material = (
                mujoco.mjtGeom.mjGEOM_SPHERE,
                [1e-3] * 3,
                "",
                "",
            )
            geom.hfieldname, geom.fromto = "", [np.nan] * 6
        for entry in (*spec.sites, *spec.tendons):
            entry.material = ""
        for entries in (
            spec.meshes,
            spec.textures,
            spec.materials,
            spec.hfields,
            spec.skins,
            spec.keys,
            spec.sensors,
            spec.pairs,
            spec.excludes,
        ):
            for entry in list(entries):
                spec.delete(entry)
        for body in spec.bodies:
            body.explicitinertial, body.mass, body.inertia, body.fullinertia = (
                True,
                1.0,
                [1.0] * 3,
                [np.nan] * 6,
            )
        spec.compiler.fusestatic = False
        model = spec.compile()
    for flag in ("CONTACT", "LIMIT", "FRICTIONLOSS"):
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    return model


def _held(mujoco: Any, model: Any) -> dict[int, float]:
    """Joints that an active equality holds, with their values."""
    kind = int(mujoco.mjtEq.mjEQ_JOINT)
    held = [
        k
        for k in range(model.neq)
        if model.eq_active0[k] and int(model.eq_type[k]) == kind and model.eq_obj2id[k] < 0
    ]
    return {
        int(j := model.eq_obj1id[k]): float(model.qpos0[model.jnt_qposadr[j]] + model.eq_data[k][0])
        for k in held
    }


def _held_at(mujoco: Any, model: Any) -> np.ndarray:
    qpos = np.array(model.qpos0)
    for joint, value in _held(mujoco, model).items():
        qpos[model.jnt_qposadr[joint]] = value
    return qpos


def _tree_joints(mujoco: Any, model: Any, robot: Robot) -> list[int]:
    """MuJoCo's joints of the robot's tree, in order. Raises DisagreementError where their count or
    types differ.
    """
    held, free = _held(mujoco, model), int(mujoco.mjtJoint.mjJNT_FREE)
    numbers = [j for j in range(model.njnt) if j not in held and int(model.jnt_type[j]) != free]
    kinds = {"mjJNT_HINGE": "R", "mjJNT_SLIDE": "P", "mjJNT_BALL": "S"}
    theirs = [kinds[mujoco.mjtJoint(int(model.jnt_type[j])).name] for j in numbers]
    if theirs != [entry.joint.type for entry in robot.tree]:
        raise DisagreementError(
            f"{len(robot.tree)} joints were read; MuJoCo has {len(theirs)}, or of other types"
        )
    return numbers


def _data_at(
    mujoco: Any, model: Any, qpos0: np.ndarray, numbers: list[int], tree: Tree, state: np.ndarray
) -> Any:
    start, data = mujoco.MjData(model), mujoco.MjData(model)
    start.qpos[:] = qpos0
    mujoco.mj_kinematics(model, start)
    data.qpos[:] = qpos0
    values = tree.by_name(state)
    for number, entry in zip(numbers, tree.robot.tree, strict=True):
        value, place = values[entry.joint.coordinates[0].name], int(model.jnt_qposadr[number])
        if len(value) == 1:
            data.qpos[place] = value[0]
            continue
        turn = Pose.from_quaternion(
            (0.0, 0.0, 0.0), tuple(start.xquat[int(model.jnt_bodyid[number])])
        )
        moved = turn.inverse() @ Pose.from_quaternion((0.0, 0.0, 0.0), tuple(value)) @ turn
        own = Pose.from_quaternion((0.0, 0.0, 0.0), tuple(qpos0[place : place + 4]))
        data.qpos[place : place + 4] = (own @ moved).quaternion
    placed = tree.displacements(state)
    for j in range(model.njnt):
        name = model.body(int(model.jnt_bodyid[j])).name
        if (
            int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_FREE)
            and name in tree.robot.floating
        ):
            pose, place = (
                placed[name] @ tree.robot.links[name],
                int(model.jnt_qposadr[j]),
            )
            data.qpos[place : place + 7] = [*pose.position, *pose.quaternion]
    mujoco.mj_forward(model, data)
    return data


def _bodies(model: Any, data: Any) -> dict[str, Pose]:
    named = {model.body(b).name: b for b in range(1, model.nbody)}
    return {
        name: Pose.from_quaternion(tuple(data.xpos[b]), tuple(data.xquat[b]))
        for name, b in named.items()
        if name
    }


def _equality_rows(mujoco: Any, model: Any, data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Violations and Jacobian of the equality constraints but those on mocap bodies and those that
    hold one joint.
    """
    count, nv = int(data.nefc), int(model.nv)
    jacobian = np.zeros((count, nv))
    if mujoco.mj_isSparse(model):
        mujoco.mju_sparse2dense(
            jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind
        )
    else:
        jacobian = np.asarray(data.efc_J)[: count * nv].reshape(count, nv)
    rows = np.asarray(data.efc_type[:count]) == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    kept = [k for k in np.flatnonzero(rows) if not _on_mocap(mujoco, model, int(data.efc_id[k]))]
    return np.asarray(data.efc_pos[:count])[kept], jacobian[kept]


def _on_mocap(mujoco: Any, model: Any, equality: int) -> bool:
    if int(model.eq_type[equality]) not in (
        int(mujoco.mjtEq.mjEQ_CONNECT),
        int(mujoco.mjtEq.mjEQ_WELD),
    ):
        return False
    ends = [int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])]
    if int(model.eq_objtype[equality]) == int(mujoco.mjtObj.mjOBJ_SITE):
        ends = [int(model.site_bodyid[end]) for end in ends]
    return any(model.body_mocapid[max(end, 0)] >= 0 for end in ends)


def _columns(mujoco: Any, model: Any, numbers: list[int], robot: Robot) -> list[int]:
    """Freedoms that the robot has, too."""
    found = []
    for j in range(model.njnt):
        free = int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_FREE)
        if j in numbers or (free and model.body(int(model.jnt_bodyid[j])).name in robot.floating):
            width = {"mjJNT_FREE": 6, "mjJNT_BALL": 3}.get(
                mujoco.mjtJoint(int(model.jnt_type[j])).name, 1
            )
            found += list(range(int(model.jnt_dofadr[j]), int(model.jnt_dofadr[j]) + width))
    return found


# --- Pinocchio ------------------------------------------------------------------------------------


def pinocchio_agreement(path: Path, robot: Robot) -> str:
    """Compare the tree of a URDF file with Pinocchio, where that reads it. Raises
    DisagreementError.
    """
    import pinocchio

    try:
        model = pinocchio.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        return f"Pinocchio does not read it ({' '.join(str(error).split())[:80]})"
    tree = Tree(robot)
    states = [("at 0", tree.own)]
    simple = all(model.joints[k].nv == 1 for k in range(1, model.njoints))
    same = {entry.joint.name for entry in robot.tree if entry.joint.type in ("R", "P")} == set(
        list(model.names)[1:]
    )
    if simple and same:
        states.append(("at a random configuration", random_state(tree)))
    compared = 0
    for where, state in states:
        compared += _compare(
            where, tree.size, poses_at(tree, state), _frames(pinocchio, model, tree, state)
        )
    return f"as Pinocchio: {compared} poses{'' if len(states) == 2 else ', at 0 only'}"


def _frames(pinocchio: Any, model: Any, tree: Tree, state: np.ndarray) -> dict[str, Pose]:
    """Poses of links by their names."""
    values = tree.by_name(state)
    q = pinocchio.neutral(model)
    for number in range(1, model.njoints):
        name, joint = model.names[number], model.joints[number]
        if joint.nv == 1 and len(values.get(name, ())) == 1:
            angle = float(values[name][0])
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            )
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    found = {}
    for k, frame in enumerate(model.frames):
        if frame.type == pinocchio.FrameType.BODY:
            found[frame.name] = Pose.from_matrix(data.oMf[k].rotation, data.oMf[k].translation)
    return found
