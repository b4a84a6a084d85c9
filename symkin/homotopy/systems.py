"""The algebraic system of a problem: its rows over the complex numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from symkin.closure.bodies import PoseForm
from symkin.closure.closure import AlgebraicClosure, algebraic_rows, build_algebraic_closure
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
from symkin.position.problem import KNOWN, Problem

_ALL_ROWS = 1e-6
"""Largest row, over the size, of a root of combined rows that is one of all: given values that were
projected close them to 1e-9.
"""


@lru_cache(maxsize=256)
def system_of(problem: Problem) -> AlgebraicSystem:
    """The rows of a problem over the complex numbers. Platforms held by six rods share one system,
    whose known values are lengths and points.
    """
    if problem.by_name:
        return _of_given(problem)
    if is_universal(problem):
        return universal_system()
    return _build(problem)


def _build(problem: Problem) -> AlgebraicSystem:
    pose_unknown = problem.of_joints
    algebraic = build_algebraic_closure(
        problem.mechanism,
        "study" if pose_unknown else "homogeneous",
        eliminate=problem.of_pose,
    )
    size = problem.closure.characteristic_length
    known_role = KNOWN[problem.kind]
    symbols = {c.name: algebraic.joints[k] for k, c in enumerate(algebraic.coordinates)}
    unknowns = tuple(c for c in algebraic.coordinates if c.role != known_role)
    known = tuple(c for c in algebraic.coordinates if c.role == known_role)
    z_parts, k_parts = [symbols[c.name] for c in unknowns], [symbols[c.name] for c in known]
    scale_z, scale_k = _scales(unknowns, size), _scales(known, size)
    pose_scale = _pose_scale(algebraic, problem.closure.role("pose"), size)
    rows = list(ca.vertsplit(algebraic.rows))
    if distance_function(problem) is not None:
        rows = [rows[i] for i in chosen_distances(problem)]
    projective: tuple[int, ...] = ()
    affine = unknowns
    if pose_unknown:
        if algebraic.form is None:
            affine = (*unknowns, *problem.closure.role("pose"))
        else:
            width = int(algebraic.pose.shape[0])
            projective = tuple(range(len(unknowns), len(unknowns) + width))
            if width == 8:
                rows.append(ca.dot(algebraic.pose[:4], algebraic.pose[4:]))
        z_parts.append(algebraic.pose)
        scale_z += pose_scale
    else:
        k_parts.append(algebraic.pose)
        scale_k += pose_scale
    z, k = ca.vertcat(*z_parts), ca.vertcat(*k_parts)
    scaled = ca.vertcat(z * ca.DM(scale_z), k * ca.DM(scale_k))
    eliminated = tuple(e for e in algebraic.eliminated if e[0].role != known_role)
    expressions = ca.substitute(
        ca.vertcat(*rows, *(size * e for _, e in eliminated)) / size, ca.vertcat(z, k), scaled
    )
    last = int(k.shape[0])
    known_ray = () if pose_unknown or algebraic.form is None else tuple(range(last - 4, last))
    whole = AlgebraicSystem(
        size, affine, z, k, expressions[: len(rows)], projective, known_ray=known_ray
    )
    cut = tuple((c, expressions[len(rows) + i]) for i, (c, _) in enumerate(eliminated))
    if whole.projective:
        return whole
    return _part(whole, cut, {c.name for c in problem.system.unknowns})


def _of_given(problem: Problem) -> AlgebraicSystem:
    """The rows of a problem of given coordinates: joints as they are, a floating body that is
    unknown in Study coordinates, those that are known by position and a quaternion of any length.
    """
    closure, system, size = problem.closure, problem.system, problem.closure.characteristic_length
    unknown = floating_bodies(system.unknowns)
    partly = {c.body for c in system.unknowns}
    known = tuple(body for body in floating_bodies(problem.known_coordinates) if body not in partly)
    forms: dict[str, PoseForm] = {
        **dict.fromkeys(unknown, "study"),
        **dict.fromkeys(known, "homogeneous"),
    }
    rows, symbols = algebraic_rows(closure, forms) if forms else (system.rows, {})
    if forms and problem.row_places is not None:
        allowed = {c.name for c in (*system.unknowns, *problem.known_coordinates)}
        rows = without_later(rows[list(problem.row_places), 0], closure, allowed)
        rows = ca.vertcat(rows, _implied(problem, unknown, symbols))
    affine = tuple(c for c in system.unknowns if c.body not in unknown)
    stacked = {c.name: closure.variables[closure.slices[c.name]] for c in closure.coordinates}
    z_parts, z_scale = [stacked[c.name] for c in affine], _scales(affine, size)
    for body in unknown:
        z_parts.append(symbols[body])
        z_scale += [1.0] * 4
        if int(symbols[body].shape[0]) == 8:
            z_scale += [size] * 4
            rows = ca.vertcat(rows, ca.dot(symbols[body][:4], symbols[body][4:]))
    k_parts, k_scale, ray = _known_parts(problem, symbols)
    z, k = ca.vertcat(*z_parts), ca.vertcat(ca.SX(0, 1), *k_parts)
    rows = (
        ca.substitute(rows, ca.vertcat(z, k), ca.vertcat(z * ca.DM(z_scale), k * ca.DM(k_scale)))
        / size
    )
    projective = tuple(range(len(affine), int(z.shape[0]))) if unknown else ()
    return AlgebraicSystem(
        size, affine, z, k, rows, projective, known_ray=ray, body=unknown[0] if unknown else "pose"
    )


def _implied(problem: Problem, unknown: Sequence[str], symbols: Mapping[str, ca.SX]) -> ca.SX:
    """The implied rows with the unknown body in the form of its symbols."""
    closure, size, found = problem.closure, problem.closure.characteristic_length, ca.SX(0, 1)
    for row in problem.implied:
        value = row.row
        for body in unknown:
            e, dual = symbols[body][:4], symbols[body][4:]
            pose = StudyPose(e, dual) if dual.numel() else HomogeneousPose(ca.SX(3, 1), e)
            names = [f"{body}.{axis}" for axis in "xyz" if f"{body}.{axis}" in closure.slices]
            place = ca.vertcat(ca.SX(0, 1), *(closure.variables[closure.slices[n]] for n in names))
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
    return np.asarray(np.max(np.abs(f), axis=1, initial=0.0) < _ALL_ROWS)


def _scales(coordinates: Sequence[Coordinate], size: float) -> list[float]:
    return [c.unit(size) for c in coordinates]


def _part(
    whole: AlgebraicSystem, cut: tuple[tuple[Coordinate, ca.SX], ...], names: set[str]
) -> AlgebraicSystem:
    """The part of the coordinates `names`; rows without unknowns (conditions on the given values)
    belong to none. `cut` are eliminated coordinates and their values.
    """
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(whole.rows, whole.z), 1)) != 0
    places = [i for i, c in enumerate(whole.unknowns) if c.name in names]
    rows = [i for i in range(whole.count) if pattern[i, places].any()]
    return AlgebraicSystem(
        characteristic_length=whole.characteristic_length,
        unknowns=tuple(whole.unknowns[i] for i in places),
        z=whole.z[places],
        k=whole.k,
        rows=whole.rows[rows, 0],
        projective=(),
        eliminated=tuple((c, value) for c, value in cut if c.name in names),
        known_ray=whole.known_ray,
    )


def _pose_scale(
    algebraic: AlgebraicClosure, pose: Sequence[Coordinate], size: float
) -> list[float]:
    if algebraic.form is None:
        return [c.unit(size) for c in pose]
    width = int(algebraic.pose.shape[0])
    if width == 4:
        return [1.0] * 4
    return [1.0] * 4 + [size] * 4 if width == 8 else [size] * 3 + [1.0] * 4


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
    bodies = floating_bodies(problem.system.unknowns) if problem.by_name else ()
    if len(bodies) > 1:
        return f"the poses of {' and '.join(bodies)} are found together"
    return None
