"""Reduce the velocity equations to an output: some velocity components of one point of the
platform, not its whole twist.

With y = O t the output's velocity and t = O^+ y + K z, where K spans the twists that leave the
output at rest, the limbs' equations A t + B q' = 0 become A O^+ y + A K z + B q' = 0. What z does
is of no interest, so z is eliminated as passive joints are, and a y + b q' = 0 is left, rows of all
limbs orthonormal together: type 1 where b loses rank, type 2 where a does. Such rows depend on the
motions of output and joints alone, not on which limb carries the platform: distances of mirror
images are equal, and are not those of the whole twist, whose rows are orthonormal limb by limb. A
limb's dead centre, whose joint turns while the output stands, is told whichever limb the platform
belongs to. O^+ and K are taken in the twists about the output's point (velocity there; size times
angular velocity), so that distances do not depend on the platform's origin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.closure.closure import Closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import count_above, null_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.given import given_coordinates
from symkin.position.solution import pose_of
from symkin.text import meant
from symkin.velocity.limb_equations import LimbEquations, LimbwiseEquations, eliminated

OUTPUT_NAMES = ("x", "y", "z", "rx", "ry", "rz")
"""Velocity of the point and angular velocity, components in the base frame."""


@dataclass(frozen=True)
class Output:
    """Velocity components `names` (of OUTPUT_NAMES) of the platform's or tool's `point`, given in
    its frame (length unit).
    """

    names: tuple[str, ...]
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __str__(self) -> str:
        where = (
            "the platform's origin"
            if not any(self.point)
            else f"the platform's point ({', '.join(f'{v:g}' for v in self.point)})"
        )
        return f"{', '.join(self.names)} of {where}"

    def to_dict(self) -> dict[str, list[str] | list[float]]:
        return {"coordinates": list(self.names), "point": list(self.point)}


@dataclass(frozen=True, eq=False)
class OutputEquations:
    """a y + b q' = 0 as the equations of one limb; `rows` (p, r) are O over the motion's twist
    coordinates, whose p independent combinations y are.
    """

    equations: LimbwiseEquations
    rows: np.ndarray

    def moving(self, twists: np.ndarray) -> np.ndarray:
        """Of the span of twists (n, r) as many as move the output independently, orthonormal
        combinations of them.
        """
        left, singular, _ = np.linalg.svd(twists @ self.rows.T)
        return left.T[: count_above(singular, RANK_TOLERANCE)] @ twists


def coordinate_names(mechanism: Mechanism, names: Sequence[str] | None) -> list[str] | None:
    """The names of an output that is told by coordinates of the mechanism, and not by velocity
    components of the platform.
    """
    if names is None or not names or set(names) <= {*OUTPUT_NAMES, "gamma"}:
        return None
    return list(names) if set(names) <= set(given_coordinates(mechanism)) else None


def make_output(names: Sequence[str] | None, point: Sequence[float] | None) -> Output | None:
    """A checked output; None where nothing is named. `gamma` is rz; a point alone stands for x, y,
    z of it.
    """
    if names is None and point is None:
        return None
    chosen = tuple(
        "rz" if name == "gamma" else name for name in (("x", "y", "z") if names is None else names)
    )
    unknown = [name for name in chosen if name not in OUTPUT_NAMES]
    if unknown or not chosen or len(set(chosen)) < len(chosen):
        raise InputError(
            f"output = {', '.join(chosen)!r}{meant(unknown[0], OUTPUT_NAMES) if unknown else ''}; "
            f"allowed: one or more of {', '.join(OUTPUT_NAMES)}, each once; or joints by name"
        )
    place = (0.0, 0.0, 0.0) if point is None else tuple(float(v) for v in point)
    if len(place) != 3 or not np.isfinite(place).all():
        raise InputError(
            f"point = {list(place)}; three finite numbers are needed, in the platform's frame"
        )
    return Output(chosen, (place[0], place[1], place[2]))


def output_equations(
    closure: Closure,
    values: np.ndarray,
    equations: LimbwiseEquations,
    output: Output,
    tolerance: float,
) -> OutputEquations:
    """The limbs' equations at a closed configuration, reduced to the output. Raises InputError for
    one that never moves.
    """
    at_point = _about_point(closure, values, output) @ equations.motion
    basis, triangle = np.linalg.qr(at_point)
    chosen = [OUTPUT_NAMES.index(name) for name in output.names]
    left, singular, right = np.linalg.svd(basis[chosen], full_matrices=True)
    rank = count_above(singular, RANK_TOLERANCE)
    if not rank:
        raise InputError(
            f"output = {', '.join(output.names)!r}: the {closure.mechanism.motion} motion of "
            f"{closure.mechanism.name} never moves it"
        )
    twist = np.linalg.solve(triangle.T, equations.twist.T).T
    moved, rest = twist @ (right[:rank].T / singular[:rank]), twist @ right[rank:].T
    p, n = rank, equations.rates.shape[1]
    rows = np.hstack([moved, equations.rates, rest])
    limb = eliminated(
        "output",
        rows,
        list(range(p)),
        list(range(p, p + n)),
        list(range(p + n, rows.shape[1])),
        tolerance,
    )
    passive = np.concatenate([*(each.passive for each in equations.limbs), limb.passive])
    one = LimbEquations(
        limb.limb,
        limb.twist,
        limb.rates,
        equations.constraints,
        passive,
        equations.idle + limb.idle,
    )
    return OutputEquations(replace(equations, limbs=(one,)), left[:, :rank].T @ at_point[chosen])


def output_twists(
    equations: LimbwiseEquations, reduced: OutputEquations, tolerance: float
) -> np.ndarray:
    """Twists (n, r) with the actuated joints held that move the output."""
    return reduced.moving(null_space(equations.twist, tolerance))


def _about_point(closure: Closure, values: np.ndarray, output: Output) -> np.ndarray:
    """(6, 6): from (velocity of the platform's origin; size times angular velocity) to the same
    about the output's point.
    """
    arm = np.asarray(pose_of(closure, values).rotation) @ np.array(output.point)
    shift = np.eye(6)
    shift[:3, 3:] = np.cross(np.eye(3), arm).T / closure.characteristic_length
    return shift
