"""A track as a short table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from symkin.plain_number import NOTHING, plain

if TYPE_CHECKING:
    from symkin.following.track_result import Sample, Track

_MOST_ROWS = 11
"""Rows of the table at most; the JSON and the CSV hold all samples."""


def track_text(track: Track) -> str:
    """Some samples with pose, smallest singular value and residual; then how it ended and on what ground."""
    mechanism = track.trajectory.mechanism
    lines = [f"{mechanism.name}, {track.trajectory.kind} problem, {len(track.samples)} samples"]
    if track.samples:
        chosen = np.unique(np.linspace(0, len(track.samples) - 1, _MOST_ROWS).round().astype(int))
        unit = mechanism.length_unit
        header = ["path", f"x [{unit}]", f"y [{unit}]", f"z [{unit}]", "qw", "qx", "qy", "qz", "sigma", "residual"]
        lines += _aligned([header, *(_row(track.samples[k], mechanism.size) for k in chosen)])
        lines.append(
            "path: share of the path, 0 to 1; sigma: smallest singular value of the unknowns' Jacobian (no unit; angles times the "
            f"size {mechanism.size:.6g} {unit}), 0 at a singularity; residual: largest closure error in {unit}"
        )
    if track.nearest is not None:
        lines.append(_nearest(track, track.nearest))
    lines += [track.statement, f"ground: {track.ground}", *track.trajectory.notes]
    return "\n".join(lines)


def _nearest(track: Track, near: Sample) -> str:
    """How near the path comes to a singularity, between samples too."""
    distances = ", ".join(f"{kind} {plain(value):.3g}" for kind, value in track.distances.items())
    return f"nearest to a singularity at {near.parameter:.9g} of the path: sigma {plain(near.smallest, 1.0):.3g}; distance: {distances}"


def _aligned(rows: list[list[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in rows]


def _row(sample: Sample, size: float) -> list[str]:
    pose = sample.pose
    return [
        f"{sample.parameter:.6f}",
        *(f"{plain(float(v), size):.6g}" for v in np.asarray(pose.position)),
        *(f"{plain(float(v), 1.0, 5e-7):.6f}" for v in np.asarray(pose.quaternion)),
        f"{plain(sample.smallest, 1.0):.2e}" if sample.smallest >= NOTHING else "0",
        f"{sample.residual:.1e}" if sample.residual >= 1e-8 * NOTHING * size else "0",
    ]
