"""Name directions in parameter space along which nothing that is read may change.

Moving the base frame or the platform frame, stretching everything, shifting a joint's point along
its axis, shifting the offsets of parallel axes: each is a velocity of every parameter of the
mechanism. A direction that lies in the null space of the identification Jacobian is what the
readings cannot tell, and has a name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from operator import matmul

import numpy as np

from symkin.calibration.data.observables import observables_named, point_path
from symkin.calibration.data.parameters import (
    AXES,
    MEASURING_FRAMES,
    Velocity,
    geometry_parameters,
    joint_paths,
    nominal_parameters,
    vector_values,
    vector_velocity,
    written_freedoms,
)
from symkin.calibration.data.reference_motions import reference_motions
from symkin.calibration.estimate.configuration_model import ConfigurationModel
from symkin.calibration.estimate.joint_lines import NEARLY_PARALLEL, parallel_axes
from symkin.model.dh import DHTable
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, quaternion_from_rotation_vector, rotate

_TURNS = ("roll (about x)", "pitch (about y)", "yaw (about z)")

_HELD_STILL = 1e-9
"""A change leaves held parameters where they are when they move by less than this share of it."""


def named_motions(model: ConfigurationModel, p: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Yield (name, scaled direction over the model's parameters) of every known change at p, most
    telling first. What a change would need of parameters that are held is made up for by freedoms
    in how the file is written; a change that cannot be so is left out.
    """
    values, read = all_values(model, p), tuple(o.name for o in model.read)
    names, free = list(values), np.isin(list(values), model.names)
    order = [names.index(name) for name in model.names]
    table, size = nominal_parameters(model.mechanism, read), model.closure.characteristic_length
    units = np.array(
        [1.0 if table.get(name, (0.0, "length"))[1] == "length" else size for name in names]
    )

    def row(velocity: Mapping[str, float]) -> np.ndarray:
        return np.asarray(units * np.array([velocity.get(name, 0.0) for name in names]))

    freedoms = [
        (text, row(velocity))
        for text, velocity in _description_freedoms(model.mechanism, values, read)
    ]
    basis = np.array([one for _, one in freedoms]).reshape(-1, len(names)).T
    motions = [
        (text, row(velocity)) for text, velocity in _all_motions(model.mechanism, values, read)
    ]
    for text, direction in (*motions, *freedoms):
        made = direction - basis @ _made_up(basis[~free], direction[~free])
        length = float(np.linalg.norm(made))
        if length > 0.0 and np.linalg.norm(made[~free]) <= _HELD_STILL * length:
            yield text, made[order] / length


