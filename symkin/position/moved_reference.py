"""The same mechanism described at another of its configurations: points, axes and zeros are those
there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import joint_readings, link_poses
from symkin.model.changed import described_at
from symkin.model.mechanism import Mechanism


def with_reference_at(closure: Closure, values: np.ndarray) -> Mechanism:
    """The closure's mechanism with the configuration of a full vector of variables as its
    reference.

    Values of R, P and H joints and of rods stay what they are. Coordinates of C, U and S joints
    count from the reference, and couplings that name them are written for the new one; an example
    that gives them, a DH table and meshes are left out.
    """
    poses = link_poses(closure, values[None])
    read = {
        name: float(np.ravel(value)[0]) for name, value in joint_readings(closure, poses).items()
    }
    held = {c.name for c in closure.coordinates}
    read |= {name: float(values[closure.slices[name]][0]) for name in read if name in held}
    given, links = closure.mechanism, poses.at(0)
    several = [c for j in given.all_joints if j.type in ("C", "U") for c in j.coordinates]
    shifts = {c.name: read[c.name] for c in several}
    example = given.example
    named = {c.name for c in given.actuated} | {
        name for name, _ in (() if example is None else example.given or ())
    }
    return replace(
        described_at(given, links, read),
        couplings=[coupling.counted_from(shifts) for coupling in given.couplings],
        example=None if named & set(shifts) else example,
        link_meshes=(),
    )
