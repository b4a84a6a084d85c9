"""An account of SDF files of its own, by maximal coordinates: where links are, and the mobility of
joints between free bodies.

It reads plain files: one model, poses and axes by the version's rules, gears, no includes, mimics
or models in models.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from helpers.inside import Robot, Tree
from helpers.robot_files import rank_at
from oracle.robot_twins import DisagreementError

_POSE = 1e-9
_RANK = 1e-9
_FREE = {
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "screw": 1,
    "universal": 2,
    "revolute2": 2,
    "ball": 3,
    "fixed": 0,
    "gearbox": 5,
}


class NotPlainError(Exception):
    """A file that this account does not read."""


def sdf_agreement(path: Path, robot: Robot) -> str:
    """Compare poses and mobility at the file's configuration. Raises DisagreementError."""
    try:
        account = _Plain(ElementTree.parse(path).getroot())
        poses = account.poses()
    except (NotPlainError, KeyError, AttributeError, ValueError) as reason:
        return f"no plain SDF ({reason})"
    frames = {name: pose for name, (_, pose) in robot.frames.items()}
    ours = {
        name: _matrix(np.asarray(pose.rotation), np.asarray(pose.position))
        for name, pose in frames.items()
    }
    common = [name for name in ours if name in poses and name != "base"]
    for name in common[1:]:
        first = common[0]
        apart = np.linalg.inv(ours[first]) @ ours[name] - np.linalg.inv(poses[first]) @ poses[name]
        if np.abs(apart).max() > _POSE * max(1.0, np.abs(poses[name]).max()):
            raise DisagreementError(
                f"{name} is {np.abs(apart).max():.2g} from where the plain account has it"
            )
    if len(robot.couplings) != sum(
        joint.attrib["type"] == "gearbox" for joint in account.joints.values()
    ):
        return f"as the plain account: {len(common)} poses"
    tree = Tree(robot)
    mobility = tree.freedom - rank_at(tree, tree.own)
    theirs = account.mobility(poses)
    if theirs is not None and theirs != mobility:
        raise DisagreementError(f"the mobility is {mobility}, and {theirs} by the plain account")
    return (
        f"as the plain account: {len(common)} "
        f"poses{'' if theirs is None else f', mobility {theirs}'}"
    )


