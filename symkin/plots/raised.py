"""What a sketch tells of platforms: how far one that lies in its base's plane is raised, and the
circles on which joints stand. NumPy only.
"""

from __future__ import annotations

import numpy as np

from symkin.drawing.layout import Layout, RodMark
from symkin.model.joint import BASE
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
    roles = {mark.role: link for link, mark in layout.links.items()}
    if layout.joints or not moves or len(layout.rods) < 3 or [*roles] != ["base", "platform"]:
        return layout, ()
    ends = np.vstack([mark.points for mark in layout.links.values()])
    up = _thin(ends)
    if np.ptp(ends @ up) > _SAME * layout.size:
        return layout, ()
    height = _RAISED * layout.size
    move = Pose(height * up, np.array([1.0, 0.0, 0.0, 0.0]))
    note = f"platform raised by {height:.4g} {mechanism.length_unit} from its reference"
    return layout.at({BASE: Pose.identity(), roles["platform"]: move}), (note,)


def _thin(points: np.ndarray) -> np.ndarray:
    """The direction in which points extend least, upward."""
    v = np.linalg.svd(points - points.mean(axis=0))[2][2]
    return np.asarray(v * np.sign(v[int(np.argmax(np.abs(v)))]))


def circle_notes(layout: Layout) -> tuple[str, ...]:
    """The circles on which the joints and rods of the most frequent kind stand on base and
    platform, where there is one: four or more, or three on both.
    """
    if layout.pose is None:
        return ()
    found, unit = [], layout.mechanism.length_unit
    for mark in (m for m in layout.links.values() if m.role != "link"):
        kinds: dict[object, list[np.ndarray]] = {}
        for own in layout.marks.values():
            kind = own.kinds if isinstance(own, RodMark) else own.type
            kinds.setdefault((kind, own.actuated), []).extend(mark.of(own.name))
        points = np.array(max(kinds.values(), key=len)).reshape(-1, 3)
        radius = _radius(points, layout.size)
        if radius is not None:
            text = f"{mark.role} joints on a circle of {radius:.5g} {unit}"
            found.append((len(points), text))
    return tuple(text for count, text in found if count > 3 or len(found) > 1)


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
