"""Screws of joints, and bases of screws that can be read.

A screw is the six-vector (s; s0) in ray order: direction s and moment s0 about the frame's origin.
A twist is (angular velocity; velocity of the point at the origin), a wrench (force; moment about
the origin); a wrench does no work on a twist when their reciprocal product s_t . s0_w + s0_t . s_w
is zero.
"""

from __future__ import annotations

import math

import numpy as np

from symkin.spatial.backend import Array, cross, scale, vector

_ZERO_ENTRY = 1e-9
"""Entries of tidy rows below this are rounding."""


def revolute_screw(point: Array, axis: Array, pitch_per_turn: Array = 0.0) -> Array:
    """Unit twist of a revolute (pitch 0) or helical joint: (a; c x a + h a), h = pitch per turn / 2
    pi.
    """
    moment = cross(point, axis) + scale(pitch_per_turn / (2 * math.pi), axis)
    return vector(axis[0], axis[1], axis[2], moment[0], moment[1], moment[2])


def prismatic_screw(axis: Array) -> Array:
    """Unit twist of a prismatic joint: (0; a)."""
    zero = 0.0 * axis[0]
    return vector(zero, zero, zero, axis[0], axis[1], axis[2])


def tidy_rows(rows: np.ndarray) -> np.ndarray:
    """The same row space in reduced echelon form with unit rows: readable bases for print-outs."""
    reduced = np.array(rows, dtype=float)
    pivot_row = 0
    for column in range(reduced.shape[1]):
        if pivot_row >= reduced.shape[0]:
            break
        best = pivot_row + int(np.argmax(np.abs(reduced[pivot_row:, column])))
        if abs(reduced[best, column]) < _ZERO_ENTRY:
            continue
        reduced[[pivot_row, best]] = reduced[[best, pivot_row]]
        reduced[pivot_row] /= reduced[pivot_row, column]
        for other in range(reduced.shape[0]):
            if other != pivot_row:
                reduced[other] -= reduced[other, column] * reduced[pivot_row]
        pivot_row += 1
    norms = np.linalg.norm(reduced, axis=1, keepdims=True)
    reduced = reduced / np.where(norms > 0, norms, 1.0)
    reduced[np.abs(reduced) < _ZERO_ENTRY] = 0.0
    return reduced
