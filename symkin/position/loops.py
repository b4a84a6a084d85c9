"""The loops of a mechanism by the joints that they run through, and what each holds by itself.

Links are the vertices of a graph, joints and rods its edges, and joints - links + 1 loops are
independent. Chosen are those with the fewest joints (a minimum cycle basis: J. D. Horton, SIAM
Journal on Computing 16, 1987). The rank of a loop is that of its joints' screws, of a rod's all but
the force along it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symkin.closure.branches import Branch, edges_of
from symkin.closure.closure import Closure
from symkin.closure.link_poses import link_poses
from symkin.computed_once import lru_cache
from symkin.model.bar import Bar
from symkin.model.joined import back, tree_from
from symkin.model.joint import Joint
from symkin.model.joint_forms import JOINT_FORMS
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import rank_of
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.spatial.pose import Pose

_ROD_FREEDOM = 5
"""Freedoms of two links on a rod with spherical ends: all but the distance."""
_SPATIAL = 6


@dataclass(frozen=True)
class Loop:
    """A loop: its joints and rods in order, and the rows that close it by itself, cut at its
    passive joint of most freedom; `rank` of the rows are independent, the `redundant` others follow
    from them.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    rows: int
    rank: int

    @property
    def name(self) -> str:
        """The names of its joints in order."""
        return ", ".join(self.joints)

    @property
    def redundant(self) -> int:
        """Rows that the others imply."""
        return self.rows - self.rank


def loops_at(
    closure: Closure, values: np.ndarray, tolerance: float = RANK_TOLERANCE
) -> tuple[Loop, ...]:
    """The independent loops with their ranks at one configuration; singular values below
    `tolerance` of the largest are zero.
    """
    mechanism = closure.mechanism
    edges = list(edges_of(mechanism))
    poses = link_poses(closure, values[None]).at(0)
    screws = [_screws(mechanism, edge, poses) for edge in edges]
    found = []
    for cycle in independent_cycles(mechanism):
        span = np.vstack([screws[k] for k in cycle])
        cut = _cut_freedom([edges[k] for k in cycle])
        # the cut joint's own freedoms are in the span: what is left of it is the rank of the rows
        # that remain
        rank = rank_of(span, tolerance, relative=True) - cut
        names = tuple(_name(edges[k]) for k in cycle)
        found.append(
            Loop(names, _links_along([edges[k] for k in cycle]), _SPATIAL - cut, max(rank, 0))
        )
    return tuple(found)


@lru_cache(maxsize=128)
def independent_cycles(mechanism: Mechanism) -> tuple[tuple[int, ...], ...]:
    """Independent cycles with the fewest edges, as numbers of `edges_of` in order along each."""
    edges = list(edges_of(mechanism))
    links = list(dict.fromkeys(link for edge in edges for link in edge.ends))
    wanted = len(edges) - len(links) + 1
    candidates = [cycle for link in links for cycle in _cycles_through(link, edges)]
    candidates.sort(key=lambda cycle: (len(cycle), sorted(cycle)))
    chosen: list[tuple[int, ...]] = []
    basis: dict[int, int] = {}
    for cycle in candidates:
        if len(chosen) == wanted:
            break
        if _adds(basis, sum(1 << edge for edge in cycle)):
            chosen.append(cycle)
    # in the order in which the file names the joint that each begins at
    return tuple(
        sorted(
            (_from_first(cycle) for cycle in chosen),
            key=lambda cycle: (cycle[0], len(cycle), cycle),
        )
    )


def _cycles_through(root: str, edges: Sequence[Branch]) -> list[tuple[int, ...]]:
    """The cycles of shortest paths from a link to both ends of an edge."""
    tree = tree_from((edge.ends for edge in edges), root)
    ways = {link: back(tree, link) for link in tree}
    within = {number for number, _ in tree.values()}

    def apart(first: str, last: str) -> bool:
        links = ({link, *(before for _, before in ways[link])} for link in (first, last))
        return set.intersection(*links) == {root}

    return [
        (
            *(k for k, _ in reversed(ways[edge.ends[0]])),
            number,
            *(k for k, _ in ways[edge.ends[1]]),
        )
        for number, edge in enumerate(edges)
        if number not in within and apart(*edge.ends)
    ]


