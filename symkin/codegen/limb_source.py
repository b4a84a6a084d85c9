"""Write the C of one limb once the pose is given: its Newton iteration and the right-hand sides of
its joint rates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from symkin.codegen.limb_platform import LimbBlock, LimbPlatform
from symkin.codegen.line_parts import line_target
from symkin.codegen.newton_kernel import Kernel, quaternion_place, sampled
from symkin.codegen.newton_source import NewtonCode
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import fill
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSURE_TOLERANCE

_LINES = 5
"""Lines of poses at whose middles a limb is asked whether it closes."""


def limb_text(made: LimbPlatform, block: LimbBlock, common: Mapping[str, object]) -> str:
    """Write the functions that solve one limb for a pose and give its right-hand sides; a rod needs
    none. `common` are the values of names that templates of limbs need.
    """
    if block.kernel is None:
        return ""
    code = _newton_code(made, block, block.kernel)
    reference = made.closure.reference
    parts = (("w->x", block.system.unknowns), ("w->at", made.inverse.known_coordinates))
    begin = [
        f"{array}[{i}] = {made.real.literal(float(v))};"
        for array, coordinates in parts
        for i, v in enumerate(made.inverse.select_values(reference, coordinates))
    ]
    follow = fill("limb.c", {**common, "k": code.k, "begin": indent(begin)})
    return code.text + follow + _twist_columns(made, block, block.kernel, code.k, common)


def rates_text(made: LimbPlatform, block: LimbBlock, common: Mapping[str, object]) -> str:
    """Write the functions that solve a limb's matrix for its joint rates; nothing for a limb whose
    formulas give these.
    """
    if block.kernel is None:
        return ""
    code = _newton_code(made, block, block.kernel)
    return code.work + code.linear.text + _twist_columns(made, block, block.kernel, code.k, common)


def _twist_columns(
    made: LimbPlatform, block: LimbBlock, kernel: Kernel, k: str, common: Mapping[str, object]
) -> str:
    sides = indent(_side_lines(block, kernel, made.geometry.names, made.real))
    return fill(
        "twist_columns.c",
        {**common, "k": k, "sides": sides, "count": kernel.m * int(block.sides.shape[1])},
    )


def _newton_code(made: LimbPlatform, block: LimbBlock, kernel: Kernel) -> NewtonCode:
    """The Newton iteration of a limb, tuned at the sampled configurations."""
    states = [made.inverse.select_values(s.values, block.system.unknowns) for s in made.samples]
    poses = [
        made.inverse.select_values(s.values, made.inverse.known_coordinates) for s in made.samples
    ]
    matrices, kappa = sampled(kernel, states, poses, made.geometry.values)
    return NewtonCode(
        kernel=kernel,
        name=made.name,
        real=made.real,
        geometry=made.geometry.names,
        matrices=matrices,
        kappa=kappa,
        target_lines=line_target(made.real, int(kernel.known.shape[0]), kernel.quaternion),
        on_the_way=kernel.is_square or _closes_on_the_way(made, block, states, poses),
        compact=made.options.compact,
    )


def _closes_on_the_way(
    made: LimbPlatform, block: LimbBlock, states: Sequence[np.ndarray], poses: Sequence[np.ndarray]
) -> bool:
    """Whether a limb of more rows than unknowns takes the poses on the line from the reference:
    others close at its end alone.
    """
    reference = made.inverse.select_values(made.closure.reference, made.inverse.known_coordinates)
    bound, size, over_p = made.closure.bound, made.closure.characteristic_length, block.system
    system = System(
        over_p.unknowns,
        over_p.unknown,
        over_p.known,
        bound(over_p.rows),
        bound(over_p.errors),
        size,
    )
    turned = quaternion_place(made.inverse.known_coordinates)
    for state, pose in zip(states[:_LINES], poses[:_LINES], strict=True):
        middle = 0.5 * (reference + pose)
        if turned is not None:
            middle[turned : turned + 4] /= np.linalg.norm(middle[turned : turned + 4])
        if system.residual(system.polish(state, middle, 20), middle) > CLOSURE_TOLERANCE * size:
            return False
    return True


def _side_lines(block: LimbBlock, kernel: Kernel, geometry: list[str], real: Real) -> list[str]:
    """Statements of the right-hand sides of the joint rates, row by row."""
    inputs = [
        (kernel.state, indexed("w->x", int(kernel.state.shape[0]))),
        (kernel.known, indexed("w->k", int(kernel.known.shape[0]))),
        (kernel.geometry, geometry),
    ]
    count = kernel.m * int(block.sides.shape[1])
    lines = Emitter.of(real, inputs, ca.vec(block.sides.T)).stored(indexed("sides", count))
    unread = not any("w->" in line for line in lines)
    return [*lines[:-count], *(["(void)w;"] if unread else []), *lines[-count:]]
