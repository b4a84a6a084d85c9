"""Group modes by what was found: poses, and actuated joints that are not given; and name the U
joints in which alone others differ.

A U joint leads to a place of the next joint in two ways, between which the link behind is turned
about its line to that joint: by half a turn where the line is across both axes. So a rod with a U
and an S joint has two modes in every place, and n of them 2^n.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.position.problem import Problem
from symkin.position.solution import Solution

_SAME = 1e-6
"""Poses and joint values nearer than this (rad, of the size) are one."""
_PROJECTIONS = 3
"""Random directions along which different ones are told apart."""


def groups_of(problem: Problem, modes: Sequence[Solution], *, joints: bool) -> np.ndarray:
    """The group (n,) of each mode, numbered in the order of their first modes: those of one pose,
    with `joints` also of one set of actuated joints. Each is its own where neither was found.
    """
    if not len(modes):
        return np.zeros(0, dtype=int)
    size = problem.closure.characteristic_length
    given = {c.name for c in problem.known_coordinates}
    found = [
        c
        for c in problem.mechanism.actuated
        if joints and c.name not in given and c.name in modes[0].values
    ]
    columns = [np.zeros((len(modes), 0))]
    if problem.mechanism.platform_link is not None:
        columns += [
            np.array([mode.position for mode in modes]),
            size * np.array([mode.rotation.ravel() for mode in modes]),
        ]
    for c in found:
        values = np.array([[mode.values[c.name]] for mode in modes])
        columns += (
            [size * np.cos(values), size * np.sin(values)]
            if c.is_periodic
            else [size * values if c.is_angular else values]
        )
    features = np.concatenate([part.reshape(len(modes), -1) for part in columns], axis=1)
    if not features.shape[1]:
        return np.arange(len(modes))
    return _labels(features / size)


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
    return np.asarray(np.argsort(np.argsort(first))[inverse.ravel()])


def differing_universal_joints(
    problem: Problem, modes: Sequence[Solution], groups: np.ndarray
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
        values = np.array([mode.values[c.name] for mode in modes]).ravel()
        gaps = values - values[first]
        far = np.abs(np.exp(1j * gaps) - 1.0) if c.is_periodic else np.abs(gaps)
        if (far > _SAME * c.unit(problem.closure.characteristic_length)).any():
            if c.name not in angles:
                return ()
            found[angles[c.name]] = None
    return tuple(found)
