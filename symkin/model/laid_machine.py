"""A machine each of whose limbs the closure describes along axes, at a stand of its own
(`closure/laid.py`): a way to write formulas, not one that a file can tell.
"""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np

from symkin.model.keys import ABOUT_Z
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import multiply

_EXACT = 1e-14
"""Numbers of a quaternion that are zero to rounding."""


class LaidMachine(Mechanism):
    """The machine of a mechanism, not equal to it: it has the same fields, and other closures."""

    @staticmethod
    def of(mechanism: Mechanism) -> LaidMachine:
        """The same machine, laid."""
        return LaidMachine(**{f.name: getattr(mechanism, f.name) for f in fields(mechanism)})


def turn_about_z(mechanism: Mechanism) -> float:
    """The platform's coordinate about z at the reference: 0, but of a laid machine, which tells it
    from an orientation without a turn about z.
    """
    w, z = mechanism.platform_quaternion[0], mechanism.platform_quaternion[3]
    is_told = isinstance(mechanism, LaidMachine) and mechanism.motion in ABOUT_Z
    return 2.0 * math.atan2(z, w) if is_told else 0.0


def untwisted(mechanism: Mechanism) -> np.ndarray:
    """The quaternion of the platform from which its turn about z is told."""
    half, own = 0.5 * turn_about_z(mechanism), np.array(mechanism.platform_quaternion)
    if not half:
        return own
    found = multiply(np.array([math.cos(half), 0.0, 0.0, -math.sin(half)]), own)
    return np.where(np.abs(found) <= _EXACT, 0.0, found)
