"""What a picture of a track shows over the path: inputs, what moves with them, distances to
singularities and to limits.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from symkin.drawing.outline import grouped
from symkin.following.sample import listed_joints
from symkin.following.stop import roles_followed
from symkin.following.track_result import Track
from symkin.model.joint import Coordinate
from symkin.singularities.classification import classify
from symkin.spatial.rotation import conjugate, euler_from_quaternion, multiply
from symkin.text import plain

_ONE_LINE = 0.004
"""Distance over the range of all curves below which two are one line throughout, with the names of
both.
"""
_STILL = 1e-9
"""Motion over the size, or in rad, below which a quantity stands."""
_MOST_DISTANCES = 41
"""Samples at which distances from singularities are computed."""
_LONGEST_LINE = 30
"""Characters of a line of a curve's names."""
_MOST_LIMITED = 6
"""Joints whose distances to their limits are drawn: those that come nearest."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A quantity over the samples `at` (numbers into the track's samples), in the unit of its
    panel.
    """

    name: str
    values: np.ndarray
    at: np.ndarray


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """Curves over one axis; `stands` names what does not move, with its value; `floor` is the least
    value of the axis, where there is one.
    """

    label: str
    curves: tuple[Curve, ...]
    stands: tuple[str, ...] = ()
    floor: float | None = None


@dataclass(frozen=True, eq=False)
class Input:
    """A coordinate that the path tells: its title and its values at the samples in the mechanism's
    units.
    """

    title: str
    values: np.ndarray


def inputs_of(track: Track) -> list[Input]:
    """The told coordinates that move."""
    mechanism, problem = track.trajectory.mechanism, track.problem
    values = np.array([sample.values for sample in track.samples])
    found = []
    for c in problem.known_coordinates:
        place = problem.closure.slices[c.name]
        name = c.name.removeprefix("pose.")
        if c.is_rotation:
            found += [
                Input(f"{turn} [{mechanism.angle_unit}]", v)
                for turn, v in _turns(track, values[:, place])
            ]
        elif c.width == 1 and _moves(track, c, values[:, place.start]):
            unit = mechanism.unit_of(c)
            found.append(Input(f"{name} [{unit}]", _out(track, c, values[:, place.start])))
    return found


def drawn_panels(track: Track) -> list[CurvePanel]:
    """The panels that hold a curve; what stands in the others is told in the first of them."""
    panels = list(panels_of(track))
    first, *more = [panel for panel in panels if panel.curves] or panels[:1]
    still = [text for panel in panels if not panel.curves for text in panel.stands]
    return [replace(first, stands=(*first.stands, *still)), *more]


def panels_of(track: Track) -> Iterator[CurvePanel]:
    """The panels from above: what moves, then the distances."""
    mechanism, samples = track.trajectory.mechanism, track.samples
    if track.problem.gives_joints and samples[0].has_platform:
        places = np.array([np.asarray(s.pose.position) for s in samples], dtype=float)
        size = _STILL * mechanism.characteristic_length
        moved = dict(zip("xyz", places.T, strict=True))
        yield _from_start(f"{mechanism.frame_name}, from its", mechanism.length_unit, moved, size)
        yield _turning(track)
    else:
        yield from _joint_panels(track)
        named = {
            f"{name}.{axis}": np.array([s.points[name][k] for s in samples])
            for name in (samples[0].points if not track.problem.gives_pose else ())
            for k, axis in enumerate("xyz")
        }
        if named:
            size = _STILL * mechanism.characteristic_length
            yield _from_start("points, from their", mechanism.length_unit, named, size)
    yield _singular(track)
    yield from _limits(track)


def _joint_panels(track: Track) -> Iterator[CurvePanel]:
    """The joints that are found, lengths and angles apart."""
    mechanism, known = track.trajectory.mechanism, {c.name for c in track.problem.known_coordinates}
    found = mechanism.actuated if track.problem.gives_pose else listed_joints(track.problem)
    stills = _STILL * mechanism.characteristic_length, mechanism.angle_out(_STILL)
    for angular, unit in ((False, mechanism.length_unit), (True, mechanism.angle_unit)):
        values = {
            c.name: np.array([s.joints[c.name] for s in track.samples], dtype=float)
            for c in found
            if c.is_angular == angular and not c.is_rotation and c.name not in known
        }
        if values:
            yield _from_start("joints, from their", unit, values, stills[angular])


def _from_start(label: str, unit: str, values: dict[str, np.ndarray], still: float) -> CurvePanel:
    """Changes from the first sample; what moves by less than `still` stands."""
    first = {name: f"{plain(float(v[0]), least=still):.5g}" for name, v in values.items()}
    away = {name: v - v[0] for name, v in values.items() if np.ptp(v) > still}
    stands = tuple(f"{name} stays {first[name]} {unit}" for name in values if name not in away)
    curves = []
    for names, v in _lines(away, still):
        told = {first[name] for name in names}
        own = names if len(told) == 1 else [f"{name} from {first[name]}" for name in names]
        common = f", from {told.pop()}" if len(told) == 1 else ""
        curves.append(Curve(_joined(own) + common, v, np.arange(len(v))))
    return CurvePanel(f"{label}\nstart [{unit}]", tuple(curves), stands)


