"""Machines whose limbs hold platform points on spheres and in planes that the actuated joints
move.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from helpers.samples import turning
from symkin import Joint, Limb, Mechanism, Rod, RodLimb

BASE = (10, 110, 130, 230, 250, 350)
PLATFORM = (40, 80, 160, 200, 280, 320)
"""Angles of joints on the circles of base and platform (degrees)."""


def _ring(radius: float, angles: Sequence[float], height: float) -> list[np.ndarray]:
    return [
        np.array([radius * math.cos(t), radius * math.sin(t), height]) for t in np.radians(angles)
    ]


def _tuple(v: np.ndarray) -> tuple[float, ...]:
    return tuple(float(x) for x in v)


def _unit(v: np.ndarray) -> tuple[float, ...]:
    return _tuple(v / np.linalg.norm(v))


def _leg(
    name: str, first: Joint, tip: np.ndarray, end: np.ndarray, height: float, *, rods: bool
) -> Limb:
    """A joint that moves a rod's foot; the rod by itself, or as a U joint and an S joint."""
    if rods:
        return Limb(name, [first], [Rod(_tuple(tip), _tuple(end - np.array([0.0, 0.0, height])))])
    d, axis = end - tip, np.asarray(first.axis, dtype=float)
    second = np.cross(d, axis)
    u = Joint(f"{name}u", "U", _tuple(tip), _unit(second), axis2=_unit(np.cross(second, d)))
    return Limb(name, [first, u, Joint(f"{name}s", "S", _tuple(end))])


def six_rss(*, rods: bool = True) -> Mechanism:
    """Six cranks of 70 that turn about radial axes on a circle of 200, and rods to a circle of 100
    at a height of 220.
    """
    limbs = []
    for k, (b, a) in enumerate(zip(_ring(200, BASE, 0), _ring(100, PLATFORM, 220), strict=True)):
        t = math.radians(BASE[k])
        out, side = (
            np.array([math.cos(t), math.sin(t), 0.0]),
            np.array([-math.sin(t), math.cos(t), 0.0]) * (1 if k % 2 else -1),
        )
        crank = Joint(f"q{k + 1}", "R", _tuple(b), _tuple(out), actuated=True)
        limbs.append(_leg(f"limb{k + 1}", crank, b + 70 * side, a, 220.0, rods=rods))
    return Mechanism("six_rss", limbs, platform_position=(0.0, 0.0, 220.0))


def hexaglide(*, rods: bool = True) -> Mechanism:
    """Six slides along x, at six places of y, and rods to a circle of 80 at a height of 200."""
    limbs = []
    feet = ((150, 40), (150, 120), (-150, 60), (-150, -60), (150, -120), (150, -40))
    for k, ((x, y), a) in enumerate(zip(feet, _ring(80, PLATFORM, 200), strict=True)):
        foot = np.array([x, y, 0.0])
        slide = Joint(f"q{k + 1}", "P", _tuple(foot), (1.0, 0.0, 0.0), actuated=True)
        limbs.append(_leg(f"limb{k + 1}", slide, foot, a, 200.0, rods=rods))
    return Mechanism("hexaglide", limbs, platform_position=(0.0, 0.0, 200.0))


def three_rpr() -> Mechanism:
    """Planar: base joints on a circle of 100, platform joints on one of 30, turned by 0.5 rad."""
    limbs = []
    for k in range(3):
        t = math.pi / 2 + 2 * math.pi * k / 3
        b, a = (
            100 * np.array([math.cos(t), math.sin(t), 0.0]),
            30 * np.array([math.cos(t + 0.5), math.sin(t + 0.5), 0.0]),
        )
        slide = Joint(
            f"p{k + 1}",
            "P",
            _tuple(b),
            _unit(a - b),
            actuated=True,
            zero=float(np.linalg.norm(a - b)),
        )
        limbs.append(
            Limb(
                f"limb{k + 1}", [turning(f"r{k + 1}", *b[:2]), slide, turning(f"c{k + 1}", *a[:2])]
            )
        )
    return Mechanism("three_rpr", limbs, motion="planar")


def three_upu() -> Mechanism:
    """Three limbs U P U from a circle of 200 to one of 80 at a height of 300; all tangential axes
    are parallel in pairs.
    """
    limbs = []
    for k in range(3):
        t = 2 * math.pi * k / 3
        out, tangent = (
            np.array([math.cos(t), math.sin(t), 0.0]),
            np.array([-math.sin(t), math.cos(t), 0.0]),
        )
        b, a = 200 * out, 80 * out + np.array([0.0, 0.0, 300.0])
        across = _unit(np.cross(tangent, a - b))
        slide = Joint(
            f"p{k + 1}",
            "P",
            _tuple(b),
            _unit(a - b),
            actuated=True,
            zero=float(np.linalg.norm(a - b)),
        )
        first = Joint(f"u{k + 1}", "U", _tuple(b), _tuple(tangent), axis2=across)
        last = Joint(f"v{k + 1}", "U", _tuple(a), across, axis2=_tuple(tangent))
        limbs.append(Limb(f"limb{k + 1}", [first, slide, last]))
    return Mechanism("three_upu", limbs, platform_position=(0.0, 0.0, 300.0))


def tricept() -> Mechanism:
    """Three rods from a circle of 200 to one of 90, and a limb U P in the middle."""
    limbs: list[Limb | RodLimb] = []
    for k in range(3):
        t = 2 * math.pi * k / 3
        out = np.array([math.cos(t), math.sin(t), 0.0])
        limbs.append(RodLimb(f"leg{k + 1}", _tuple(200 * out), _tuple(90 * out)))
    cross = Joint("cu", "U", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), axis2=(0.0, 1.0, 0.0))
    limbs.append(Limb("centre", [cross, Joint("cp", "P", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))]))
    return Mechanism("tricept", limbs, platform_position=(0.0, 0.0, 300.0))
