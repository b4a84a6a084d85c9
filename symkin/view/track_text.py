"""A track as a short table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from symkin.motion.track_result import Sample, Track

_MOST_ROWS = 11
"""Rows of the table at most; the JSON and the CSV hold all samples."""


def track_text(track: Track) -> str:
    """Some samples with pose, smallest singular value and residual; then how it ended and on what ground."""
    mechanism = track.trajectory.mechanism
    lines = [f"{mechanism.name}, {track.trajectory.kind} problem, {len(track.samples)} samples"]
    if track.samples:
        unit = mechanism.length_unit
        lines.append(f"{'path':>10}  {'x, y, z [' + unit + ']':<36}{'qw, qx, qy, qz':<42}{'sigma':>9} {'residual':>9}")
        chosen = np.unique(np.linspace(0, len(track.samples) - 1, _MOST_ROWS).round().astype(int))
        lines += [_row(track.samples[k]) for k in chosen]
    lines += [track.statement, f"ground: {track.ground}", *track.trajectory.notes]
    return "\n".join(lines)


def _row(sample: Sample) -> str:
    position = ", ".join(f"{v:.6g}" for v in np.asarray(sample.pose.position))
    quaternion = ", ".join(f"{v:.6f}" for v in np.asarray(sample.pose.quaternion))
    return f"{sample.parameter:>10.6f}  {position:<36}{quaternion:<42}{sample.smallest:>9.2e} {sample.residual:>9.1e}"
