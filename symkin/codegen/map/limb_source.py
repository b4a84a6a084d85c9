"""Write the C of one limb once the pose is given: its joints by formulas, by Newton's iteration or
as a rod's length, and the Jacobian's rows of them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.codegen.closed_limb import LimbFormulas, actuated_places
from symkin.codegen.line_parts import line_target
from symkin.codegen.map.limb_platform import LimbBlock, LimbPlatform
from symkin.codegen.map.rates import SolvedColumns, step_columns, step_text
from symkin.codegen.map.record import Source
from symkin.codegen.steps.formula_guards import feasible_error
from symkin.codegen.steps.linear_solver import singular_condition
from symkin.codegen.steps.newton_kernel import Kernel, quaternion_place, rounded, sampled
from symkin.codegen.steps.newton_source import NewtonCode
from symkin.codegen.steps.pose_coordinates import COLUMNS
from symkin.codegen.text.c import Emitter, block, if_ok, indexed
from symkin.codegen.text.templates import copy, fill
from symkin.computed_once import cached_property
from symkin.model.joint import places_of
from symkin.model.names import identifiers
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.text import c_comment

_LINES = 5
"""Lines of poses at whose middles a limb is asked whether it closes."""


@dataclass(frozen=True, eq=False)
class LimbSource(Source):
    """The C of one limb; `common` are the values of names that templates of limbs need."""

    made: LimbPlatform
    block: LimbBlock
    common: Mapping[str, object]

    @property
    def k(self) -> str:
        """What the names of its functions begin with."""
        return f"{self.name}_{self.block.name}"

    @property
    def _pose(self) -> list[str]:
        return indexed("c", self.block.system.known.numel())

    @property
    def _comment(self) -> str:
        return f"/* {c_comment(', '.join(c.name for c in self.block.system.unknowns))} */"

    @cached_property
    def places(self) -> list[tuple[str, int, int]]:
        """(array, index there, index in the block) of each number of the limb's unknowns."""
        arrays = {"q": self.made.actuated, "passive": self.made.passive}
        there = {
            name: (array, place)
            for array, own in arrays.items()
            for name, place in places_of(own, [c.width for c in own]).items()
        }
        return [
            (there[name][0], k, here.start + i)
            for name, here in self.block.system.places.items()
            for i, k in enumerate(there[name][1])
        ]

    @property
    def _actuated(self) -> list[int]:
        """Numbers of its actuated joints among those of the platform."""
        return [there for array, there, _ in self.places if array == "q"]

    @property
    def _columns(self) -> tuple[int, ...]:
        """Columns of the twist that the platform's motion has."""
        return COLUMNS[self.made.mechanism.motion]

    # --- functions --------------------------------------------------------------------------------

    @property
    def text(self) -> str:
        """The functions that give its joints for a pose, and their rates; a rod needs none."""
        text, kernel = "", self.block.kernel
        if self.block.formulas is not None:
            text = self._closed_text(LimbFormulas(self.made, self.block, self.block.formulas))
        if kernel is None:
            return text
        code = self._newton_code(kernel)
        if self.block.formulas is not None:
            # the matrix gives the rates alone
            return text + code.work + code.linear.text + self._twist_columns_text(kernel)
        reference = self.made.closure.reference
        parts = (
            ("w->x", self.block.system.unknowns),
            ("w->at", self.made.inverse.known_coordinates),
        )
        begin = [
            f"{array}[{i}] = {v};"
            for array, coordinates in parts
            for i, v in enumerate(self.made.inverse.select_values(reference, coordinates))
        ]
        follow = fill("limb.c", {**self.common, "k": self.k, "begin": begin})
        return code.text + follow + self._twist_columns_text(kernel)

    def _closed_text(self, written: LimbFormulas) -> str:
        """The functions that give its joints by formulas, and their rates where no matrix does."""
        block = self.block
        count = len(actuated_places(block)) * block.sides.shape[1]
        within = ", real within" if block.is_checked else ""
        values = {
            **self.common,
            "k": self.k,
            "count": block.system.width,
            "rates": count,
            "joints_lines": written.joints,
            "within": within,
            "within_words": "; its rows may be off by `within`" if within else "",
        }
        text = fill("closed_limb.c", values)
        if not count or block.kernel is not None:
            return text
        rates = written.rates
        if not any(re.search(r"\bc\[", line) for line in rates):
            # of slides in a direction that no pose turns
            rates = ["(void)c;", *rates]
        return text + fill("closed_rates.c", values | {"rates_lines": rates})

    def _twist_columns(self, kernel: Kernel) -> SolvedColumns:
        """The joint rates by each freedom of the platform's twist."""
        columns = f"{self.k}_twist_columns"
        return SolvedColumns(kernel, self.k, columns, len(self._columns), self.common)

    def _twist_columns_text(self, kernel: Kernel) -> str:
        """The function of the right-hand sides of the joint rates."""
        inputs = [
            (kernel.state, "w->x"),
            (kernel.known, "w->k"),
            (kernel.geometry, self.made.geometry.names),
        ]
        about = (
            "Minus the derivative of the limb's rows by the platform's twist, row by row: the "
            "right-hand sides of the joint rates."
        )
        emitter = Emitter.of(self.real, inputs, self.block.sides)
        return self._twist_columns(kernel).text(about, emitter)

    def _newton_code(self, kernel: Kernel) -> NewtonCode:
        """Its Newton iteration, tuned at the sampled configurations."""
        made, select = self.made, self.made.inverse.select_values
        states = [select(s.values, self.block.system.unknowns) for s in made.samples]
        poses = list(made.sampled_poses)
        matrices, kappa = sampled(kernel, states, poses, made.geometry.values)
        return NewtonCode(
            kernel=kernel,
            name=made.name,
            real=self.real,
            geometry=made.geometry.names,
            matrices=matrices,
            kappa=kappa,
            target_lines=line_target(kernel.known.numel(), kernel.quaternion),
            measured=True,
            on_the_way=kernel.is_square or self._closes_on_the_way(states, poses),
            compact=made.options.compact,
        )

    def _closes_on_the_way(self, states: Sequence[np.ndarray], poses: Sequence[np.ndarray]) -> bool:
        """Whether a limb of more rows than unknowns takes the poses on the line from the reference:
        others close at its end alone.
        """
        inverse, closure = self.made.inverse, self.made.closure
        reference = inverse.select_values(closure.reference, inverse.known_coordinates)
        system = self.block.system
        bound = replace(
            system, rows=closure.bound(system.rows), errors=closure.bound(system.errors)
        )
        turned = quaternion_place(inverse.known_coordinates)
        for state, pose in zip(states[:_LINES], poses[:_LINES], strict=True):
            middle = 0.5 * (reference + pose)
            if turned is not None:
                middle[turned : turned + 4] /= np.linalg.norm(middle[turned : turned + 4])
            gap = bound.residual(bound.polish(state, middle, 20), middle)
            if gap > CLOSURE_TOLERANCE * closure.characteristic_length:
                return False
        return True

    # --- joints and rates at a pose ---------------------------------------------------------------

    def _solve(self, array: str, within: str) -> list[str]:
        """Statements that set an array to its unknowns, a rod's apart."""
        if self.block.formulas is None:
            return [f"status = {self.k}_follow_pose(GEOMETRY &w, c);"]
        return [f"status = {self.k}_joints(c, {array}{within if self.block.is_checked else ''});"]

    @property
    def joint_lines(self) -> list[str]:
        """Statements of its joints at a pose."""
        if self.block.rod is not None:
            emitter = self._rod_emitter(self.block.rod)
            array, there, _ = self.places[0]
            return [self._comment, *emitter.stored([f"{array}[{there}]"])]
        by_formulas = self.block.formulas is not None
        begin = f"real x[{self.block.system.width}];" if by_formulas else (f"{self.k}_work w;")
        x = "x" if by_formulas else "w.x"
        copies = [f"{array}[{there}] = {x}[{here}];" for array, there, here in self.places]
        return [self._comment, *if_ok([begin, *self._solve("x", ", within"), *copies])]

    @property
    def rate_lines(self) -> list[str]:
        """Statements of the Jacobian's rows of its joints: by a rod's direction, by formulas, or by
        its matrix.
        """
        if self.block.rod is not None:
            return [self._comment, *self._rod_rate_lines]
        if self.block.kernel is None:
            return [self._comment, *self._closed_rate_lines]
        return [self._comment, *if_ok(self._matrix_rate_lines(self.block.kernel))]

    def _matrix_rate_lines(self, kernel: Kernel) -> list[str]:
        made, k, system, size = self.made, self.k, self.block.system, self.made.size
        wanted = [c for c in system.unknowns if c.role == "actuated"]
        steps = step_columns(system.unknowns, wanted, size)
        error = rounded(feasible_error(self.real.epsilon, size))
        known = system.known.numel() if self.block.formulas is not None else 0
        singular = singular_condition(kernel, k, "&w", compact=made.options.compact)
        columns, solved = self._columns, self._twist_columns(kernel)
        table, column = list[str](), "j"
        if wanted and columns != tuple(range(len(columns))):
            numbers, column = ", ".join(f"{c}U" for c in columns), "(int)column[j]"
            table = [f"static const uint8_t column[{len(columns)}] = {{ {numbers} }};"]
        stores = [
            f"jacobian[{6 * there} + {column}] = {step_text(*place)};"
            for there, place in zip(self._actuated, steps, strict=True)
        ]
        return [
            *table,
            f"{k}_work w;",
            f"real sides[{solved.size}];",
            *self._solve("w.x", f", {error}"),
            *copy("w.k", "c", known),
            *if_ok(block(f"if ({singular})", ["status = NAME_SINGULAR;"], solved.solved(stores))),
        ]

    @property
    def _closed_rate_lines(self) -> list[str]:
        columns, actuated = self._columns, self._actuated
        if not actuated:
            return []
        copies = [
            f"jacobian[{6 * there + column}] = of_limb[{i * len(columns) + j}];"
            for i, there in enumerate(actuated)
            for j, column in enumerate(columns)
        ]
        begin = f"real of_limb[{len(actuated) * len(columns)}];"
        return if_ok([begin, f"status = {self.k}_rates(c, of_limb);", *copies])

    def _rod_emitter(self, expression: ca.SX) -> Emitter:
        """Emitter of a function of the pose, temporaries beginning with the rod's name as an
        identifier, different from those of the other rods.
        """
        system, geometry = self.block.system, self.made.geometry
        rods = [other for other in self.made.blocks if other.rod is not None]
        names = identifiers([other.system.unknowns[0].name for other in rods])
        inputs = [
            (system.unknown, ["0"]),
            (system.known, self._pose),
            (geometry.symbols, geometry.names),
        ]
        prefix = names[rods.index(self.block)] + "_"
        return Emitter.of(self.real, inputs, expression, prefix=prefix)

    @property
    def _rod_rate_lines(self) -> list[str]:
        """The derivative of a rod's coordinate by the twist."""
        there = self.places[0][1]
        emitter = self._rod_emitter(self.block.sides)
        lines = emitter.stored([f"jacobian[{6 * there + c}]" for c in self._columns])
        if not emitter.divisions:
            return lines
        # where the rod has no length there is no direction
        first, length = emitter.divisions[0]
        return [
            *lines[:first],
            *block(f"if ({length} > 0.0)", lines[first:], ["status = NAME_SINGULAR;"]),
        ]
