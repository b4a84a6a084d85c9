"""What a kinematic sketch shows and where: joints with their axes, links, base, platform, frames
and dimensions, and the direction from which they are seen. NumPy only, base frame, length unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from symkin.model.joint import JointType
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism
from symkin.plots.mechanism_lines import (
    LimbLines,
    MechanismLines,
    Segment,
    lines_at,
    reference_lines,
)
from symkin.spatial.pose import Pose

_SAME = 1e-6
"""Distance over the size below which two points are one, and sine below which two directions
are.
"""
_RAISED = 0.6
"""Height over the size to which a platform on rods is raised whose reference lies in its base's
plane.
"""
_NEAR, _ASIDE = 0.075, 0.08
"""Distances over the size: below which symbols cover each other, and at which those of joints that
share a point stand, while directions are tried.
"""
_ELEVATIONS = (20.0, 26.0, 32.0, 14.0)
_AZIMUTHS = (-57.0, -66.0, -48.0, -38.0, -30.0, -75.0, -22.0)
"""Directions of the eye that are tried for a mechanism that is not planar, degrees, the preferred
first.
"""


@dataclass(frozen=True, eq=False)
class JointMark:
    """One joint's symbol: centre (3,) and directions (3,) of its axes, none for an S joint, two for
    a U joint.
    """

    name: str
    type: JointType
    centre: np.ndarray
    axes: tuple[np.ndarray, ...]
    actuated: bool
    limb: str


@dataclass(frozen=True, eq=False)
class Dimension:
    """A length between two points that stays as it is, at `place` (3,)."""

    text: str
    place: np.ndarray


@dataclass(frozen=True, eq=False)
class Layout:
    """All that is drawn; `right` and `up` (3,) span the picture, `towards` points to the eye."""

    mechanism: Mechanism
    body: MechanismLines
    joints: tuple[JointMark, ...]
    dimensions: tuple[Dimension, ...]
    notes: tuple[str, ...]
    planar: bool
    axes: np.ndarray

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture (..., 2)."""
        return np.asarray(np.asarray(points, dtype=float) @ self.axes[:2].T)


def make_layout(mechanism: Mechanism) -> Layout:
    """The sketch of a mechanism at its reference; a platform on rods in its base's plane is raised,
    and a note says so.
    """
    body, notes = _body(mechanism)
    joints = _marks(mechanism, body)
    normal = plane_normal(joints, body, mechanism.characteristic_length)
    axes = (
        view_onto(normal)
        if normal is not None
        else best_view(joints, mechanism.characteristic_length)
    )
    return Layout(
        mechanism=mechanism,
        body=body,
        joints=joints,
        dimensions=_dimensions(mechanism, body),
        notes=(*notes, *_circle_notes(mechanism, body)),
        planar=normal is not None,
        axes=axes,
    )


def _body(mechanism: Mechanism) -> tuple[MechanismLines, tuple[str, ...]]:
    body = reference_lines(mechanism)
    if any(limb.joints for limb in mechanism.limbs) or mechanism.motion not in (
        "spatial",
        "schoenflies",
        "translation",
    ):
        return body, ()
    ends = np.vstack([body.base, body.platform])
    if (
        np.ptp(ends @ _thin(ends)) > _SAME * mechanism.characteristic_length
        or len(mechanism.limbs) < 3
    ):
        return body, ()
    height = _RAISED * mechanism.characteristic_length
    reference = mechanism.reference_pose
    raised = Pose(np.asarray(reference.position) + height * _thin(ends), reference.quaternion)
    return lines_at(mechanism, {}, raised), (
        f"platform raised by {height:.4g} {mechanism.length_unit} from its reference",
    )


def _thin(points: np.ndarray) -> np.ndarray:
    """The direction in which points extend least, upward."""
    v = np.linalg.svd(points - points.mean(axis=0))[2][2]
    return np.asarray(v * np.sign(v[int(np.argmax(np.abs(v)))]))


# --- joints ---------------------------------------------------------------------------------------


def _marks(mechanism: Mechanism, body: MechanismLines) -> tuple[JointMark, ...]:
    found: list[JointMark] = []
    for limb, lines in zip(mechanism.limbs, body.limbs, strict=True):
        found += _joint_marks(limb, lines) if limb.joints else _leg_marks(limb, lines)
    return tuple(found)


