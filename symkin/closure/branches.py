"""Split a mechanism into bodies and the branches between them, and choose which bodies keep
coordinates of their own.

Bodies are the base, the links at which three or more joints and rods meet, those at the end of an
open chain, and the platform where its pose is a coordinate. A branch is a chain of joints between
two bodies, through links of two joints each: a limb. Each body but the base is carried by one
branch (its pose follows from the joints of that branch), or it floats (it has a pose of its own);
every other branch closes loops, and writes rows. That choice keeps unknown coordinates few: a
minimum spanning tree of the bodies, where a branch weighs as many unknown freedoms as its joints
have, and a pose of its own six.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from symkin.model.bar import Bar
from symkin.model.joint import BASE, Joint
from symkin.model.limb import turns_about
from symkin.model.machine import gaps_of
from symkin.model.mechanism import Mechanism

_POSE_FREEDOM = 6
"""Unknown freedoms of a body that floats."""


@dataclass(frozen=True)
class Element:
    """A joint or a rod on the way from the first body of a branch to the second; not `along`: it
    was described the other way.
    """

    part: Joint | Bar
    path: str
    along: bool = True

    @property
    def balls(self) -> int:
        """Spherical joints, a rod's ends included."""
        return 2 if isinstance(self.part, Bar) else int(self.part.type == "S")

    @property
    def name(self) -> str:
        return self.part.name

    @property
    def freedom(self) -> int:
        """Freedoms that it leaves the links at its ends."""
        return self.part.freedom


@dataclass(frozen=True)
class Branch:
    """A chain of elements between two bodies; `links` are those between its elements. `carries`
    says that the second body's pose follows from it.
    """

    name: str
    ends: tuple[str, str]
    elements: tuple[Element, ...]
    links: tuple[str, ...]
    carries: bool = False

    @property
    def reversed(self) -> Branch:
        """The same branch from its second body."""
        elements = tuple(replace(e, along=not e.along) for e in reversed(self.elements))
        return Branch(
            self.name, (self.ends[1], self.ends[0]), elements, tuple(reversed(self.links))
        )


@dataclass(frozen=True)
class Layout:
    """Branches in the order in which rows are written, and the bodies that float."""

    branches: tuple[Branch, ...]
    floating: tuple[str, ...]


def layout_of(mechanism: Mechanism, kept: frozenset[str], *, pose: bool) -> Layout:
    """The layout for some coordinates that the closure must hold (`kept`: given or coupled ones),
    and, with `pose`, the platform's pose. Limbs of which it must hold none, or the pose, begin and
    end at the base and the platform, whose pose is a coordinate.
    """
    gaps = gaps_of(mechanism)
    if gaps is not None:
        return _layout_as_told(mechanism, gaps)
    pose = pose or not (mechanism.is_graph or kept)
    edges, platform = list(edges_of(mechanism)), mechanism.platform_link
    wanted = {platform} if pose and platform is not None else set()
    chains = chains_of(edges, wanted)
    # a distance does not say how the link between two balls is turned
    told = {point.link for point in mechanism.link_points} | (
        {platform} if platform is not None else set()
    )
    bridged = told & {link for chain in chains for link in _bridged(chain)}
    if bridged:
        chains = chains_of(edges, wanted | bridged)
    return _spanned(chains, mechanism, kept, pose)


def _layout_as_told(mechanism: Mechanism, closing: Collection[str]) -> Layout:
    """Every joint carries a link, but those that are told to close loops."""
    placed, carrying, rest = {BASE}, [], []
    for edge in edges_of(mechanism):
        if edge.name in closing:
            rest.append(edge)
            continue
        outward = edge if edge.ends[0] in placed else edge.reversed
        carrying.append(replace(outward, carries=True))
        placed.add(outward.ends[1])
    return Layout((*carrying, *rest), ())


# --- graphs ---------------------------------------------------------------------------------------


