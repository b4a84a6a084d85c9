"""Modes of the machine that a description means, told as the description has its coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.modes_result import Group, Modes
from symkin.closure.closure import Closure
from symkin.machine.lower import Lowered, lowered
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.feasible_pose import ties_poses
from symkin.position.given import Given, given_from
from symkin.position.given_by_name import plain_kind, pose_names, told_by_name
from symkin.position.problem import Problem
from symkin.position.solution import Solution
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
    listed: Sequence[Solution] = ()
    if len(found):
        own = np.array([mode.variables for mode in found])
        told = as_checked(low, problem, found.problem.closure, own, given.values, given.notes)
        size = problem.closure.characteristic_length
        if not (told.residual <= CLOSURE_TOLERANCE * size).all():
            return None
        listed = _in_order(problem, _with_proofs(told, found))
    names = {reading.of: reading.name for reading in low.readings}
    return replace(
        found,
        problem=problem,
        given=given.echo,
        modes=listed,
        groups=tuple(_renamed(group, names) for group in found.groups),
        notes=tuple(_told(note, names) for note in found.notes),
    )


def as_checked(
    low: Lowered,
    problem: Problem,
    own: Closure,
    values: np.ndarray,
    known: np.ndarray,
    notes: tuple[str, ...] = (),
) -> SolutionList:
    """Configurations of the machine, variables of its `own` closure (m, own variables), in the
    coordinates of the description at its `known` values, with what its rows leave open.
    """
    told = many_as_written(problem.closure, own, values, low)
    told[:, problem.known_places] = known
    return checked_solutions(problem, told, notes)


def _is_pose(mechanism: Mechanism, given: Given) -> bool:
    """Whether the platform's pose as a whole is what is given."""
    return given.of_pose or given.names == pose_names(mechanism)


def _with_proofs(listed: SolutionList, found: Modes) -> SolutionList:
    """Modes with what is proved of those that they are."""
    certified = [-1 if mode.certified is None else int(mode.certified) for mode in found]
    radius = [np.nan if mode.radius is None else mode.radius for mode in found]
    ground = np.full(len(listed), None, dtype=object)
    for place, mode in enumerate(found):
        ground[place] = mode.ground
    return replace(
        listed, certified=np.array(certified), radius=np.array(radius), ground=ground, _made={}
    )


def _in_order(problem: Problem, listed: SolutionList) -> SolutionList:
    one_input = np.zeros(len(listed), dtype=int)
    order = order_of_modes(problem, listed.values, listed.position, listed.quaternion, one_input)
    return listed.chosen(order)


def _renamed(group: Group, names: dict[str, str]) -> Group:
    unknowns = tuple(names.get(name, name) for name in group.unknowns)
    return replace(group, name=", ".join(unknowns), unknowns=unknowns)


def _told(note: str, names: dict[str, str]) -> str:
    """A note with the description's names."""
    for name, written in names.items():
        note = note.replace(name, written)
    return note
