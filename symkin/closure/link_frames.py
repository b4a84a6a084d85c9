"""Where every link is, as expressions of a closure's variables and of the whole geometry.

The frame of a link is the base frame at the reference configuration, so that its pose is its
displacement from there. Links between two spherical joints (a bridge) may spin about the line of
their centres, which nothing holds: no expression places them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.branches import Branch
from symkin.closure.chain import Chain, JointSymbols, Side
from symkin.closure.closure import Closure, built_rows
from symkin.closure.rows import RowBuilder
from symkin.computed_once import lru_cache
from symkin.model.joint import Joint
from symkin.spatial.backend import stacked
from symkin.spatial.rotation import multiply, rotate


@dataclass(frozen=True, eq=False)
class Bridge:
    """`links` between two spherical joints: the links on which these are, and their centres at the
    reference.
    """

    links: tuple[str, ...]
    ends: tuple[str, str]
    centres: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class LinkFrames:
    """Position and quaternion (7) of each link by name, over the closure's variables and
    `geometry`: every number of the description by key path, as symbol and nominal value (the
    closure's own symbol where its rows depend on it). Frames of links of a bridge are as seen from
    its first link; `joints` are the links that each joint is between, the one that it moves last,
    and `symbols` the geometry of each by name.
    """

    frames: dict[str, ca.SX]
    bridges: tuple[Bridge, ...]
    joints: dict[Joint, tuple[str, str]]
    symbols: dict[str, JointSymbols]
    geometry: dict[str, tuple[ca.SX, float]]

    @property
    def placed(self) -> tuple[str, ...]:
        """The links that the closure places."""
        hung = {link for bridge in self.bridges for link in bridge.links}
        return tuple(link for link in self.frames if link not in hung)

    def bound(self, expression: ca.SX, free: Collection[str] = ()) -> ca.SX:
        """The expression with the nominal geometry, but for numbers that stay `free`."""
        numbers = [pair for name, pair in self.geometry.items() if name not in free]
        symbols = stacked(symbol for symbol, _ in numbers)
        return ca.substitute(expression, symbols, ca.SX(ca.DM([value for _, value in numbers])))


@lru_cache(maxsize=128)
def link_frames(closure: Closure) -> LinkFrames:
    """The frames of all links, those within limbs ("leg1.1", from the base on) included; limbs that
    are laid are left out.
    """
    builder = built_rows(closure.mechanism, closure.partition)
    branches, laid = builder.layout.branches, builder.laid.links(builder.layout.branches)
    sides: dict[str, Side] = {
        link: side for link, side in {**builder.bodies, **builder.links}.items() if link not in laid
    }
    chains = [
        (branch, (branch.ends[0], *branch.links, branch.ends[1]))
        for branch in branches
        if not laid & {branch.ends[0], branch.ends[1], *branch.links}
    ]
    bridges = []
    for branch, links in chains:
        free = [k for k, link in enumerate(links) if link not in sides]
        if free:
            first, last = free[0], free[-1]
            centres = [
                np.array(builder.mechanism.places[branch.elements[k].name])
                for k in (first - 1, last)
            ]
            bridges.append(
                Bridge(
                    links[first : last + 1],
                    (links[first - 1], links[last + 1]),
                    (centres[0], centres[1]),
                )
            )
            sides |= {
                links[k]: builder.chain_of(branch.elements[first:k]) for k in range(first, last + 1)
            }
    geometry, theirs, ours = _geometry(builder, closure)
    theirs += [builder.coordinates[c.name][1] for c in closure.coordinates]
    ours.append(closure.symbols(closure.coordinates))
    replaced = [stacked(theirs)], [stacked(ours)]
    frames = ca.substitute(side_frames(list(sides.values())), *replaced)
    joints = _joints_between(chains)
    return LinkFrames(
        dict(zip(sides, frames, strict=True)),
        tuple(bridges),
        joints,
        {j.name: builder.joints[j.name].substituted(*replaced) for j in joints},
        geometry,
    )


def _geometry(
    builder: RowBuilder, closure: Closure
) -> tuple[dict[str, tuple[ca.SX, float]], list[ca.SX], list[ca.SX]]:
    """The numbers of the description; and the builder's symbols of those for which the closure has
    its own, with these.
    """
    own = (
        dict(zip(closure.parameter_names, ca.vertsplit(closure.parameters), strict=True))
        if closure.parameter_names
        else {}
    )
    table = builder.table
    geometry = {
        name: (own.get(name, symbol), float(value))
        for name, symbol, value in zip(table.names, table.symbols, table.values, strict=True)
        if name not in builder.coordinates
    }
    shared = [
        (symbol, own[name])
        for name, symbol in zip(table.names, table.symbols, strict=True)
        if name in own
    ]
    return geometry, [theirs for theirs, _ in shared], [ours for _, ours in shared]


def side_frames(sides: Sequence[Side]) -> list[ca.SX]:
    """Position and quaternion of each side; those that begin alike are built on each other, so that
    a long chain costs its length.
    """
    known: dict[tuple[int, ...], tuple[ca.SX, ca.SX]] = {}

    def key(side: Side) -> tuple[int, ...]:
        return (0 if isinstance(side, Chain) else id(side.pose), *map(id, side.steps))

    def frame(side: Side) -> tuple[ca.SX, ca.SX]:
        begun, longer = side, []
        while key(begun) not in known and begun.steps:
            longer.append(begun)
            begun = replace(begun, steps=begun.steps[:-1])
        if key(begun) not in known:
            known[key(begun)] = begun.move(ca.SX(3, 1)) / begun.weight, begun.quaternion
        position, quaternion = known[key(begun)]
        for each in reversed(longer):
            step = each.steps[-1]
            position = position + rotate(quaternion, step.move(ca.SX(3, 1)))
            quaternion = multiply(quaternion, step.quaternion)
            known[key(each)] = position, quaternion
        return position, quaternion

    return [ca.vertcat(*frame(side)) for side in sides]


def _joints_between(
    chains: Sequence[tuple[Branch, tuple[str, ...]]],
) -> dict[Joint, tuple[str, str]]:
    """The links that each joint is between, the one that it moves last."""
    found: dict[Joint, tuple[str, str]] = {}
    for branch, links in chains:
        for k, element in enumerate(branch.elements):
            if isinstance(element.part, Joint) and element.part.type != "weld":
                found[element.part] = (
                    (links[k], links[k + 1]) if element.along else (links[k + 1], links[k])
                )
    return found
