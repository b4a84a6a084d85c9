"""Counts of links, joints and freedoms, and what they say of the mobility."""

from __future__ import annotations

from symkin.closure.branches import edges_of
from symkin.model.bar import Bar
from symkin.model.joint import Joint
from symkin.model.limb import RodLimb
from symkin.model.mechanism import Mechanism


def gruebler_kutzbach(mechanism: Mechanism) -> int:
    """6 (n - g - 1) + sum f over links n, joints g and their freedoms f."""
    links, joints, freedoms = counts(mechanism)
    return 6 * (links - joints - 1) + freedoms


def counts(mechanism: Mechanism) -> tuple[int, int, int]:
    """Links, joints, and the freedoms of the joints; of a graph a rod is one joint, of five freedoms, and a coupling takes one."""
    if mechanism.is_graph:
        return _counts_of_graph(mechanism)
    links, joints, freedoms = 2, 0, 0
    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            links, joints, freedoms = links + 2, joints + 3, freedoms + (7 if limb.type == "SPS" else 6)
            continue
        links += len(limb.joints) - 1 + (1 + len(limb.rods) if limb.rods else 0)
        joints += len(limb.joints) + 2 * len(limb.rods)
        freedoms += sum(joint.freedom for joint in limb.joints) + 6 * len(limb.rods)
    return links, joints, freedoms


def _counts_of_graph(mechanism: Mechanism) -> tuple[int, int, int]:
    parts = [(edge.ends, edge.elements[0].part) for edge in edges_of(mechanism)]
    links = {link for ends, _ in parts for link in ends}
    bars = [part for _, part in parts if isinstance(part, Bar)]
    freedoms = sum(part.freedom for _, part in parts if isinstance(part, Joint))
    # a rod takes the distance of its ends; one whose length is a coordinate takes nothing
    freedoms += sum(5 if bar.coordinate is None else 6 for bar in bars) - len(mechanism.couplings)
    return len(links), len(parts), freedoms
