"""Motions that the joints leave a platform declared spatial anyway."""

from __future__ import annotations

from dataclasses import replace

from symkin.closure.closure import build_closure
from symkin.model.mechanism import MOTIONS, Mechanism, Motion
from symkin.position.mobility import mobility
from symkin.position.mobility_result import Mobility
from symkin.position.problem import Problem


def fewer_rows(found: Mobility) -> tuple[Motion, int] | None:
    """The motion of a platform declared spatial that the joints leave it anyway and that removes
    most redundant rows, with the number of those left; None where there is none. Declared, it
    changes no solution of the same assembly.
    """
    mechanism = found.closure.mechanism
    if (
        not found.limbs
        or mechanism.motion != "spatial"
        or not found.implied_rows
        or not found.closed
    ):
        return None
    restricted = [(m, mobility(replace(mechanism, motion=m))) for m in MOTIONS if m != "spatial"]
    kept = [
        (m, other.implied_rows)
        for m, other in restricted
        if other.closed and other.mobility == found.mobility
    ]
    best = min(kept, key=lambda pair: pair[1], default=None)
    return best if best is not None and best[1] < found.implied_rows else None


def implied_motion(mechanism: Mechanism) -> Motion | None:
    """The motion of a platform declared spatial that its joints leave it anyway, each pose
    coordinate free: declared, no pose has to satisfy conditions. None where there is none, so that
    what moves is no group of motions, or tied within one.
    """
    if mechanism.serial or mechanism.motion != "spatial":
        return None
    spatial = mobility(mechanism)
    for motion in MOTIONS:
        restricted = mechanism if motion == "spatial" else replace(mechanism, motion=motion)
        coordinates = sum(c.freedom for c in build_closure(restricted).role("pose"))
        if motion == "spatial" or coordinates != spatial.mobility:
            continue
        found = mobility(restricted)
        if found.closed and found.mobility == spatial.mobility:
            return motion
    return None


def motion_notes(problem: Problem) -> list[str]:
    """Which motion, declared, removes the conditions that poses of a platform declared spatial must
    satisfy, or some of them.
    """
    motion = implied_motion(problem.mechanism) if problem.of_pose else None
    if motion is not None:
        return [
            f"its joints leave the platform a {motion} motion: with motion = {motion!r} in "
            f"[platform] poses need not satisfy "
            "conditions, and the list of that motion's solutions is complete"
        ]
    within = fewer_rows(mobility(problem.mechanism))
    if within is None:
        return []
    return [
        f"its joints move the platform within a {within[0]} motion: with motion = {within[0]!r} in "
        f"[platform] fewer rows are redundant, and "
        "the list of that motion's solutions may be complete"
    ]
