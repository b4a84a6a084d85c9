"""Give generated code its geometry: numbers folded into it, or the members of a struct given at run
time.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.codegen.text.c import Real, block
from symkin.codegen.text.templates import FARTHEST, fill
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.machine.frame import Frames
from symkin.model.names import identifiers
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.spatial.rotation import conjugate, multiply

_ROUNDING = 1e-15
"""Of numbers of a rotation."""
_LARGEST = 100.0
"""Sizes of the machine, beyond which a float's rounding of a length is above a hundred times the
rounding of the machine's own.
"""
_WIDTH = {"axis.x": 3, "axis2.x": 3, "quaternion.w": 4}
"""Numbers of directions and quaternions, by the end of the first one's key path."""
_ANGLES = {"theta", "alpha", "zero"}
"""Ends of the key paths of numbers that may be angles."""
_SHORTEST = 1e-6
"""Least length of a direction: a float holds its square."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """The parameters p of a closure: none of them symbols where `at_run_time` is false. Poses are
    told in the `frames` of a description (None: in those of the closure).
    """

    closure: Closure
    at_run_time: bool
    frames: Frames | None = None

    @property
    def symbols(self) -> ca.SX:
        return self.closure.parameters if self.at_run_time else ca.SX(0, 1)

    @property
    def values(self) -> np.ndarray:
        """Nominal numbers in the order of the symbols."""
        return self.closure.parameter_values if self.at_run_time else np.zeros(0)

    @cached_property
    def rotation(self) -> np.ndarray | None:
        """The matrix that turns vectors as they are told into those of the closure, whose numbers
        are 0 and 1 where they are so to rounding.
        """
        return None if self.frames is None else exact_turn(self.frames.base.rotation)

    @cached_property
    def _turn(self) -> np.ndarray:
        """The matrix that turns quaternions of the closure into those as they are told."""
        assert self.frames is not None  # noqa: S101 - the caller has looked
        base, own = self.frames.base.quaternion, self.frames.platform.quaternion
        return exact_turn(
            np.array([multiply(multiply(conjugate(base), unit), own) for unit in np.eye(4)]).T
        )

    @cached_property
    def pose(self) -> ca.SX:
        """Position and quaternion of the platform as they are told, over the pose coordinates."""
        pose, rotation = self.closure.pose, self.rotation
        position, quaternion = pose.position, pose.quaternion
        if rotation is not None:
            position = ca.mtimes(ca.DM(rotation.T), position)
            quaternion = ca.mtimes(ca.DM(self._turn), quaternion)
        return self.of(ca.vertcat(position, quaternion))

    def taken(self, x: ca.SX) -> ca.SX:
        """The seven numbers of a pose as it is told as the closure has them."""
        if self.rotation is None:
            return x
        turned = (ca.mtimes(ca.DM(self.rotation), x[:3]), ca.mtimes(ca.DM(self._turn.T), x[3:]))
        return ca.vertcat(*turned)

    @cached_property
    def members(self) -> list[str]:
        """Members of the struct: key paths with C's letters, `leg1.base.x` as `leg1_base_x`."""
        return identifiers(self.closure.parameter_names) if self.at_run_time else []

    @property
    def largest(self) -> float:
        """Largest number that the struct may hold, so that products do not overflow: the largest
        nominal one, a turn where some are no lengths, and 1,000 sizes of the machine.
        """
        nominal = float(np.max(np.abs(self.values), initial=0.0))
        ends = {name.split(".")[-1] for name in self.closure.parameter_names}
        turn = 2 * np.pi if self.directions or ends & _ANGLES else 0.0
        size = self.closure.characteristic_length
        return float(f"{FARTHEST * size + max(nominal, turn):.3g}")

    @property
    def directions(self) -> list[tuple[int, str]]:
        """Where numbers begin that code divides by their length, and the end of their key path."""
        ends = enumerate(".".join(n.split(".")[-2:]) for n in self.closure.parameter_names)
        return [(k, end) for k, end in ends if end in _WIDTH] if self.at_run_time else []

    @property
    def names(self) -> list[str]:
        """C text of each symbol."""
        return [f"geometry->{member}" for member in self.members]

    def of(self, expression: ca.SX) -> ca.SX:
        """An expression of the closure with numbers in place of p, unless p comes at run time."""
        return expression if self.at_run_time else self.closure.bound(expression)

    def system(self, problem: Problem) -> System:
        """The problem's system over p."""
        bound, closure = problem.system, self.closure
        return System(
            bound.unknowns,
            bound.unknown,
            bound.known,
            self.of(closure.rows),
            self.of(closure.errors),
            bound.characteristic_length,
        )

    def check(self, real: Real) -> None:
        """Raises InputError where a struct in this type cannot hold numbers that cancel to the size
        of the machine.
        """
        largest, mechanism = float(np.max(np.abs(self.values), initial=0.0)), self.closure.mechanism
        if real.name == "float" and largest > _LARGEST * max(mechanism.characteristic_length, 1.0):
            raise InputError(
                f"{mechanism.name}: a number of its geometry is {largest:g}, over {_LARGEST:g} "
                f"times its size of "
                f"{mechanism.characteristic_length:.3g} {mechanism.length_unit}: a float holds it "
                f"too coarsely; "
                "use --real double, or leave --geometry struct out, which folds it into the code"
            )

    def declaration(self, name: str, real: Real) -> str:
        """The struct and its nominal values, for the header."""
        last = len(self.members) - 1
        numbers = [
            f"{real.literal(v)}{',' if k < last else ''} /* {member} */ \\"
            for k, (member, v) in enumerate(zip(self.members, self.values, strict=True))
        ]
        members = [f"{name}_real {member};" for member in self.members]
        shown = {
            "p": name,
            "P": name.upper(),
            "members": members,
            "numbers": numbers,
            "largest": self.largest,
            "shortest": _SHORTEST,
        }
        return fill("geometry.h", shown)


def exact_turn(numbers: np.ndarray) -> np.ndarray:
    """Numbers of rotations that are 0, 1 or -1 to rounding so to the last digit."""
    return np.where(np.abs(numbers - np.round(numbers)) <= _ROUNDING, np.round(numbers), numbers)


def geometry_check(geometry: Geometry) -> str:
    """Write NAME_check_geometry, which keeps a status where all numbers of the struct are finite,
    none is too large and directions have a length; nothing without a struct.
    """
    if not geometry.names:
        return ""
    last = len(geometry.names) - 1
    members = [f"{text}{',' if k < last else ''}" for k, text in enumerate(geometry.names)]
    squares = (
        " + ".join(f"values[{k}] * values[{k}]" for k in range(first, first + _WIDTH[end]))
        for first, end in geometry.directions
    )
    short = " || ".join(f"({square} < {_SHORTEST**2:g})" for square in squares)
    shown = {
        "count": len(members),
        "members": members,
        "largest": geometry.largest,
        "or_short": " or a direction has next to no length" if short else "",
        "directed": block(f"if ((status == NAME_OK) && ({short}))", ["status = NAME_OUT_OF_RANGE;"])
        if short
        else "",
    }
    return fill("check_geometry.c", shown)
