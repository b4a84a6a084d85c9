"""Build the equations of a singularity locus over a plane of two coordinates (u, v), or over one.

With the closure F(q, x, X) = 0, all coordinates but the plane's two and those that they leave free
held at a configuration, and J the part of dF/d(q, x, X) that must not lose rank,

    F = 0,   J w = 0,   (w.w - 1) / 2 = 0

describe a smooth curve of (q, x, X, w) whose picture in (u, v) is the locus, folds and cusps
included. Type 2: all rows, columns of pose and passive joints. Type 1 of a limb: its rows, columns
of its own joints. Where J w = 0 has solutions everywhere, w shows a loss of the generic rank in
another way (`rank_loss`). Every equation is solved, also where J is not square, so that points of
the curve are true zeros. Where known coordinates are told by name, the plane's are two of them, and
type 2 has all columns but theirs; over one coordinate the zeros are points.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import casadi as ca
import numpy as np

from symkin.assembly.as_written import machine_of
from symkin.closure.closure import Closure
from symkin.errors import InputError
from symkin.machine.lower import Lowered, arm_or_limbs, posed
from symkin.model.joint import Coordinate
from symkin.model.joint_forms import Kind
from symkin.model.mechanism import Mechanism
from symkin.numeric.system import System
from symkin.position.closed_configurations import closed_configurations, whole_system
from symkin.position.determination import refuse_unless_determined
from symkin.position.problem import Problem, actuated_names, are_of_limbs, build_problem, pose_names
from symkin.position.solution import Solution, named_values
from symkin.position.transfer import (
    many_of_machine,
    own_closure,
)
from symkin.position.varied_pose import POSE_AXES, TURNS, given_at, varied_pose
from symkin.singularities.rank_loss import RankLoss, generic_matrix
from symkin.text import meant
from symkin.velocity.limb_equations import limb_blocks
from symkin.velocity.roles import named_coordinates

LocusKind = Literal["type 1", "type 2"]


@dataclass(frozen=True, eq=False)
class Plane:
    """Two coordinates that vary (or one), all others of their family held: pose coordinates,
    actuated joints, or known coordinates by name.

    `told` are the names of the coordinates that are given, `problem` is the one of the machine
    `low` (None: the description itself) for which they are known; `here` are its closure's
    variables at the solution. `values` are these with the symbols `u`, `v` in place of the plane's
    coordinates, the held ones as numbers, and `free` (the rest) as symbols of the closure. Pose
    coordinates have the meaning of `position.varied_pose`: x, y, z, gamma, and the rotation vector
    rx, ry, rz before the configuration's orientation.
    """

    problem: Problem
    solution: Solution
    low: Lowered | None
    here: np.ndarray
    names: tuple[str, ...]
    told: tuple[str, ...]
    coordinates: tuple[Coordinate, ...]
    symbols: ca.SX
    values: ca.SX
    free: tuple[Coordinate, ...]

    @property
    def closure(self) -> Closure:
        return self.problem.closure

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism as it is written."""
        return self.solution.mechanism

    @property
    def of_pose(self) -> bool:
        """Whether coordinates of the pose vary."""
        return self.problem.of_pose

    @property
    def by_name(self) -> bool:
        """Whether the known coordinates are neither all actuated joints of limbs nor their pose."""
        return self.problem.by_name

    @property
    def family(self) -> tuple[Coordinate, ...]:
        """The coordinates of which two vary."""
        return self.problem.known_coordinates

    def value(self, coordinate: Coordinate) -> np.ndarray:
        """A coordinate's numbers at the configuration."""
        return np.asarray(self.here[self.closure.slices[coordinate.name]])

    def given(self, point: Sequence[float]) -> dict[str, Any]:
        """The pose, the joint values or the values by name at a point (mechanism's units), as
        arguments of `symkin.solve`.
        """
        varied = {name: float(value) for name, value in zip(self.names, point, strict=True)}
        base: Any = self.solution.actuated_values
        if self.of_pose:
            base = (*self.solution.position, *self.solution.quaternion)
        elif not are_of_limbs(self.mechanism, self.told):
            base = {
                c.name: self.mechanism.value_out(c, float(self.value(c)[0])) for c in self.family
            }
        return given_at(self.mechanism, base, varied, of_pose=self.of_pose)

    def limb_name(self, limb: str | None) -> str | None:
        """A limb of the machine as the description calls it; a graph has the names of joints."""
        own = next((one for one in self.closure.mechanism.limbs if one.name == limb), None)
        if own is None or not self.mechanism.is_graph or not own.joints:
            return limb
        return ", ".join(joint.name for joint in own.joints)

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as the configuration and the names, from which the symbols are built anew."""
        return plane_of, (self.solution, self.names, None if self.of_pose else self.told)


def pose_planes(mechanism: Mechanism) -> Lowered | None:
    """The machine over whose pose coordinates loci may be asked for, a platform on limbs, in the
    frame of its description; None of another one.
    """
    turned = posed(mechanism)
    low = turned if turned.frames is None else arm_or_limbs(mechanism)
    return None if low is None or low.machine.is_graph else low


def plane_of(solution: Solution, names: Sequence[str], known: Sequence[str] | None = None) -> Plane:
    """The plane of two named coordinates through a configuration, or a line of one; `known` are all
    coordinates that are given, of which they are some. Raises InputError for names that do not fit.
    """
    mechanism = solution.mechanism
    joints = actuated_names(mechanism)
    told = joints if known is None else named_coordinates(mechanism, known, "given")
    of_poses = pose_planes(mechanism) if known is None else None
    axes = () if of_poses is None else POSE_AXES[of_poses.machine.motion]
    if not 1 <= len(names) <= 2 or len(set(names)) < len(names):
        raise InputError(
            f"plane = {', '.join(names)!r}; one or two different coordinates are needed"
        )
    # a joint that is named as a coordinate of the pose is the joint, as among values by name
    if of_poses is not None and not set(names) <= set(told) and set(names) <= set(axes):
        return _plane_of_pose(solution, names, of_poses)
    if not set(names) <= set(told) or any(name.startswith("pose.") for name in told):
        poses = f"two of {', '.join(axes)} (pose), or " if axes else ""
        what = "actuated joints" if known is None else "coordinates that are given"
        raise InputError(
            f"plane = {', '.join(names)!r}{_guess(names, [*axes, *told])}; allowed: {poses}one or "
            f"two of the {what}, {', '.join(told) or 'none'}"
        )
    low = machine_of(mechanism, told)
    machine = mechanism if low is None else low.machine
    if are_of_limbs(machine, told):
        return _plane(build_problem(machine, told), solution, low, names, told)
    problem = build_problem(mechanism, told)
    refuse_unless_determined(problem, rates=True)
    return _plane(problem, solution, None, names, told)


def _guess(names: Sequence[str], known: Sequence[str]) -> str:
    """What the first name that is none of the known ones may stand for."""
    wrong = [name for name in names if name not in known]
    return meant(wrong[0], known) if wrong else ""


def _plane_of_pose(solution: Solution, names: Sequence[str], low: Lowered) -> Plane:
    """A plane of two coordinates of the pose."""
    if len(names) < 2 or set(names) == {"gamma", "rz"}:
        same = "; they are the same angle: " if len(names) == 2 else "; "
        raise InputError(f"plane = {', '.join(names)!r}{same}two different coordinates are needed")
    problem = build_problem(low.machine, pose_names(low.machine))
    return _plane(problem, solution, low, names, ())


def _plane(
    problem: Problem,
    solution: Solution,
    low: Lowered | None,
    names: Sequence[str],
    told_names: tuple[str, ...],
) -> Plane:
    closure, own = problem.closure, own_closure(solution)
    here = many_of_machine(closure, own, solution.variables[None], low)[0]
    u = ca.SX.sym("uv", len(names))
    values, held = ca.SX(closure.variables), named_values(closure, here)
    varied = {name: u[k] for k, name in enumerate(names)}
    known = problem.known_coordinates
    told = (
        varied_pose(closure, held, varied)
        if problem.of_pose
        else [varied.get(c.name, float(held[c.name])) for c in known]
    )
    for c, value in zip(known, told, strict=True):
        values[closure.slices[c.name]] = value
    coordinates = tuple(_coordinate(problem, held, name, names) for name in names)
    free = tuple(c for c in closure.coordinates if c not in known)
    told_names = told_names or pose_names(solution.mechanism)
    return Plane(
        problem, solution, low, here, tuple(names), told_names, coordinates, u, values, free
    )


def _coordinate(
    problem: Problem, held: Mapping[str, Any], name: str, names: Sequence[str]
) -> Coordinate:
    """One coordinate of a plane. One component of a rotation vector has a period of a turn, two
    together have none.
    """
    if not problem.of_pose:
        known = next(c for c in problem.known_coordinates if c.name == name)
        here, least = (float(held[name]),), known.least
        return Coordinate(f"plane.{name}", known.kind, "actuated", here, least=least)
    now = 0.0 if name in TURNS else float(held[f"pose.{name}"])
    kind: Kind = "angle" if name in TURNS or name == "gamma" else "length"
    if set(names) <= set(TURNS):
        kind = "turns"
    return Coordinate(f"plane.{name}", kind, "pose", (now,))


@dataclass(frozen=True, eq=False)
class LocusSystem:
    """One curve's equations: `curve` in the unknowns (free coordinates, u, v, w) and `closed`, F =
    0 alone, in the free coordinates, u and v; `loss` holds J at (free, u, v) and its generic rank.
    `limb` is set for type 1.
    """

    plane: Plane
    kind: LocusKind
    limb: str | None
    free: tuple[Coordinate, ...]
    curve: System
    closed: System
    loss: RankLoss

    @property
    def name(self) -> str:
        limb = self.plane.limb_name(self.limb)
        return self.kind + (f" of {limb}" if limb else "")

    @property
    def uv(self) -> slice:
        """Where (u, v) stand in a point of the curve."""
        width = sum(c.width for c in self.free)
        return slice(width, width + len(self.plane.coordinates))

    @property
    def uv_columns(self) -> slice:
        """Where (u, v) stand in a tangent of the curve."""
        freedom = sum(c.freedom for c in self.free)
        return slice(freedom, freedom + len(self.plane.coordinates))

    @property
    def centre(self) -> np.ndarray:
        """Free coordinates, u and v of the plane's configuration."""
        parts = [self.plane.value(c) for c in self.free]
        return np.concatenate([*parts, [c.reference[0] for c in self.plane.coordinates]])

    def lift(self, closed: np.ndarray) -> tuple[np.ndarray, float]:
        """A closed configuration with each w of `RankLoss.vectors` (r, width), and the smallest
        singular value.
        """
        vectors, singular = self.loss.vectors(closed)
        return np.hstack(
            [np.tile(closed, (len(vectors), 1)), self.curve.characteristic_length * vectors]
        ), float(singular[0])

    def through(self, z: np.ndarray) -> tuple[LocusSystem, np.ndarray]:
        """The equations for tracing from a seed, and the seed in them: these, with rows chosen at
        the seed where they are chosen at all. Where J has lost more than one rank there, C w = 0
        too, with the rows of C spanning the null vectors at the seed that are orthogonal to its
        own: w has no other one to turn to.
        """
        place, w, here = z[: self.uv.stop], z[self.uv.stop :], self
        if self.loss.chooses_rows:
            loss, w = self.loss.around(place, w)
            here = replace(
                self, loss=loss, curve=_curve(self.closed, loss.kernel(self.closed.unknown), loss)
            )
        null = here.loss.null_space(place)
        if len(null) > 1:
            others = np.linalg.svd((null @ w)[None])[2][1:] @ null
            kept = ca.DM(others) @ here.curve.unknown[self.uv.stop :]
            rows, errors = ca.vertcat(here.curve.rows, kept), ca.vertcat(here.curve.errors, kept)
            here = replace(here, curve=replace(here.curve, rows=rows, errors=errors))
        return here, np.concatenate([place, w])


