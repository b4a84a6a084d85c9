"""Whether a platform's pose coordinates can vary alone, the others held, or the joints put a
condition on them.

A platform of fewer freedoms than its pose has coordinates takes hardly any pose of a grid. Closed
configurations with the held coordinates at their values are found; from each the varied ones are
moved by a small random step and the joints are asked to follow. A condition lets none of the steps
pass, whatever its order; an end of the workspace stops some.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.machine.lower import posed
from symkin.model.joint import Coordinate
from symkin.model.keys import ABOUT_Z
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import NOTHING, System
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.mobility import mobility
from symkin.position.platform_motion import fewer_rows
from symkin.position.pose_coordinates import pose_coordinates
from symkin.position.varied_pose import varied_pose
from symkin.spatial.pose import Pose
from symkin.text import counted, plain

_STARTS = 24
"""Random starts from which closed configurations are sought."""
_TRIED = 6
"""Closed configurations from which a step is tried."""
_STEP = 0.01
"""Step of the varied coordinates, of the size or in rad: a condition of third order leaves a
thousand times the tolerance.
"""
_FOLLOWING = 8
"""Starts for the joints near a configuration, so that one of them leaves a singular one."""

Box = tuple[tuple[str, float, float], ...]
"""Names of varied coordinates (x, y, z, gamma, rx, ry, rz) with their least and largest values, in
length units and rad.
"""


@lru_cache(maxsize=32)
def poses_vary(mechanism: Mechanism, base: tuple[float, ...], box: Box) -> bool | None:
    """Whether poses near closed ones are taken when the coordinates of `box` vary and all others
    are those of `base` (x, y, z, qw, qx, qy, qz); None where no closed configuration was found, so
    that nothing is known.
    """
    closure = build_closure(mechanism)
    joints = closure.role("actuated", "passive")
    unknown = closure.symbols(joints)
    names = [name for name, _, _ in box]
    varied = ca.SX.sym("varied", len(names))
    held = _held(closure, Pose(np.array(base[:3]), np.array(base[3:])))
    pose = ca.vertcat(
        *varied_pose(closure, held, dict(zip(names, ca.vertsplit(varied), strict=True)))
    )
    place = closure.variables[closure.variables.shape[0] - pose.shape[0] :]
    rows, errors = (
        ca.substitute(closure.bound(e), place, pose) for e in (closure.rows, closure.errors)
    )
    coordinates = tuple(
        Coordinate(f"varied.{n}", "length" if n in "xyz" else "angle", "pose") for n in names
    )
    together = System(
        (*joints, *coordinates),
        ca.vertcat(unknown, varied),
        ca.SX(0, 1),
        rows,
        errors,
        closure.characteristic_length,
    )
    rng = np.random.default_rng(0)
    found = _closed(together, _starts(closure, together, box, rng))
    alone = System(joints, unknown, varied, rows, errors, closure.characteristic_length)
    units = np.array([c.unit(closure.characteristic_length) for c in coordinates])
    return any(_follows(alone, z, units, rng) for z in found) if found else None


def condition_sentence(
    mechanism: Mechanism, varied: str, instead: str, freedoms: int, coordinates: int
) -> str:
    """Why `varied` pose coordinates cannot vary alone, for a platform whose `freedoms` are less
    than its pose's coordinates.
    """
    frame = mechanism.frame_name
    named = fewer_rows(mobility(mechanism))
    motion = (
        "" if named is None else f", or pose coordinates with motion = {named[0]!r} in [platform]"
    )
    return (
        f"the {frame} of {mechanism.name} has {counted(freedoms, 'freedom')} of "
        f"{coordinates}, so that {varied} cannot vary alone; "
        f"allowed: {instead}{motion}{_of_turned(mechanism)}"
    )


def _of_turned(mechanism: Mechanism) -> str:
    """What else would let pose coordinates vary, of a platform whose motion is about another axis
    than z.
    """
    low = posed(mechanism)
    if low.frames is None or low.machine.motion not in ABOUT_Z:
        return ""
    axis = np.asarray(low.frames.base.inverse().turn((0.0, 0.0, 1.0)))
    told = ", ".join(f"{plain(float(value)):.6g}" for value in axis)
    return (
        f"; its joints leave it a {low.machine.motion} motion about ({told}): x, y and gamma vary "
        f"where it is described with this axis along z"
    )


def _held(closure: Closure, base: Pose) -> dict[str, np.ndarray]:
    """A pose by the closure's names."""
    values, _ = pose_coordinates(closure.mechanism, base)
    coordinates = closure.role("pose")
    ends = np.cumsum([c.width for c in coordinates])[:-1]
    return dict(zip((c.name for c in coordinates), np.split(values, ends), strict=True))


def _starts(closure: Closure, system: System, box: Box, rng: np.random.Generator) -> np.ndarray:
    """Joints about the reference; varied coordinates anywhere in the box, in half of the starts
    those of the reference.
    """
    rest, _ = pose_coordinates(closure.mechanism, closure.mechanism.reference_pose)
    names = [c.name.removeprefix("pose.") for c in closure.role("pose") if not c.is_rotation]
    at_rest = dict(zip(names, rest, strict=False))
    joints = closure.reference[: system.width - len(box)]
    starts = np.zeros((_STARTS, system.width))
    starts[:, : len(joints)] = joints
    for k, (name, low, high) in enumerate(box, start=len(joints)):
        starts[:, k] = rng.uniform(low, high, _STARTS)
        starts[1::2, k] = at_rest.get(name, 0.0)
    radii = np.tile([0.03, 0.1, 0.3], _STARTS // 3)[:, None] * closure.characteristic_length
    steps = radii * rng.normal(size=(_STARTS, system.freedom))
    return system.move(starts, steps)


def _closed(system: System, starts: np.ndarray) -> list[np.ndarray]:
    batch = levenberg_marquardt(system, starts, NOTHING, max_iterations=200)
    ends = system.polish_many(batch.points[batch.converged]).points
    return list(ends[system.residuals(ends) <= CLOSURE_TOLERANCE * system.characteristic_length])[
        :_TRIED
    ]


def _follows(system: System, z: np.ndarray, units: np.ndarray, rng: np.random.Generator) -> bool:
    """Whether the joints follow one of two opposite steps of the varied coordinates from a closed
    configuration.
    """
    joints, varied = z[: system.width], z[system.width :]
    step = _STEP * units * rng.choice([-1.0, 1.0], len(units)) * rng.uniform(0.5, 1.0, len(units))
    for target in (varied + step, varied - step):
        spread = (
            _STEP * system.characteristic_length * rng.normal(size=(_FOLLOWING, system.freedom))
        )
        batch = levenberg_marquardt(
            system, system.move(np.tile(joints, (_FOLLOWING, 1)), spread), target
        )
        ends = system.polish_many(batch.points[batch.converged], target).points
        if (
            system.residuals(ends, target) <= CLOSURE_TOLERANCE * system.characteristic_length
        ).any():
            return True
    return False
