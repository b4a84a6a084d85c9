"""The algebraic system of a problem: its rows over the complex numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from symkin.closure.bodies import PoseForm
from symkin.closure.closure import algebraic_rows
from symkin.closure.pose_forms import HomogeneousPose, StudyPose
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import (
    chosen_distances,
    distance_function,
    is_universal,
    universal_system,
)
from symkin.model.joint import Coordinate, units_of
from symkin.position.groups import without_later
from symkin.position.problem import Problem
from symkin.spatial.backend import stacked

_ALL_ROWS = 1e-6
"""Largest row, over the size, of a root of combined rows that is one of all: given values that were
projected close them to 1e-9.
"""


@lru_cache(maxsize=256)
def system_of(problem: Problem) -> AlgebraicSystem:
    """The rows of a problem over the complex numbers: joints as they are, a floating body that is
    unknown in Study coordinates, those that are known by position and a quaternion of any length.
    Platforms held by six rods share one system, whose known values are lengths and points.
    """
    if is_universal(problem):
        return universal_system()
    closure, system, size = problem.closure, problem.system, problem.closure.characteristic_length
    unknown = floating_bodies(system.unknowns)
    partly = {c.body for c in system.unknowns}
    known = tuple(body for body in floating_bodies(problem.known_coordinates) if body not in partly)
    forms: dict[str, PoseForm] = {
        **dict.fromkeys(unknown, "study"),
        **dict.fromkeys(known, "homogeneous"),
    }
    rows, symbols, eliminated = _written(problem, forms)
    affine = tuple(c for c in system.unknowns if c.body not in unknown and c not in eliminated)
    z_parts = [closure.variables[closure.slices[c.name]] for c in affine]
    z_scale = units_of(affine, size)
    for body in unknown:
        z_parts.append(symbols[body])
        z_scale += [1.0] * 4
        if symbols[body].shape[0] == 8:
            z_scale += [size] * 4
            rows = ca.vertcat(rows, ca.dot(symbols[body][:4], symbols[body][4:]))
    k_parts, k_scale, ray = _known_parts(problem, symbols)
    z, k = ca.vertcat(*z_parts), stacked(k_parts)
    scaled = ca.vertcat(z * ca.DM(z_scale), k * ca.DM(k_scale))
    angles = ca.substitute(ca.vertcat(*eliminated.values()), ca.vertcat(z, k), scaled)
    return AlgebraicSystem(
        size,
        affine,
        z,
        k,
        ca.substitute(rows, ca.vertcat(z, k), scaled) / size,
        tuple(range(len(affine), z.shape[0])) if unknown else (),
        eliminated=tuple(zip(eliminated, ca.vertsplit(angles), strict=True)),
        known_ray=ray,
        body=unknown[0] if unknown else "pose",
    )


def _written(
    problem: Problem, forms: Mapping[str, PoseForm]
) -> tuple[ca.SX, dict[str, ca.SX], dict[Coordinate, ca.SX]]:
    """The closure's rows of a problem with bodies in algebraic forms, their symbols, and the values
    of unknown joints that these rows do not hold.
    """
    closure, system = problem.closure, problem.system
    eliminate = _may_eliminate(problem)
    if not forms and not eliminate:
        return system.rows, {}, {}
    written = algebraic_rows(closure, tuple(forms.items()), eliminate=eliminate)
    rows, allowed = written.rows, {c.name for c in (*system.unknowns, *problem.known_coordinates)}
    if distance_function(problem) is not None:
        rows = rows[list(chosen_distances(problem)), 0]
    elif eliminate:
        # rows without unknowns are conditions on what is given
        held = ca.which_depends(rows, closure.symbols(system.unknowns), 1, True)
        rows = rows[[k for k, some in enumerate(held) if some], 0]
    else:
        rows = without_later(rows[list(problem.row_places), 0], closure, allowed)
        rows = ca.vertcat(rows, _implied(problem, written.symbols))
    return rows, written.symbols, {c: v for c, v in written.eliminated if c.name in allowed}


def _may_eliminate(problem: Problem) -> bool:
    """Whether the unknowns are all joints of some limbs, at a pose: in a limb without a passive
    joint to cut an actuated one is then found by the others.
    """
    own, held = {c.name for c in problem.system.unknowns}, problem.closure.slices.keys()
    limbs = problem.mechanism.limbs
    each = [{c.name for joint in limb.joints for c in joint.coordinates} for limb in limbs]
    return problem.of_pose and all(names & held <= own or not names & own for names in each)


def joint_rows(problem: Problem) -> ca.SX:
    """The rows of a problem without unknown bodies, whose known quaternions may have any length."""
    bodies = floating_bodies(problem.known_coordinates)
    rows, symbols, _ = _written(problem, dict.fromkeys(bodies, "homogeneous"))
    known = stacked(_known_parts(problem, symbols)[0])
    return ca.substitute(rows, known, problem.system.known)


def _implied(problem: Problem, symbols: Mapping[str, ca.SX]) -> ca.SX:
    """The implied rows with the unknown body in the form of its symbols."""
    closure, size, found = problem.closure, problem.closure.characteristic_length, ca.SX(0, 1)
    unknown = floating_bodies(problem.system.unknowns)
    for row in problem.implied:
        value = row.row
        for body in unknown:
            e, dual = symbols[body][:4], symbols[body][4:]
            pose = StudyPose(e, dual) if dual.numel() else HomogeneousPose(ca.SX(3, 1), e)
            names = [f"{body}.{axis}" for axis in "xyz" if f"{body}.{axis}" in closure.slices]
            place = stacked(closure.variables[closure.slices[n]] for n in names)
            turn = closure.variables[closure.slices[f"{body}.quaternion"]]
            value = row.weighted(place, turn, pose)
        found = ca.vertcat(found, value / (2 * size) if row.is_sphere else value)
    return found


def _known_parts(
    problem: Problem, symbols: Mapping[str, ca.SX]
) -> tuple[list[ca.SX], list[float], tuple[int, ...]]:
    """Symbols and scales of the known coordinates in their order, and the places of the first known
    quaternion.
    """
    closure, size = problem.closure, problem.closure.characteristic_length
    parts: list[ca.SX] = []
    scale: list[float] = []
    ray: tuple[int, ...] = ()
    for c in problem.known_coordinates:
        if c.body is not None and c.body in symbols:
            key = c.name.rpartition(".")[2]
            symbol = (
                symbols[c.body][-4:] if key == "quaternion" else symbols[c.body]["xyz".index(key)]
            )
        else:
            symbol = closure.variables[closure.slices[c.name]]
        if c.is_rotation and not ray:
            ray = tuple(range(len(scale), len(scale) + 4))
        parts.append(symbol)
        scale += units_of([c], size)
    return parts, scale, ray


def floating_bodies(coordinates: Sequence[Coordinate]) -> tuple[str, ...]:
    """The bodies whose rotation is among some coordinates, by the part of these names before the
    last point; a platform that keeps its orientation, or turns about one axis, has numbers for
    coordinates as joints do.
    """
    return tuple(dict.fromkeys(c.body for c in coordinates if c.body is not None and c.is_rotation))


@lru_cache(maxsize=64)
def squared(system: AlgebraicSystem) -> AlgebraicSystem:
    """As many random combinations of the rows as there are unknowns: their roots are those of all
    rows, and others that the rows tell apart. The given values need satisfy no conditions then.
    """
    mixed = np.random.default_rng(7).normal(size=(system.width, system.count))
    return replace(
        system,
        rows=ca.mtimes(ca.DM(mixed / np.linalg.norm(mixed, axis=1, keepdims=True)), system.rows),
    )


def meets_all_rows(
    problem: Problem, system: AlgebraicSystem, z: np.ndarray, k: np.ndarray
) -> np.ndarray:
    """Which roots z (width, n) at k (known, n) meet all rows of the problem, of which `system` may
    hold combinations.
    """
    whole = system_of(problem)
    if whole.count <= system.count or whole.width != system.width:
        return np.ones(z.shape[1], dtype=bool)
    f, _ = whole.linearise(z, k.astype(complex))
    return np.max(np.abs(f), axis=1, initial=0.0) < _ALL_ROWS


def unsuitable(problem: Problem) -> str | None:
    """Why a problem has no complex start system, if it has none."""
    for c in problem.system.unknowns:
        if c.is_advancing:
            reason = problem.mechanism.advancing.get(c.name)
            return (
                f"the closure is not algebraic in {c.name} "
                f"({'helical joint' if reason is None else reason})"
            )
        if c.is_rotation and c.role not in ("pose", "body"):
            return f"{c.name} is a spherical joint that the closure keeps"
    bodies = floating_bodies(problem.system.unknowns)
    if len(bodies) > 1:
        return f"the poses of {' and '.join(bodies)} are found together"
    return None
