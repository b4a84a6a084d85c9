"""Make test vectors of a map between joints, and the text of their header."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.codegen.joint_map import JointMap, map_configurations
from symkin.codegen.passive_limits import keeps_limits
from symkin.codegen.rates import derivatives
from symkin.codegen.refused_vectors import infeasible_values, joints_past
from symkin.codegen.samples import Configuration
from symkin.codegen.text.c import Real
from symkin.codegen.vectors import COUNT, JACOBIANS, rounded_to, tidied
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import units_of

_SPREAD, _TURN = 0.06, 0.3
"""How far the given coordinates go from the reference: in sizes, and in radians."""
_NEAR = 2e-4
"""How far every other guess is from its answer: in radians, and in sizes."""
_DIGITS = 13
_PARTS = (1.0, 0.25, 0.0625)
"""Shares of the way from the reference that are tried where limits of passive joints or
singularities leave few configurations.
"""
_LARGEST_CONDITION = 1e4
"""Condition from which on errors allowed do not grow."""
_HIDDEN = 2e-4
"""Largest condition of a case, times roundings: beyond it a hundred of them are as far as a
singularity may be away.
"""


@dataclass(frozen=True, eq=False)
class MapVectors:
    """Cases of a map, numbers as generated code reads them."""

    made: JointMap

    @property
    def _real(self) -> Real:
        return self.made.real

    @cached_property
    def cases(self) -> list[Configuration]:
        """Configurations whose given values are numbers of the type."""
        made, direct = self.made, self.made.direct.problem
        found = []
        for case in self._configurations:
            given = rounded_to(self._real, np.round(case.known, _DIGITS))
            values = case.values.copy()
            values[direct.known_places] = given
            values[direct.unknown_places] = direct.system.polish(case.unknown, given, 6)
            found.append(Configuration(values, values[direct.unknown_places], given))
        if not found:
            raise InputError(
                f"{made.name}: no configuration near the reference is regular to the digits of "
                f"{self._real.name} both ways, so that "
                "generated code cannot be tested; give the file another reference"
            )
        return found

    @property
    def _configurations(self) -> list[Configuration]:
        """Configurations about the reference within limits of passive joints, and nearer ones if
        they are few.
        """
        made, found = self.made, list[Configuration]()
        for part in _PARTS:
            cases = map_configurations(made, COUNT, 20, _SPREAD * part, _TURN * part)
            found += [
                case
                for case in cases
                if keeps_limits(made.passive_limits, made.direct.problem.closure, case.values)
                and self._is_regular(case)
            ]
            if len(found) >= COUNT:
                break
        return found[:COUNT]

    def _is_regular(self, case: Configuration) -> bool:
        """Whether roundings of the type cannot hide a singularity."""
        return self._condition(case) * self._real.epsilon <= _HIDDEN

    def _condition(self, case: Configuration) -> float:
        """The larger condition of the two directions."""
        directions = (self.made.direct.problem, self.made.inverse.problem)
        return max(
            p.system.condition(case.values[p.unknown_places], case.values[p.known_places])
            for p in directions
        )

    def _of(self, values: np.ndarray, which: str) -> np.ndarray:
        coordinates = self.made.given if which == "joints" else self.made.found
        places = self.made.direct.problem.places(coordinates)
        return tidied(values[places], units_of(coordinates, self.made.size))

    @cached_property
    def tables(self) -> dict[str, np.ndarray]:
        """Rows by name. Every other case starts next to its answer, as a loop does; the others at
        the reference.
        """
        home, direct = self.made.reference, self.made.direct.problem
        rows: dict[str, list[np.ndarray]] = {
            name: [] for name in ("joints", "found", "guesses", "joint_guesses")
        }
        for number, case in enumerate(self.cases):
            near = home
            if number % 2:
                scales = np.array(units_of(self.made.given, self.made.size))
                known = case.known + _NEAR * scales
                near = case.values.copy()
                near[direct.known_places], near[direct.unknown_places] = (
                    known,
                    direct.system.polish(case.unknown, known, 6),
                )
            for name, values in (
                ("joints", case.values),
                ("found", case.values),
                ("guesses", near),
                ("joint_guesses", near),
            ):
                rows[name].append(
                    self._of(values, "joints" if name.startswith("joint") else "found")
                )
        tables = {name: np.array(found) for name, found in rows.items()}
        return tables | {
            "inverse": np.array(
                [self._inverse_of(c, f) for c, f in zip(self.cases, tables["found"], strict=True)]
            )
        }

    def _inverse_of(self, case: Configuration, found: np.ndarray) -> np.ndarray:
        """Joints of found values as generated code reads them, near a case."""
        inverse, values = self.made.inverse.problem, case.values.copy()
        values[inverse.known_places] = rounded_to(self._real, found)
        values[inverse.unknown_places] = inverse.system.polish(
            values[inverse.unknown_places], values[inverse.known_places], 6
        )
        return self._of(values, "joints")

    @cached_property
    def refused(self) -> dict[str, np.ndarray]:
        """Values (n, coordinates) that code refuses, by name: those that no configuration has, and
        those beyond limits.
        """
        made, home, found = self.made, self.made.reference, dict[str, np.ndarray]()
        for what, coordinates, direction in (
            ("joints", made.given, made.direct),
            ("found", made.found, made.inverse),
        ):
            infeasible = np.round(infeasible_values(made, direction, self.cases), 9)
            found[f"infeasible_{what}"] = rounded_to(self._real, infeasible).reshape(
                -1, len(coordinates)
            )
            found[f"past_{what}"] = joints_past(coordinates, self._of(home, what))[0]
        return found

    @property
    def blamed(self) -> list[int]:
        """Which joint is beyond a limit in each of the rows of joints that are."""
        return joints_past(self.made.given, self._of(self.made.reference, "joints"))[1]

    @cached_property
    def _derivatives(self) -> dict[str, np.ndarray]:
        """Jacobians (count, n * n) and second derivatives (count, n * n * n) of the first cases."""
        found = [derivatives(self.made, case.values) for case in self.cases[:JACOBIANS]]
        return {
            name: np.array([np.round(part, 9).ravel() + 0.0 for part in parts])
            for name, parts in zip(("jacobians", "seconds"), zip(*found, strict=True), strict=True)
        }

    @cached_property
    def bounds(self) -> np.ndarray:
        """Error allowed of each case, as a length: what rounding and the tolerance leave of the
        rows, times the larger condition.
        """
        size, found = self.made.size, []
        tolerance = self._real.epsilon * size * (1.0 if self._real.name == "float" else 1e4)
        for case in self.cases:
            worst = min(self._condition(case), _LARGEST_CONDITION)
            found.append((4 + worst) * tolerance + self._real.epsilon * size * (32 + 8 * worst))
        return np.array(found)

    @property
    def answers(self) -> dict[str, np.ndarray]:
        """Cases and their answers, by the name of their table."""
        return self.tables | self._derivatives

    @property
    def places(self) -> dict[str, np.ndarray]:
        """Values at the reference."""
        home = self.made.reference
        return {f"home_{which}": self._of(home, which) for which in ("joints", "found")}
