"""Robots of files against data of their own: the real models with their JSON, and displacements by
products of exponentials.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from helpers.inside import (
    Closed,
    ClosingJoint,
    Rank,
    Robot,
    RobotJoint,
    Tree,
    exponential,
    levenberg_marquardt,
    prismatic_screw,
    quaternion_from_axis_angle,
    revolute_screw,
)
from symkin import Joint, LinkJoint, Pose

MODELS = Path(__file__).resolve().parent.parent / "data" / "models"
ROBOTS = sorted(path for ending in ("xml", "urdf", "sdf") for path in MODELS.glob(f"*/*.{ending}"))
"""The real models."""
CLOSED = 1e-10
"""Of the size: what closed loops are open by."""
LARGEST = [path for path in ROBOTS if path.stem == "strandbeest"]
"""Those that take seconds to load."""


def robot_of(
    name: str,
    links: Mapping[str, Pose],
    joints: Sequence[LinkJoint],
    closures: Sequence[ClosingJoint] = (),
    **more: Any,
) -> Robot:
    """A robot of joints in the base frame, whose links have frames there."""
    still = (1.0, 0.0, 0.0, 0.0)
    told = [_told(links, e, [Pose.from_quaternion(e.joint.point, still)] * 2) for e in joints]
    told += [replace(_told(links, e, e.frames), closing=True, where=e.where) for e in closures]
    return Robot(name, [*links], "base", told, root_frame=links["base"], **more)


def _told(links: Mapping[str, Pose], entry: LinkJoint, frames: Sequence[Pose]) -> RobotJoint:
    own = {key: getattr(entry.joint, key) for key in ("pitch", "limits", "motor", "actuated")}
    ends = [{**links, "base": Pose.identity()}[link] for link in entry.links]
    first, second = (end.inverse() @ frame for end, frame in zip(ends, frames, strict=True))
    axis, axis2 = (
        None if a is None else tuple(frames[0].inverse().turn(np.array(a)))
        for a in (entry.joint.axis, entry.joint.axis2)
    )
    joint, pair = entry.joint, (entry.links[0], entry.links[1])
    return RobotJoint(
        joint.name, joint.type, pair, (first, second), axis, axis2, value=joint.zero, **own
    )


def facts(model: str) -> dict[str, Any]:
    """The JSON beside a real model."""
    return dict(json.loads((MODELS / f"{model}.json").read_text(encoding="utf-8")))


def told_poses(data: Mapping[str, Any], robot: Robot) -> dict[str, Pose]:
    """The body poses of a JSON, under the robot's names for its links; the root is the base."""
    root = next(iter(data["body_poses"]))
    names = {root: "base"}
    return {
        names.get(body, body): Pose(
            np.array(pose["p"]), np.array(pose["q"]) / np.linalg.norm(pose["q"])
        )
        for body, pose in data["body_poses"].items()
    }


def all_frames(robot: Robot) -> dict[str, tuple[str, Pose]]:
    """Every link and every merged one: the link that moves it, and its pose at the file's
    configuration.
    """
    return robot.frames


def joint_misfit(joint: Joint, moved: Pose) -> float:
    """How far a displacement of the second link against the first is from being one of the joint's
    own.
    """
    point = np.array(joint.point)
    turn, gap = np.asarray(moved.rotation), np.asarray(moved.apply(point)) - point
    axis = None if joint.axis is None else np.array(joint.axis)
    if joint.type == "S":
        return float(np.linalg.norm(gap))
    if joint.type == "weld":
        return float(np.linalg.norm(gap)) + float(np.linalg.norm(turn - np.eye(3)))
    assert axis is not None
    off_axis = float(np.linalg.norm(turn @ axis - axis))
    match joint.type:
        case "R":
            return float(np.linalg.norm(gap)) + off_axis
        case "P":
            return float(np.linalg.norm(turn - np.eye(3))) + float(
                np.linalg.norm(np.cross(gap, axis))
            )
        case "H":
            angle = 2.0 * np.arctan2(
                np.asarray(moved.quaternion)[1:] @ axis, np.asarray(moved.quaternion)[0]
            )
            turns = (gap @ axis) / joint.pitch - angle / (2 * np.pi)
            return float(np.linalg.norm(np.cross(gap, axis))) + off_axis + abs(turns - round(turns))
        case "U":
            assert joint.axis2 is not None
            return float(np.linalg.norm(gap)) + abs(
                float(axis @ (turn @ np.array(joint.axis2)) - axis @ np.array(joint.axis2))
            )
    raise AssertionError(joint.type)


