"""What the page draws of a mechanism: the layout of marks on links as numbers for JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from symkin.drawing.camera import Camera
from symkin.drawing.layout import JOINT_NAMES, Layout, LinkMark, RodMark, layout_of
from symkin.drawing.outline import distinct
from symkin.drawing.palette import COLOURS, FRAME_COLOURS
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.page.mesh_files import UnreadMeshError, mesh_item
from symkin.page.solids import with_solids
from symkin.spatial.pose import Pose
from symkin.text import counted, first_of

_SYMBOL, _SMALLEST = 0.085, 0.03
"""Length of a joint's symbol over the size: at most, and at least where joints stand close
together.
"""
_APART = 0.55
"""Length of a symbol over the distance between neighbouring joints."""
_LINES = 8
"""Lines of the grid to each side of its middle."""
_SAME = 1e-6
"""Distance over the size below which two points are one."""

_LIGHT = {
    **COLOURS,
    "white": "#ffffff",
    "outline": COLOURS["text"],
    **dict(zip(("frame x", "frame y", "frame z"), FRAME_COLOURS, strict=True)),
}
_DARK = {
    "text": "#e8edf2",
    "quiet": "#9fb0c0",
    "base": "#5d6b78",
    "base edge": "#8796a5",
    "platform": "#3f90d2",
    "platform edge": "#7dbbee",
    "link": "#a9b7c4",
    "accent": "#f08a54",
    "loop": "#c39be0",
    "grid": "#26303a",
    "pane": "#12181e",
    "axis": "#5d6b78",
    "white": "#e8edf2",
    "outline": "#080b0e",
    "frame x": "#e06c5c",
    "frame y": "#57b985",
    "frame z": "#6d9be0",
}
Item = dict[str, Any]


def scene_of(mechanism: Mechanism, links: Sequence[str]) -> dict[str, Any]:
    """The scene of a mechanism whose links are numbered as in `links`; lengths in its unit."""
    meshes, notes = _meshes(mechanism, links)
    layout = layout_of(mechanism)
    items, camera = [*_items(layout, links), *meshes], Camera.of(layout)
    size = mechanism.characteristic_length
    symbol = _symbol(items, size)
    view = {
        "right": camera.axes[0].tolist(),
        "up": camera.axes[1].tolist(),
        "towards": camera.axes[2].tolist(),
        "planar": camera.planar,
    }
    return {
        "name": mechanism.name,
        "title": mechanism.title or mechanism.name,
        "size": size,
        "lengthUnit": mechanism.length_unit,
        "symbol": symbol,
        "grid": _grid(items, view, size, symbol),
        "view": view,
        "colours": {"light": _LIGHT, "dark": _DARK},
        "items": [_told(with_solids(item, symbol, size, view)) for item in items],
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


def _grid(items: Sequence[Item], view: Item, size: float, symbol: float) -> list[list[float]]:
    """Ends of lines a round length apart, below the base or behind all of a planar mechanism, whose
    base may stand at one end.
    """
    bodies = [i for i in items if i["kind"] == "body" and (view["planar"] or i["role"] == "base")]
    points = np.array([p for i in bodies for p in i["points"]] or [[0.0, 0.0, 0.0]])
    normal = np.array(view["towards"] if view["planar"] else [0.0, 0.0, 1.0])
    along = np.array([view["right"], view["up"]]) if view["planar"] else np.eye(3)[:2]
    level = np.min(points @ normal) - (1.2 if view["planar"] else 0.4) * symbol
    power = 10.0 ** math.floor(math.log10(size / 5.0))
    step = power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(k - size / 5.0 / power))
    centre = np.floor(along @ points.mean(axis=0) / step + 0.5)
    ends, k = np.array([-_LINES, _LINES]), np.arange(-_LINES, _LINES + 1)[:, None]
    across = np.stack(np.broadcast_arrays(k, ends), axis=2)
    lines = np.stack([across, across[..., ::-1]], axis=1).reshape(-1, 2)
    return (step * (centre + lines) @ along + level * normal).tolist()


def _items(layout: Layout, links: Sequence[str]) -> Iterator[Item]:
    """The layout of marks at the reference as numbers for JSON, links numbered as in `links`."""
    number = {name: k for k, name in enumerate(links)}

    def at(link: str, point: np.ndarray) -> dict[str, Any]:
        return {"link": number[link], "point": point.tolist()}

    def owner(name: str) -> dict[str, Any]:
        mark = layout.marks[name]
        is_rod = isinstance(mark, RodMark)
        return at(mark.links[0], mark.start) if is_rod else at(mark.links[1], mark.end)

    for link, mark in layout.links.items():
        yield _body(number[link], link, mark, layout.size)
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
    platform = layout.mechanism.platform_link
    if layout.pose is not None and platform is not None:
        yield _frame(number[platform], layout.mechanism.frame_name, layout.pose)
    for first, second in layout.couplings:
        yield {"kind": "coupling", "from": owner(first), "to": owner(second)}


def _told(item: Item) -> Item:
    """An item with its name on the picture, and what is said of it under the pointer."""
    kind, name = item["kind"], item.get("name", "")
    if kind == "body":
        told = {"base": "base, the fixed link", "link": f"link {name}"}
        platform = f"{name}, the link of the platform frame"
        return item | {"told": told.get(item["role"], platform)}
    if kind in ("joint", "rod"):
        what = "rod" if kind == "rod" else f"{JOINT_NAMES[item['type']]} joint"
        drives = "actuated " if item["actuated"] else ""
        return item | {"told": f"{name}: {drives}{what}", "label": name}
    return item | {"told": f"{'link' if kind == 'mesh' else kind} {name}", "label": name}


def _body(number: int, link: str, mark: LinkMark, size: float) -> Item:
    body = mark.body(size)
    return {
        "kind": "body",
        "link": number,
        "name": link,
        "role": mark.role,
        "label": "" if mark.role == "base" else mark.label,
        "colour": mark.colour,
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
