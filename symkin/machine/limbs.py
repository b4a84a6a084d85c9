"""Find the limbs between the base and the platform that a graph of links is: chains of joints,
rods, and chains that end in rods.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from symkin.closure.branches import Branch, Element, chains_of, edges_of
from symkin.errors import InputError
from symkin.model.arm import arm_of
from symkin.model.bar import Bar
from symkin.model.joint import BASE, PLATFORM, Joint
from symkin.model.limb import AnyLimb, Limb, Rod, RodLimb
from symkin.model.mechanism import Mechanism, require_mechanism

_TURNED = ("R", "P", "H", "C")
"""Types whose coordinates stay what they are where the axis points the other way and the links
change places.
"""


def with_limbs(
    mechanism: Mechanism, verb: str, instead: str, *, arms_only: bool = False
) -> Mechanism:
    """The mechanism, or the arm or the limbs that a graph is, for a verb that takes limbs between a
    base and a platform; `arms_only` where answers are over coordinates that the graph's closure
    must hold too. Raises InputError for other graphs; `instead` says what is taken for them.
    """
    require_mechanism(mechanism)
    found = arm_of(mechanism) or (mechanism if arms_only else limbs_of(mechanism)[0])
    if not found.is_graph:
        return found
    arm = (
        "; of an arm, name the tool's link by [platform] link, of a robot's file by --platform LINK"
    )
    raise InputError(
        f"{mechanism.name} is a graph of links and joints, and {verb} takes limbs between a "
        f"base and a platform, and serial arms; "
        f"{instead}{arm if mechanism.platform_link is None else ''}"
    )


def limbs_of(graph: Mechanism) -> tuple[Mechanism, dict[str, str]]:
    """The graph as limbs between the base and the platform, with its names and the order of its
    actuated joints, without named points, and what these call its links. Itself where it is
    limbs, or another graph: of loops within loops, couplings, links that no limb holds.

    >>> import symkin
    >>> z, links = [0, 0, 1], []
    >>> for k in range(2):
    ...     motor = symkin.Joint(f"motor{k}", "R", [70 * k, 0, 0], z, actuated=True)
    ...     end = symkin.Joint(f"end{k}", "R", [70 * k, 90, 0], z)
    ...     links.append(symkin.LinkJoint(motor, ["base", f"arm{k}"]))
    ...     links.append(symkin.LinkJoint(end, [f"arm{k}", "platform"]))
    >>> bench, called = limbs_of(symkin.Mechanism("bench", link_joints=links))
    >>> [limb.type for limb in bench.limbs], called["arm1"]
    (['RR', 'RR'], 'limb2.1')
    """
    platform = graph.platform_link
    if platform is None or graph.couplings or not graph.is_graph:
        return graph, {}
    chains = [
        chain if chain.ends[0] == BASE or chain.ends[1] == platform else chain.reversed
        for chain in chains_of(list(edges_of(graph)), {platform})
    ]
    links = {BASE: BASE}
    found = list(_limbs(graph, chains, platform, links))
    limbs = [limb for limb in found if limb is not None]
    if not limbs or len(limbs) < len(found):
        return graph, {}
    names = [c.name for c in graph.actuated]
    made = replace(
        graph,
        limbs=sorted(limbs, key=lambda limb: _first(limb, names)),
        link_joints=(),
        link_rods=(),
        link_points=(),
        link_meshes=(),
        platform_link=PLATFORM,
        example=None,
    )
    if [c.name for c in made.actuated] != names:
        return graph, {}
    return made, links | {platform: PLATFORM}


def _first(limb: AnyLimb, names: Sequence[str]) -> int:
    """The place of a limb's first actuated coordinate among the names; after all where it has
    none.
    """
    own = {limb.name} | {c.name for joint in limb.joints for c in joint.coordinates}
    return min((k for k, name in enumerate(names) if name in own), default=len(names))


def _limbs(
    graph: Mechanism, chains: Sequence[Branch], platform: str, names: dict[str, str]
) -> Iterator[AnyLimb | None]:
    """The limb of each chain from the base, with the rods that go on from its end; None of what is
    none. The limbs' names of links are added to `names`.
    """
    used = 0
    for number, chain in enumerate(c for c in chains if c.ends[0] == BASE):
        name, end = f"limb{number + 1}", chain.ends[1]
        rods = () if end == platform else [c for c in chains if end in c.ends and c is not chain]
        used += 1 + len(rods)
        names |= _names_of_links(chain, name)
        yield _limb(graph, name, chain, rods, platform)
    if used < len(chains):
        yield None


def _names_of_links(chain: Branch, limb: str) -> dict[str, str]:
    """What a limb calls the links of its chain; a weld makes two links one."""
    found, count = {}, 0
    for element, link in zip(chain.elements, (*chain.links, chain.ends[1]), strict=True):
        count += not _is_weld(element)
        found[link] = f"{limb}.{count}" if count else BASE
    return found


def _is_weld(element: Element) -> bool:
    return isinstance(element.part, Joint) and element.part.type == "weld"


def _limb(
    graph: Mechanism, name: str, chain: Branch, rods: Sequence[Branch], platform: str
) -> AnyLimb | None:
    if any(r.ends != (chain.ends[1], platform) or len(r.elements) > 1 for r in rods):
        return None
    if not rods and chain.ends[1] != platform:
        return None
    elements = [e for e in chain.elements if not _is_weld(e)]
    at_end = 0 if rods or not elements else int(isinstance(elements[-1].part, Bar))
    joints = [_outward(e) for e in elements[: len(elements) - at_end]]
    bars = [r.elements[0] for r in rods] or elements[len(elements) - at_end :]
    if not joints and len(bars) == 1:
        return _rod_limb(graph, bars[0])
    ends = [_rod(graph, bar) for bar in bars]
    if not joints or None in joints or None in ends:
        return None
    return Limb(name, [j for j in joints if j is not None], [r for r in ends if r is not None])


def _outward(element: Element) -> Joint | None:
    """The joint as it moves its outer link; None of what is no joint, or has other coordinates from
    its other side.
    """
    joint = element.part
    if not isinstance(joint, Joint):
        return None
    if element.along:
        return joint
    return joint.turned() if joint.type in _TURNED else None


def _ends(graph: Mechanism, element: Element) -> tuple[list[float], list[float]]:
    """The centre of a rod on its first link, and that on the platform in the platform's frame."""
    bar = element.part
    assert isinstance(bar, Bar)  # noqa: S101 - the caller has looked
    start, end = bar.places if element.along else bar.places[::-1]
    return start.tolist(), graph.reference_pose.inverse().apply(end).tolist()


def _rod_limb(graph: Mechanism, element: Element) -> RodLimb | None:
    bar = element.part
    if not isinstance(bar, Bar) or bar.coordinate is None:
        return None
    start, end = _ends(graph, element)
    limits, kind = bar.coordinate.limits, "SPS" if bar.spins else "UPS"
    return RodLimb(bar.coordinate.name, start, end, bar.offset, limits, kind)  # type: ignore[arg-type]


def _rod(graph: Mechanism, element: Element) -> Rod | None:
    bar = element.part
    if not isinstance(bar, Bar) or bar.coordinate is not None:
        return None
    return Rod(*_ends(graph, element), bar.length)
