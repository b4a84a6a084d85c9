"""C of parallel mechanisms of any limbs: pose and passive joints by Newton on the closure's rows, limbs one by one.

Once the pose is given the limbs decouple: each is solved from the reference configuration along the line of poses to the
given one, so that it stays on the reference's branch. Rods are explicit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.closure.closure import Closure
from symkin.closure.snapping import snapped_expression
from symkin.codegen.emit import Real, indexed
from symkin.codegen.geometry import Geometry
from symkin.codegen.kernel import Kernel, system_kernel
from symkin.codegen.options import Options
from symkin.codegen.samples import Configuration, configurations
from symkin.errors import InputError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.system import System, constant_rows, split_blocks
from symkin.position.mobility import mobility
from symkin.position.problem import Problem, build_problem


@dataclass(frozen=True, eq=False)
class Block:
    """A limb once the pose is given: `rod` is the explicit value of its only coordinate, else `kernel` solves it.
    `sides` are -dF/d(twist) (rows x freedom of the pose), or d(rod)/d(twist)."""

    system: System
    kernel: Kernel | None
    rod: ca.SX | None
    sides: ca.SX


@dataclass(frozen=True, eq=False)
class ClosedMechanism:
    """A parallel mechanism with its options: what the emitters read."""

    mechanism: Mechanism
    options: Options
    real: Real

    @property
    def name(self) -> str:
        return self.mechanism.name

    @cached_property
    def direct(self) -> Problem:
        return build_problem(self.mechanism, "direct")

    @cached_property
    def inverse(self) -> Problem:
        return build_problem(self.mechanism, "inverse")

    @property
    def closure(self) -> Closure:
        return self.direct.closure

    @cached_property
    def geometry(self) -> Geometry:
        return Geometry(self.closure, self.options.geometry == "struct")

    @cached_property
    def actuated(self) -> tuple[Coordinate, ...]:
        return self.closure.role("actuated")

    @cached_property
    def passive(self) -> tuple[Coordinate, ...]:
        return self.closure.role("passive")

    @cached_property
    def samples(self) -> list[Configuration]:
        return configurations(self.direct, self.closure.reference, 40, 3)

    @cached_property
    def direct_kernel(self) -> Kernel:
        system = self.geometry.system(self.direct)
        return system_kernel("direct", system, system.known, [c.is_angular for c in self.actuated], None, self.geometry.symbols)

    @property
    def limited_angles(self) -> tuple[bool, ...]:
        """Which actuated joints are angles with limits: where they stand in whole turns is told by these."""
        return tuple(c.kind == "angle" and c.limits is not None for c in self.actuated)

    @property
    def has_dead_centres(self) -> bool:
        """Whether a limb is more than a rod, whose length the pose decides."""
        return any(block.kernel is not None for block in self.blocks)

    @cached_property
    def conditions(self) -> System:
        """Rows that no joint enters: the pose alone must satisfy them."""
        return constant_rows(self.geometry.system(self.inverse))

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        pose, symbols = self.closure.role("pose"), self.geometry.symbols
        made = []
        for number, system in enumerate(split_blocks(self.geometry.system(self.inverse)), start=1):
            size, rod, kernel = self.closure.size, None, None
            if len(system.unknowns) == 1 and system.unknowns[0].least is not None and int(system.errors.shape[0]) == 1:
                rod = snapped_expression(ca.substitute(system.errors, system.unknown, 0), [system.known, symbols])
            else:
                kernel = system_kernel(
                    f"limb{number}", system, system.known, [c.is_angular for c in pose], _quaternion_place(pose), symbols
                )
            of_pose = System(pose, system.known, system.unknown, system.rows if rod is None else rod, system.errors, size)
            scale = ca.diag(ca.SX([size if angular else 1.0 for angular in _angular(pose)]))
            sides = ca.mtimes(of_pose.jacobian, scale)
            sides = snapped_expression(sides if rod is not None else -sides, [system.unknown, system.known, symbols])
            made.append(Block(system, kernel, rod, sides))
        return tuple(made)

    def check(self) -> None:
        """Raises InputError where a generated solver could not work."""
        if not self.actuated:
            raise InputError(f"{self.name} has no actuated joint; nothing to generate")
        found = mobility(self.mechanism)
        if found.closed and found.direct_rank.value < found.rank.value:
            more = found.rank.value - found.direct_rank.value
            raise InputError(
                f"{self.name}: {found.actuated} actuated joints move {found.mobility} freedoms, so that their values must agree "
                "with each other; between two sets of values that do, they do not, and generated code follows the straight line "
                f"between them. Leave {more} of the limbs out of the file, or let {more} of the joints be passive: the pose is the same"
            )
        if not self.samples:
            raise InputError(f"{self.name}: no closed configurations were found near the reference; nothing to generate")
        for sample in self.samples[:5]:
            matrix = self.direct_kernel.matrix(sample.unknown, sample.known, self.geometry.values)
            singular = np.linalg.svd(matrix, compute_uv=False)
            if matrix.shape[0] < matrix.shape[1] or singular[-1] < 1e-9 * singular[0]:
                raise InputError(
                    f"{self.name}: locking the actuated joints does not fix the platform near the reference "
                    "(`symkin show` prints mobility and rank); nothing to generate"
                )
        for block in self.blocks:
            self._check_block(block)

    def _check_block(self, block: Block) -> None:
        """Raises InputError where a pose leaves joints of a limb free."""
        if block.kernel is None:
            return
        known = self.inverse.known_coordinates
        for sample in self.samples[:5]:
            state, pose = (self.inverse.select_values(sample.values, c) for c in (block.system.unknowns, known))
            matrix = block.kernel.matrix(state, pose, self.geometry.values)
            if Rank.of(matrix).value < matrix.shape[1]:
                names = ", ".join(c.name for c in block.system.unknowns)
                raise InputError(
                    f"{self.name}: the platform's pose does not fix joints of one limb ({names}), so that there is no inverse; "
                    "nothing to generate"
                )


def _angular(pose: Sequence[Coordinate]) -> list[bool]:
    flags: list[bool] = []
    for c in pose:
        flags += [c.kind != "length"] * c.freedom
    return flags


def _quaternion_place(pose: Sequence[Coordinate]) -> int | None:
    start = 0
    for c in pose:
        if c.kind == "quaternion":
            return start
        start += c.width
    return None


def line_target(real: Real, count: int, quaternion: int | None) -> list[str]:
    """Statements: w->k on the line from w->at to `to`; unit quaternions along the shorter arc, with the
    sign of the guess's."""
    loop = f"for (int i = 0; i < {count}; ++i) {{"
    lines = [loop, "    w->k[i] = to[i];", "}"]
    at, to, k = (indexed(name, 4, quaternion or 0) for name in ("w->at", "to", "w->k"))
    if quaternion is not None:
        lines.append(f"if ({' + '.join(f'{a} * {b}' for a, b in zip(at, to, strict=True))} < {real.literal(0.0)}) {{")
        lines += [*(f"    {v} = -{v};" for v in k), "}"]
    lines += [
        f"if (part < {real.literal(1.0)}) {{",
        f"    {loop}",
        "        w->k[i] = w->at[i] + part * (w->k[i] - w->at[i]);",
        "    }",
    ]
    if quaternion is not None:
        square = " + ".join(f"{v} * {v}" for v in k)
        lines.append(f"    const {real.type} inverse = {real.literal(1.0)} / {real.call('sqrt')}({square});")
        lines += [f"    {v} *= inverse;" for v in k]
    return [*lines, "}"]


def ranges(coordinates: Sequence[Coordinate], real: Real, size: float) -> str:
    """C condition: each joint value within its limits, rods not shorter than zero; at least finite."""
    parts = []
    for i, c in enumerate(coordinates):
        slack = max(1e-9, 16 * real.epsilon) * (1.0 if c.is_angular else size)
        low, high = c.limits or ((-1e3, 1e3) if c.is_angular else (-1e3 * size, 1e3 * size))
        if c.least is not None:
            low = max(low, c.least + 1e-6 * size)
        parts.append(f"(joints[{i}] >= {real.literal(low - slack)}) && (joints[{i}] <= {real.literal(high + slack)})")
    return "\n        && ".join(parts)
