"""What a sketch tells of platforms: how far one that lies in its base's plane is raised, and the
circles on which joints stand. NumPy only.
"""

from __future__ import annotations

import numpy as np

from symkin.drawing.layout import Layout
from symkin.model.joint import BASE, PLATFORM
from symkin.spatial.pose import Pose

_SAME = 1e-6
"""Height over the size below which points lie in a plane."""
_RAISED = 0.6
"""Height over the size to which a platform on rods is raised whose reference lies in its base's
plane.
"""


def raised(layout: Layout) -> tuple[Layout, tuple[str, ...]]:
    """The marks of the reference; a platform on rods in its base's plane is raised, and a note says
    so.
    """
    mechanism = layout.mechanism
    moves = mechanism.motion in ("spatial", "schoenflies", "translation")
    if mechanism.is_graph or layout.joints or not moves or len(layout.rods) < 3:
        return layout, ()
    ends = np.vstack([layout.links[link].points for link in (BASE, PLATFORM)])
    up = _thin(ends)
    if np.ptp(ends @ up) > _SAME * layout.size:
        return layout, ()
    height = _RAISED * layout.size
    move = Pose(height * up, np.array([1.0, 0.0, 0.0, 0.0]))
    note = f"platform raised by {height:.4g} {mechanism.length_unit} from its reference"
    return layout.at({BASE: Pose.identity(), PLATFORM: move}), (note,)


def _thin(points: np.ndarray) -> np.ndarray:
    """The direction in which points extend least, upward."""
    v = np.linalg.svd(points - points.mean(axis=0))[2][2]
    return np.asarray(v * np.sign(v[int(np.argmax(np.abs(v)))]))


def circle_notes(layout: Layout) -> tuple[str, ...]:
    """The circles on which limbs of the most frequent kind stand on base and platform, where these
    are three or more.
    """
    mechanism = layout.mechanism
    kinds = [limb.type for limb in mechanism.limbs]
    if mechanism.is_graph or mechanism.serial or not kinds:
        return ()
    alike = {limb.name for limb in mechanism.limbs if limb.type == max(kinds, key=kinds.count)}
    found = []
    for link in (BASE, PLATFORM):
        points = _points_of(layout, link, alike)
        radius = _radius(points, layout.size)
        if radius is not None:
            text = f"{link} joints on a circle of {radius:.5g} {mechanism.length_unit}"
            found.append(text)
    return tuple(found)


def _points_of(layout: Layout, link: str, limbs: set[str]) -> np.ndarray:
    """Where some limbs end on a link, (n, 3)."""
    owners: set[str] = set()
    for limb in layout.mechanism.limbs:
        if limb.name in limbs:
            owners |= {joint.name for joint in limb.joints} | {limb.name}
            owners |= {rod.name for rod in layout.rods if rod.name.startswith(f"{limb.name} ")}
    mark = layout.links[link]
    kept = [point for owner, point in zip(mark.owners, mark.points, strict=True) if owner in owners]
    return np.array(kept).reshape(-1, 3)


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
