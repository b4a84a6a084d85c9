"""Take a platform as one of a declared motion where its joints leave it that motion and formulas
watch that they do.

The wrenches by which limbs keep a platform in its motion, couples for a platform that stays level,
must not lose rank along a line: there the platform could leave the motion, though no formula of the
motion's own rows were singular. Their volumes, determinants of as many of them as there are
freedoms to hold, are not all zero where a divisor of the formulas is a sum of multiples of their
squares and is not zero; and divisors are guards of the line. Of a platform that only translates the
determinant itself is made a guard, where each limb has one such wrench and that is linear in the
position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.options import Options
from symkin.codegen.steps.direct_formulas import DirectFormulas
from symkin.codegen.steps.limbwise import Held
from symkin.codegen.steps.pose_coordinates import COLUMNS
from symkin.codegen.text.c import Real
from symkin.machine.frame import Frames
from symkin.model.joint import units_of
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import null_space, row_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.limb_screws import limb_screws
from symkin.position.platform_motion import implied_motion

CONFIGURATIONS = 20
"""Configurations at which volumes are compared with divisors."""
_MOST_SETS = 10
"""Sets of limbs of which volumes are taken: fewer than configurations, so that a sum of their
multiples says something.
"""
_SAME = 1e-8
"""Share by which a sum may miss a divisor, of numbers from configurations that close to
rounding.
"""
_LINEAR = 1e-4
"""Share of the largest singular value above which places determine a linear map: they are
spread.
"""
_AXES_ALONE = ("translation", "schoenflies", "planar")
"""Motions whose twists are axes of the base, wherever the platform is."""


def limb_platform(
    mechanism: Mechanism, options: Options, real: Real, frames: Frames | None = None
) -> LimbPlatform:
    """The platform to write code for, whose poses are told in these frames: of its implied motion
    where that is watched, else as described.
    """
    described = LimbPlatform(mechanism, options, real, frames=frames)
    if options.geometry == "struct" or mechanism.motion != "spatial":
        return described
    motion = implied_motion(mechanism)
    if motion not in _AXES_ALONE:
        return described
    declared = LimbPlatform(replace(mechanism, motion=motion), options, real, frames=frames)
    found = declared.direct_formulas
    if found is not None and keeps_motion(declared, found):
        return declared
    watched = replace(declared, held=held_motion(declared))
    return (
        watched if watched.held is not None and watched.direct_formulas is not None else described
    )


def held_motion(made: LimbPlatform) -> Held | None:
    """The limbs' wrenches of a translating platform by its position, where they are linear in it
    and just as many as the freedoms that they hold; else None.
    """
    pose = made.closure.role("pose")
    if made.mechanism.motion != "translation":
        return None
    held = [c for c in range(6) if c not in COLUMNS["translation"]]
    wrenches = [_holding(made, sample.values, held) for sample in made.samples[:CONFIGURATIONS]]
    if sum(len(w) for w in wrenches[0]) != len(held) or any(
        len(w) > 1 for at in wrenches for w in at
    ):
        return None
    size, symbols = (
        made.closure.characteristic_length,
        made.closure.symbols(pose),
    )
    places = (
        np.array(
            [made.inverse.select_values(s.values, pose) for s in made.samples[:CONFIGURATIONS]]
        )
        / size
    )
    found: list[ca.SX | None] = []
    for i, first in enumerate(wrenches[0]):
        if any(len(at[i]) != len(first) for at in wrenches):
            return None
        factors = (
            _linear_direction(places, np.array([at[i][0] for at in wrenches]))
            if len(first)
            else None
        )
        if len(first) and factors is None:
            return None
        found.append(
            None if factors is None else ca.mtimes(ca.DM(factors), ca.vertcat(1, symbols / size))
        )
    volume = ca.det(ca.horzcat(*(w for w in found if w is not None)))
    sign = np.sign(float(ca.Function("volume", [symbols], [volume])(size * places[0])))
    return Held(float(sign) * volume, tuple(None if w is None else ca.sumsqr(w) for w in found))


def _linear_direction(places: np.ndarray, directions: np.ndarray) -> np.ndarray | None:
    """The matrix M (3, 4) for which M (1, place) has these directions (n, 3) at places (n, 3); None
    where there is none, or more than one.
    """
    rows = []
    for place, (x, y, z) in zip(places, directions, strict=True):
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        rows.append(np.kron(across, np.concatenate([[1.0], place])))
    _, sizes, vectors = np.linalg.svd(np.vstack(rows))
    if sizes[-1] > _SAME * sizes[0] or sizes[-2] <= _LINEAR * sizes[0]:
        return None
    # rounded, and of one sign: the last digits and the sign of a singular vector are the
    # processor's
    found = np.array([snap(float(f"{v:.13g}")) if abs(v) > _SAME else 0.0 for v in vectors[-1]])
    return np.asarray(found * np.sign(found[np.flatnonzero(found)[0]])).reshape(3, 4)


def keeps_motion(made: LimbPlatform, found: DirectFormulas) -> bool:
    """Whether the limbs hold the platform in its motion wherever no guard of its formulas is
    zero.
    """
    samples = made.samples[:CONFIGURATIONS]
    held = [c for c in range(6) if c not in COLUMNS[made.mechanism.motion]]
    wrenches = [_holding(made, sample.values, held) for sample in samples]
    counts = [len(w) for w in wrenches[0]]
    if any([len(w) for w in other] != counts for other in wrenches):
        return False
    known = np.array([s.known for s in samples]) / units_of(made.actuated, found.unit)
    numbers = found.form.at(found.form.divisors, found.form.signs_at(samples[0].values), known)
    sets = _sets_of(counts, len(held))[:_MOST_SETS]
    if not sets:
        return False
    squares = np.array(
        [[np.linalg.det(np.vstack([w[i] for i in limbs])) ** 2 for limbs in sets] for w in wrenches]
    )
    # a sum that is one is never zero
    told = np.hstack([np.ones((len(samples), 1)), numbers, numbers**2])
    left = squares @ np.linalg.lstsq(squares, told, rcond=None)[0] - told
    return bool(np.any(np.max(np.abs(left), axis=0) <= _SAME * np.max(np.abs(told), axis=0)))


def _sets_of(counts: Sequence[int], whole: int) -> list[tuple[int, ...]]:
    """Sets of limbs that hold so many freedoms together, each one by all its wrenches."""
    bearing = [i for i, count in enumerate(counts) if count]
    sets = [limbs for k in range(1, len(bearing) + 1) for limbs in combinations(bearing, k)]
    return [limbs for limbs in sets if sum(counts[i] for i in limbs) == whole]


def _holding(made: LimbPlatform, values: np.ndarray, held: Sequence[int]) -> list[np.ndarray]:
    """Of each limb the wrenches that do no work on the motion, as orthonormal rows over the
    freedoms that they hold.
    """
    found, size = [], made.closure.characteristic_length
    free = [c for c in range(6) if c not in held]
    scale = np.array([1.0, 1.0, 1.0, 1.0 / size, 1.0 / size, 1.0 / size])
    for limb in limb_screws(made.closure, values):
        # a unit couple is small beside a unit force times a huge machine's size
        scaled = limb.locked * scale
        scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
        kept = null_space(scaled[:, free].T, RANK_TOLERANCE, relative=True) @ scaled
        found.append(row_space(kept[:, held], RANK_TOLERANCE))
    return found
