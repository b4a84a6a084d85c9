"""The lines that a mechanism is drawn with, at one configuration: NumPy only, base frame, length
unit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from symkin.model.joint import Joint
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism
from symkin.plots.link_displacements import link_displacements
from symkin.spatial.pose import Pose

SegmentKind = Literal["link", "slide", "actuated slide", "rod"]


@dataclass(frozen=True, eq=False)
class Segment:
    """A straight line from `start` to `end`, each (3,)."""

    start: np.ndarray
    end: np.ndarray
    kind: SegmentKind

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))


@dataclass(frozen=True, eq=False)
class Dot:
    """The place of a joint, (3,)."""

    point: np.ndarray
    actuated: bool


@dataclass(frozen=True, eq=False)
class _Rail:
    """A P joint: the direction along which it slides, in the base frame."""

    name: str
    axis: np.ndarray
    actuated: bool


@dataclass(eq=False)
class LimbLines:
    """One limb: `segments` on end from `base`, `rods` where it ends in rods, and its `ends` on the
    platform. `places` are those of its joints by name, of a P joint the middle of its slide.
    """

    name: str
    base: np.ndarray
    segments: list[Segment] = field(default_factory=list)
    rods: list[Segment] = field(default_factory=list)
    dots: list[Dot] = field(default_factory=list)
    ends: list[np.ndarray] = field(default_factory=list)
    places: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def points(self) -> np.ndarray:
        """Corners of the polyline from the base, without the rods, shape (n, 3)."""
        return np.array([self.base, *(s.end for s in self.segments)])

    def line_to(self, point: np.ndarray, kind: SegmentKind) -> None:
        """Add a segment from the last corner to `point`."""
        last = self.segments[-1].end if self.segments else self.base
        self.segments.append(Segment(last, point, kind))


@dataclass(frozen=True, eq=False)
class MechanismLines:
    """What is drawn of one configuration: the limbs, base and platform points (k, 3), and the
    platform's pose. An arm has a tool and no platform, only the point where it ends.
    """

    limbs: tuple[LimbLines, ...]
    base: np.ndarray
    platform: np.ndarray
    pose: Pose
    has_platform: bool

    @property
    def points(self) -> np.ndarray:
        """Every point drawn, shape (k, 3): what the axes must hold."""
        ends = [
            p for limb in self.limbs for s in (*limb.segments, *limb.rods) for p in (s.start, s.end)
        ]
        return np.array(
            [np.zeros(3), np.asarray(self.pose.position), *self.base, *self.platform, *ends]
        )


def lines_at(mechanism: Mechanism, values: Mapping[str, Any], pose: Pose) -> MechanismLines:
    """The lines of a configuration: `values` of the closure coordinates by name (radians, length
    unit; those of cut joints are not among them) and the platform's pose, as in a Solution.
    """
    places = _joint_places(mechanism)
    limbs = tuple(
        _joint_limb_lines(mechanism, limb, places, values, pose)
        if limb.joints
        else _leg_lines(mechanism, limb, pose)
        for limb in mechanism.limbs
    )
    base = np.array([limb.base for limb in limbs])
    platform = np.array([end for limb in limbs for end in limb.ends])
    return MechanismLines(limbs, base, platform, pose, has_platform=not mechanism.serial)


def reference_lines(mechanism: Mechanism) -> MechanismLines:
    """The lines at the reference configuration."""
    coordinates = [c for _, joint in mechanism.joints for c in joint.coordinates]
    values = {c.name: c.reference[0] if c.width == 1 else c.reference for c in coordinates}
    return lines_at(mechanism, values, mechanism.reference_pose)


def outline(points: np.ndarray) -> np.ndarray:
    """Corners (k, 3) of the convex hull of points (n, 3) seen along the normal of their best plane,
    in order around it; fewer than three for points on a line.
    """
    centred = points - points.mean(axis=0)
    _, s, vt = np.linalg.svd(centred, full_matrices=True)
    if len(s) < 2 or s[1] <= 1e-6 * max(s[0], 1e-300):
        along = centred @ vt[0]
        return points[sorted({int(np.argmin(along)), int(np.argmax(along))})]
    return points[_hull(centred @ vt[:2].T)]


# --- limbs ----------------------------------------------------------------------------------------


def _leg_lines(mechanism: Mechanism, limb: AnyLimb, pose: Pose) -> LimbLines:
    """A limb without joints: its rod, which is actuated."""
    (rod,) = limb.bars(mechanism.reference_pose)
    base, end = np.array(rod.start.point), pose.apply(np.array(rod.end.point))
    lines = LimbLines(limb.name, base, dots=[Dot(base, False), Dot(end, False)], ends=[end])
    lines.line_to(end, "actuated slide")
    return lines


def _joint_limb_lines(
    mechanism: Mechanism,
    limb: AnyLimb,
    places: Mapping[str, np.ndarray],
    values: Mapping[str, Any],
    pose: Pose,
) -> LimbLines:
    links = link_displacements(mechanism, limb, values, pose)
    lines = LimbLines(limb.name, _base_point(mechanism, limb, places))
    slides: list[_Rail] = []
    for i, joint in enumerate(limb.joints):
        axis = None if joint.axis is None else links[i].turn(np.array(joint.axis))
        if joint.type == "P" and axis is not None:
            slides.append(_Rail(joint.name, axis, joint.actuated))
            continue
        point = places[joint.name]
        entry, leave = links[i].apply(point), links[i + 1].apply(point)
        _walk(lines, entry, slides)
        slides = []
        lines.dots.append(Dot(entry, joint.actuated))
        lines.places[joint.name] = entry
        if joint.type in "CH":
            lines.line_to(leave, _slide_kind(joint.actuated))
    _finish(mechanism, limb, places, lines, slides, links[-1], pose)
    return lines


def _finish(
    mechanism: Mechanism,
    limb: AnyLimb,
    places: Mapping[str, np.ndarray],
    lines: LimbLines,
    slides: Sequence[_Rail],
    last_link: Pose,
    pose: Pose,
) -> None:
    """From the last joint to the platform: by rods, to the tool, or along what slides there."""
    rods = limb.bars(mechanism.reference_pose)
    if not rods:
        end = _end_point(mechanism, limb, places)
        if end is not None:
            _walk(lines, last_link.apply(end), slides)
        lines.ends = [lines.points[-1]]
        return
    starts = [last_link.apply(np.array(rod.start.point)) for rod in rods]
    _walk(lines, np.mean(starts, axis=0), slides)
    lines.ends = [pose.apply(np.array(rod.end.point)) for rod in rods]
    hub = lines.points[-1]
    for start, end in zip(starts, lines.ends, strict=True):
        lines.rods += [Segment(hub, start, "link"), Segment(start, end, "rod")]
        lines.dots += [Dot(start, False), Dot(end, False)]


def _walk(lines: LimbLines, target: np.ndarray, slides: Sequence[_Rail]) -> None:
    """Go on to `target`: straight, or along the axes of the P joints on the way, after what they
    cannot cover.
    """
    last = lines.points[-1]
    if slides:
        axes = np.array([rail.axis for rail in slides])
        shares = np.linalg.lstsq(axes.T, target - last, rcond=None)[0]
        lines.line_to(target - shares @ axes, "link")
        for k, (rail, share) in enumerate(zip(slides, shares, strict=True), start=1):
            begin = lines.points[-1]
            lines.line_to(
                target if k == len(slides) else begin + share * rail.axis,
                _slide_kind(rail.actuated),
            )
            lines.places[rail.name] = 0.5 * (begin + lines.points[-1])
    else:
        lines.line_to(target, "link")


def _base_point(
    mechanism: Mechanism, limb: AnyLimb, places: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Where the limb begins: a serial arm at the origin; P joints at the point of their rails
    nearest their own point.
    """
    if mechanism.serial:
        return np.zeros(3)
    first = limb.joints[0]
    if first.type != "P":
        return places[first.name]
    held = [joint for joint in limb.joints if joint.type != "P"]
    leading = limb.joints[: limb.joints.index(held[0])] if held else limb.joints
    starts = [rod.start.point for rod in limb.bars(mechanism.reference_pose)]
    end = np.asarray(np.mean(starts, axis=0)) if starts else np.array(mechanism.platform_position)
    target = places[held[0].name] if held else end
    return _beside(mechanism.places[first.name], target, leading)