def _leg_marks(limb: AnyLimb, lines: LimbLines) -> list[JointMark]:
    """The three joints of an SPS, UPS or SPU limb; axes of a universal joint across the rod."""
    base, end = lines.segments[0].start, lines.segments[0].end
    along = end - base
    length = float(np.linalg.norm(along))
    along = along / length if length else np.array([0.0, 0.0, 1.0])
    across = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    across /= np.linalg.norm(across)
    axes = {"S": (), "U": (across, np.cross(along, across)), "P": (along,)}
    places = (base, 0.5 * (base + end), end)
    return [
        JointMark(
            limb.name if kind == "P" else f"{limb.name}.{kind}",
            kind,  # type: ignore[arg-type]
            place,
            axes[kind],
            kind == "P",
            limb.name,
        )
        for kind, place in zip(limb.type, places, strict=True)
    ]


def _joint_marks(limb: AnyLimb, lines: LimbLines) -> list[JointMark]:
    """The joints of a limb, and the spherical ends of its rods."""
    found = []
    for joint in limb.joints:
        axes = tuple(np.array(axis) for axis in (joint.axis, joint.axis2) if axis is not None)
        found.append(
            JointMark(
                joint.name, joint.type, lines.places[joint.name], axes, joint.actuated, limb.name
            )
        )
    for number, rod in enumerate((s for s in lines.rods if s.kind == "rod"), start=1):
        for place, end in ((rod.start, "a"), (rod.end, "b")):
            found.append(
                JointMark(f"{limb.name}.rod{number}{end}", "S", place, (), False, limb.name)
            )
    return found


def apart(joints: Sequence[JointMark], size: float, step: float) -> tuple[JointMark, ...]:
    """The joints where their symbols are drawn: those of a limb that share a point stand `step` and
    more from it along their own axes.
    """
    centres = [joint.centre for joint in joints]
    groups: list[list[int]] = []
    for k, joint in enumerate(joints):
        last = groups[-1] if groups else []
        together = (
            last
            and joints[last[-1]].limb == joint.limb
            and np.linalg.norm(centres[last[0]] - joint.centre) < _SAME * size
        )
        groups = [*groups[:-1], [*last, k]] if together else [*groups, [k]]
    for group in groups:
        taken: list[np.ndarray] = []
        for k in group[1:]:
            centres[k] = joints[k].centre + step * _aside(joints, k, group, taken)
    return tuple(
        replace(joint, centre=centre) for joint, centre in zip(joints, centres, strict=True)
    )


def _aside(
    joints: Sequence[JointMark], k: int, group: Sequence[int], taken: list[np.ndarray]
) -> np.ndarray:
    """Along the joint's own axis, towards the next joint of its limb, past those that stand
    there.
    """
    joint = joints[k]
    axis = joint.axes[0] if joint.axes else np.array([0.0, 0.0, 1.0])
    after = next((j for j in joints[group[-1] + 1 :] if j.limb == joint.limb), None)
    if after is not None and (after.centre - joint.centre) @ axis < 0.0:
        axis = -axis
    first = joints[group[0]]
    behind = 1 if first.axes and np.linalg.norm(np.cross(first.axes[0], axis)) < _SAME else 0
    behind += sum(1 for other in taken if np.linalg.norm(other - axis) < _SAME)
    taken.append(axis)
    return np.asarray(max(1, behind) * axis)


# --- view -----------------------------------------------------------------------------------------


def plane_normal(
    joints: Sequence[JointMark], body: MechanismLines, size: float
) -> np.ndarray | None:
    """The normal of the plane in which a planar mechanism moves; None for others: all turns are
    about it, all slides across it, and the points of each limb lie in one plane across it.
    """
    turning = [joint.axes[0] for joint in joints if joint.type == "R"]
    if not turning or any(joint.type not in ("R", "P") for joint in joints):
        return None
    normal = turning[0] * np.sign(turning[0][int(np.argmax(np.abs(turning[0])))])
    parallel = all(np.linalg.norm(np.cross(axis, normal)) < _SAME for axis in turning)
    across = all(abs(joint.axes[0] @ normal) < _SAME for joint in joints if joint.type == "P")
    flat = np.ptp([joint.centre @ normal for joint in joints]) < _SAME * size
    return (
        normal
        if parallel and across and flat and np.ptp(body.points @ normal) < _SAME * size
        else None
    )


