"""Refuse graphs of links that cannot be right: links that nothing holds, couplings in a circle,
names that nothing has.
"""

from __future__ import annotations

from collections.abc import Sequence

from symkin.errors import MechanismError
from symkin.model.description import Description
from symkin.model.joined import joined_to
from symkin.model.joint import BASE
from symkin.model.names import check_name
from symkin.text import meant, shown


def links_of(graph: Description) -> tuple[str, ...]:
    """The links by name, the base first; those within limbs have no names."""
    pairs = [tuple(entry.links) for entry in (*graph.link_joints, *graph.link_rods, *graph.limbs)]
    return tuple(dict.fromkeys([BASE, *(link for pair in pairs for link in pair)]))


def check_graph(graph: Description) -> None:
    """Raise MechanismError where the description contradicts itself."""
    links = links_of(graph)
    for link in links:
        check_name(link, "link")
    _check_held(graph, links)
    if (
        not graph.link_rods
        and not graph.limbs
        and all(entry.joint.type == "weld" for entry in graph.link_joints)
    ):
        raise MechanismError(
            "no joint moves: all of them are welds; a mechanism needs one that moves"
        )
    if graph.platform_link is not None:
        if graph.platform_link == BASE:
            raise MechanismError(
                "platform.link = 'base'; the base does not move, name the link whose pose is wanted"
            )
        _check_known(graph.platform_link, links, "platform.link", "links")
    elif _has_frame(graph):
        raise MechanismError(
            f"platform.link is missing; name the link that carries the platform frame: "
            f"{', '.join(links[1:])}"
        )
    for point in graph.link_points:
        _check_known(point.link, links, "link", "links")
        check_name(point.name, f"link {point.link!r}: points")
    names = [point.name for point in graph.link_points]
    for name in names:
        if names.count(name) > 1:
            raise MechanismError(f"two points are named {name!r}; names must be unique in the file")
    _check_couplings(graph)


def _has_frame(graph: Description) -> bool:
    frame = tuple(graph.platform_position), tuple(graph.platform_quaternion), graph.motion
    return frame != ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), "spatial")


def _check_held(graph: Description, links: Sequence[str]) -> None:
    """Every link is joined to the base, if over others."""
    reached = joined_to((*graph.link_joints, *graph.link_rods, *graph.limbs), BASE)
    lost = [link for link in links if link not in reached]
    if len(reached) == 1:
        raise MechanismError("no joint or rod names the link 'base'; the fixed link has that name")
    if lost:
        raise MechanismError(
            f"link {lost[0]!r}: nothing holds it to the "
            f"base{f', nor {len(lost) - 1} more' if len(lost) > 1 else ''}; join it by a "
            "joint or rod to a link that is held"
        )


def _check_known(name: str, known: Sequence[str], where: str, what: str) -> None:
    if name not in known:
        raise MechanismError(
            f"{where} = {shown(name)} is unknown{meant(name, known)}; {what} are {', '.join(known)}"
        )


def _check_couplings(graph: Description) -> None:
    coordinates = {c.name: c for c in graph.coordinates}
    known = [name for name, c in coordinates.items() if not c.is_rotation]
    depends: dict[str, tuple[str, ...]] = {}
    for coupling in graph.couplings:
        where = f"coupling of {coupling.joint!r}"
        ball = next(
            (
                name
                for name in (coupling.joint, *coupling.names)
                if name in coordinates and name not in known
            ),
            None,
        )
        if ball is not None:
            raise MechanismError(
                f"{where}: {ball!r} is a spherical joint, which has no angle to couple; allowed: "
                f"{', '.join(known)}"
            )
        _check_known(coupling.joint, known, "coupling: joint", "coordinates")
        for name in coupling.names:
            _check_known(name, known, f"{where}: of", "coordinates")
        if coupling.joint in depends:
            raise MechanismError(
                f"{where} stands twice; a joint is coupled once, to any number of others"
            )
        depends[coupling.joint] = coupling.names
    for name in depends:
        _check_circle(name, depends)


def _check_circle(begin: str, depends: dict[str, tuple[str, ...]]) -> None:
    path, todo = {begin}, list(depends[begin])
    while todo:
        name = todo.pop()
        if name == begin:
            raise MechanismError(
                f"coupling of {begin!r}: the couplings run in a circle back to it; leave one of "
                f"them out"
            )
        if name in depends and name not in path:
            path.add(name)
            todo.extend(depends[name])
