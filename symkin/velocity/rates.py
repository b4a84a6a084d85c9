"""Rates of any coordinates by those of any others that decide the motion: of' = J by'.

With the closure F(u, k) = 0, u its unknowns and k the coordinates of `by`: F_u u' + F_k k' = 0.
Structure groups are solved one after another, so that each expression holds no more than a group's
own equations, and each by least squares of all its rows without a choice of pivots: expressions
have no poles but where these rows leave a rate free. Joints between floating bodies go first.

Square groups leave none wherever all rows together leave none, for determinants multiply.
Redundant rows may decide more than their own group (the third crank of a parallelogram carries
it through its dead points), so that such a group is solved together with all groups that lead to
it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import null_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations
from symkin.position.determination import refuse_unless_determined
from symkin.position.groups import structure_groups
from symkin.position.problem import Problem, actuated_names, build_problem, pose_names
from symkin.position.solve_result import SolveError
from symkin.position.transfer import many_elsewhere
from symkin.velocity.differential import TWIST_COLUMNS, by_name, tangent_jacobian
from symkin.velocity.elimination import factored, inner_rates, outer_rates, shortest
from symkin.velocity.equations import VelocityEquations, rows_at
from symkin.velocity.jacobian_names import JacobianKind, Matrix

_LEVEL = ("azimuth", "tilt")
"""Angles of a platform that have no rates where it does not tilt."""


@dataclass(frozen=True, eq=False)
class Rates:
    """Rates of all coordinates of a problem by those of its known ones, as expressions of the
    closure's variables: all at once by the velocity equations of `limbs` whose actuated joints are
    known, or block by block.

    Jacobians are (rows, columns) in the units of rates; columns and rows that a motion does not
    have are zero.
    """

    problem: Problem
    limbs: VelocityEquations | None = None

    @property
    def closure(self) -> Closure:
        return self.problem.closure

    @property
    def free(self) -> Collection[str]:
        """Numbers of the geometry that stay symbols."""
        return () if self.limbs is None or self.limbs.bound else self.closure.parameter_names

    @property
    def quaternion(self) -> ca.SX:
        """That of the platform's or tool's pose."""
        if self.limbs is not None:
            return self.limbs.differential.pose.quaternion
        return self.closure.symbols([c for c in self.closure.role("pose") if c.is_rotation])

    @cached_property
    def of(self) -> dict[str, ca.SX]:
        """(freedom, k) for each coordinate: its rates by those of the known ones."""
        return _rates(self.problem) if self.limbs is None else self.limbs.rates

    @property
    def following(self) -> ca.SX:
        """All rates by those of the known coordinates: these first; of limbs the twist last."""
        if self.limbs is None:
            return ca.vertcat(*self.of.values())
        joints = (self.of[c.name] for c in self._coordinates if c.role != "pose")
        return ca.vertcat(*joints, self.direct)

    def split(self, rates: ca.SX) -> dict[str, ca.SX]:
        """Rates of each coordinate among all rates, those of `following`."""
        found = by_name(self._coordinates, rates)
        if self.limbs is not None:
            pose = self.closure.role("pose")
            found |= {c.name: rates[-6:, :][list(TWIST_COLUMNS[c.name]), :] for c in pose}
        return found

    @property
    def _coordinates(self) -> tuple[Coordinate, ...]:
        return (*self.problem.known_coordinates, *self.problem.system.unknowns)

    @cached_property
    def direct(self) -> ca.SX:
        """J (6, n)."""
        twist = ca.SX(6, len(self.problem.known_coordinates))
        for c in self.closure.role("pose"):
            twist[list(TWIST_COLUMNS[c.name]), :] = self.of[c.name]
        return ca.sparsify(twist)

    @property
    def inverse(self) -> ca.SX:
        """J^-1 (n, 6)."""
        if self.limbs is not None:
            return self.limbs.inverse
        closure, size = self.closure, self.closure.characteristic_length
        lengths = ca.diag(ca.DM([1.0, 1.0, 1.0, size, size, size]))
        matrix, samples = ca.mtimes(lengths, self.direct), closed_configurations(closure, 0)
        shrunk = ca.diag(ca.DM([1 / c.lever(size) for c in self.problem.known_coordinates]))
        scaled = ca.mtimes(matrix, shrunk)
        columns = rows_at(closure, scaled.T, samples)
        if len(columns) == matrix.shape[1]:
            return factored(matrix, lengths).solution()
        # of rates by which the platform moves alike the shortest
        deciding = scaled[:, columns]
        rows = rows_at(closure, deciding, samples)
        feasible = ca.mtimes(deciding[rows, :], factored(deciding, lengths).solution())
        return ca.mtimes(shrunk, shortest(scaled[rows, :], feasible))

    def refuse_singular(self, values: np.ndarray, asked: Sequence[str]) -> None:
        """Raise SolveError where the known coordinates do not decide the rates that are asked
        for.
        """
        undecided = self.undecided(values, asked)
        if undecided:
            known = ", ".join(c.name for c in self.problem.known_coordinates)
            raise SolveError(
                f"{self.closure.mechanism.name}: {known} do not decide the rates of "
                f"{', '.join(undecided)} at this configuration: it is singular"
            )

    def undecided(self, values: np.ndarray, asked: Sequence[str] = ()) -> list[str]:
        """The coordinates, of those that are asked for or of all, whose rates the known ones leave
        free at a configuration.
        """
        system = self.problem.system
        known = self.problem.select_values(values, self.problem.known_coordinates)
        point = self.problem.select_values(values, system.unknowns)
        free = null_space(system.linearise_one(point, known)[1], RANK_TOLERANCE, relative=True)
        owners = [c.name for c in system.unknowns for _ in range(c.freedom)]
        moves = (np.abs(free) > RANK_TOLERANCE).any(axis=0)
        loose = {name for name, moving in zip(owners, moves, strict=True) if moving}
        return [n for n in dict.fromkeys(asked or owners) if n in loose]


def graph_rates(mechanism: Mechanism, kind: JacobianKind) -> Rates:
    """The rates for a kind of Jacobian of a graph whose actuated joints are as many as its
    mobility. Raises InputError for a graph without a platform, or whose actuated joints do not
    decide its motion.
    """
    if kind != "passive" and mechanism.platform_link is None:
        raise InputError(
            f"{mechanism.name} has no platform link, whose rates the {kind} Jacobian relates to "
            f"those of the actuated joints; name it by [platform] link in its mechanism file, of a "
            f"robot's file by --platform LINK, or name coordinates: of=[...], by=[...] (--of NAMES "
            f"--by NAMES)"
        )
    held = () if kind == "passive" else pose_names(mechanism)
    problem = build_problem(mechanism, actuated_names(mechanism), held)
    refuse_unless_determined(problem, rates=True)
    return Rates(problem)


def rates_by_name(
    mechanism: Mechanism, of: tuple[str, ...], by: tuple[str, ...]
) -> tuple[Rates, Matrix]:
    """The rates of some coordinates by those of others, as many as the mobility. Raises InputError
    for `by` that do not decide the motion, or say the same thing twice.
    """
    others = tuple(name for name in of if name not in by)
    plain = tuple(name for name in others if name not in _LEVEL)
    problem = build_problem(mechanism, by, others)
    rates = Rates(problem)
    asked = build_problem(mechanism, by, plain) if others != plain else problem
    refuse_unless_determined(asked, rates=True)
    if others != plain:
        _refuse_level(rates, of, by)
        refuse_unless_determined(problem, rates=True)
    return rates, Matrix(of, by, ca.vertcat(*(rates.of[name] for name in of)))


def _refuse_level(rates: Rates, of: Sequence[str], by: Sequence[str]) -> None:
    """Raise InputError for angles of a platform that never tilts, which have no rates."""
    problem = rates.problem
    # a closure that holds the tilt tells one of zero from others to the root of rounding only: it
    # is read off the orientation
    held = tuple(name for name in (*of, *by) if name not in POSE_CONDITIONS)
    plain = build_problem(problem.mechanism, (), held).closure
    closed = many_elsewhere(problem.closure, plain, np.array(closed_configurations(plain, 0)))
    everywhere = set(of).intersection(*(rates.undecided(values, of) for values in closed))
    without = [name for name in of if name in everywhere]
    if without:
        have = "has no rate" if len(without) == 1 else "have no rates"
        raise InputError(
            f"of: {', '.join(without)} {have} by {', '.join(by)} at any configuration of "
            f"{problem.mechanism.name}: the "
            "platform never tilts, its azimuth is then any angle, and its tilt, which is never "
            "negative, has no derivative at 0; "
            "allowed: joints, x, y, z, torsion"
        )


def _rates(problem: Problem) -> dict[str, ca.SX]:
    closure = problem.closure
    rates: dict[str, ca.SX] = {
        c.name: ca.SX.eye(len(problem.known_coordinates))[k, :]
        for k, c in enumerate(problem.known_coordinates)
    }
    for block in _blocks(problem):
        knowns = tuple(c for c in closure.coordinates if c.name in rates)
        # joints between bodies that float go first, limb by limb
        last = tuple(c for c in block.unknowns if c.body is not None) or block.unknowns
        first = tuple(c for c in block.unknowns if c not in last)
        inner, outer, driving = (
            ca.sparsify(tangent_jacobian(block.rows, closure, part))
            for part in (first, last, knowns)
        )
        driven = ca.mtimes(driving, ca.vertcat(*(rates[c.name] for c in knowns)))
        size = closure.characteristic_length
        levers = [c.lever(size) for c in first for _ in range(c.freedom)]
        found = outer_rates(inner, outer, driven, levers)
        rates |= by_name(last, found)
        rates |= by_name(first, inner_rates(inner, outer, driven, found))
    # in the order of the problem's unknowns
    return {c.name: rates[c.name] for c in (*problem.known_coordinates, *problem.system.unknowns)}


@dataclass(frozen=True, eq=False)
class _Block:
    """Rows whose unknowns are solved together, and the names of the coordinates that they hold
    beside these."""

    unknowns: tuple[Coordinate, ...]
    rows: ca.SX
    knowns: frozenset[str]

    def leads_to(self, other: _Block) -> bool:
        return any(c.name in other.knowns for c in self.unknowns)


def _blocks(problem: Problem) -> list[_Block]:
    """The structure groups in order; those with redundant rows in one with all that lead to
    them, which needs no other before."""
    blocks: list[_Block] = []
    for group in structure_groups(problem):
        known = frozenset(c.name for c in group.known_coordinates)
        block = _Block(group.system.unknowns, group.system.rows, known)
        if group.system.rows.shape[0] <= group.system.freedom:
            blocks.append(block)
            continue
        before: list[_Block] = []
        for other in reversed(blocks):
            if other.leads_to(block) or any(other.leads_to(b) for b in before):
                before.insert(0, other)
        blocks = [_joined([*before, block]), *(other for other in blocks if other not in before)]
    return blocks


def _joined(blocks: list[_Block]) -> _Block:
    unknowns = tuple(c for block in blocks for c in block.unknowns)
    own = {c.name for c in unknowns}
    return _Block(
        unknowns,
        ca.vertcat(*(block.rows for block in blocks)),
        frozenset(name for block in blocks for name in block.knowns if name not in own),
    )