def _end_point(
    mechanism: Mechanism, limb: AnyLimb, places: Mapping[str, np.ndarray]
) -> np.ndarray | None:
    """Where a limb without rods ends at the reference: the tool, or behind P joints the point of
    their rails nearest the platform's origin; None where it ends at its last joint.
    """
    origin = np.array(mechanism.platform_position)
    held = [joint for joint in limb.joints if joint.type != "P"]
    if mechanism.serial or not held:
        return origin
    trailing = limb.joints[limb.joints.index(held[-1]) + 1 :]
    return _beside(origin, places[held[-1].name], trailing) if trailing else None


def _joint_places(mechanism: Mechanism) -> dict[str, np.ndarray]:
    """A point on each joint at the reference; where the joints of all limbs meet in one point (a
    spherical mechanism), points of their axes at the distance `size` from it stand for them.
    """
    joints = [joint for _, joint in mechanism.joints]
    points = dict(mechanism.places)
    held = [points[joint.name] for joint in joints if joint.type != "P"]
    if (
        mechanism.bars
        or mechanism.serial
        or not held
        or np.ptp(held, axis=0).max() > 1e-9 * mechanism.characteristic_length
    ):
        return points
    return {
        joint.name: points[joint.name]
        + mechanism.characteristic_length * np.array(joint.axis or (0.0, 0.0, 0.0))
        for joint in joints
    }


# --- geometry -------------------------------------------------------------------------------------


def _slide_kind(actuated: bool) -> SegmentKind:
    return "actuated slide" if actuated else "slide"


def _beside(anchor: np.ndarray, target: np.ndarray, rails: Sequence[Joint]) -> np.ndarray:
    """The point nearest `anchor` from which the rails' axes lead to `target`."""
    u, s, _ = np.linalg.svd(np.array([rail.axis for rail in rails]).T, full_matrices=False)
    basis = u[:, s > 1e-9]
    away = target - anchor
    return np.asarray(anchor + away - basis @ (basis.T @ away))


def _hull(flat: np.ndarray) -> list[int]:
    """Indices of the convex hull of points (n, 2), counter-clockwise (Andrew's monotone chain)."""
    order = [int(i) for i in np.lexsort((flat[:, 1], flat[:, 0]))]
    slack = 1e-9 * float(np.ptp(flat, axis=0).max()) ** 2

    def half(indices: Sequence[int]) -> list[int]:
        chain: list[int] = []
        for i in indices:
            while len(chain) >= 2 and _turn(flat[chain[-2]], flat[chain[-1]], flat[i]) <= slack:
                chain.pop()
            chain.append(i)
        return chain[:-1]

    return half(order) + half(order[::-1])


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
