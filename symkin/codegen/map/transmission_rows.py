"""The few equations of a transmission from which array code is written: rows R(m, j) = 0 over
motors and joints alone, and formulas of one by the other where elimination finds them.

They are rows that each loop implies without its passive joints, distances mostly; else, where
formulas give the motors, R = m - f(j), and where they give the joints, R = j - g(m).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.codegen.map.joint_map import Direction, JointMap
from symkin.codegen.map.options import Options
from symkin.codegen.steps.composed import Formulas
from symkin.codegen.text.c import Real
from symkin.computed_once import cached_property
from symkin.elimination.implied_rows import PointRow
from symkin.elimination.product_rows import ProductRow
from symkin.errors import InputError
from symkin.model.joint import Coordinate
from symkin.numeric.rank import independent_rows
from symkin.numeric.system import System
from symkin.position.groups import coordinates_in, implied_rows_of
from symkin.position.problem import Problem
from symkin.transmissions.linkage import Linkage

_OF_POINTS = ("distance", "point")
"""Relations of rows from which spheres are implied."""


@dataclass(frozen=True, eq=False)
class Formula:
    """Values of coordinates as expressions of known ones and of signs, with the signs that the
    reference has.
    """

    values: ca.SX
    signs: ca.SX
    at_reference: np.ndarray


@dataclass(frozen=True, eq=False)
class TransmissionRows:
    """Rows and formulas of a linkage of as many motors as joints; `m` and `j` are their symbols."""

    linkage: Linkage

    @cached_property
    def m(self) -> ca.SX:
        return ca.SX.sym("m", len(self.linkage.motors))

    @cached_property
    def j(self) -> ca.SX:
        return ca.SX.sym("j", len(self.linkage.joints))

    @cached_property
    def motors_of(self) -> Formula | None:
        """Motors by joints."""
        linkage = self.linkage
        return self._formula(self._map.inverse, linkage.joints, linkage.motors, self.j)

    @cached_property
    def joints_of(self) -> Formula | None:
        """Joints by motors."""
        linkage = self.linkage
        return self._formula(self._map.direct, linkage.motors, linkage.joints, self.m)

    @cached_property
    def rows(self) -> ca.SX:
        """R(m, j), as many as motors, explicit ones at the signs of the reference. Raises
        InputError.
        """
        if self._implied:
            return self._chosen
        if self.motors_of is not None:
            return self.m - _at_reference(self.motors_of)
        if self.joints_of is not None:
            return self.j - _at_reference(self.joints_of)
        raise InputError(
            f"{', '.join(self.linkage.joints)}: no formula and no row without passive joints was "
            f"found for this linkage, so that no array file is written; C has its Newton iteration"
        )

    # --- formulas ---------------------------------------------------------------------------------

    @cached_property
    def _map(self) -> JointMap:
        linkage = self.linkage
        options = Options(given=linkage.motors, find=linkage.joints)
        return JointMap(linkage.mechanism, options, Real("double"))

    def _formula(
        self, direction: Direction, given: tuple[str, ...], wanted: tuple[str, ...], known: ca.SX
    ) -> Formula | None:
        """The formula of a direction, by all rows or else by implied ones: what is `wanted` by what
        is `given`, whose values are `known`.
        """
        if self._implied:
            direction = Direction(direction.name, self._implied_problem(given))
        if not direction.is_closed:
            return None
        formulas = Formulas.of(direction.problem, direction.parts)
        reference = dict(zip(wanted, self._reference(wanted), strict=True))
        told = {c.name: known[k] for k, c in enumerate(direction.known)}
        signs = ca.SX.sym("s", formulas.roots.numel())
        values = []
        for one in wanted:
            number = formulas.whole.numbers[one][0]
            turned = number.value
            if number.cosine is not None and number.sine is not None:
                about = float(reference[one])
                turned = _angle_about(number.cosine, number.sine, about) + about
            turned = formulas.of_values(formulas.with_roots(turned, signs, ca.sqrt), known)
            values.append(told.get(one, turned))
        return Formula(ca.vertcat(*values), signs, formulas.signs_at(self._map.reference))

    def _reference(self, names: tuple[str, ...]) -> np.ndarray:
        return self.linkage.reference[self.linkage.places_of(names)]

    # --- implied rows -----------------------------------------------------------------------------

    @cached_property
    def _implied(self) -> tuple[PointRow | ProductRow, ...]:
        """What each loop says without the joints that it alone holds, where that is enough."""
        problem, ends = self.linkage.problem, {*self.linkage.motors, *self.linkage.joints}
        if any(source.relation not in _OF_POINTS for source in problem.closure.row_sources):
            return ()
        found = implied_rows_of(problem, ends)
        own = [row for row in found if coordinates_in(row.row, problem.closure) <= ends]
        return tuple(own) if len(self._independent(own)) == self._needed else ()

    @property
    def _needed(self) -> int:
        """Rows that tie motors and joints: those that are both need none."""
        return len({*self.linkage.motors} - {*self.linkage.joints})

    def _coordinates(self, names: set[str]) -> list[Coordinate]:
        return [c for c in self.linkage.problem.closure.coordinates if c.name in names]

    def _independent(self, rows: Sequence[PointRow | ProductRow]) -> list[int]:
        if not rows:
            return []
        closure = self.linkage.problem.closure
        names = {*self.linkage.motors, *self.linkage.joints}
        symbols = closure.symbols(self._coordinates(names))
        slopes = ca.Function("s", [closure.variables], [ca.jacobian(self._scaled(rows), symbols)])
        matrix = np.asarray(slopes(self.linkage.reference)).reshape(len(rows), -1)
        return sorted(independent_rows(matrix, 1e-6, groups=range(len(rows))))

    def _scaled(self, rows: Sequence[PointRow | ProductRow]) -> ca.SX:
        size = self.linkage.size
        return ca.vertcat(*(r.row / (2 * size * size if r.is_sphere else size) for r in rows))

    def _implied_problem(self, known: tuple[str, ...]) -> Problem:
        linkage = self.linkage
        problem, closure = linkage.problem, linkage.problem.closure
        names = {*linkage.motors, *linkage.joints} - {*known}
        parts = [self._coordinates(names), linkage.coordinates_of(known)]
        unknown, given = (closure.symbols(part) for part in parts)
        rows = linkage.size * self._scaled(list(self._implied))
        system = System(tuple(parts[0]), unknown, given, rows, rows, closure.characteristic_length)
        return replace(
            problem,
            system=system,
            known_coordinates=tuple(parts[1]),
            row_places=(),
            implied=self._implied,
        )

    @cached_property
    def _chosen(self) -> ca.SX:
        """As many implied rows as motors, over `m` and `j`; what is motor and joint is equal."""
        linkage, closure = self.linkage, self.linkage.problem.closure
        rows = self._scaled([self._implied[k] for k in self._independent(list(self._implied))])
        both = [n for n in linkage.joints if n in linkage.motors]
        same = [self.j[linkage.joints.index(n)] - self.m[linkage.motors.index(n)] for n in both]
        names = (*linkage.motors, *(n for n in linkage.joints if n not in both))
        symbols = [closure.variables[closure.slices[n]] for n in names]
        mine = [
            self.m[linkage.motors.index(n)]
            if n in linkage.motors
            else self.j[linkage.joints.index(n)]
            for n in names
        ]
        return ca.vertcat(ca.substitute(rows, ca.vertcat(*symbols), ca.vertcat(*mine)), *same)


def _at_reference(formula: Formula) -> ca.SX:
    return ca.substitute(formula.values, formula.signs, ca.SX(ca.DM(formula.at_reference)))


def _angle_about(cosine: ca.SX, sine: ca.SX, about: float) -> ca.SX:
    """The angle less `about`, within half a turn."""
    if not about:
        return ca.atan2(sine, cosine)
    c, s = float(np.cos(about)), float(np.sin(about))
    return ca.atan2(sine * c - cosine * s, cosine * c + sine * s)
