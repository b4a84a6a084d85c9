"""The same machine said as a graph: every joint of a limb between two links of its own, every rod
between two links.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin import LinkJoint, LinkRod, Mechanism, RodLimb


def graph_twin(mechanism: Mechanism) -> Mechanism:
    """Joints, rods and the platform's frame as they are, on links that have the names of those
    within limbs."""
    joints, rods = [], []
    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            end = mechanism.reference_pose.apply(np.array(limb.platform))
            rods.append(
                LinkRod(
                    limb.name,
                    ["base", "platform"],
                    limb.base,
                    end,
                    actuated=True,
                    offset=limb.offset,
                    limits=limb.limits,
                )
            )
            continue
        links = limb.links_along
        joints += [LinkJoint(joint, links[k : k + 2]) for k, joint in enumerate(limb.joints)]
        for k, rod in enumerate(limb.rods, start=1):
            end = mechanism.reference_pose.apply(np.array(rod.platform))
            rods.append(
                LinkRod(f"{limb.name}_rod{k}", [links[-1], "platform"], rod.start, end, rod.length)
            )
    return replace(
        mechanism,
        limbs=(),
        link_joints=joints,
        link_rods=rods,
        platform_link="platform",
        serial=False,
        dh=None,
        example=None,
    )
