"""Write the C of a platform on six rods: explicit inverse, direct problem by Newton on the pose, no
trigonometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.codegen.map.limb_platform_source import LimbPlatformSource
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.steps.joint_ranges import Range, range_functions
from symkin.codegen.steps.rod_kernel import rod_vectors
from symkin.codegen.text.c import Emitter, block
from symkin.codegen.text.templates import FARTHEST, copy, copy_loop, fill
from symkin.computed_once import cached_property
from symkin.spatial.backend import cross, dot

_LEAST_PART = 2.0**-10
"""Shortest part, of what is left of a line, that is looked at: nearer to a limit than that is not
within it.
"""


@dataclass(frozen=True, eq=False)
class RodSource(LimbPlatformSource):
    """The C of one platform on six rods, function by function."""

    made: RodPlatform

    @property
    def _driver(self) -> dict[str, Any]:
        retarget = "name_direct_retarget(GEOMETRY w, to, aim, done);"
        return {
            "members": ["const name_pose *guess; /* where the line begins */"],
            "matrix": _matrix_lines(self.made),
            "retarget": retarget,
        }

    @property
    def _line(self) -> dict[str, object]:
        leave = [
            *copy("pose->position", "w->x", 3),
            *(f"pose->quaternion[{i}] = w->x[{3 + i}];" for i in range(4)),
        ]
        enter = ["w->guess = guess;", "status = name_normalise_pose(GEOMETRY guess, w->x);"]
        return {"enter": enter, "leave": leave, "unwrap": "", "to": "joints", "whole": ""}

    @property
    def _at_pose(self) -> list[str]:
        words = " and rods longer than zero"
        return [range_functions(self._ranges, self.real, self.values, words)]

    @property
    def _direct(self) -> list[str]:
        code = self.code
        return [
            code.work,
            code.functions,
            fill("rod_values.c", self._common | {"lines": self._rod_value_lines}),
            code.target,
            code.solver,
            fill("retarget.c", self.values),
            code.driver,
            fill("no_step.c", self.values),
            fill("parallel_direct.c", self.values),
        ]

    @cached_property
    def _ranges(self) -> list[Range]:
        return _ranges(self.made)

    @property
    def _target_lines(self) -> list[str]:
        """Statements that set w->k: squared lengths L^2, or (2 L0 + dL) dL."""
        joints = ca.SX.sym("j", 6)
        if self.made.options.home_relative:
            values = [
                (2 * self.made.rods.home_lengths[i] + joints[i]) * joints[i] for i in range(6)
            ]
        else:
            values = [(joints[i] + self.made.rods.offsets[i]) ** 2 for i in range(6)]
        inputs = [(joints, "to")]
        return self._rolled(inputs, values)

    @property
    def _rod_value_lines(self) -> list[str]:
        """Statements of joint values from the rows: with w->k = 0 these are -d.d, or -(2 d0 +
        delta).delta in the home-relative form.
        """
        f, rods = ca.SX.sym("f", 6), self.made.rods
        if rods.home is None:
            joints = [ca.sqrt(-f[i]) - rods.offsets[i] for i in range(6)]
        else:
            # L - L0 = (L^2 - L0^2) / (L + L0): no large numbers cancel
            joints = [
                -f[i] / (ca.sqrt(length**2 - f[i]) + length)
                for i, length in enumerate(rods.home_lengths)
            ]
        return [
            *(f"w->k[{i}] = 0.0;" for i in range(6)),
            "name_direct_rows(GEOMETRY w);",
            *self._rolled([(f, "w->f")], joints),
        ]

    def _rolled(
        self, inputs: Sequence[tuple[ca.SX, Sequence[str]]], values: Sequence[ca.SX]
    ) -> list[str]:
        """Statements that set w->k to a value for each rod: a loop where all six are alike, which
        takes less room.
        """
        whole = [*inputs, (self.made.geometry.symbols, self.made.geometry.names)]

        def lines(i: int, prefix: str) -> list[str]:
            emitter = Emitter.of(self.real, whole, ca.vertcat(*values), prefix=prefix)
            text = emitter.value(0, i)
            return [*emitter.lines, f"w->k[{i}] = {text};"]

        each = [[line.replace(f"[{i}]", "[i]") for line in lines(i, "t")] for i in range(6)]
        if all(found == each[0] for found in each):
            return block("for (int i = 0; i < 6; ++i)", each[0])
        return [line for i in range(6) for line in lines(i, f"t{i}_")]

    @property
    def _inverse(self) -> list[str]:
        """NAME_inverse and NAME_jacobian, and NAME_line where rods have limits."""
        jacobian, stores = self._jacobian
        own = {
            "jacobian": jacobian,
            "store_jacobian": stores,
            "copy_joints": copy("joints", "w.k", 6),
        }
        line = self._limits_along_lines if self.made.has_limits else ""
        return [fill("rod_inverse.c", self.values | own), line]

    @property
    def _limits_along_lines(self) -> str:
        """NAME_line: limits of rods along a straight line of poses, exactly.

        With the unit quaternions q0, q1 of both ends and c = q0 . q1 the turn on the way is that of
        q = q0 + t (q1 - q0), whose squared length n has the Bernstein coefficients 1, c, 1. The
        vector n d of a rod, d = p + R(q) a - b, is a cubic in t: R(q) |q|^2 is quadratic in q and p
        is linear. Its coefficients follow from d at both ends and at the middle pose (the rotation
        of q0 + q1):

            d0,  (2 (1 + c) dm - d1 + (1 - c) v) / 3,  (2 (1 + c) dm - d0 - (1 - c) v) / 3,  d1,
            v = p1 - p0.

        So n^2 (|d|^2 - L^2) is a polynomial of degree 6. It is at least 0 where its Bernstein
        coefficients are; parts decide it else.
        """
        # a rod without limits, whose range is that of its length, is as short as it likes
        lows = (r.low if r.above == Range.above else f"-{r.high}" for r in self._ranges)
        own = {
            "lows": tuple(lows),
            "highs": tuple(r.high for r in self._ranges),
            "third": 1.0 / 3.0,
            "least_part": _LEAST_PART,
        }
        return fill("rod_line.c", self.values | own)

    @property
    def _jacobian(self) -> tuple[list[str], list[str]]:
        """Statements of the Jacobian, and of its copy."""
        if self.made.options.compact and not self.made.options.home_relative:
            return self._looped_jacobian, copy_loop("jacobian", "rows", 36)
        x, size = ca.SX.sym("x", 7), self.made.size
        arms, d, _ = rod_vectors(self.made.rods, x[:3], x[3:])
        squared = [dot(v, v) for v in d]
        inverses = [1 / ca.sqrt(s) for s in squared]
        rows = [
            ca.vertcat(v * inverse, cross(arm, v) * inverse)
            for arm, v, inverse in zip(arms, d, inverses, strict=True)
        ]
        # zero where a rod has no length; in units of the size, so that twelve do not overflow
        shortest = prod((square / size**2 for square in squared[1:]), start=squared[0] / size**2)
        inputs = [(x, "x"), (self.made.geometry.symbols, self.made.geometry.names)]
        emitter = Emitter.of(self.real, inputs, ca.vertcat(*rows), shortest)
        text, texts = emitter.value(1, 0), emitter.values(0)
        stores = [f"jacobian[{k}] = {text};" for k, text in enumerate(texts)]
        return [*emitter.lines, f"const real shortest = {text};"], stores

    @property
    def _looped_jacobian(self) -> list[str]:
        """Statements of the Jacobian's rows in a loop over the rods, whose vectors are those of the
        direct problem's rows: with d = p + R a - b the moment (R a) x d is (b - p) x d.
        """
        table, b = _bases(self.made, 1.0)
        towards = [
            f"const real {axis} = {b[k] + ' - ' if k in b else '-'}x[{k}];"
            for k, axis in enumerate(("forth", "aside", "up"))
        ]
        state = [*copy_loop("w.x", "x", 7), *(f"w.k[{i}] = 0.0;" for i in range(6))]
        shown = {"table": table, "state": state, "towards": towards}
        return fill("rod_jacobian.c", self._common | shown).splitlines()


def _matrix_lines(platform: RodPlatform) -> list[str]:
    """Statements for [d, 4 b x d] in a loop: the fallback's matrix, where time does not matter but
    room does. The table holds 4 b without coordinates that are zero for all bases.
    """
    struct = platform.options.geometry == "struct"
    table, b = _bases(platform, 4.0)
    four = "4.0 * " if struct else ""
    entries = [f"row[{k}] = d[{k}];" for k in range(3)]
    for k, m, n in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        plus = f"{four}{b[m]} * d[{n}]" if m in b else ""
        minus = f"{four}{b[n]} * d[{m}]" if n in b else ""
        text = (
            f"{plus} - {minus}" if plus and minus else plus or (f"-({minus})" if minus else "0.0")
        )
        entries.append(f"row[{3 + k}] = {text};")
    return [
        *table,
        *block(
            "for (int i = 0; i < 6; ++i)",
            ["const real *const d = &w->d[3 * i];", "real *const row = &w->a[6 * i];", *entries],
        ),
    ]


def _bases(platform: RodPlatform, factor: float) -> tuple[list[str], dict[int, str]]:
    """Statement of a table of the bases' points times a factor, without coordinates that are zero
    for all of them, and C text of each coordinate; of a geometry struct no table, and no factor.
    """
    if platform.options.geometry == "struct":
        return [], {k: f"geometry->base[i][{k}]" for k in range(3)}
    size = platform.size
    rows = platform.geometry.rows[:, :3]
    kept = [k for k in range(3) if np.any(rows[:, k] != 0.0)] or [0]
    numbers = ", ".join(
        "{ " + ", ".join(str(factor * snap(float(row[k]), size)) for k in kept) + " }"
        for row in rows
    )
    table = f"static const real base[6][{len(kept)}] = {{ {numbers} }};"
    return [table + (" /* 4 b */" if factor == 4.0 else "")], {
        k: f"base[i][{place}]" for place, k in enumerate(kept)
    }


def _ranges(platform: RodPlatform) -> list[Range]:
    """Ranges: the limbs' own, and lengths that are positive."""
    real, size = platform.real, platform.size
    slack = max(1e-9, 16 * real.epsilon) * size
    zero = platform.zero + np.zeros(6)
    found = []
    for i, bar in enumerate(platform.mechanism.bars):
        limits = platform.mechanism.actuated[i].limits
        low = max(-bar.offset + 1e-6 * size, limits[0] - slack if limits else -np.inf) - zero[i]
        high = str(limits[1] + slack - zero[i] if limits else FARTHEST * size)
        if (
            platform.options.geometry == "struct"
            and not limits
            and not platform.options.home_relative
        ):
            found.append(Range(str(1e-6 * size), high, "joints[{i}] + geometry->offset[{i}]"))
        else:
            found.append(Range(str(low), high))
    return found
