"""Modes on parts of a closure that no loop of the joint values connects.

A translating platform on a limb U R R, whose last two axes are along x, and on a rod: the limb
keeps the orientation where Turn(a, alpha) Turn(b, beta) Turn(x, r3 + r4) = 1, so that a . Turn(x,
-t) b = a . b for t = r3 + r4. This holds for t = 0 and for one other t, whatever the rod's length:
two circles of positions, each of which the rod meets in two places or none.
"""

from __future__ import annotations

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from symkin import Joint, Limb, Mechanism, RodLimb

X = np.array([1.0, 0.0, 0.0])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' rotation matrix."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def machine(a: np.ndarray, b: np.ndarray, points: np.ndarray) -> Mechanism:
    u, r3, r4, base, end, origin = points
    limb = Limb(
        "limb",
        (
            Joint("u", "U", tuple(u), axis=tuple(a), axis2=tuple(b)),
            Joint("r3", "R", tuple(r3), axis=(1, 0, 0)),
            Joint("r4", "R", tuple(r4), axis=(1, 0, 0)),
        ),
    )
    rod = RodLimb("rod", tuple(base), tuple(end), type="UPS")
    return Mechanism(
        "two_circles",
        (limb, rod),
        tuple(origin),
        motion="translation",
        length_unit="mm",
        angle_unit="deg",
    )


def sums(a: np.ndarray, b: np.ndarray) -> list[float]:
    """Both values of r3 + r4: a . Turn(x, -t) b = a . b is (1 - cos t) A + B sin t = 0, with the
    parts of b normal to x.
    """
    flat = b - b[0] * X
    first, second = a @ flat, -a @ np.cross(X, flat)
    return [0.0, 2 * np.arctan2(second, first)]


def heights(
    a: np.ndarray, b: np.ndarray, points: np.ndarray, t: float, r3: np.ndarray
) -> np.ndarray:
    """Positions of the platform for values of r3, at a sum t: the universal joint turns by Turn(x,
    -t) in all.
    """
    u, p3, p4, _, _, origin = points
    around = turn(X, -t)
    return np.array(
        [
            u + around @ (p3 - u + turn(X, q) @ (p4 - p3 + turn(X, t - q) @ (origin - p4)))
            for q in r3
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", in_gate(range(4), [0, 1]))
def test_modes_on_both_circles_are_listed(seed):
    rng = np.random.default_rng(seed)
    while True:
        a, b = rng.normal(size=(2, 3))
        points = 100.0 * rng.normal(size=(6, 3))
        base, end = points[3:5]
        q = np.linspace(-np.pi, np.pi, 2001)
        lengths = [
            np.linalg.norm(heights(a, b, points, t, q) + end - base, axis=1) for t in sums(a, b)
        ]
        low, high = max(d.min() for d in lengths), min(d.max() for d in lengths)
        if high - low > 20.0:
            break
    length = 0.5 * (low + high)
    meets = sum(int(np.sum(np.diff(np.sign(d - length)) != 0)) for d in lengths)
    assert meets == 4

    found = symkin.modes(machine(a, b, points), joints=[length])

    assert found.completeness == "probability one"
    assert len(found.modes) == 4
    for t, expected in zip(sums(a, b), (2, 2), strict=True):
        apart = [
            np.angle(np.exp(1j * (np.radians(m.joints["r3"] + m.joints["r4"]) - t)))
            for m in found.modes
        ]
        assert sum(abs(angle) < 1e-9 for angle in apart) == expected