class _Plain:
    """One model: links, frames and joints by name."""

    def __init__(self, root: ElementTree.Element) -> None:
        major, minor = root.attrib["version"].split(".")[:2]
        self.version = (int(major), int(minor))
        models = [model for model in root.iter("model") if model.find("joint") is not None]
        if len(models) != 1:
            raise NotPlainError(f"{len(models)} models")
        (self.model,) = models
        if self.model.find("include") is not None or self.model.find("model") is not None:
            raise NotPlainError("models in models")
        self.links = {
            link.attrib["name"]: link
            for link in self.model.findall("link")
            if link.attrib["name"] != "world"
        }
        self.frames = (
            {frame.attrib["name"]: frame for frame in self.model.findall("frame")}
            if self.version >= (1, 7)
            else {}
        )
        self.joints = {joint.attrib["name"]: joint for joint in self.model.findall("joint")}
        if any(joint.attrib["type"] not in _FREE for joint in self.joints.values()):
            raise NotPlainError("joints of other types")
        self.own = _pose(self.model.find("pose"))[0]

    @property
    def on_world(self) -> bool:
        return any(self._link(_text(joint, "parent")) == "world" for joint in self.joints.values())

    def poses(self) -> dict[str, np.ndarray]:
        return {name: self._at(name) for name in self.links}

    def mobility(self, poses: dict[str, np.ndarray]) -> int | None:
        """Freedoms of all bodies less the rank of what joints forbid; None where a part hangs on
        nothing.
        """
        bodies = [*poses, "world"] if self.on_world else list(poses)
        solid = [j for j in self.joints.values() if j.attrib["type"] != "gearbox"]
        ends = [(self._link(_text(j, "parent")), self._link(_text(j, "child"))) for j in solid]
        held = "world" if self.on_world else bodies[0]
        reached = {held}
        while more := {b for pair in ends for b in pair if set(pair) & reached} - reached:
            reached |= more
        if set(bodies) - reached:
            return None
        place = {body: k for k, body in enumerate(b for b in bodies if b != held)}
        rows = []
        for name, joint in self.joints.items():
            parts = (
                self._gear(name, joint)
                if joint.attrib["type"] == "gearbox"
                else self._both_ends(name, joint)
            )
            row = np.zeros((len(parts[0][1]), 6 * len(place)))
            for body, block in parts:
                if body != held:
                    row[:, 6 * place[body] : 6 * place[body] + 6] += block
            rows.append(row)
        s = np.linalg.svd(np.concatenate(rows), compute_uv=False)
        return 6 * len(place) - int(np.sum(s > _RANK * s[0]))

    def _both_ends(self, name: str, joint: ElementTree.Element) -> list[tuple[str, np.ndarray]]:
        """What a joint holds at 0, by the twists of its links."""
        forbidden = self._forbidden(name, joint)
        return [
            (self._link(_text(joint, "parent")), -forbidden),
            (self._link(_text(joint, "child")), forbidden),
        ]

    def _gear(self, name: str, joint: ElementTree.Element) -> list[tuple[str, np.ndarray]]:
        """theta_2 = -ratio theta_1, the angles of child and parent against the reference body about
        axis2 and axis.
        """
        at, ratio = self._at(name), float(_text(joint, "gearbox_ratio"))
        first, second = (
            np.concatenate([self._axis(joint, tag, at), np.zeros(3)])[None]
            for tag in ("axis", "axis2")
        )
        parent, child, reference = (
            self._link(_text(joint, tag)) for tag in ("parent", "child", "gearbox_reference_body")
        )
        return [(child, second), (parent, ratio * first), (reference, -second - ratio * first)]

    def _forbidden(self, name: str, joint: ElementTree.Element) -> np.ndarray:
        """Rows on the relative twist (turn; velocity at the origin) that a joint holds at 0."""
        at = self._at(name)
        kind = joint.attrib["type"]
        if kind == "fixed":
            return np.eye(6)
        point = at[:3, 3]
        if kind == "ball":
            free = [np.concatenate([axis, np.cross(point, axis)]) for axis in np.eye(3)]
        else:
            axes = [self._axis(joint, tag, at) for tag in ("axis", "axis2")[: _FREE[kind]]]
            free = [np.concatenate([axis, np.cross(point, axis)]) for axis in axes]
            if kind == "prismatic":
                free = [np.concatenate([np.zeros(3), axes[0]])]
            if kind == "screw":
                free[0][3:] += axes[0] * _lead(joint)
        _, s, vt = np.linalg.svd(np.array(free))
        return vt[int(np.sum(s > 1e-9)) :]

    def _axis(self, joint: ElementTree.Element, tag: str, at: np.ndarray) -> np.ndarray:
        axis = joint.find(tag)
        assert axis is not None
        xyz = axis.find("xyz")
        assert xyz is not None
        vector = np.array([float(c) for c in (xyz.text or "").split()])
        flag = (axis.findtext("use_parent_model_frame") or "0").strip() in ("1", "true")
        if self.version >= (1, 7):
            frame = self._at(xyz.attrib["expressed_in"]) if "expressed_in" in xyz.attrib else at
        else:
            frame = self.own if flag or self.version < (1, 5) else at
        turned = frame[:3, :3] @ vector
        return np.asarray(turned / np.linalg.norm(turned))

    def _link(self, name: str) -> str:
        while name in self.frames and name not in self.links:
            name = self.frames[name].attrib.get("attached_to") or next(iter(self.links))
        if name in self.joints and name not in self.links:
            return self._link(_text(self.joints[name], "child"))
        return next(iter(self.links)) if name == "__model__" else name

    def _at(self, name: str) -> np.ndarray:
        if name == "world":
            return np.eye(4)
        if name == "__model__":
            return self.own
        found = self.links.get(name)
        default = "__model__"
        if found is None and name in self.frames:
            found = self.frames[name]
            default = found.attrib.get("attached_to") or "__model__"
        elif found is None:
            found = self.joints[name]
            default = _text(found, "child")
        pose, told_in = _pose(found.find("pose"))
        return self._at(told_in or default) @ pose


def _lead(joint: ElementTree.Element) -> float:
    new = joint.findtext("screw_thread_pitch")
    return (
        float(new) / (2 * np.pi)
        if new is not None
        else -1.0 / float(joint.findtext("thread_pitch") or "nan")
    )


def _text(element: ElementTree.Element, tag: str) -> str:
    return (element.findtext(tag) or "").strip()


def _pose(element: ElementTree.Element | None) -> tuple[np.ndarray, str | None]:
    if element is None or not (element.text or "").strip():
        return np.eye(4), None if element is None else element.attrib.get("relative_to") or None
    if "rotation_format" in element.attrib or "degrees" in element.attrib:
        raise NotPlainError("poses in other numbers")
    x, y, z, roll, pitch, yaw = (float(c) for c in (element.text or "").split())
    turn = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
    return _matrix(turn, np.array([x, y, z])), element.attrib.get("relative_to") or None


def _about(axis: int, angle: float) -> np.ndarray:
    turn, (i, j) = np.eye(3), [k for k in range(3) if k != axis]
    turn[i, i] = turn[j, j] = np.cos(angle)
    turn[i, j], turn[j, i] = (
        (np.sin(angle), -np.sin(angle)) if axis == 1 else (-np.sin(angle), np.sin(angle))
    )
    return turn


def _matrix(turn: np.ndarray, position: np.ndarray) -> np.ndarray:
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = turn, position
    return found