def _made_up(held: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Shares of freedoms that move the held parameters as a change does; none where it does not
    move them.
    """
    if not np.any(wanted) or not held.size:
        return np.zeros(held.shape[1])
    return np.asarray(np.linalg.lstsq(held, wanted, rcond=1e-10)[0])


def _description_freedoms(
    mechanism: Mechanism, values: Mapping[str, float], read: Sequence[str]
) -> Iterator[tuple[str, Velocity]]:
    yield from written_freedoms(mechanism, values, read)
    yield from reference_motions(mechanism, values, read)


def all_values(model: ConfigurationModel, p: np.ndarray) -> Velocity:
    """Return the values of all parameters by name: nominal, those of the model's as p has them."""
    return _nominal_values(model) | dict(zip(model.names, map(float, p), strict=True))


def _nominal_values(model: ConfigurationModel) -> Velocity:
    read = tuple(o.name for o in model.read)
    table = {**geometry_parameters(model.mechanism, read)}
    return table | {
        name: value
        for name, (value, _) in nominal_parameters(model.mechanism, read).items()
        if name.endswith(".scale")
    }


def _all_motions(
    mechanism: Mechanism, values: Mapping[str, float], read: tuple[str, ...]
) -> Iterator[tuple[str, Velocity]]:
    if mechanism.dh is None:
        yield from _frames(mechanism, values)
    yield from _measuring(mechanism, values)
    stretched = _stretched(mechanism, values, read)
    yield "size of the whole mechanism", stretched
    lengths = {f"{c.name}.scale": 1.0 for c in mechanism.actuated if not c.is_angular}
    lengths |= {
        f"{o.name}.scale": 1.0
        for o in observables_named(mechanism, read)
        if o.kind == "joint" and not o.angular
    }
    if lengths:
        yield (
            "size of the whole mechanism with the factors of all length readings",
            stretched | lengths,
        )


# --- frames ---------------------------------------------------------------------------------------


def _frames(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    for frame, move in ((BASE, _base_moved), (mechanism.frame_name, _platform_moved)):
        label = f"{frame} frame"
        for k, axis in enumerate(AXES):
            yield f"{label} translation {axis}", move(mechanism, values, np.eye(3)[k], np.zeros(3))
        for k, turn in enumerate(_TURNS):
            text = turn if frame == BASE else f"rotation about {AXES[k]}"
            yield f"{label} {text}", move(mechanism, values, np.zeros(3), np.eye(3)[k])


def _measuring(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    """Move the frame that readings are taken in against the frame of the mechanism that it is fixed
    to; of the target frame also the position alone, which is all that positions determine.
    """
    for text, velocity, (t, w) in (
        *_base_twists(mechanism, values),
        *_platform_twists(mechanism, values),
    ):
        if text.startswith("world"):
            yield text, velocity | _world_moved(values, t, w)
            continue
        moved = _target_moved(values, t, w)
        yield text, velocity | moved
        yield text, velocity | {name: v for name, v in moved.items() if ".position." in name}


_Twisted = tuple[str, Velocity, tuple[np.ndarray, np.ndarray]]
"""Text, velocity of the mechanism's parameters and the twist (t, w) that it gives one of the
mechanism's ends.
"""


def _base_twists(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[_Twisted]:
    if mechanism.dh is not None:
        for key, before, _, (t, w) in _elements(mechanism.dh, values, 1):
            yield f"world frame with dh.1.{key}", {f"dh.1.{key}": 1.0}, _seen(before, t, w)
        return
    for k, axis in enumerate(AXES):
        for what, t, w in (
            ("position", np.eye(3)[k], np.zeros(3)),
            ("rotation", np.zeros(3), np.eye(3)[k]),
        ):
            yield (
                f"world frame {what} {axis} with the base frame",
                _base_moved(mechanism, values, t, w),
                (t, w),
            )


def _platform_twists(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[_Twisted]:
    if mechanism.dh is not None:
        last = len(mechanism.dh.rows)
        for key, _, after, (t, w) in _elements(mechanism.dh, values, last):
            yield (
                f"target frame with dh.{last}.{key}",
                {f"dh.{last}.{key}": 1.0},
                _seen(after.inverse(), t, w),
            )
        return
    for k, axis in enumerate(AXES):
        for what, t, w in (
            ("position", np.eye(3)[k], np.zeros(3)),
            ("rotation", np.zeros(3), np.eye(3)[k]),
        ):
            yield (
                f"target frame {what} {axis} with the platform frame",
                _platform_moved(mechanism, values, t, w),
                (t, w),
            )


def _world_moved(values: Mapping[str, float], t: np.ndarray, w: np.ndarray) -> Velocity:
    """Move the world frame W so that W exp(t, w) stays: the base frame has moved by the twist in
    its own axes.
    """
    r = vector_values(values, "world.rotation")
    turned = rotate(np.asarray(quaternion_from_rotation_vector(r)), t)
    return vector_velocity("world.position", -np.asarray(turned)) | vector_velocity(
        "world.rotation", -_rotation_vector_rate(r, w, 1.0)
    )


def _target_moved(values: Mapping[str, float], t: np.ndarray, w: np.ndarray) -> Velocity:
    """Move the target frame T so that exp(t, w) T stays: the platform frame has moved by the twist
    in its own axes.
    """
    r, p = vector_values(values, "target.rotation"), vector_values(values, "target.position")
    return vector_velocity("target.position", -(t + np.cross(w, p))) | vector_velocity(
        "target.rotation", -_rotation_vector_rate(r, w, -1.0)
    )


def _rotation_vector_rate(r: np.ndarray, w: np.ndarray, side: float) -> np.ndarray:
    """Rate of the rotation vector r at an angular velocity w in the turned axes (side 1) or the
    fixed ones (-1).
    """
    half = 0.5 * float(np.linalg.norm(r))
    if half < 1e-9:
        return w + side * 0.5 * np.cross(r, w)
    axis, share = r / (2.0 * half), half / np.tan(half)
    return np.asarray(
        share * w + (1.0 - share) * axis * (axis @ w) + side * half * np.cross(axis, w)
    )


def _elements(
    table: DHTable, values: Mapping[str, float], number: int
) -> Iterator[tuple[str, Pose, Pose, tuple[np.ndarray, np.ndarray]]]:
    """Yield the four elementary motions of a row: key, what stands before and after it in the row,
    and its twist.
    """
    keys = (
        ("theta", "d", "a", "alpha")
        if table.convention == "standard"
        else ("alpha", "a", "theta", "d")
    )
    axes = {key: np.eye(3)[2 if key in ("theta", "d") else 0] for key in keys}

    def pose(key: str) -> Pose:
        value, axis = values.get(f"dh.{number}.{key}", 0.0), axes[key]
        if key in ("d", "a"):
            return Pose(value * axis, np.array([1.0, 0.0, 0.0, 0.0]))
        return Pose(np.zeros(3), np.asarray(quaternion_from_rotation_vector(value * axis)))

    for k, key in enumerate(keys):
        before, after = (
            reduce(matmul, map(pose, part), Pose.identity()) for part in (keys[:k], keys[k + 1 :])
        )
        yield (
            key,
            before,
            after,
            (axes[key], np.zeros(3)) if key in ("d", "a") else (np.zeros(3), axes[key]),
        )


def _seen(frame: Pose, t: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Transform a twist of a frame to the axes in which the frame stands."""
    turned = np.asarray(frame.turn(w))
    return np.asarray(frame.turn(t)) + np.cross(np.asarray(frame.position), turned), turned


def _base_moved(
    mechanism: Mechanism, values: Mapping[str, float], t: np.ndarray, w: np.ndarray
) -> Velocity:
    """Move everything given in the base frame by the twist (t, w)."""
    velocity: Velocity = {}

    def point(path: str) -> None:
        _put(velocity, path, t + np.cross(w, vector_values(values, path)))

    def direction(path: str) -> None:
        _put(velocity, path, np.cross(w, vector_values(values, path)))

    for path in _base_points(mechanism):
        point(path)
    for path, joint in joint_paths(mechanism):
        for key in ("axis", "axis2"):
            if getattr(joint, key) is not None:
                direction(f"{path}.{key}")
    frame = mechanism.frame_name
    if f"{frame}.position.x" in values or f"{frame}.quaternion.w" in values:
        _put(
            velocity,
            f"{frame}.position",
            t + np.cross(w, vector_values(values, f"{frame}.position")),
        )
        q = vector_values(values, f"{frame}.quaternion", "wxyz")
        _put(
            velocity,
            f"{frame}.quaternion",
            0.5 * np.asarray(multiply(np.array([0.0, *w]), q)),
            "wxyz",
        )
    return velocity


def _base_points(mechanism: Mechanism) -> Iterator[str]:
    """Key paths of all points that are given in the base frame."""
    for path, _ in joint_paths(mechanism):
        yield f"{path}.point"
    yield from (
        end.path
        for bar in mechanism.bars
        for end in (bar.start, bar.end)
        if not end.in_platform_frame
    )
    yield from map(point_path, mechanism.link_points)


def _platform_moved(
    mechanism: Mechanism, values: Mapping[str, float], t: np.ndarray, w: np.ndarray
) -> Velocity:
    """Move the platform frame by the twist (t, w) in its own axes; what is given in it moves the
    other way.
    """
    velocity: Velocity = {}
    for path in (
        end.path for bar in mechanism.bars for end in (bar.start, bar.end) if end.in_platform_frame
    ):
        _put(velocity, path, -(t + np.cross(w, vector_values(values, path))))
    frame = mechanism.frame_name
    if f"{frame}.position.x" in values or f"{frame}.quaternion.w" in values:
        q = vector_values(values, f"{frame}.quaternion", "wxyz")
        _put(velocity, f"{frame}.position", np.asarray(rotate(q / np.linalg.norm(q), t)))
        _put(
            velocity,
            f"{frame}.quaternion",
            0.5 * np.asarray(multiply(q, np.array([0.0, *w]))),
            "wxyz",
        )
    return velocity


def _stretched(
    mechanism: Mechanism, values: Mapping[str, float], read: tuple[str, ...]
) -> Velocity:
    """Stretch every length in proportion."""
    table = nominal_parameters(mechanism, read)
    lengths = {
        name
        for name, (_, kind) in table.items()
        if kind == "length" and name not in MEASURING_FRAMES
    }
    return {name: value for name, value in values.items() if name in lengths}


def _put(velocity: Velocity, path: str, value: np.ndarray, letters: str = "xyz") -> None:
    velocity.update(vector_velocity(path, value, letters))


def parallel_offsets(
    mechanism: Mechanism, values: Mapping[str, float], within: float = 0.0
) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield (name, rates of parameters) for neighbouring rows whose axes are parallel to rounding,
    or `within` an angle: the offset d of one and that of the next move the tool alike.
    """
    for k, twist in parallel_axes(mechanism, values, max(within, 1e-12)):
        names = " and ".join(mechanism.actuated[i].name for i in (k - 1, k))
        other = -1.0 if np.cos(twist) > 0 else 1.0
        yield (
            f"parallel axes {names}: only the sum of their offsets dh.{k}.d and dh.{k + 1}.d is "
            f"told",
            {f"dh.{k}.d": 1.0, f"dh.{k + 1}.d": other},
        )


def nearly_parallel(mechanism: Mechanism, values: Mapping[str, float]) -> tuple[str, ...]:
    """Name pairs of neighbouring axes that are parallel or nearly so."""
    return tuple(
        text.split(":")[0].removeprefix("parallel axes ")
        for text, _ in parallel_offsets(mechanism, values, NEARLY_PARALLEL)
    )
