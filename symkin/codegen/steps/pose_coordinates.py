"""Write C that turns a pose into the coordinates of a restricted platform, and back."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.codegen.steps.formula_guards import feasible_error
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.text.c import Emitter, Real, block, indexed, refused
from symkin.codegen.text.templates import fill
from symkin.model.keys import ABOUT_Z
from symkin.spatial.backend import stacked
from symkin.spatial.rotation import conjugate, multiply

COLUMNS: dict[str, tuple[int, ...]] = {
    "spatial": (0, 1, 2, 3, 4, 5),
    "schoenflies": (0, 1, 2, 5),
    "planar": (0, 1, 5),
    "translation": (0, 1, 2),
    "spherical": (3, 4, 5),
}
"""Columns of a twist (velocity, angular velocity) that a motion has."""

POSE = indexed("pose->position", 3) + indexed("pose->quaternion", 4)
"""C text of the numbers of a pose."""


@dataclass(frozen=True, eq=False)
class Restricted:
    """A pose as a platform's motion takes it: `lengths` and quaternion entries, cosine and sine of
    half its turn about z, if it has one, and what is `off` the motion, as lengths.
    """

    lengths: list[ca.SX]
    half_turn: tuple[ca.SX, ca.SX] | None
    off: list[ca.SX]

    @property
    def coordinates(self) -> ca.SX:
        turn = (
            [] if self.half_turn is None else [2 * ca.atan2(self.half_turn[1], self.half_turn[0])]
        )
        return ca.vertcat(*self.lengths, *turn)


def restricted(geometry: Geometry, x: ca.SX) -> Restricted:
    """The seven numbers of a pose as the platform's motion takes them."""
    closure = geometry.closure
    reference, size = _reference(geometry), closure.characteristic_length
    x = geometry.taken(x)
    delta = multiply(x[3:], conjugate(reference[3:]))
    away = [x[i] - reference[i] for i in range(3)]
    # of a turn about z the quaternion is (cos a/2, 0, 0, sin a/2); its other components are the
    # tilt
    half = (delta[0], delta[3])
    tilt = [2 * size * delta[1], 2 * size * delta[2]]
    return {
        "spatial": Restricted(ca.vertsplit(x), None, []),
        "schoenflies": Restricted([x[i] for i in range(3)], half, tilt),
        "planar": Restricted([x[0], x[1]], half, [*tilt, away[2]]),
        "translation": Restricted([x[i] for i in range(3)], None, [*tilt, 2 * size * delta[3]]),
        "spherical": Restricted(ca.vertsplit(x)[3:], None, away),
    }[closure.mechanism.motion]


def pose_coordinates_text(geometry: Geometry, real: Real, values: dict[str, object]) -> str:
    """NAME_pose_coordinates: the pose coordinates of a pose; OUT_OF_RANGE for one off the
    platform's motion.
    """
    closure = geometry.closure
    motion = closure.mechanism.motion
    x = ca.SX.sym("x", 7)
    found = restricted(geometry, x)
    coordinates, off = found.coordinates, found.off
    count = coordinates.numel()
    inputs = [(x, "x"), (geometry.symbols, geometry.names)]
    emitter = Emitter.of(real, inputs, coordinates, stacked(off))
    texts = [emitter.value(0, i) for i in range(count)]
    limit = off_motion(geometry, real)
    tests = [f"(fabs({emitter.value(1, i)}) <= {limit})" for i in range(len(off))]
    body = [*emitter.lines, *(f"c[{i}] = {text};" for i, text in enumerate(texts))]
    if motion in ABOUT_Z:
        pi, two_pi = np.pi, 2 * np.pi
        angle = f"c[{count - 1}]"
        body += [
            *block(f"if ({angle} > {pi})", [f"{angle} -= {two_pi};"]),
            *block(f"if ({angle} < -{pi})", [f"{angle} += {two_pi};"]),
        ]
    body += refused(" && ".join(tests), "OUT_OF_RANGE")
    return fill("pose_coordinates.c", values | {"count": count, "body": body})


def pose_text(geometry: Geometry, real: Real, values: dict[str, object]) -> str:
    """NAME_pose_from_coordinates: the pose of pose coordinates."""
    closure = geometry.closure
    symbols = closure.symbols(closure.role("pose"))
    count = symbols.numel()
    inputs = [(symbols, "c"), (geometry.symbols, geometry.names)]
    body = Emitter.of(real, inputs, geometry.pose).stored(POSE)
    return fill("pose_from_coordinates.c", values | {"count": count, "body": body})


def off_motion(geometry: Geometry, real: Real) -> float:
    """How far a pose may be off the platform's motion, a length."""
    return feasible_error(real.epsilon, geometry.closure.characteristic_length)


def _reference(geometry: Geometry) -> ca.SX:
    """Position of the closure's platform at the reference configuration, and the unit quaternion
    from which its turn about z is told.
    """
    closure, pose = geometry.closure, geometry.closure.pose
    own = geometry.of(ca.vertcat(pose.position, pose.quaternion))
    home = closure.reference.copy()
    if "pose.gamma" in closure.slices:
        home[closure.slices["pose.gamma"]] = 0.0
    at = ca.substitute(own, closure.variables, ca.SX(ca.DM(home)))
    return snapped_expression(ca.densify(at), [geometry.symbols])