def edges_of(mechanism: Mechanism) -> Iterator[Branch]:
    """Joints and rods as branches of one element each, limbs by their joints."""
    for limb in mechanism.limbs:
        links = limb.links_along
        for joint, ends in zip(limb.joints, pairwise(links), strict=True):
            yield Branch(limb.name, ends, (Element(joint, mechanism.key_path(limb, joint)),), ())
        for bar in limb.bars(mechanism.reference_pose):
            yield Branch(limb.name, (links[-1], limb.links[1]), (Element(bar, bar.path),), ())
    for entry in mechanism.link_joints:
        yield Branch(
            entry.joint.name,
            (entry.links[0], entry.links[1]),
            (Element(entry.joint, entry.joint.name),),
            (),
        )
    for rod in mechanism.link_rods:
        yield Branch(rod.name, (rod.links[0], rod.links[1]), (Element(rod.bar, rod.name),), ())


def chains_of(edges: Sequence[Branch], wanted: set[str]) -> list[Branch]:
    """Branches between bodies, the base and those `wanted` among them, joined from the edges at
    links of two joints.
    """
    bodies = {BASE} | wanted
    while True:
        chains = _joined(edges, bodies)
        # a link between the second and the third ball of a chain keeps nothing at a distance: it is
        # a body
        more = {link for chain in chains for link in _between_balls(chain)}
        if not more:
            return chains
        bodies |= more


def _joined(edges: Sequence[Branch], bodies: set[str]) -> list[Branch]:
    at: dict[str, list[int]] = {}
    for number, edge in enumerate(edges):
        for link in edge.ends:
            at.setdefault(link, []).append(number)
    inner = {link for link, numbers in at.items() if len(numbers) == 2 and link not in bodies}
    used: set[int] = set()
    chains = []
    for number in range(len(edges)):
        if number in used:
            continue
        chain, own = _extended(number, edges, at, inner)
        used |= own
        chains.append(chain)
    return chains


def _extended(
    number: int, edges: Sequence[Branch], at: dict[str, list[int]], inner: set[str]
) -> tuple[Branch, set[int]]:
    """The chain to which an edge belongs, and the numbers of its edges."""
    own = {number}
    chain = edges[number]
    for _ in range(2):
        while chain.ends[1] in inner and chain.ends[1] != chain.ends[0]:
            following = next((n for n in at[chain.ends[1]] if n not in own), None)
            if following is None:
                break
            other = edges[following]
            other = other if other.ends[0] == chain.ends[1] else other.reversed
            chain = Branch(
                chain.name,
                (chain.ends[0], other.ends[1]),
                chain.elements + other.elements,
                (*chain.links, chain.ends[1], *other.links),
            )
            own.add(following)
        chain = chain.reversed
    return chain, own


def _between_balls(chain: Branch) -> list[str]:
    count, found = 0, []
    for k, element in enumerate(chain.elements):
        if count and element.balls and count + element.balls > 2:
            found.append(chain.links[k - 1])
        count += element.balls
    return found[:1]


def _bridged(chain: Branch) -> tuple[str, ...]:
    """The links between the balls of a chain, which one distance replaces."""
    balls = [k for k, element in enumerate(chain.elements) if element.balls]
    return chain.links[balls[0] : balls[-1]] if balls else ()


def _spanned(
    chains: Sequence[Branch], mechanism: Mechanism, kept: frozenset[str], pose: bool
) -> Layout:
    """Which branches carry bodies: from the base outward, the one of fewest unknown freedoms first,
    of equal ones that which ends at a pin; a body that only balls and rods reach floats, as the
    platform does whose pose is a coordinate.
    """
    floating = [mechanism.platform_link] if pose and mechanism.platform_link else []
    bodies = dict.fromkeys(link for chain in chains for link in chain.ends)
    placed = {BASE, *floating}
    carrying: dict[int, Branch] = {}
    queue: list[tuple[int, bool, int, bool]] = []

    weights = [_unknown_freedom(chain, kept) for chain in chains]
    pins = _pins(chains, weights)

    def offer(link: str) -> None:
        for number, (chain, weight) in enumerate(zip(chains, weights, strict=True)):
            if weight is None or number in carrying or link not in chain.ends:
                continue
            along = chain.ends[0] == link
            heapq.heappush(queue, (weight, (number, along) not in pins, number, along))

    for link in list(placed):
        offer(link)
    while True:
        while queue:
            weight, _, number, along = heapq.heappop(queue)
            branch = chains[number] if along else chains[number].reversed
            if branch.ends[1] in placed or number in carrying or weight > _POSE_FREEDOM:
                continue
            carrying[number] = replace(branch, carries=True)
            placed.add(branch.ends[1])
            offer(branch.ends[1])
        left = [body for body in bodies if body not in placed]
        if not left:
            break
        # the body that most branches hold to what is placed comes first
        held = {
            body: sum(body in c.ends and bool(placed & set(c.ends)) for c in chains)
            for body in left
        }
        body = max(left, key=lambda link: held[link])
        floating.append(body)
        placed.add(body)
        offer(body)
    order = _outward([carrying[n] for n in sorted(carrying)], {BASE, *floating})
    closing = [chain for number, chain in enumerate(chains) if number not in carrying]
    return Layout((*order, *(_from_base(chain, floating) for chain in closing)), tuple(floating))