def _adds(basis: dict[int, int], cycle: int) -> bool:
    """Whether a set of edges is no sum (modulo 2) of those in the basis; it is then kept there."""
    while cycle:
        leading = cycle.bit_length()
        if leading not in basis:
            basis[leading] = cycle
            return True
        cycle ^= basis[leading]
    return False


def _from_first(cycle: tuple[int, ...]) -> tuple[int, ...]:
    """The same cycle from its first edge on, towards the lower of the two beside it."""
    start = cycle.index(min(cycle))
    turned = cycle[start:] + cycle[:start]
    return (
        turned if len(turned) < 3 or turned[1] <= turned[-1] else (turned[0], *reversed(turned[1:]))
    )


def _links_along(cycle: Sequence[Branch]) -> tuple[str, ...]:
    """The links between the edges of a cycle, that before the first edge first."""
    first, last = cycle[0].ends
    if len(cycle) > 1 and last not in cycle[1].ends:
        first, last = last, first
    links = [first]
    for edge in cycle[:-1]:
        links.append(edge.ends[1] if edge.ends[0] == links[-1] else edge.ends[0])
    return tuple(links)


# --- screws ---------------------------------------------------------------------------------------


def _name(edge: Branch) -> str:
    """A joint or rod by its name; a rod at the end of a limb by the limb's as well."""
    part = edge.elements[0].part
    return (
        f"{edge.name}.{part.name}"
        if isinstance(part, Bar) and part.name != edge.name
        else part.name
    )


def _cut_freedom(cycle: Sequence[Branch]) -> int:
    """Freedoms of what a loop is cut at: a rod, or all between two spherical joints, else the
    passive joint of most freedom.
    """
    parts = [edge.elements[0].part for edge in cycle]
    if sum(edge.elements[0].balls for edge in cycle) >= 2:
        return _ROD_FREEDOM
    passive = [
        part.freedom
        for part in parts
        if isinstance(part, Joint) and not part.actuated and part.form.may_be_cut
    ]
    return max(passive, default=0)


def _screws(mechanism: Mechanism, edge: Branch, poses: Mapping[str, Pose]) -> np.ndarray:
    """Twists (angular velocity; velocity at the mechanism's middle over the size) of an edge's
    freedoms, as rows.
    """
    part, size, middle = edge.elements[0].part, mechanism.characteristic_length, _middle(mechanism)
    before, after = (poses[link] for link in edge.ends)
    if isinstance(part, Bar):
        start, end = part.places
        ends = [before.apply(start), after.apply(end)]
        ball = JOINT_FORMS["S"]
        turns = np.vstack([ball.screws((end - middle) / size, (), 0.0) for end in ends])
        along = np.concatenate([np.zeros(3), ends[1] - ends[0]])[None]
        length = float(np.linalg.norm(along))
        return (
            turns if part.coordinate is None or not length else np.vstack([turns, along / length])
        )
    point = before.apply(np.array(mechanism.places[part.name])) - middle
    axes = [
        pose.turn(np.array(axis))
        for pose, axis in ((before, part.axis), (after, part.axis2))
        if axis is not None
    ]
    return part.form.screws(point / size, axes, part.pitch / size)


@lru_cache(maxsize=128)
def _middle(mechanism: Mechanism) -> np.ndarray:
    """The mean of joints and rod ends at the reference: moments about it are of the size of the
    mechanism, however far that stands from the base's origin."""
    points = [*mechanism.places.values(), *mechanism.rod_ends]
    return np.mean(np.array(points, dtype=float), axis=0)
