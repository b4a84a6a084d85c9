"""Name directions in parameter space along which nothing that is read may change.

Moving the base frame or the platform frame, stretching everything, shifting a joint's point along
its axis, shifting the offsets of parallel axes: each is a velocity of every parameter of the
mechanism. A direction that lies in the null space of the identification Jacobian is what the
readings cannot tell, and has a name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from symkin.calibration.data.parameters import (
    AXES,
    MEASURING_FRAMES,
    Velocity,
    nominal_parameters,
    vector_values,
    vector_velocity,
    written_freedoms,
)
from symkin.calibration.data.reference_motions import moved, reference_motions
from symkin.calibration.estimate.configuration_model import ConfigurationModel
from symkin.calibration.estimate.joint_lines import NEARLY_PARALLEL, parallel_axes
from symkin.closure.branches import edges_of
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import multiply, rotate

_TURNS = ("roll (about x)", "pitch (about y)", "yaw (about z)")

_HELD_STILL = 1e-9
"""A change leaves held parameters where they are when they move by less than this share of it."""


def named_motions(model: ConfigurationModel, p: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Yield (name, scaled direction over the model's parameters) of every known change at p, most
    telling first. What a change would need of parameters that are held is made up for by freedoms
    in how the file is written; a change that cannot be so is left out.
    """
    mechanism, read, values = model.mechanism, _read(model), all_values(model, p)
    names, free = list(values), np.isin(list(values), model.names)
    order = [names.index(name) for name in model.names]
    table, size = nominal_parameters(mechanism, read), model.closure.characteristic_length
    units = np.where([table.get(name, ("", "length"))[1] == "length" for name in names], 1.0, size)

    def rows(changes: Iterable[tuple[str, Velocity]]) -> list[tuple[str, np.ndarray]]:
        return [(text, units * [v.get(name, 0.0) for name in names]) for text, v in changes]

    written = written_freedoms(mechanism, values, read)
    freedoms = rows((*written, *reference_motions(mechanism, values, read)))
    basis = np.array([one for _, one in freedoms]).reshape(-1, len(names)).T
    for text, direction in (*rows(_all_motions(model, values)), *freedoms):
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


def _read(model: ConfigurationModel) -> tuple[str, ...]:
    return tuple(o.name for o in model.read)


def all_values(model: ConfigurationModel, p: np.ndarray) -> Velocity:
    """Return the values of all parameters by name: nominal, those of the model's as p has them;
    measuring frames only among these.
    """
    table = nominal_parameters(model.mechanism, _read(model))
    values = {name: value for name, (value, _) in table.items() if name not in MEASURING_FRAMES}
    return values | dict(zip(model.names, map(float, p), strict=True))


def _all_motions(model: ConfigurationModel, values: Velocity) -> Iterator[tuple[str, Velocity]]:
    if model.mechanism.dh is None:
        yield from _frame_motions(model.mechanism, values)
    table = nominal_parameters(model.mechanism, _read(model))
    stretched = {
        name: value
        for name, value in values.items()
        if table.get(name, ("", ""))[1] == "length" and name not in MEASURING_FRAMES
    }
    yield "size of the whole mechanism", stretched
    lengths = [c.name for c in model.mechanism.actuated if not c.is_angular]
    lengths += [o.name for o in model.read if o.kind == "joint" and not o.angular]
    if lengths:
        yield (
            "size of the whole mechanism with the factors of all length readings",
            stretched | {f"{name}.scale": 1.0 for name in lengths},
        )
    yield from _parallel_offsets(model.mechanism, values)


# --- frames ---------------------------------------------------------------------------------------


def frame_names(mechanism: Mechanism) -> Iterator[tuple[str, str, str]]:
    """Yield the names of unit twists of base and platform frame, translations first, each with the
    frame between the mechanism and what is measured there, and the name of what mixes both.
    """
    for frame, beside, fixed in (
        (BASE, "world", "base"),
        (mechanism.frame_name, "target", "platform"),
    ):
        for axis in AXES:
            mixed = f"{beside} frame position {axis} with the {fixed} frame"
            yield f"{frame} frame translation {axis}", beside, mixed
        for axis, turn in zip(AXES, _TURNS, strict=True):
            turn = turn if frame == BASE else f"rotation about {axis}"
            mixed = f"{beside} frame rotation {axis} with the {fixed} frame"
            yield f"{frame} frame {turn}", beside, mixed


def _frame_motions(mechanism: Mechanism, values: Velocity) -> Iterator[tuple[str, Velocity]]:
    """Move base and platform frame by unit twists (t, w)."""
    links = {link for edge in edges_of(mechanism) for link in edge.ends}
    links |= {BASE, *(p.link for p in mechanism.link_points)}
    texts = [text for text, *_ in frame_names(mechanism)]
    for text, twist in zip(texts, np.eye(6), strict=False):
        yield text, moved(mechanism, values, dict.fromkeys(links, twist))
    for text, twist in zip(texts[6:], np.eye(6), strict=True):
        yield text, _platform_moved(mechanism, values, twist[:3], twist[3:])


def _platform_moved(
    mechanism: Mechanism, values: Velocity, t: np.ndarray, w: np.ndarray
) -> Velocity:
    """Move the platform frame by the twist (t, w) in its own axes; what is given in it moves the
    other way.
    """
    velocity: Velocity = {}
    for end in (end for bar in mechanism.bars for end in (bar.start, bar.end)):
        if end.in_platform_frame:
            back = -(t + np.cross(w, vector_values(values, end.path)))
            velocity |= vector_velocity(end.path, back)
    frame = mechanism.frame_name
    if f"{frame}.quaternion.w" in values:
        q = vector_values(values, f"{frame}.quaternion", "wxyz")
        shifted, turned = rotate(q / np.linalg.norm(q), t), multiply(q, np.array([0.0, *w]))
        velocity |= vector_velocity(f"{frame}.position", np.asarray(shifted))
        velocity |= vector_velocity(f"{frame}.quaternion", 0.5 * np.asarray(turned), "wxyz")
    return velocity


# --- parallel axes --------------------------------------------------------------------------------


def _parallel_offsets(mechanism: Mechanism, values: Velocity) -> Iterator[tuple[str, Velocity]]:
    """Shift the offset d of an axis that is parallel to the next to rounding against that one's:
    both move the tool alike.
    """
    for k, twist in parallel_axes(mechanism, values, 1e-12):
        yield (
            f"parallel axes {_axes_named(mechanism, k)}: only the sum of their offsets dh.{k}.d "
            f"and dh.{k + 1}.d is told",
            {f"dh.{k}.d": 1.0, f"dh.{k + 1}.d": -1.0 if np.cos(twist) > 0 else 1.0},
        )


def nearly_parallel(mechanism: Mechanism, values: Velocity) -> tuple[str, ...]:
    """Name pairs of neighbouring axes that are parallel or nearly so."""
    found = parallel_axes(mechanism, values, NEARLY_PARALLEL)
    return tuple(_axes_named(mechanism, k) for k, _ in found)


def _axes_named(mechanism: Mechanism, k: int) -> str:
    return " and ".join(mechanism.actuated[i].name for i in (k - 1, k))
