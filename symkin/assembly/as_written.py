"""Modes of the machine that a description means, told as the description has its coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.modes_result import Group, Modes
from symkin.machine.lower import Lowered, lowered
from symkin.model.mechanism import Mechanism
from symkin.position.feasible_pose import ties_poses
from symkin.position.given import Given, given_from
from symkin.position.given_by_name import plain_kind, pose_names, told_by_name
from symkin.position.problem import Problem
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.position.transfer import many_as_written
from symkin.spatial.pose import Pose

COMPLETE = ("proved", "probability one")
"""What is said of lists that hold all modes."""


def machine_of(mechanism: Mechanism, given: Given) -> Lowered | None:
    """The machine for known values of joints, or of the platform's pose as a whole; None where it
    is the mechanism itself, and where parts of the pose are given.
    """
    names = set(given.names) if given.by_name else set()
    if names == set(pose_names(mechanism)):
        return lowered(mechanism)
    if not names <= {c.name for c in mechanism.coordinates}:
        return None
    return lowered(mechanism, frozenset(names), pose=not mechanism.is_graph)


def is_complete(found: Modes) -> bool:
    """Whether a list is said to hold all modes."""
    return found.completeness in COMPLETE


def may_contradict(low: Lowered, given: Given) -> bool:
    """Whether rounding may leave a given pose without modes: the joints tie the pose, so that its
    rows contradict each other by rounding.
    """
    return _is_pose(low.written, given) and ties_poses(low.machine)


def given_of_machine(low: Lowered, given: Given) -> Given:
    """The same known values of the machine: joints as they are, a pose in its frame."""
    stands_otherwise = low.frames is not None or low.machine.motion != low.written.motion
    if _is_pose(low.written, given) and stands_otherwise:
        pose = Pose(given.values[:3], given.values[3:])
        taken = pose if low.frames is None else low.frames.taken(pose)
        given = replace(given_from(low.machine, None, taken), echo=given.echo)
        return told_by_name(low.machine, given) if low.machine.is_graph else given
    kind = plain_kind(low.machine, given.names) if given.by_name else None
    if kind is None:
        return given
    if kind == "inverse":
        return replace(given, kind=kind, names=())
    places = [given.names.index(c.name) for c in low.machine.actuated]
    return replace(given, kind=kind, names=(), values=given.values[places])


def as_written(low: Lowered, problem: Problem, given: Given, found: Modes) -> Modes | None:
    """The modes in the coordinates of the description, held against all of its own rows; None where
    some do not close there, and where the list may not be complete.
    """
    if not is_complete(found):
        return None
    listed = SolutionList.of_none(problem.closure)
    if len(found):
        known, owner = np.tile(given.values, (len(found), 1)), np.zeros(len(found), dtype=int)
        listed = replace(
            told_as_written(low, problem, found.modes, known, owner), notes=given.notes
        )
        if not listed.closed.all():
            return None
    names = {reading.of: reading.name for reading in low.readings}
    return replace(
        found,
        problem=problem,
        given=given.echo,
        modes=listed,
        groups=tuple(_renamed(group, names) for group in found.groups),
        notes=tuple(_told(note, names) for note in found.notes),
    )


def told_as_written(
    low: Lowered, problem: Problem, own: SolutionList, known: np.ndarray, owner: np.ndarray
) -> SolutionList:
    """The machine's modes (m,) of the inputs `owner` (m,), rising, with what is proved of them, in
    the coordinates of the description at its `known` values (m, known): in the order of the modes
    there, with what its rows leave open.
    """
    values = many_as_written(problem.closure, own.closure, own.values, low)
    values[:, problem.known_places] = known
    proofs = {"certified": own.certified, "radius": own.radius, "ground": own.ground}
    listed = replace(checked_solutions(problem, values), **proofs)  # type: ignore[arg-type]
    return listed.chosen(order_of_modes(problem, listed, owner))


def _is_pose(mechanism: Mechanism, given: Given) -> bool:
    """Whether the platform's pose as a whole is what is given."""
    return given.of_pose or given.names == pose_names(mechanism)


def _renamed(group: Group, names: dict[str, str]) -> Group:
    unknowns = tuple(names.get(name, name) for name in group.unknowns)
    return replace(group, name=", ".join(unknowns), unknowns=unknowns)


def _told(note: str, names: dict[str, str]) -> str:
    """A note with the description's names."""
    for name, written in names.items():
        note = note.replace(name, written)
    return note
