"""Read a path that the page plays from a CSV file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from symkin.errors import InputError
from symkin.following.track_csv import read_trajectory
from symkin.following.track_result import Track
from symkin.model.mechanism import Mechanism
from symkin.page.page import PlayedPath

_MOST = 20_000
"""Rows that a page takes: more make it large and slow to open."""
_POSE_SAMPLES = 400
"""Configurations along a path of poses, at least: between them the page goes straight in the
joints, not in the pose.
"""


def played_path(
    mechanism: Mechanism, file: Path | str, given: Mapping[str, float] | None = None
) -> PlayedPath:
    """The rows of a CSV file by the coordinates `given`, else by the actuated joints; rows of poses
    are followed by `track`, whose joints are played. Raises InputError.
    """
    read = read_trajectory(mechanism, file, given=None if given is None else dict.fromkeys(given))
    title, times = Path(file).name, read["times"]
    if "poses" in read:
        return _of_poses(mechanism, title, read["poses"], times)
    if given is not None:
        columns = [read["given"][name] for name in given]
        rows = [list(row) for row in zip(*columns, strict=True)]
        return _checked(PlayedPath(title, list(given), rows, times))
    return _checked(PlayedPath(title, [c.name for c in mechanism.actuated], read["joints"], times))


def _of_poses(
    mechanism: Mechanism, title: str, poses: list[list[float]], times: list[float] | None
) -> PlayedPath:
    from symkin.following.track import track

    found = track(mechanism, poses=poses, times=times, samples=max(len(poses), _POSE_SAMPLES))
    if not found.reached:
        raise InputError(f"{title}: the poses cannot all be followed: {found.statement}")
    return _checked(path_of_track(found, title))


def path_of_track(track: Track, title: str) -> PlayedPath:
    """The samples of a track, by the coordinates that its path tells or by the actuated joints."""
    samples, mechanism = track.samples, track.trajectory.mechanism
    names = [c.name for c in track.problem.known_coordinates]
    if not samples[0].joints.keys() >= set(names):
        names = [c.name for c in mechanism.actuated]
    rows = [[float(sample.joints[name]) for name in names] for sample in samples]
    played = [sample.time for sample in samples]
    every = None if None in played else [float(time or 0.0) for time in played]
    return PlayedPath(title, names, rows, every, samples[0].solution.to_dict())


def _checked(path: PlayedPath) -> PlayedPath:
    if len(path.rows) > _MOST:
        raise InputError(f"{path.title}: {len(path.rows)} rows; a page plays {_MOST} at most")
    if path.times is not None and path.times[0] == path.times[-1]:
        return replace(path, times=None)
    return path
