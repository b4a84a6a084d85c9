"""Counts of links, joints and freedoms, and what they say of the mobility."""

from __future__ import annotations

from symkin.closure.branches import edges_of
from symkin.model.mechanism import Mechanism


def gruebler_kutzbach(mechanism: Mechanism) -> int:
    """6 (n - g - 1) + sum f over links n, joints g and their freedoms f."""
    links, joints, freedoms = counts(mechanism)
    return 6 * (links - joints - 1) + freedoms


def counts(mechanism: Mechanism) -> tuple[int, int, int]:
    """Links, joints, and the freedoms of the joints; a coupling takes one. Rods of limbs are links
    between spherical joints (legs two, with a slide between them); in a graph a rod is one joint,
    of five freedoms, or six where its length is a coordinate.
    """
    edges = list(edges_of(mechanism))
    links, joints = len({link for edge in edges for link in edge.ends}), len(edges)
    freedoms = sum(edge.elements[0].freedom for edge in edges) - len(mechanism.couplings)
    if mechanism.is_graph:
        return links, joints, freedoms
    parts = sum(1 if bar.coordinate is None else 2 for bar in mechanism.bars)
    return links + parts, joints + parts, freedoms + sum(bar.spins for bar in mechanism.bars)
