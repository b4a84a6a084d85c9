"""Take closed linkages out of a robot: the tree of driven joints that is left stands for it where
loops are not wanted.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from symkin.errors import MechanismError
from symkin.formats.graph_form import as_graph
from symkin.formats.naming import fresh_name
from symkin.formats.parts import in_two
from symkin.model.graph import LinkJoint
from symkin.model.graph_checks import links_of
from symkin.model.joined import joined_to
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.model.motor import Motor


@dataclass(frozen=True)
class Drive:
    """What drives a coordinate in a linkage's place, in metres, radians and SI units: its range,
    and what the motors give there together.
    """

    limits: tuple[float, float]
    motor: Motor | None


def serial_form(
    mechanism: Mechanism, inside: Collection[str], drives: Mapping[str, Drive]
) -> Mechanism:
    """Leave out the joints and rods `inside` linkages, but those of the driven coordinates, which
    are actuated, and the links that nothing else carries.

    The graph is in metres and radians. Raises MechanismError where a joint is driven in part, and
    where what stands outside the linkages, or the platform frame, hangs on a link that is left out.
    """
    graph = as_graph(mechanism)
    links, kept = set(links_of(graph)), list[LinkJoint]()
    for entry in graph.link_joints:
        names = [c.name for c in entry.joint.coordinates]
        driven = [name for name in names if name in drives]
        if entry.joint.name not in inside:
            kept.append(entry)
        elif driven and driven != names:
            raise MechanismError(
                f"{mechanism.name}: of the joint {entry.joint.name!r} {', '.join(driven)} alone is "
                f"driven; a serial robot needs all of {', '.join(names)}"
            )
        elif driven:
            kept += _driven(entry, drives, links)
    rods = [rod for rod in graph.link_rods if rod.name not in inside]
    reached = joined_to(kept, BASE)
    hanging = {entry.joint.name: entry.links for entry in kept}
    hanging |= {rod.name: rod.links for rod in rods}
    if graph.platform_link is not None:
        hanging["the platform frame"] = (graph.platform_link,)
    for name, ends in hanging.items():
        for link in ends:
            if link not in reached:
                raise MechanismError(
                    f"{mechanism.name}: {name} is on the link {link!r}, which only joints carry "
                    f"that are left out; name driven joints that lead there from the base"
                )
    left = {c.name for entry in kept for c in entry.joint.coordinates}
    return replace(
        graph,
        link_joints=kept,
        link_rods=rods,
        couplings=[c for c in graph.couplings if left >= {c.joint, *c.names}],
        link_points=[point for point in graph.link_points if point.link in reached],
    )


def _driven(entry: LinkJoint, drives: Mapping[str, Drive], links: set[str]) -> Iterator[LinkJoint]:
    """A driven joint; one of two coordinates as two, which have a range each."""
    joint, (first, second) = entry.joint, entry.links
    parts, ends = [joint], [entry.links]
    if len(joint.coordinates) > 1:
        middle = fresh_name(f"{joint.name}.link", links)
        parts, ends = [*in_two(joint)], [(first, middle), (middle, second)]
    for part, between in zip(parts, ends, strict=True):
        own = drives[part.name]
        yield LinkJoint(replace(part, actuated=True, limits=own.limits, motor=own.motor), between)