def _lines(values: dict[str, np.ndarray], near: float) -> list[tuple[list[str], np.ndarray]]:
    """Curves by name; one line that has the names of all that cannot be told apart hides none."""
    reach = max((float(np.abs(v).max()) for v in values.values()), default=0.0)
    return grouped(values.items(), max(near, _ONE_LINE * reach), np.inf)


def _turning(track: Track) -> CurvePanel:
    """The rotation vector of the platform from its start, base frame."""
    mechanism = track.trajectory.mechanism
    first = conjugate(np.asarray(track.samples[0].pose.quaternion))
    turns = np.array(
        [_rotation_vector(multiply(np.asarray(s.pose.quaternion), first)) for s in track.samples]
    )
    shown = turns * mechanism.angle_out(1.0)
    curves = [
        Curve(f"about {axis}", v, np.arange(len(v))) for axis, v in zip("xyz", shown.T, strict=True)
    ]
    still = mechanism.angle_out(_STILL)
    moving = tuple(curve for curve in curves if np.ptp(curve.values) > still)
    stands = () if moving else ("does not turn",)
    return CurvePanel(
        f"{mechanism.frame_name}, turned\nfrom its start [{mechanism.angle_unit}]", moving, stands
    )


def _rotation_vector(q: np.ndarray) -> np.ndarray:
    """Angle times axis, an angle from 0 to a whole turn: it goes on beyond half a turn where the
    quaternions of a path do.
    """
    sine = float(np.linalg.norm(q[1:]))
    if sine == 0.0:
        return np.zeros(3)
    return 2.0 * math.atan2(sine, float(q[0])) / sine * np.asarray(q[1:], dtype=float)


# --- distances ------------------------------------------------------------------------------------


def _singular(track: Track) -> CurvePanel:
    """The smallest singular value of what is followed, and the distances from each kind of
    singularity.
    """
    samples, roles = track.samples, roles_followed(track.problem)
    at = np.unique(np.linspace(0, len(samples) - 1, _MOST_DISTANCES).round().astype(int))
    rows = [classify(samples[k].solution, roles=roles).distances for k in at]
    kinds = [
        kind for kind in rows[0] if all(math.isfinite(row.get(kind, math.inf)) for row in rows)
    ]
    curves = [Curve(f"from {kind}", np.array([row[kind] for row in rows]), at) for kind in kinds]
    # without unknowns nothing can be lost and the smallest singular value is 1
    if track.nearest is not None:
        sigma = np.array([s.smallest_singular_value for s in samples])
        curves.insert(0, Curve("smallest singular value", sigma, np.arange(len(sigma))))
    return CurvePanel("distance to\nsingularity", tuple(curves), floor=0.0)


def _limits(track: Track) -> Iterator[CurvePanel]:
    """How far joints are from their limits, as a share of their ranges: 0.5 in the middle, 0 at a
    limit, negative beyond.
    """
    found = {}
    for c in track.trajectory.mechanism.coordinates:
        shares = _limit_shares(track, c)
        if shares is not None:
            found[c.name] = shares
    if not found:
        return
    nearest = sorted(_lines(found, _STILL), key=lambda entry: float(entry[1].min()))
    curves = tuple(
        Curve(_joined(names), values, np.arange(len(values)))
        for names, values in nearest[:_MOST_LIMITED]
    )
    others = sum(len(names) for names, _ in nearest[_MOST_LIMITED:])
    more = (f"{others} others are farther",) if others else ()
    yield CurvePanel("distance to limits\n[share of the range]", curves, more, floor=0.0)


def _limit_shares(track: Track, c: Coordinate) -> np.ndarray | None:
    """Distances of a joint from the nearer of its limits; whole turns of an angle count as one
    place, that of the first sample.
    """
    if (
        c.limits is None
        or c.width != 1
        or c.name not in track.samples[0].joints
        or not np.isfinite(c.limits).all()
    ):
        return None
    low, high = c.limits
    told = [float(sample.joints[c.name]) for sample in track.samples]
    values = np.array([track.trajectory.mechanism.value_in(c, value) for value in told])
    if c.is_angular:
        values = values - 2.0 * math.pi * round((values[0] - 0.5 * (low + high)) / (2.0 * math.pi))
    return np.asarray(np.minimum(values - low, high - values) / (high - low))


def _joined(names: list[str]) -> str:
    return textwrap.fill(", ".join(names), _LONGEST_LINE)


# --- values ---------------------------------------------------------------------------------------


def _out(track: Track, c: Coordinate, values: np.ndarray) -> np.ndarray:
    return values * (track.trajectory.mechanism.angle_out(1.0) if c.is_angular else 1.0)


def _moves(track: Track, c: Coordinate, values: np.ndarray) -> bool:
    return bool(np.ptp(values) > _STILL * c.unit(track.trajectory.mechanism.characteristic_length))


def _turns(track: Track, quaternions: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Roll, pitch and yaw of a told orientation, those that move."""
    angles = [np.asarray(euler_from_quaternion(q, "xyz"), dtype=float) for q in quaternions]
    shown = np.unwrap(angles, axis=0)
    out = track.trajectory.mechanism.angle_out(1.0)
    return [
        (name, v * out)
        for name, v in zip(("roll", "pitch", "yaw"), shown.T, strict=True)
        if np.ptp(v) > _STILL
    ]