def locus_systems(plane: Plane, kinds: Sequence[LocusKind]) -> list[LocusSystem]:
    """Type 2 once, type 1 for each limb with an actuated joint, unless known coordinates are told
    by name: these have no output that could stand. A kind that cannot occur has no system.
    """
    closure, systems = plane.closure, []
    whole = whole_system(closure)
    generic = [whole.linearise_one(z, np.zeros(0))[1] for z in closed_configurations(closure, 0)]
    if "type 2" in kinds and not closure.mechanism.serial:
        family = (
            {c.name for c in plane.family}
            if plane.by_name
            else {c.name for c in closure.role("actuated")}
        )
        kept = [k for k, c in enumerate(closure.owners) if c.name not in family]
        systems.append(
            _system(plane, whole, "type 2", None, list(range(closure.rows.shape[0])), kept, generic)
        )
    if "type 1" in kinds and not plane.by_name:
        for block in limb_blocks(closure):
            if block.actuated:
                systems.append(
                    _system(plane, whole, "type 1", block.limb, block.rows, block.joints, generic)
                )
    return [system for system in systems if system.loss.rank]


def _system(
    plane: Plane,
    whole: System,
    kind: LocusKind,
    limb: str | None,
    rows: list[int],
    columns: list[int],
    generic: list[np.ndarray],
) -> LocusSystem:
    """With a given pose limbs are apart: type 1 of a limb needs its own rows and joints only."""
    closure, size = plane.closure, plane.closure.characteristic_length
    alone = plane.of_pose and kind == "type 1"
    names = {closure.owners[k].name for k in columns}
    free = tuple(c for c in plane.free if c.name in names) if alone else plane.free
    used = rows if alone else list(range(closure.rows.shape[0]))
    closed_rows = _substituted(plane, whole.rows[used, 0])
    jacobian = _substituted(plane, whole.jacobian[rows, columns])
    fixed, nothing = ca.vertcat(plane.closure.symbols(free), plane.symbols), ca.SX(0, 1)
    role = "pose" if kind == "type 2" else "actuated"
    loss = RankLoss(
        ca.Function("kernel", [fixed], [ca.densify(jacobian)], {"cse": True}),
        generic_matrix(generic, rows, columns),
        [
            k
            for k, column in enumerate(columns)
            if plane.by_name or closure.owners[column].role == role
        ],
    )
    closed = System((*free, *plane.coordinates), fixed, nothing, closed_rows, closed_rows, size)
    return LocusSystem(
        plane=plane,
        kind=kind,
        limb=limb,
        free=free,
        curve=_curve(closed, jacobian, loss),
        closed=closed,
        loss=loss,
    )


def _curve(closed: System, jacobian: ca.SX, loss: RankLoss) -> System:
    """F = 0, what says that J loses rank, and the length of w."""
    w, size = ca.SX.sym("w", loss.rank), closed.characteristic_length
    weights = tuple(Coordinate(f"w.{k}", "length", "passive") for k in range(loss.rank))
    rows = ca.vertcat(closed.rows, loss.equations(jacobian, w), (ca.dot(w, w) / size - size) / 2)
    return System(
        (*closed.unknowns, *weights), ca.vertcat(closed.unknown, w), closed.known, rows, rows, size
    )


def _substituted(plane: Plane, expression: ca.SX) -> ca.SX:
    return ca.substitute(expression, plane.closure.variables, plane.values)
