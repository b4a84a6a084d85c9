"""What the page draws of a mechanism: the layout of marks on links as numbers for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from symkin.drawing.camera import Camera
from symkin.drawing.layout import Layout, LinkMark, RodMark, layout_of, link_colours
from symkin.drawing.outline import distinct
from symkin.drawing.palette import COLOURS
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.page.bodies import Body, body_of
from symkin.page.mesh_files import UnreadMeshError, mesh_item
from symkin.spatial.pose import Pose
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
    layout = layout_of(mechanism)
    items, camera = [*_items(layout, links), *meshes], Camera.of(layout)
    size = mechanism.characteristic_length
    return {
        "name": mechanism.name,
        "title": mechanism.title or mechanism.name,
        "size": size,
        "lengthUnit": mechanism.length_unit,
        "symbol": _symbol(items, size),
        "view": {
            "right": camera.axes[0].tolist(),
            "up": camera.axes[1].tolist(),
            "towards": camera.axes[2].tolist(),
            "planar": camera.planar,
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


def _items(layout: Layout, links: Sequence[str]) -> Iterator[Item]:
    """The layout of marks at the reference as numbers for JSON, links numbered as in `links`."""
    number = {name: k for k, name in enumerate(links)}

    def at(link: str, point: np.ndarray) -> dict[str, Any]:
        return {"link": number[link], "point": point.tolist()}

    def owner(name: str) -> dict[str, Any]:
        mark = layout.marks[name]
        is_rod = isinstance(mark, RodMark)
        return at(mark.links[0], mark.start) if is_rod else at(mark.links[1], mark.end)

    colours = link_colours(layout)
    for link, mark in layout.links.items():
        yield _body(number[link], link, mark, layout, colours.get(link, "base edge"))
    for joint in layout.joints:
        yield {
            "kind": "joint",
            "type": joint.type,
            "name": joint.name,
            "links": [number[link] for link in joint.links],
            "between": list(joint.links),
            "start": joint.start.tolist(),
            "point": joint.end.tolist(),
            "axes": [axis.tolist() for axis in joint.axes],
            "actuated": joint.actuated,
            "coordinates": [c.name for c in joint.joint.coordinates if not c.is_rotation],
            "slides": joint.type in "PCH",
        }
    for rod in layout.rods:
        yield {
            "kind": "rod",
            "name": rod.name,
            "from": at(rod.links[0], rod.start),
            "to": at(rod.links[1], rod.end),
            "actuated": rod.actuated,
            "coordinates": [rod.bar.coordinate.name] if rod.bar.coordinate is not None else [],
        }
    for name, (link, point) in layout.points.items():
        yield {"kind": "point", "name": name, **at(link, point)}
    yield _frame(number[BASE], "base", Pose.identity())
    platform, mechanism = layout.mechanism.platform_link, layout.mechanism
    if layout.pose is not None and platform is not None:
        yield _frame(number[platform], mechanism.frame_name, layout.pose)
    for first, second in layout.couplings:
        yield {"kind": "coupling", "from": owner(first), "to": owner(second)}


def _body(number: int, link: str, mark: LinkMark, layout: Layout, colour: str) -> Item:
    roles = {BASE: "base", layout.mechanism.platform_link: "platform"}
    role = roles.get(link, "link")
    body = (
        body_of(mark.points, layout.size)
        if mark.edges is None
        else Body(mark.points, list(mark.edges), [])
    )
    return {
        "kind": "body",
        "link": number,
        "name": link,
        "role": role,
        "colour": colour if role == "link" else "platform" if role == "platform" else "base edge",
        "points": body.points.tolist(),
        "edges": [list(edge) for edge in body.edges],
        "faces": body.faces,
    }


def _frame(link: int, name: str, pose: Pose) -> Item:
    return {
        "kind": "frame",
        "link": link,
        "name": name,
        "position": np.asarray(pose.position).tolist(),
        "rotation": np.asarray(pose.rotation).tolist(),
    }
