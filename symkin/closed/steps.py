"""What a plan is made of: vectors that known motions carry, and steps that decide one joint each.

F is a joint's motion, or its inverse. The canonical subproblems (Paden 1986, Kahan; Murray, Li,
Sastry 1994, section 3.3; Elias and Wen, IK-Geo, 2022) come down to four steps: a joint that carries
a point to another, one that brings a point to a level, one that brings it to a distance, and slides
that make up a displacement.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.closed.screws import Vector

TOOL = -1
"""Number of the factor M: the tool's motion from the reference, the product of all joints'
motions.
"""


@dataclass(frozen=True)
class Factor:
    """The motion of a joint (its number), or of the tool, or the inverse of it (`sign` -1)."""

    joint: int
    sign: int = 1

    @property
    def inverse(self) -> Factor:
        return Factor(self.joint, -self.sign)


Word = tuple[Factor, ...]
"""A product of motions; the last one acts first."""


def inverse(word: Word) -> Word:
    """The inverse of a product."""
    return tuple(factor.inverse for factor in reversed(word))


@dataclass(frozen=True)
class Operand:
    """A point or a direction at the reference, carried by a product of motions."""

    vector: Vector
    is_point: bool
    word: Word = ()

    def carried(self, word: Word) -> Operand:
        return Operand(self.vector, self.is_point, word + self.word)


@dataclass(frozen=True)
class Step:
    """What all steps have: the joints that they decide, why their equation holds, and the name of
    their choice of two, if any.
    """

    joints: tuple[int, ...]
    reason: str
    branch: str | None


@dataclass(frozen=True)
class Carry(Step):
    """F x = y: one solution (a rotation that takes a point to a point)."""

    sign: int
    x: Operand
    y: Operand


@dataclass(frozen=True)
class Level(Step):
    """normal . W F x = level_normal . y: A cos + B sin = C, two solutions (a circle and a plane);
    one for a slide.
    """

    sign: int
    normal: Operand
    before: Word
    x: Operand
    level_normal: Operand
    y: Operand


@dataclass(frozen=True)
class Distance(Step):
    """|F x - centre| = |y - other|: A cos + B sin = C, two solutions (a circle and a sphere); for a
    slide a quadratic.
    """

    sign: int
    x: Operand
    centre: Operand
    y: Operand
    other: Operand


@dataclass(frozen=True)
class Slides(Step):
    """F_1 ... F_n x = M x of slides at known rotations: a linear system. `chain` are the motions of
    the part that holds them, `target` is what they make together.
    """

    chain: Word
    x: Operand
    target: Word