def _pins(chains: Sequence[Branch], weights: Sequence[int | None]) -> set[tuple[int, bool]]:
    """Branches of several unknown freedoms, by number and whether along, that end at a body by a
    revolute joint about whose axis another one of them turns: carried by one, the body keeps its
    own turn out of the rows of the other, so that both are solved before it.
    """
    ends: dict[str, list[tuple[Joint, tuple[int, bool]]]] = {}
    for number, (chain, weight) in enumerate(zip(chains, weights, strict=True)):
        for along, link, element in zip((False, True), chain.ends, (0, -1), strict=True):
            part = chain.elements[element].part
            if (weight or 0) > 1 and isinstance(part, Joint) and part.type == "R":
                ends.setdefault(link, []).append((part, (number, along)))
    return {
        place
        for held in ends.values()
        for joint, place in held
        for other, another in held
        if another != place
        and turns_about(joint, other.point)
        and turns_about(joint, np.add(other.point, other.axis or ()).tolist())
    }


def _unknown_freedom(chain: Branch, kept: frozenset[str]) -> int | None:
    """Freedoms of a branch whose values are not given, None where a ball or a rod keeps it from
    carrying a body.
    """
    total = 0
    for element in chain.elements:
        if element.balls or not isinstance(element.part, Joint):
            return None
        total += sum(
            c.freedom
            for c in element.part.coordinates
            if c.name not in kept and c.role != "actuated"
        )
    return total


def _outward(branches: Sequence[Branch], roots: set[str]) -> list[Branch]:
    """Carrying branches such that each begins at a body that is placed already."""
    placed, order, left = set(roots), [], list(branches)
    while left:
        following = next(b for b in left if b.ends[0] in placed)
        left.remove(following)
        placed.add(following.ends[1])
        order.append(following)
    return order


def _from_base(chain: Branch, floating: Sequence[str]) -> Branch:
    """A closing branch that ends on a floating body, if one of its ends is one, and begins at the
    base, if one is.
    """
    first, last = chain.ends
    turned = (first in floating and last not in floating) or (
        last == BASE and first != BASE and last not in floating
    )
    return chain.reversed if turned else chain


# --- where a loop is cut --------------------------------------------------------------------------


def middle_turn(elements: Sequence[Element]) -> int | None:
    """The revolute joint nearest the middle of a limb: cut there, an unknown joint leaves the rows,
    and both sides are short. None where it is the only joint: then nothing would be left to solve
    for.
    """
    if len(elements) == 1:
        return None
    turns = [
        i
        for i, element in enumerate(elements)
        if isinstance(element.part, Joint) and element.part.type == "R"
    ]
    return min(turns, key=lambda i: abs(2 * i - len(elements) + 1), default=None)


def cut_index(elements: Sequence[Element], kept: frozenset[str]) -> int | None:
    """The passive joint of most freedom, the last of equals; helical joints are never cut (their
    angle stays), nor those that are kept.
    """
    best: int | None = None
    most = 0
    for i, element in enumerate(elements):
        joint = element.part
        if not isinstance(joint, Joint) or joint.actuated or not joint.form.may_be_cut:
            continue
        if any(c.name in kept for c in joint.coordinates):
            continue
        # >= takes the last of equals, so that the chain from the base is the longer one
        if joint.freedom >= most:
            best, most = i, joint.freedom
    return best
