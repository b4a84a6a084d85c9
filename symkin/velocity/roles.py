"""What drives a mechanism and what is wanted of it: the inputs q' and the outputs t of its velocity
equations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from symkin.closure.closure import Closure, build_closure
from symkin.errors import InputError
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.determination import determination
from symkin.position.given import checked_names, given_coordinates
from symkin.position.problem import actuated_names, are_of_limbs, build_problem, pose_names

_OPEN_RANK, _MOST_OPEN = 1e3, 1e-2
"""Singular values below this many times the share of the size by which loops stay open are those of
redundant rows, up to a share of the largest.
"""


@dataclass(frozen=True)
class Roles:
    """The coordinates that are driven (`inputs`) and those that are wanted (`outputs`), by name;
    `outputs` of None are all other joints. `by_name`: they are told, and not the actuated joints
    and the platform's pose of limbs.
    """

    mechanism: Mechanism
    inputs: tuple[str, ...]
    outputs: tuple[str, ...] | None
    by_name: bool = True

    @staticmethod
    def of_limbs(mechanism: Mechanism) -> Roles:
        """The actuated joints drive, and the platform's pose is wanted."""
        return Roles(mechanism, actuated_names(mechanism), pose_names(mechanism), by_name=False)

    @property
    def has_twist(self) -> bool:
        """Whether the output is the platform's twist."""
        return self.outputs == pose_names(self.mechanism)

    @property
    def closure(self) -> Closure:
        """The closure of what is asked; that of names holds every joint whose coordinates are
        numbers, so that where loops would be cut does not matter.
        """
        if not self.by_name:
            return build_closure(self.mechanism)
        numbers = [c.name for c in self.mechanism.coordinates if not c.is_rotation]
        held = dict.fromkeys([*numbers, *(self.outputs or ())])
        names = tuple(name for name in held if name not in self.inputs)
        return build_problem(self.mechanism, self.inputs, names).closure

    @property
    def names_output(self) -> bool:
        """Whether the output is less than all that is not driven."""
        return self.outputs is not None

    @property
    def dependent_rows(self) -> float:
        """Singular value of rows, over the largest, below which rows of names follow from others:
        more than rounding where loops of redundant constraints close only to the digits of a file.
        """
        misfit = determination(build_problem(self.mechanism, self.inputs, ())).misfit
        return max(
            RANK_TOLERANCE,
            min(_OPEN_RANK * misfit / self.mechanism.characteristic_length, _MOST_OPEN),
        )

    def input_columns(self, closure: Closure) -> list[int]:
        """Columns of the closure's Jacobian by rates of what is driven."""
        return columns_by_name(closure, self.inputs)

    def driven(self, closure: Closure) -> list[Coordinate]:
        """The coordinates that drive, one for each input column."""
        return [closure.owners[k] for k in self.input_columns(closure)]

    def output_columns(self, closure: Closure) -> list[int]:
        """Columns of the closure's Jacobian by rates of what is wanted."""
        return columns_by_name(
            closure, other_joints(closure, self.inputs) if self.outputs is None else self.outputs
        )

    @property
    def output_text(self) -> str:
        """What the output is, in words."""
        return (
            "the platform"
            if self.has_twist
            else "the other joints"
            if self.outputs is None
            else ", ".join(self.outputs)
        )


def roles_of(
    mechanism: Mechanism, inputs: Iterable[str] | None = None, outputs: Iterable[str] | None = None
) -> Roles:
    """The roles for coordinates that are told by name; without `inputs` the actuated joints,
    without `outputs` the platform, or all other joints where there is none or its own coordinates
    drive. Raises InputError for names that nothing has.
    """
    driven = actuated_names(mechanism)
    driven = driven if inputs is None else named_coordinates(mechanism, inputs, "given")
    if outputs is None and are_of_limbs(mechanism, driven):
        return Roles.of_limbs(mechanism)
    if not driven:
        raise InputError(f"{mechanism.name}: no joint is actuated; name what drives it, by given")
    if outputs is not None:
        wanted = named_coordinates(mechanism, outputs, "output")
        both = [name for name in wanted if name in driven]
        if both:
            raise InputError(
                f"output = {', '.join(wanted)}: {', '.join(both)} is given, and drives the "
                f"mechanism"
            )
        return Roles(mechanism, driven, wanted)
    pose_drives = any(
        name in POSE_CONDITIONS and name not in _joint_names(mechanism) for name in driven
    )
    pose_drives = pose_drives or any(name.startswith("pose.") for name in driven)
    others = any(not c.is_rotation and c.name not in driven for c in mechanism.coordinates)
    platform = mechanism.platform_link is not None and not (pose_drives and others)
    return Roles(mechanism, driven, pose_names(mechanism) if platform else None)


def other_joints(closure: Closure, inputs: Sequence[str]) -> list[str]:
    """The joints whose coordinates are numbers and that do not drive."""
    found = (c for c in closure.role("actuated", "passive") if not c.is_rotation)
    return [c.name for c in found if c.name not in inputs]


def named_coordinates(mechanism: Mechanism, names: Iterable[str], what: str) -> tuple[str, ...]:
    """Names of coordinates, those of the whole pose for "pose". Raises InputError for what no
    coordinate is named, or twice.
    """
    known = given_coordinates(mechanism)
    pose = () if "pose" in known or mechanism.platform_link is None else ("pose",)
    told = checked_names(mechanism, names, what, [*known, *pose])
    return tuple(
        own for name in told for own in (pose_names(mechanism) if name in pose else (name,))
    )


def _joint_names(mechanism: Mechanism) -> set[str]:
    return {c.name for c in mechanism.coordinates}


def columns_by_name(closure: Closure, names: Sequence[str]) -> list[int]:
    """Columns of the closure's Jacobian by rates of some coordinates, in the order of the names."""
    return [k for name in names for k, c in enumerate(closure.owners) if c.name == name]
