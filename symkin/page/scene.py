"""What the page draws of a mechanism: shapes of links, joints, rods and frames, as numbers for
JSON.

Every link's frame is the base frame at the reference configuration, as in `closure/link_poses.py`:
a link's pose is its displacement from there, so that all geometry stands at the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symkin.closure.branches import Branch, edges_of
from symkin.model.bar import Bar
from symkin.model.joint import BASE, Joint
from symkin.model.mechanism import Mechanism
from symkin.page.bodies import body_of, distinct
from symkin.page.mesh_files import UnreadMeshError, mesh_item
from symkin.plots.graph_lines import reference_graph_lines, view_axes
from symkin.plots.graph_painter import LINK_COLOURS
from symkin.plots.mechanism_lines import reference_lines
from symkin.plots.style import COLOURS
from symkin.text import counted, first_of

_SYMBOL, _SMALLEST = 0.085, 0.03
"""Length of a joint's symbol over the size: at most, and at least where joints stand close
together.
"""
_APART = 0.55
"""Length of a symbol over the distance between neighbouring joints."""
_SAME = 1e-6
"""Distance over the size below which two points are one."""

Item = dict[str, Any]


def scene_of(mechanism: Mechanism, links: Sequence[str]) -> dict[str, Any]:
    """The scene of a mechanism whose links are numbered as in `links`; lengths in its unit."""
    meshes, notes = _meshes(mechanism, links)
    items = _Items(mechanism, links).all() + meshes
    axes, planar = view_axes(reference_graph_lines(mechanism))
    size = mechanism.characteristic_length
    return {
        "name": mechanism.name,
        "title": mechanism.title or mechanism.name,
        "size": size,
        "lengthUnit": mechanism.length_unit,
        "symbol": _symbol(items, size),
        "view": {
            "right": axes[0].tolist(),
            "up": axes[1].tolist(),
            "towards": axes[2].tolist(),
            "planar": planar,
        },
        "colours": COLOURS,
        "items": items,
        "notes": notes,
    }


def _meshes(mechanism: Mechanism, links: Sequence[str]) -> tuple[list[Item], list[str]]:
    """The meshes that can be read, and sentences about the others."""
    found: list[Item] = []
    unread: dict[str, dict[str, None]] = {}
    for mesh in (mesh for mesh in mechanism.link_meshes if mesh.link in links):
        try:
            found.append(mesh_item(mesh, links.index(mesh.link)))
        except UnreadMeshError as error:
            unread.setdefault(str(error), {})[mesh.file] = None
    notes = [
        f"Not shown: {counted(len(files), 'file')} of meshes ({first_of(list(files), 3)}); {why}."
        for why, files in unread.items()
    ]
    return found, notes


def _symbol(items: Sequence[Item], size: float) -> float:
    """Length of joint symbols: smaller where joints stand close together."""
    places = distinct(
        np.array([i["point"] for i in items if i["kind"] == "joint"]).reshape(-1, 3), _SAME * size
    )
    if len(places) < 2:
        return _SYMBOL * size
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2) + np.diag(
        np.full(len(places), np.inf)
    )
    return float(np.clip(_APART * np.median(gaps.min(axis=1)), _SMALLEST * size, _SYMBOL * size))


class _Items:
    """Gathers the items of a scene, link by link."""

    def __init__(self, mechanism: Mechanism, links: Sequence[str]) -> None:
        self.mechanism, self.size = mechanism, mechanism.characteristic_length
        self.number = {name: k for k, name in enumerate(links)}
        self.points: dict[str, list[np.ndarray]] = {}
        self.items: list[Item] = []
        self.slides = _slides(mechanism)

    def all(self) -> list[Item]:
        edges = list(edges_of(self.mechanism))
        slides = [edge for edge in edges if _has_no_place(edge)]
        for edge in edges:
            if isinstance(edge.elements[0].part, Bar):
                self._rod(edge, edge.elements[0].part)
            elif edge not in slides:
                self._joint(edge, *self._place(edge))
        for point in self.mechanism.link_points:
            self._point(point.link, point.name, np.array(point.point))
        for edge in slides:
            self._joint(edge, *[self._beside(edge)] * 2)
        self._frames()
        return [*self._bodies(edges), *self.items, *self._couplings()]

    # --- joints and rods --------------------------------------------------------------------------

    def _at(self, link: str, point: np.ndarray) -> dict[str, Any]:
        return {"link": self.number[link], "point": point.tolist()}

    def _attach(self, link: str, point: np.ndarray) -> None:
        self.points.setdefault(link, []).append(point)

    def _place(self, edge: Branch) -> tuple[np.ndarray, np.ndarray]:
        """The places of a joint on its two links: a slide of a limb goes from one to the other."""
        name = edge.elements[0].name
        place = np.asarray(self.mechanism.places[name])
        return self.slides.get(name, (place, place))

    def _beside(self, edge: Branch) -> np.ndarray:
        """A slide or weld without a place of its own stands halfway between the other joints of its
        links.
        """
        middles = [
            np.mean(self.points[link], axis=0)
            for link in edge.ends
            if link != BASE and self.points.get(link)
        ]
        return np.asarray(np.mean(middles, axis=0)) if middles else self._place(edge)[0]

    def _joint(self, edge: Branch, start: np.ndarray, place: np.ndarray) -> None:
        joint = edge.elements[0].part
        assert isinstance(joint, Joint)  # noqa: S101 - the caller has asked
        before, after = edge.ends
        self._attach(before, start)
        self._attach(after, place)
        axes = [list(axis) for axis in (joint.axis, joint.axis2) if axis is not None]
        self.items.append(
            {
                "kind": "joint",
                "type": joint.type,
                "name": joint.name,
                "links": [self.number[before], self.number[after]],
                "between": [before, after],
                "start": start.tolist(),
                "point": place.tolist(),
                "axes": axes,
                "actuated": joint.actuated,
                "coordinates": [c.name for c in joint.coordinates if c.kind != "quaternion"],
                "slides": joint.type in "PCH",
            }
        )

    def _rod(self, edge: Branch, bar: Bar) -> None:
        first, second = (
            end.at_reference(self.mechanism.reference_pose) for end in (bar.start, bar.end)
        )
        for link, point in zip(edge.ends, (first, second), strict=True):
            self._attach(link, point)
        ends = [
            self._at(link, point) for link, point in zip(edge.ends, (first, second), strict=True)
        ]
        drives = bar.coordinate is not None
        self.items.append(
            {
                "kind": "rod",
                "name": bar.coordinate.name if bar.coordinate is not None else bar.name,
                "from": ends[0],
                "to": ends[1],
                "actuated": drives,
                "coordinates": [bar.coordinate.name] if bar.coordinate is not None else [],
            }
        )

    def _point(self, link: str, name: str, point: np.ndarray) -> None:
        if link != BASE:
            self._attach(link, point)
        self.items.append({"kind": "point", "name": name, **self._at(link, point)})

    def _couplings(self) -> list[Item]:
        """Lines between coupled joints, numbered as the items of those joints."""
        joints = {i["name"]: i for i in self.items if i["kind"] in ("joint", "rod")}
        found = []
        for coupling in self.mechanism.couplings:
            first, *others = (_owner(name, joints) for name in (coupling.joint, *coupling.names))
            for other in others:
                found.append(
                    {
                        "kind": "coupling",
                        "from": _middle(joints[first]),
                        "to": _middle(joints[other]),
                    }
                )
        return found

    # --- links and frames -------------------------------------------------------------------------

    def _frames(self) -> None:
        reference, link = self.mechanism.reference_pose, self.mechanism.platform_link
        self.items.append(_frame(self.number[BASE], "base", np.zeros(3), np.eye(3)))
        if link is not None:
            position = np.asarray(reference.position)
            self._attach(link, position)
            self.items.append(
                _frame(
                    self.number[link],
                    self.mechanism.frame_name,
                    position,
                    np.asarray(reference.rotation),
                )
            )

    def _bodies(self, edges: Sequence[Branch]) -> list[Item]:
        self._hands(edges)
        found, turn = [], 0
        for link, points in self.points.items():
            role = (
                "base"
                if link == BASE
                else "platform"
                if link == self.mechanism.platform_link
                else "link"
            )
            colour = {"base": "base edge", "platform": "platform"}.get(role)
            if colour is None:
                colour, turn = LINK_COLOURS[turn % len(LINK_COLOURS)], turn + 1
            body = body_of(np.array(points), self.size)
            found.append(
                {
                    "kind": "body",
                    "link": self.number[link],
                    "name": link,
                    "role": role,
                    "colour": colour,
                    "points": body.points.tolist(),
                    "edges": [list(edge) for edge in body.edges],
                    "faces": body.faces,
                }
            )
        return found

    def _hands(self, edges: Sequence[Branch]) -> None:
        """A link with one point gets a second one, which shows how it turns."""
        hand = 0.16 * self.size * min(1.0, float(np.sqrt(12 / max(1, len(self.points)))))
        for edge in edges:
            axis = np.array(getattr(edge.elements[0].part, "axis", None) or (0.0, 0.0, 1.0))
            across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
            for link in edge.ends:
                points = self.points.get(link, [])
                if link != BASE and len(distinct(np.array(points), _SAME * self.size)) == 1:
                    points.append(points[0] + hand * across / np.linalg.norm(across))


def _frame(link: int, name: str, position: np.ndarray, rotation: np.ndarray) -> Item:
    return {
        "kind": "frame",
        "link": link,
        "name": name,
        "position": position.tolist(),
        "rotation": rotation.tolist(),
    }


def _slides(mechanism: Mechanism) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Where the slides of limbs and arms begin and end, as pictures draw them: along their axes,
    one after the other.
    """
    if mechanism.is_graph:
        return {}
    found: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for lines in reference_lines(mechanism).limbs:
        for segment in (s for s in lines.segments if "slide" in s.kind):
            middle = 0.5 * (segment.start + segment.end)
            names = [name for name, place in lines.places.items() if np.array_equal(place, middle)]
            found |= dict.fromkeys(names, (segment.start, segment.end))
    return found


def _has_no_place(edge: Branch) -> bool:
    """A P joint or a weld whose point, which holds nothing, the file may have left out."""
    part = edge.elements[0].part
    return isinstance(part, Joint) and part.type in ("P", "weld") and not any(part.point)


def _owner(coordinate: str, joints: dict[str, Item]) -> str:
    """The joint that has a coordinate: `u.1` is one of `u`."""
    return coordinate if coordinate in joints else coordinate.rsplit(".", 1)[0]


def _middle(item: Item) -> dict[str, Any]:
    return (
        item["from"]
        if item["kind"] == "rod"
        else {"link": item["links"][1], "point": item["point"]}
    )