def closure_misfit(closure: ClosingJoint, moved: Mapping[str, Pose]) -> float:
    """How far a closure is from being closed where the links are displaced so."""
    first, second = (
        moved[link] @ frame for link, frame in zip(closure.links, closure.frames, strict=True)
    )
    gap = float(np.linalg.norm(np.asarray(second.position) - np.asarray(first.position)))
    a, b = np.asarray(first.rotation), np.asarray(second.rotation)
    between = np.asarray(second.position) - np.asarray(first.position)
    tilt = float(np.linalg.norm(b[:, 2] - a[:, 2]))
    off = float(np.linalg.norm(np.cross(between, a[:, 2])))
    match closure.joint.type:
        case "S":
            return gap
        case "R":
            return gap + tilt
        case "U":
            return gap + abs(float(a[:, 2] @ b[:, 0]))
        case "C":
            return off + tilt
        case "P":
            return off + float(np.linalg.norm(b - a))
        case "weld":
            return gap + float(np.linalg.norm(b - a))
        case "H":
            angle = np.arctan2(a[:, 1] @ b[:, 0], a[:, 0] @ b[:, 0])
            turns = between @ a[:, 2] / closure.joint.pitch - angle / (2 * np.pi)
            return off + tilt + abs(turns - round(turns))
    raise AssertionError(closure.joint.type)


def displaced(robot: Robot, values: Mapping[str, Any]) -> dict[str, Pose]:
    """The displacement of every link from the file's configuration, for values of the tree's joints
    (a quaternion for S).
    """
    moved = {"base": Pose.identity()}
    waiting = list(robot.tree)
    while waiting:
        entry = next(e for e in waiting if moved.keys() & set(e.links))
        waiting.remove(entry)
        first, second = entry.links
        between = displacement(entry.joint, values[entry.joint.name])
        if first in moved:
            moved[second] = moved[first] @ between
        else:
            moved[first] = moved[second] @ between.inverse()
    return moved


def displacement(joint: Joint, value: Any) -> Pose:
    """What a joint does at a value: R, P and H a number, U two, S a quaternion."""
    point = np.array(joint.point)
    axis, axis2 = (
        np.array(a if a is not None else (0.0, 0.0, 1.0)) for a in (joint.axis, joint.axis2)
    )
    match joint.type:
        case "P":
            return exponential(prismatic_screw(axis), value)
        case "U":
            turns = (
                quaternion_from_axis_angle(axis, value[0]),
                quaternion_from_axis_angle(axis2, value[1]),
            )
            first, second = (Pose(point, q) @ Pose(-point, np.array([1.0, 0, 0, 0])) for q in turns)
            return first @ second
        case "S":
            return Pose(point, np.array(value)) @ Pose(-point, np.array([1.0, 0, 0, 0]))
        case _:
            return exponential(revolute_screw(point, axis, joint.pitch), value)


def poses_at(robot: Robot, values: Mapping[str, Any]) -> dict[str, Pose]:
    """The frame of every link and merged body in the base frame."""
    moved = displaced(robot, values)
    return {name: moved[link] @ pose for name, (link, pose) in all_frames(robot).items()}


def rank_at(tree: Tree, state: np.ndarray, share: float = 1e-8) -> int:
    """Rank of the derivative of all closures and couplings, lengths and angles times the size
    alike.
    """
    return Rank.of(tree.constraints.linearise_one(state)[1], share).value


def closed_neighbours(closed: Closed, count: int, seed: int, step: float = 0.1) -> list[np.ndarray]:
    """Configurations, closed as well as another one, from random steps off it; those searches that
    stay open are left out.
    """
    tree, rng = closed.tree, np.random.default_rng(seed)
    steps = step * tree.size * rng.normal(size=(count, tree.freedom))
    begun = tree.system.move(np.tile(closed.state, (count, 1)), steps)
    batch = levenberg_marquardt(
        tree.system, begun, np.zeros(0), tolerance=1e-14, max_iterations=300
    )
    bound = max(CLOSED * tree.size, closed.residual)
    ends = tree.system.polish_many(batch.points).points
    return [end for end in ends if max(tree.misfits(end).values(), default=0.0) <= bound]
