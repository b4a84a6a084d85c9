"""Group modes by what was found: poses, and actuated joints that are not given; and name the U
joints in which alone others differ.

A U joint leads to a place of the next joint in two ways, between which the link behind is turned
about its line to that joint: by half a turn where the line is across both axes. So a rod with a U
and an S joint has two modes in every place, and n of them 2^n.
"""

from __future__ import annotations

import numpy as np

from symkin.position.problem import Problem
from symkin.position.roots import features_of
from symkin.position.solution_list import SolutionList

_SAME = 1e-6
"""Poses and joint values nearer than this (rad, of the size) are one."""
_PROJECTIONS = 3
"""Random directions along which different ones are told apart."""


def sets_of_modes(problem: Problem, modes: SolutionList, *, joints: bool) -> np.ndarray:
    """The group (n,) of each mode, numbered in the order of their first modes: those of one pose,
    with `joints` also of one set of actuated joints. Each is its own where neither was found.
    """
    closure, given = modes.closure, {c.name for c in problem.known_coordinates}
    size, columns = closure.characteristic_length, [np.zeros((len(modes), 0))]
    if problem.mechanism.platform_link is not None:
        turns = modes.quaternion[:, :, None] * modes.quaternion[:, None, :]
        columns += [modes.position, size * turns.reshape(len(modes), 16)]
    for c in closure.role("actuated") if joints else ():
        if c.name not in given:
            columns.append(features_of([(c, closure.slices[c.name])], modes.values, size))
    features = np.hstack(columns)
    return _labels(features / size) if features.shape[1] else np.arange(len(modes))


def _labels(features: np.ndarray) -> np.ndarray:
    """Numbers (n,) of rows that are the same, in the order of their first ones."""
    labels = np.zeros(len(features), dtype=int)
    for direction in np.random.default_rng(0).normal(size=(_PROJECTIONS, features.shape[1])):
        along = features @ (direction / np.linalg.norm(direction))
        order = np.lexsort((along, labels))
        begins = np.diff(labels[order], prepend=-1) != 0
        begins |= np.diff(along[order], prepend=np.nan) > _SAME
        labels[order] = np.cumsum(begins) - 1
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse.ravel()]


def differing_universal_joints(
    problem: Problem, modes: SolutionList, groups: np.ndarray
) -> tuple[str, ...]:
    """U joints in which alone the modes of one group differ; none where other joints differ too."""
    first = np.unique(groups, return_index=True)[1][groups]
    angles = {
        f"{joint.name}.{k}": joint.name
        for joint in problem.mechanism.all_joints
        if joint.type == "U"
        for k in (1, 2)
    }
    found: dict[str, None] = {}
    for c in problem.system.unknowns:
        if c.role in ("pose", "body") or c.is_rotation:
            continue
        values = modes.values[:, modes.closure.slices[c.name].start]
        gaps = values - values[first]
        far = np.abs(np.exp(1j * gaps) - 1.0) if c.is_periodic else np.abs(gaps)
        if (far > _SAME * c.unit(problem.closure.characteristic_length)).any():
            if c.name not in angles:
                return ()
            found[angles[c.name]] = None
    return tuple(found)
