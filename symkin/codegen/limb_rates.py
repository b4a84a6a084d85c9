"""Write the statements of the Jacobian's rows limb by limb: by a limb's matrix, by its formulas, or
by a rod's direction.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.codegen.formula_guards import feasible_error
from symkin.codegen.limb_platform import LimbBlock, LimbPlatform
from symkin.codegen.linear_solver import singular_condition
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.pose_coordinates import COLUMNS
from symkin.codegen.text.c import Emitter, Real, indexed
from symkin.codegen.text.templates import copy
from symkin.model.names import identifiers
from symkin.numeric.system import System
from symkin.text import c_comment


@dataclass(frozen=True, eq=False)
class LimbRates:
    """Rows of one platform's Jacobian; `ga` is the geometry as an argument of a call."""

    made: LimbPlatform
    ga: str

    @property
    def real(self) -> Real:
        return self.made.real

    @property
    def name(self) -> str:
        return self.made.name

    @property
    def _ok(self) -> str:
        return f"{self.name.upper()}_OK"

    def places(self, block: LimbBlock) -> list[tuple[str, int, int]]:
        """(array, index there, index in the block) of each number of the block's unknowns."""
        found = []
        for c, place in zip(block.system.unknowns, block.system.slices, strict=True):
            group = self.made.actuated if c.role == "actuated" else self.made.passive
            before = sum(other.width for other in group[: group.index(c)])
            array = "q" if c.role == "actuated" else "passive"
            found += [(array, before + i, place.start + i) for i in range(c.width)]
        return found

    def prefix(self, block: LimbBlock) -> str:
        """What temporaries of a rod limb begin with: its name as an identifier, different from
        those of the other rods.
        """
        rods = [other for other in self.made.blocks if other.rod is not None]
        return (
            identifiers([other.system.unknowns[0].name for other in rods])[rods.index(block)] + "_"
        )

    def lines(self, block: LimbBlock) -> list[str]:
        """Statements of the Jacobian's rows of one limb."""
        comment = f"/* {c_comment(', '.join(c.name for c in block.system.unknowns))} */"
        if block.rod is not None:
            return [comment, *self._rod_rate_lines(block)]
        if block.kernel is None:
            return [comment, *self._closed_rate_lines(block)]
        made, real, k, m = self.made, self.real, f"{self.name}_{block.kernel.name}", block.kernel.m
        columns, solved = COLUMNS[made.mechanism.motion], _actuated_columns(block.system)
        actuated = [
            (there, *solved[here]) for array, there, here in self.places(block) if array == "q"
        ]
        solve = [f"status = {k}_follow_pose({self.ga}&w, c);"]
        if block.formulas is not None:
            error = feasible_error(real.epsilon, made.closure.characteristic_length)
            within = f", {real.literal(rounded(error))}" if block.is_checked else ""
            solve = [
                f"status = {k}_joints(c, w.x{within});",
                *copy("w.k", "c", int(block.system.known.shape[0])),
            ]
        body = [
            f"{k}_work w;",
            f"{real.type} sides[{m * len(columns)}];",
            *solve,
            f"if (status == {self._ok}) {{",
            f"    {k}_twist_columns({self.ga}&w, sides);",
            f"    if "
            f"({singular_condition(block.kernel, k, '&w', self.ga, compact=made.options.compact)}) "
            f"{{",
            f"        status = {self.name.upper()}_SINGULAR;",
            "    } else {",
        ]
        for j, column in enumerate(columns):
            plus = f" + {j}" if j else ""
            body += [
                f"        for (int i = 0; i < {m}; ++i) {{",
                f"            w.f[i] = sides[{len(columns)} * i{plus}];",
                "        }",
                f"        {k}_solve(&w);",
            ]
            for there, index, angular in actuated:
                # steps of angles are lengths, angle times the size
                scale = (
                    f" * {real.literal(1 / made.closure.characteristic_length)}"
                    if angular and made.closure.characteristic_length != 1.0
                    else ""
                )
                body.append(f"        jacobian[{6 * there + column}] = w.f[{index}]{scale};")
        return [
            comment,
            f"if (status == {self._ok}) {{",
            *("    " + line for line in [*body, "    }", "}"]),
            "}",
        ]

    def _closed_rate_lines(self, block: LimbBlock) -> list[str]:
        """Statements that copy the rates of a limb in closed form."""
        columns, k = COLUMNS[self.made.mechanism.motion], f"{self.name}_{block.name}"
        actuated = [there for array, there, _ in self.places(block) if array == "q"]
        if not actuated:
            return []
        copies = [
            f"    jacobian[{6 * there + column}] = of_limb[{i * len(columns) + j}];"
            for i, there in enumerate(actuated)
            for j, column in enumerate(columns)
        ]
        return [
            f"if (status == {self._ok}) {{",
            f"    {self.real.type} of_limb[{len(actuated) * len(columns)}];",
            f"    status = {k}_rates(c, of_limb);",
            *copies,
            "}",
        ]

    def _rod_rate_lines(self, block: LimbBlock) -> list[str]:
        """Statements of the Jacobian's row of a rod, the derivative of its coordinate by the
        twist.
        """
        made, system = self.made, block.system
        columns, there = COLUMNS[made.mechanism.motion], self.places(block)[0][1]
        inputs = [
            (system.unknown, ["0"]),
            (system.known, indexed("c", int(system.known.shape[0]))),
            (made.geometry.symbols, made.geometry.names),
        ]
        emitter = Emitter.of(self.real, inputs, block.sides, prefix=self.prefix(block))
        lines = emitter.stored([f"jacobian[{6 * there + c}]" for c in columns])
        if not emitter.divisions:
            return lines
        # where the rod has no length there is no direction
        first, length = emitter.divisions[0]
        return [
            *lines[:first],
            f"if ({length} > {self.real.literal(0.0)}) {{",
            *("    " + line for line in lines[first:]),
            "} else {",
            f"    status = {self.name.upper()}_SINGULAR;",
            "}",
        ]


def _actuated_columns(system: System) -> dict[int, tuple[int, bool]]:
    """For each single-number unknown of a block: its column in the tangent space, and whether it is
    an angle.
    """
    found, column = {}, 0
    for c, place in zip(system.unknowns, system.slices, strict=True):
        if c.width == 1:
            found[place.start] = (column, c.is_angular)
        column += c.freedom
    return found
