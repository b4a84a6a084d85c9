"""What a track is: its samples, why it ended, and on what ground it is one mode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.following.sample import Sample, listed_joints
from symkin.following.stop import Stop, roles_followed
from symkin.following.trajectory import Trajectory
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.result import Result, Summary, json_fields
from symkin.singularities.classification import classify
from symkin.text import NOTHING, plain

_MOST_COLUMNS = 7
"""Joints and coordinates of the pose in the table at most."""
_MOST_JUDGED = 41
"""Samples of a path of poses whose distance from type 2 singularities is told."""
_MOST_ROWS = 11
"""Rows of the table at most; the dict and the CSV hold all samples."""


@dataclass(frozen=True, eq=False, repr=False)
class Track(Result):
    """One mode along a path; made by `symkin.track`.

    `samples` are its configurations, the last one `end`; `stop` is None where the path's end was
    reached. `certified`: ball arithmetic has proved that all samples lie on one branch of solutions
    without a singularity, up to the end or to the turning point that is its first singularity, or
    the pose is a formula of the joints; `ground` says so in words. `followed_to` is the parameter
    (0 to 1) up to which steps lead, `steps` their count, of whose tubes images fill at most
    `tightest`. `residual` is the largest closure error of the samples (length unit). `nearest` is
    the place nearest to a singularity of the followed problem, between samples too (None where
    nothing is lost anywhere: the pose is a formula of the joints). `plot()` draws the platform's
    motion or the joints, and the smallest singular value.

    >>> import symkin
    >>> platform = symkin.load("zhao2000")
    >>> ends = [[81.6, 202.8, 330.6, 105.2], [85.0, 202.8, 330.6, 105.2]]
    >>> found = symkin.track(platform, joints=ends, samples=5)
    >>> found.reached, found.certified, len(found.samples)
    (True, True, 5)
    """

    trajectory: Trajectory
    problem: Problem
    samples: tuple[Sample, ...]
    stop: Stop | None
    certified: bool
    followed_to: float | None
    steps: int
    tightest: float
    residual: float
    ground: str
    elapsed_s: float
    nearest: Sample | None = None

    @cached_property
    def distances(self) -> dict[str, float]:
        """Distances from singularities (see `Singularity.distances`) at `nearest`; empty where
        there is none.
        """
        return (
            {}
            if self.nearest is None
            else classify(self.nearest.solution, roles=roles_followed(self.problem)).distances
        )

    @property
    def reached(self) -> bool:
        """Whether the path's end was reached."""
        return self.stop is None

    @property
    def end(self) -> Sample:
        """The last configuration of the track."""
        return self.samples[-1]

    @property
    def statement(self) -> str:
        """How the track ended, in one sentence."""
        if self.stop is None:
            return "reached the end of the path on one mode"
        return f"stopped: {self.stop}"

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `symkin track`, with all samples."""
        trajectory = self.trajectory
        return {
            "mechanism": trajectory.mechanism.name,
            "problem": trajectory.kind,
            "given": {
                "from": next(iter(trajectory.given[0].values())),
                "to": next(iter(trajectory.given[1].values())),
                "rows": len(trajectory),
            },
            "length_unit": trajectory.mechanism.length_unit,
            "angle_unit": trajectory.mechanism.angle_unit,
            **json_fields(self, "reached", "statement", "stop", "certified", "ground"),
            **json_fields(self, "followed_to", "steps"),
            "nearest": None
            if self.nearest is None
            else {
                **json_fields(self.nearest, "parameter", "time", "smallest_singular_value"),
                "distances": self.distances,
            },
            **json_fields(self, "samples", "elapsed_s"),
            "notes": list(trajectory.notes),
        }

    def summary(self, most_rows: int | None = None) -> Summary:
        """Some samples with pose, smallest singular value and residual; then how it ended and on
        what ground.
        """
        mechanism = self.trajectory.mechanism
        unit, size = mechanism.length_unit, mechanism.characteristic_length
        what = f"{self.trajectory.kind} problem"
        if self.trajectory.kind == "given":
            what = f"given {', '.join(c.name for c in self.problem.known_coordinates)}"
        above = [f"{mechanism.name}, {what}, {len(self.samples)} samples"]
        below = [self.statement, f"ground: {self.ground}", *self.trajectory.notes]
        if self.nearest is not None:
            below[:0] = [self._nearest_line(self.nearest), *self._motors_lines]
        if not self.samples:
            return Summary(above, below=below)
        chosen = self._spread(_MOST_ROWS if most_rows is None else min(most_rows, _MOST_ROWS))
        header = ["path", *self._header, "sigma", "residual"]
        legend = (
            "path: share of the path, 0 to 1; sigma: smallest singular value of the unknowns' "
            "Jacobian (no unit; angles times the "
            f"size {size:.6g} {unit}), 0 at a singularity; residual: largest closure error in "
            f"{unit}"
        )
        return Summary(above, header, [*self._rows(chosen)], [legend, *below])

    def _spread(self, most: int) -> list[int]:
        """Numbers of samples that stand evenly along the path."""
        numbers = np.linspace(0, len(self.samples) - 1, most).round().astype(int)
        return np.unique(numbers).tolist()

    @property
    def _shows_pose(self) -> bool:
        """Whether the platform's pose is the story, and not the joints'."""
        return self.samples[0].has_platform and self.trajectory.kind != "given"

    @property
    def _shown(self) -> list[tuple[str, np.ndarray, float]]:
        """Title, values (samples,) and scale of the columns: what is told along the path, other
        joints, and where the platform is, as many as a table takes.
        """
        mechanism, problem = self.trajectory.mechanism, self.problem
        unit, size = mechanism.length_unit, mechanism.characteristic_length
        found: dict[str, tuple[str, np.ndarray, float]] = {}
        for c in problem.known_coordinates:
            if c.role == "condition":
                place = problem.closure.slices[c.name].start
                values = [mechanism.value_out(c, float(s.values[place])) for s in self.samples]
                found[c.name] = self._column(c, values)
        known = {c.name for c in problem.known_coordinates}
        for c in sorted(listed_joints(problem), key=lambda c: c.name not in known):
            if not c.is_rotation:
                found[c.name] = self._column(c, [s.joints[c.name] for s in self.samples])
        if self.samples[0].has_platform:
            places = np.array([np.asarray(sample.pose.position) for sample in self.samples])
            for k, name in enumerate("xyz"):
                found.setdefault(name, (f"{name} [{unit}]", places[:, k], size))
        return list(found.values())[:_MOST_COLUMNS]

    def _column(self, c: Coordinate, values: list[float]) -> tuple[str, np.ndarray, float]:
        mechanism = self.trajectory.mechanism
        title = f"{c.name} [{mechanism.unit_of(c)}]"
        return title, np.array(values), c.unit(mechanism.characteristic_length)

    @property
    def _header(self) -> list[str]:
        unit = self.trajectory.mechanism.length_unit
        if self._shows_pose:
            return [f"x [{unit}]", f"y [{unit}]", f"z [{unit}]", "qw", "qx", "qy", "qz"]
        return [title for title, _, _ in self._shown]

    def _rows(self, chosen: Sequence[int]) -> Iterator[list[str]]:
        """The cells of some samples; what is rounding is written as 0."""
        size, shown = self.trajectory.mechanism.characteristic_length, self._shown
        for k in chosen:
            sample = self.samples[k]
            cells = [f"{plain(float(v[k]), scale):.6g}" for _, v, scale in shown]
            if self._shows_pose:
                cells = [f"{plain(float(v), size):.6g}" for v in sample.pose.position]
                cells += [f"{plain(float(v), 1.0, 5e-6):.5f}" for v in sample.pose.quaternion]
            sigma = sample.smallest_singular_value
            yield [
                f"{sample.parameter:.4g}",
                *cells,
                f"{plain(sigma, 1.0):.3g}" if sigma >= NOTHING else "0",
                f"{sample.residual:.1e}" if sample.residual >= 1e-8 * NOTHING * size else "0",
            ]

    @cached_property
    def _motors_lines(self) -> list[str]:
        """How near a path of poses comes to where the motors no longer tell the pose, at samples:
        it is not what is followed.
        """
        if not self.problem.gives_pose or "type 2" not in self.distances:
            return []
        chosen = self._spread(_MOST_JUDGED)
        roles = roles_followed(self.problem)
        values = [
            classify(self.samples[k].solution, roles=roles).distances.get("type 2", np.inf)
            for k in chosen
        ]
        best = int(np.argmin(values))
        return [
            f"of {len(chosen)} samples the one at {self.samples[chosen[best]].parameter:.4g} of "
            f"the path is nearest to where the motors no "
            f"longer tell the pose: type 2 {plain(values[best]):.3g}; between samples it may be "
            f"less, and no stop is made there"
        ]

    def _nearest_line(self, near: Sample) -> str:
        """How near the path comes to a singularity, between samples too."""
        sigma = plain(near.smallest_singular_value, 1.0)
        distances = ", ".join(
            f"{kind} {plain(value):.3g}" for kind, value in self.distances.items()
        )
        return (
            f"nearest to a singularity at {near.parameter:.9g} of the path: sigma {sigma:.3g}; "
            f"distance: {distances}"
        )
