"""Modes of the machine that a description means, told as the description has its coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.assembly.modes_result import Group, Modes
from symkin.closure.closure import Closure
from symkin.machine.lower import Lowered, lowered
from symkin.machine.universal import BallReading
from symkin.model.mechanism import Mechanism
from symkin.position.feasible_pose import ties_poses
from symkin.position.given import Given
from symkin.position.problem import Problem, are_of_limbs, pose_names
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.position.transfer import many_as_written

COMPLETE = ("proved", "probability one")
"""What is said of lists that hold all modes."""


def machine_of(
    mechanism: Mechanism, names: tuple[str, ...], kept: frozenset[str] = frozenset()
) -> Lowered | None:
    """The machine for known values, by their names, of joints or of the platform's pose, which has
    the joints `kept` as they are written; None where it is the mechanism itself.
    """
    if names == pose_names(mechanism) or are_of_limbs(mechanism, names):
        return lowered(mechanism, kept=kept)
    joints = frozenset(names) & {c.name for c in mechanism.coordinates}
    return lowered(mechanism, joints, pose=not mechanism.is_graph, kept=kept)


def is_complete(found: Modes) -> bool:
    """Whether a list is said to hold all modes."""
    return found.completeness in COMPLETE


def may_contradict(low: Lowered, given: Given) -> bool:
    """Whether rounding may leave a given pose without modes: the joints tie the pose, so that its
    rows contradict each other by rounding.
    """
    return given.names == pose_names(low.written) and ties_poses(low.machine)


@dataclass(frozen=True, eq=False)
class Told:
    """A description whose `problem`, at `known` values (n, numbers) of n inputs, is that of its
    machine: in its coordinates the machine's modes are told.
    """

    low: Lowered
    problem: Problem
    known: np.ndarray

    def listed(self, own: Closure, values: np.ndarray, owner: np.ndarray) -> SolutionList:
        """Configurations of the machine, variables of its `own` closure (m, own variables), of the
        inputs `owner` (m,), with what the description's rows leave open.
        """
        told = many_as_written(self.problem.closure, own, values, self.low)
        self.problem.put_known(told, self.known[owner])
        return checked_solutions(self.problem, told)

    def of(self, inputs: Sequence[int] | np.ndarray) -> Told:
        """Some of the inputs, in their order."""
        return self if len(inputs) == len(self.known) else replace(self, known=self.known[inputs])


def as_written(told: Told, given: Given, found: Modes) -> Modes | None:
    """The modes of one input, which are told in the coordinates of a description, with its names;
    None where the list may not be complete.
    """
    if not is_complete(found):
        return None
    if not told.low.readings:
        return found
    names = {reading.of: reading.name for reading in told.low.readings}
    told_notes = [_told(note, names) for note in found.notes]
    return replace(
        found,
        groups=tuple(_renamed(group, names) for group in found.groups),
        notes=tuple(dict.fromkeys((*given.notes, *told_notes, *_ball_notes(told.low)))),
    )


def _ball_notes(low: Lowered) -> list[str]:
    """What is said of three revolute joints that turn their link as a ball does."""
    return [
        f"{reading.name} turn their link as a ball: of the two triples of angles of each turn the "
        f"one is told whose second is next to the reference"
        for reading in low.readings
        if isinstance(reading, BallReading)
    ]


def _renamed(group: Group, names: dict[str, str]) -> Group:
    unknowns = tuple(names.get(name, name) for name in group.unknowns)
    return replace(group, name=", ".join(unknowns), unknowns=unknowns)


def _told(note: str, names: dict[str, str]) -> str:
    """A note with the description's names."""
    for name, written in names.items():
        note = note.replace(name, written)
    return note