def view_onto(normal: np.ndarray) -> np.ndarray:
    """Rows right, up and towards the eye, along a normal; x is to the right where it can be, z up
    where x cannot.
    """
    right = np.eye(3)[0] if abs(normal[0]) < 0.9 else np.eye(3)[1]
    right = right - (right @ normal) * normal
    right /= np.linalg.norm(right)
    up = np.cross(normal, right)
    if up[int(np.argmax(np.abs(up)))] < 0.0:
        normal, up = -normal, -up
    return np.array([right, up, normal])


def best_view(joints: Sequence[JointMark], size: float) -> np.ndarray:
    """The direction, of those tried, in which joints are farthest from hiding each other."""
    points = np.array([joint.centre for joint in apart(joints, size, _ASIDE * size)])
    views = [_axes(e, a) for e in _ELEVATIONS for a in _AZIMUTHS]
    return max(views, key=lambda axes: round(_clear(points @ axes[:2].T, points, size), 3))


def _axes(elevation: float, azimuth: float) -> np.ndarray:
    (se, sa), (ce, ca) = (f(np.radians([elevation, azimuth])) for f in (np.sin, np.cos))
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def _clear(flat: np.ndarray, points: np.ndarray, size: float) -> float:
    """Closeness, negative, of joints that are apart and look near: 0 where none looks nearer than
    `_NEAR`.
    """
    near = _NEAR * size
    pairs = [
        (i, j)
        for i, j in combinations(range(len(flat)), 2)
        if np.linalg.norm(points[i] - points[j]) > _SAME * size
    ]
    gaps = np.array([near, *(float(np.linalg.norm(flat[i] - flat[j])) for i, j in pairs)])
    return -float(np.sum(np.clip(near - gaps, 0.0, None) ** 2)) / near**2


# --- dimensions -----------------------------------------------------------------------------------


def _dimensions(mechanism: Mechanism, body: MechanismLines) -> tuple[Dimension, ...]:
    """Lengths of links and rods, each once: that of a link between joints, of a rod that is no leg,
    between two base joints.
    """
    found: dict[str, Dimension] = {}
    for segment in _rigid(mechanism, body):
        if segment.length > 0.01 * mechanism.characteristic_length:
            text = f"{segment.length:.5g}"
            found.setdefault(text, Dimension(text, 0.5 * (segment.start + segment.end)))
    return tuple(found.values())


def _rigid(mechanism: Mechanism, body: MechanismLines) -> list[Segment]:
    links = [
        s
        for lines in body.limbs
        for s in (*lines.segments, *lines.rods)
        if s.kind in ("link", "rod")
    ]
    corners = [
        np.unique(np.round(points / mechanism.characteristic_length, 9), axis=0)
        * mechanism.characteristic_length
        for points in (body.base, body.platform)
    ]
    return links + [Segment(c[0], c[1], "link") for c in corners if len(c) == 2]


def _circle_notes(mechanism: Mechanism, body: MechanismLines) -> tuple[str, ...]:
    """The circles on which limbs of the most frequent kind stand on base and platform, where these
    are three or more.
    """
    kinds = [limb.type for limb in mechanism.limbs]
    alike = [k for k, kind in enumerate(kinds) if kind == max(kinds, key=kinds.count)]
    ends = np.array([end for k in alike for end in body.limbs[k].ends])
    found = []
    for name, points in (("base", body.base[alike]), ("platform", ends)):
        radius = _radius(points, mechanism.characteristic_length)
        if radius is not None:
            found.append(f"{name} joints on a circle of {radius:.5g} {mechanism.length_unit}")
    return tuple(found)


def _radius(points: np.ndarray, size: float) -> float | None:
    """Radius of the circle through points (n, 3); None where they are fewer than three, on a line
    or on no circle.
    """
    rows = points[:, None] - points[None]
    if len(points) < 3 or np.linalg.norm(np.cross(rows[1:, 0], rows[2:, 0][:1])) < 1e-3 * size**2:
        return None
    normal = _thin(points)
    plane = points - np.outer(points @ normal, normal)
    system = np.column_stack([2 * plane, np.ones(len(plane))])
    centre = np.linalg.lstsq(system, np.sum(plane**2, axis=1), rcond=None)[0][:3]
    radii = np.linalg.norm(plane - centre, axis=1)
    level = np.ptp(points @ normal) < 1e-6 * size
    return float(radii.mean()) if level and np.ptp(radii) < 1e-4 * size else None
