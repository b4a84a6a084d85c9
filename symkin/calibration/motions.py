"""Changes of the parameters that are known to mean nothing, as directions in parameter space.

Moving the base frame or the platform frame, stretching everything, shifting a joint's point along its axis: each is a
velocity of every parameter of the mechanism. A direction that lies in the null space of the identification Jacobian is
what the readings cannot tell, and has a name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from symkin.calibration.model import PostureModel
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import multiply, rotate

_AXES = ("x", "y", "z")
_TURNS = ("roll (about x)", "pitch (about y)", "yaw (about z)")
Velocity = dict[str, float]
"""Velocity of parameters by name; what is not named stays."""


def named_motions(model: PostureModel, p: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """(name, scaled direction over the model's parameters) of every known change at p, most telling first. A change
    that would need a parameter that is held is left out."""
    values = dict(zip(model.names, p, strict=True))
    nominal = _nominal(model)
    for name, velocity in _all(model.mechanism, nominal | values):
        moved = {k: v for k, v in velocity.items() if abs(v) > 1e-14}
        if not moved or any(k not in values for k in moved):
            continue
        direction = np.array([moved.get(n, 0.0) for n in model.names]) / model.scales
        yield name, direction / np.linalg.norm(direction)


def _nominal(model: PostureModel) -> Velocity:
    from symkin.model.closure import build_closure

    closure = build_closure(model.mechanism)
    table = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    for c in model.mechanism.actuated:
        table[f"{c.name}.scale"] = 1.0
    return table


def _all(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    if mechanism.dh is None:
        yield from _frames(mechanism, values)
    yield from _local(mechanism, values)
    yield from _measuring(mechanism, values)
    yield "size of the whole mechanism", _stretched(mechanism, values)
    scales = {n: v for n, v in values.items() if n.endswith(".scale")}
    lengths = {f"{c.name}.scale": 1.0 for c in mechanism.actuated if not c.is_angular}
    if scales and lengths:
        yield "size of the whole mechanism with the factors of all length readings", _stretched(mechanism, values) | lengths


# --- frames --------------------------------------------------------------------------------------------------------


def _frames(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    for frame, move in (("base frame", _base_moved), ("platform frame", _platform_moved)):
        label = frame if frame == "base frame" or not mechanism.serial else "tool frame"
        for k, axis in enumerate(_AXES):
            yield f"{label} translation {axis}", move(mechanism, values, np.eye(3)[k], np.zeros(3))
        for k, turn in enumerate(_TURNS):
            text = turn if frame == "base frame" else f"rotation about {_AXES[k]}"
            yield f"{label} {text}", move(mechanism, values, np.zeros(3), np.eye(3)[k])


def _measuring(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    """The frame that readings are taken in, moved against the frame of the mechanism that it is fixed to."""
    if mechanism.dh is not None:
        return
    for k, axis in enumerate(_AXES):
        for what, t, w in (("position", np.eye(3)[k], np.zeros(3)), ("rotation", np.zeros(3), np.eye(3)[k])):
            base, platform = _base_moved(mechanism, values, t, w), _platform_moved(mechanism, values, t, w)
            yield f"world frame {what} {axis} with the base frame", base | {f"world.{what}.{axis}": -1.0}
            yield f"target frame {what} {axis} with the platform frame", platform | {f"target.{what}.{axis}": -1.0}


def _base_moved(mechanism: Mechanism, values: Mapping[str, float], t: np.ndarray, w: np.ndarray) -> Velocity:
    """Everything given in the base frame moves by the twist (t, w)."""
    velocity: Velocity = {}

    def point(path: str) -> None:
        _put(velocity, path, t + np.cross(w, _get(values, path)))

    def direction(path: str) -> None:
        _put(velocity, path, np.cross(w, _get(values, path)))

    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            point(f"{limb.name}.base")
            continue
        _each_joint(mechanism, limb, point, direction)
        for k in range(1, len(limb.rods) + 1):
            point(f"{limb.name}.rod{k}.from")
    frame = "tool" if mechanism.serial else "platform"
    if f"{frame}.position.x" in values or f"{frame}.quaternion.w" in values:
        _put(velocity, f"{frame}.position", t + np.cross(w, _get(values, f"{frame}.position")))
        q = _get(values, f"{frame}.quaternion", "wxyz")
        _put(velocity, f"{frame}.quaternion", 0.5 * np.asarray(multiply(np.array([0.0, *w]), q)), "wxyz")
    return {k: v for k, v in velocity.items() if k in values or abs(v) > 1e-14}


def _platform_moved(mechanism: Mechanism, values: Mapping[str, float], t: np.ndarray, w: np.ndarray) -> Velocity:
    """The platform frame moves by the twist (t, w) in its own axes; what is given in it moves the other way."""
    velocity: Velocity = {}
    for limb in mechanism.limbs:
        paths = [f"{limb.name}.platform"] if isinstance(limb, RodLimb) else []
        if isinstance(limb, Limb):
            paths = [f"{limb.name}.rod{k}.platform" for k in range(1, len(limb.rods) + 1)]
        for path in paths:
            _put(velocity, path, -(t + np.cross(w, _get(values, path))))
    frame = "tool" if mechanism.serial else "platform"
    if f"{frame}.position.x" in values or f"{frame}.quaternion.w" in values:
        q = _get(values, f"{frame}.quaternion", "wxyz")
        _put(velocity, f"{frame}.position", np.asarray(rotate(q / np.linalg.norm(q), t)))
        _put(velocity, f"{frame}.quaternion", 0.5 * np.asarray(multiply(q, np.array([0.0, *w]))), "wxyz")
    return velocity


def _stretched(mechanism: Mechanism, values: Mapping[str, float]) -> Velocity:
    """Every length grows in proportion."""
    turning = {j.name for _, j in mechanism.joints if j.type in ("R", "H")}

    def is_length(name: str) -> bool:
        pieces = name.split(".")
        if pieces[-1] == "zero":
            return pieces[-2] not in turning
        if pieces[-1] in ("theta", "alpha", "scale") or pieces[0] in ("world", "target"):
            return False
        return pieces[-2] not in ("axis", "axis2", "quaternion")

    return {name: value for name, value in values.items() if is_length(name)}


# --- single joints -------------------------------------------------------------------------------------------------


def _local(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    """Freedoms in how a joint is written down: where on its axis its point lies, the length of a direction."""
    for limb, joint in mechanism.joints:
        path = joint.name if mechanism.serial else f"{limb.name}.{joint.name}"
        if joint.type == "P":
            for k, axis in enumerate(_AXES):
                yield f"point {axis} of prismatic joint {path}", _vector(f"{path}.point", np.eye(3)[k])
        elif joint.type in ("R", "H", "C"):
            yield f"point of {path} along its axis", _vector(f"{path}.point", _get(values, f"{path}.axis"))
        for key in ("axis", "axis2"):
            if getattr(joint, key) is not None:
                yield f"length of the vector {path}.{key}", _vector(f"{path}.{key}", _get(values, f"{path}.{key}"))
        if joint.freedom == 1 and not joint.actuated:
            yield f"zero of passive joint {path}", {f"{path}.zero": 1.0}
    frame = "tool" if mechanism.serial else "platform"
    if f"{frame}.quaternion.w" in values:
        q = _get(values, f"{frame}.quaternion", "wxyz")
        yield f"length of {frame}.quaternion", _vector(f"{frame}.quaternion", q, "wxyz")


def _each_joint(mechanism: Mechanism, limb: Limb, point: Callable[[str], None], direction: Callable[[str], None]) -> None:
    joints: list[Joint] = list(limb.joints)
    for joint in joints:
        path = joint.name if mechanism.serial else f"{limb.name}.{joint.name}"
        point(f"{path}.point")
        for key in ("axis", "axis2"):
            if getattr(joint, key) is not None:
                direction(f"{path}.{key}")


def _get(values: Mapping[str, float], path: str, letters: str = "xyz") -> np.ndarray:
    return np.array([values.get(f"{path}.{k}", 0.0) for k in letters])


def _put(velocity: Velocity, path: str, value: np.ndarray, letters: str = "xyz") -> None:
    velocity.update(_vector(path, value, letters))


def _vector(path: str, value: np.ndarray, letters: str = "xyz") -> Velocity:
    return {f"{path}.{k}": float(v) for k, v in zip(letters, value, strict=True)}
