"""Steps that solve F_1 ... F_n x = y for up to three joints, x and y known points or directions."""

from __future__ import annotations

from collections.abc import Iterator

from symkin.closed.geometry import AxisGeometry, Invariant
from symkin.closed.steps import Carry, Distance, Factor, Level, Operand, Step, Word

Steps = tuple[Step, ...]


def carried(axes: AxisGeometry, factor: Factor, x: Operand, y: Operand, what: str) -> Carry:
    """The step that decides F from F x = y."""
    name, ways = (
        axes.arm.screws[factor.joint].name,
        "slides" if axes.arm.screws[factor.joint].slides else "turns",
    )
    return Carry(
        (factor.joint,), f"{name} {ways} {what} to where it must be", None, factor.sign, x, y
    )


def balanced(
    axes: AxisGeometry,
    same: Invariant,
    factor: Factor,
    x: Operand,
    y: Operand,
    what: str,
    branch: str,
) -> Step:
    """The step that decides F from an invariant of F x, which is that of y."""
    screw = axes.arm.screws[factor.joint]
    reason = f"{what}: its {same.text} tells {screw.name}"
    if same.is_level:
        normal = Operand(same.vector, False)
        chosen = None if screw.slides else branch
        return Level((factor.joint,), reason, chosen, factor.sign, normal, (), x, normal, y)
    centre = Operand(same.vector, True)
    return Distance((factor.joint,), reason, branch, factor.sign, x, centre, y, centre)


def point_steps(
    axes: AxisGeometry, factors: Word, x: Operand, y: Operand, what: str, branch: str
) -> Iterator[Steps]:
    """All sequences of steps for F_1 ... F_n x = y, best first."""
    if len(factors) == 1:
        yield (carried(axes, factors[0], x, y, what),)
    elif len(factors) == 2:
        yield from _two(axes, factors, x, y, what, branch)
    elif len(factors) == 3:
        yield from _three(axes, factors, x, y, what, branch)


def _two(
    axes: AxisGeometry, factors: Word, x: Operand, y: Operand, what: str, branch: str
) -> Iterator[Steps]:
    first, last = factors
    ahead, back = x.carried((last,)), y.carried((first.inverse,))
    found: list[Steps] = [
        (balanced(axes, same, last, x, y, what, branch), carried(axes, first, ahead, y, what))
        for same in _of(axes, first, x)
    ]
    others: list[Steps] = [
        (
            balanced(axes, same, first.inverse, y, x, what, branch),
            carried(axes, last, x, back, what),
        )
        for same in _of(axes, last, x)
    ]
    # what does not depend on the pose turns in a fixed circle: fewer operations, and the branch is
    # the sign of one angle
    yield from found + others if len(x.word) <= len(y.word) else others + found


def _of(axes: AxisGeometry, factor: Factor, x: Operand) -> list[Invariant]:
    """Invariants of a joint, of points (the distance first: it is the one that parallel axes leave)
    or of directions.
    """
    found = axes.invariants(factor.joint)
    return found[::-1] if x.is_point else [same for same in found if same.is_level]


def _three(
    axes: AxisGeometry, factors: Word, x: Operand, y: Operand, what: str, branch: str
) -> Iterator[Steps]:
    first, middle, last = factors
    behind = axes.common_invariant(middle.joint, last.joint)
    if behind is not None:
        step = balanced(axes, behind, first.inverse, y, x, what, branch)
        for rest in _two(axes, (middle, last), x, y.carried((first.inverse,)), what, branch):
            yield (step, *rest)
    before = axes.common_invariant(first.joint, middle.joint)
    if before is not None:
        step = balanced(axes, before, last, x, y, what, branch)
        for rest in _two(axes, (first, middle), x.carried((last,)), y, what, branch):
            yield (step, *rest)
