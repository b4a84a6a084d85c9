"""What is odd about a mechanism's numbers without being wrong: slips of units and signs that a
reader should hear of.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.text import first_of

_FAR_OFF = 200.0
"""How many times farther than the others a point lies that may be in another unit, metres among
millimetres.
"""
_LEAST_POINTS = 4
"""Points from which one can be told to lie off the others."""
FULL_TURN = 2.0 * math.pi * (1.0 + 1e-3)
"""Radians from which an angle is more than a turn; files write a turn with three digits."""


_MOST_DEGREES = 720.0
"""Limits up to which degrees may be meant; larger ones stand for none."""


def oddities(mechanism: Mechanism) -> tuple[str, ...]:
    """Sentences on numbers that are allowed and rarely meant: rods whose limits leave no positive
    length, a point far off all others, angles of more than a turn where the unit is rad.
    """
    return (*_negative_rods(mechanism), *_far_points(mechanism), *_degrees(mechanism))


def _negative_rods(mechanism: Mechanism) -> Iterator[str]:
    drives = [(bar, bar.coordinate.limits) for bar in mechanism.bars if bar.coordinate is not None]
    wrong = [
        f"{'limb' if bar.end.in_platform_frame else 'rod'} {bar.name} (limits {limits[0]:g} to "
        f"{limits[1]:g} beyond offset {bar.offset:g})"
        for bar, limits in drives
        if limits is not None and limits[1] + bar.offset <= 0.0
    ]
    if wrong:
        yield (
            f"{first_of(wrong, 3)}: all lengths within the limits are negative, and no rod has "
            f"such a length; limits are values beyond `offset`"
        )


def _far_points(mechanism: Mechanism) -> Iterator[str]:
    """Points of each frame apart: platform points of rods are given in the platform's frame."""
    fixed: dict[str, tuple[float, ...]] = {
        joint.name: tuple(joint.point) for joint in mechanism.all_joints if joint.type != "P"
    }
    moving: dict[str, tuple[float, ...]] = {}
    for end in (end for bar in mechanism.bars for end in (bar.start, bar.end)):
        (moving if end.in_platform_frame else fixed)[end.path] = end.point
    for points in (fixed, moving):
        yield from _far_of(points, mechanism.length_unit)


def _far_of(points: dict[str, tuple[float, ...]], unit: str) -> Iterator[str]:
    if len(points) < _LEAST_POINTS:
        return
    places = np.array(list(points.values()), dtype=float)
    ordered, half = np.sort(places, axis=0), len(places) // 2
    # not np.median: it imports numpy.ma, for a tenth of the time of a short command
    middle = (ordered[half] + ordered[-1 - half]) / 2.0
    away = np.linalg.norm(places - middle, axis=1)
    far = int(np.argmax(away))
    others = float(np.max(np.delete(away, far)))
    if others > 0.0 and away[far] > _FAR_OFF * others:
        yield (
            f"{list(points)[far]} lies {away[far]:.4g} {unit} from the middle of the points, "
            f"{away[far] / others:.0f} times as far as any other: "
            f"is it in {unit}?"
        )


def degrees_question(mechanism: Mechanism) -> str | None:
    """What is asked where angles and limits in radians are more than a turn, as in a file in
    degrees that does not say so.
    """
    if mechanism.angle_unit != "rad":
        return None
    found = [
        f"{where} = {value:g}" for where, value in _angles(mechanism) if abs(value) > FULL_TURN
    ]
    for joint in mechanism.all_joints:
        largest = max(map(abs, joint.limits or (0.0,)))
        if (
            joint.type in ("R", "H")
            and joint.limits is not None
            and FULL_TURN < largest <= _MOST_DEGREES
        ):
            found.append(f"{joint.name}.limits = {joint.limits[0]:g} to {joint.limits[1]:g}")
    return (
        f"{first_of(found, 3)}: more than a turn in radians; are degrees meant?" if found else None
    )


def _degrees(mechanism: Mechanism) -> Iterator[str]:
    question = degrees_question(mechanism)
    if question is not None:
        yield f'{question} Then write angle_unit = "deg"'


def _angles(mechanism: Mechanism) -> Iterator[tuple[str, float]]:
    """Angles that a file gives, limits left aside, by where they stand there."""
    for joint in mechanism.all_joints:
        if joint.type in ("R", "H"):
            yield f"{joint.name}.zero", joint.zero
    for row in mechanism.dh.rows if mechanism.dh is not None else ():
        yield from ((f"{row.name}.theta", row.theta), (f"{row.name}.alpha", row.alpha))
    example = mechanism.example
    if example is not None and example.joints is not None:
        yield from (
            (f"example.joints: {c.name}", value)
            for c, value in zip(mechanism.actuated, example.joints, strict=True)
            if c.is_periodic
        )
