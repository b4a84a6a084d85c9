"""What a track is: its samples, why it ended, and on what ground it is one mode."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.caching import cached_property
from symkin.following.follow import Branch
from symkin.following.joint_limits import Limit
from symkin.following.meeting_modes import Meeting
from symkin.following.trajectory import Trajectory
from symkin.position.problem import Problem
from symkin.position.solution import Solution, make_solution
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class Sample:
    """One configuration of the path. `values` are all variables of the closure, angles and quaternions continuing those
    before; `parameter` runs from 0 to 1; `smallest` is the smallest singular value of the unknowns' Jacobian (angles times the
    size), zero at a singularity; `radius` (length unit) is proved to hold the one exact solution, None where it is not."""

    problem: Problem
    parameter: float
    time: float | None
    values: np.ndarray
    pose: Pose
    residual: float
    condition: float
    smallest: float
    radius: float | None

    @cached_property
    def joints(self) -> dict[str, Any]:
        """Joint coordinates in the mechanism's units, passive ones included."""
        mechanism, closure = self.problem.mechanism, self.problem.closure
        out: dict[str, Any] = {}
        for c in closure.role("actuated", "passive"):
            part = self.values[closure.slices[c.name]]
            scalar = mechanism.angle_out(float(part[0])) if c.is_angular else float(part[0])
            out[c.name] = scalar if c.width == 1 else [float(v) for v in part]
        return out

    @property
    def solution(self) -> Solution:
        """The same configuration as `solve` gives it: angles within half a turn, no certificate."""
        return make_solution(self.problem, self.values)

    @property
    def actuated_values(self) -> list[float]:
        """Actuated joint values in file order and the mechanism's units."""
        return [self.joints[c.name] for c in self.problem.mechanism.actuated]

    @property
    def actuated(self) -> list[float]:
        """Deprecated name of `actuated_values`."""
        return self.actuated_values

    def to_dict(self) -> dict[str, Any]:
        return {
            "parameter": self.parameter,
            "time": self.time,
            "pose": {
                "position": np.asarray(self.pose.position).tolist(),
                "quaternion": np.asarray(self.pose.quaternion).tolist(),
                "matrix": np.asarray(self.pose.rotation).tolist(),
            },
            "joints": self.joints,
            "residual": self.residual,
            "condition": self.condition if math.isfinite(self.condition) else None,
            "smallest_singular_value": self.smallest,
            "radius": self.radius,
        }


@dataclass(frozen=True, eq=False)
class Stop:
    """Where and why a track ended before the path. `kind`: turning point, bifurcation, degenerate, limit, open loops,
    unproved, singular start, no start. `type` is what the followed problem loses, `kinds` all that `singularity` names there;
    `error` bounds the place on its interval (share of it) where that is proved; `blocks` counts the independent parts (limbs
    whose platform pose is given) that stop there together."""

    kind: str
    row: int
    u: float
    place: Sample | None
    text: str
    type: str | None = None
    kinds: tuple[str, ...] = ()
    meeting: Meeting | None = None
    error: float | None = None
    limit: Limit | None = None
    blocks: int = 1

    def to_dict(self) -> dict[str, Any]:
        return {
            "kind": self.kind,
            "type": self.type,
            "kinds": list(self.kinds),
            "row": self.row + 1,
            "share": self.u,
            "place": None if self.place is None else self.place.to_dict(),
            "error": self.error,
            "limit": None if self.limit is None else self.limit.name,
            "meeting": None if self.meeting is None else self.meeting.to_dict(),
            "text": self.text or stop_text(self),
        }


@dataclass(frozen=True, eq=False)
class Track:
    """One mode along a path. `stop` is None where the end was reached. `certified`: ball arithmetic has proved that all samples
    lie on one branch of solutions without a singularity, up to the end or to the turning point that is its first
    singularity, or the pose is a formula of the joints. `ground` says so in words. `followed_to` is the parameter up to which
    steps lead, `steps` their count, of whose tubes images fill at most `tightest`. `nearest` is the place nearest to a singularity
    of the followed problem, between samples too (None where nothing is lost anywhere: the pose is a formula of the joints)."""

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
        """Distances from singularities (see `Singularity.distances`) at `nearest`; empty where there is none."""
        if self.nearest is None:
            return {}
        from symkin.singularities.singularity import classify

        return classify(self.nearest.solution).distances

    @property
    def reached(self) -> bool:
        return self.stop is None

    @property
    def end(self) -> Sample:
        """The last configuration of the track."""
        return self.samples[-1]

    @property
    def statement(self) -> str:
        if self.stop is None:
            return "reached the end of the path on one mode"
        return f"stopped: {self.stop.text or stop_text(self.stop)}"

    def to_dict(self) -> dict[str, Any]:
        trajectory = self.trajectory
        return {
            "mechanism": trajectory.mechanism.name,
            "problem": trajectory.kind,
            "given": {"from": list(trajectory.given[0]), "to": list(trajectory.given[1]), "rows": len(trajectory)},
            "length_unit": trajectory.mechanism.length_unit,
            "angle_unit": trajectory.mechanism.angle_unit,
            "reached": self.reached,
            "statement": self.statement,
            "stop": None if self.stop is None else self.stop.to_dict(),
            "certified": self.certified,
            "ground": self.ground,
            "followed_to": self.followed_to,
            "steps": self.steps,
            "nearest": self._nearest_json(),
            "samples": [sample.to_dict() for sample in self.samples],
            "elapsed_s": self.elapsed_s,
            "notes": list(trajectory.notes),
        }

    def _nearest_json(self) -> dict[str, Any] | None:
        near = self.nearest
        if near is None:
            return None
        return {
            "parameter": near.parameter,
            "time": near.time,
            "smallest_singular_value": near.smallest,
            "distances": self.distances,
        }

    def __str__(self) -> str:
        from symkin.following.track_text import track_text

        return track_text(self)


def ground(branch: Branch, certified: bool, residual: float, length_unit: str) -> str:
    """On what ground the samples of a branch are said to be one mode."""
    steps = f"{branch.steps} step{'s' if branch.steps != 1 else ''}"
    if branch.formula:
        return "proved: the pose is a formula of the joints, one for every input; no steps are needed"
    if certified and not branch.steps:
        return "proved: ball arithmetic shows exactly one solution at the start"
    if certified:
        return f"proved: {steps}, in each of which ball arithmetic shows exactly one solution for every input{_arrived(branch)}"
    if not branch.walks:
        return "checked: nothing was followed"
    if branch.is_square:
        return (
            f"proved up to parameter {branch.followed:.9g} by {steps}, in each of which ball arithmetic shows exactly one "
            "solution for every input; beyond, checked in double precision only"
        )
    rows, unknowns = (sum(n) for n in zip(*((w.system.count, w.system.width) for w in branch.walks), strict=True))
    return (
        f"checked: rows are redundant ({rows} for {unknowns} unknowns; `symkin show` names the motion that removes some, where "
        f"there is one); in each of {steps} ball arithmetic shows at most one "
        f"solution for every input (margin {1 - branch.tightest:.2g}), and the residual, at most {residual:.1e} "
        f"{length_unit}, that there is one" + _left_on_others(branch, length_unit)
    )


def _left_on_others(branch: Branch, length_unit: str) -> str:
    """What is proved of redundant rows at the ends of steps."""
    left = max((walk.left for walk in branch.walks), default=0.0)
    if not branch.steps or not math.isfinite(left):
        return ""
    return (
        "; proved at the end of each step: as many independent rows as unknowns vanish at exactly one point there, and no other "
        f"row is more than {left:.1e} {length_unit} at it"
    )


def _arrived(branch: Branch) -> str:
    if branch.ending != "singular":
        return ""
    return (
        ", and a last one in which it shows that the path parameter grows up to the turning point, which is the first singularity"
    )


def stop_text(stop: Stop) -> str:
    """A singular stop in words."""
    place = "" if stop.place is None else f" at {stop.place.parameter:.12g} of the path"
    kinds = ", ".join(stop.kinds or ([stop.type] if stop.type else []))
    named = f"{stop.kind} ({kinds})" if kinds else stop.kind
    named += f" of {stop.blocks} limbs at once" if stop.blocks > 1 else ""
    match stop.kind:
        case "turning point":
            text = f"{named}{place}: the mode ends there"
        case "bifurcation":
            text = f"{named}{place}: branches meet there, and which one goes on is not defined"
        case _:
            text = f"{named}{place}: the Jacobian loses rank and the branch is flat there"
    if stop.meeting is None:
        return text
    return f"{text}; {_meeting_text(stop.meeting)}"


def _meeting_text(meeting: Meeting) -> str:
    own = "the mode followed" if meeting.own is None else f"mode {meeting.own}"
    listed = f"of the {meeting.count} that `modes` lists at {meeting.parameter:.9g} of the path ({meeting.completeness})"
    if not meeting.others:
        return f"{own} {listed} was followed, and no other one is listed near it"
    *most, last = (str(k) for k in meeting.others)
    others = f"{', '.join(most)} and {last}" if most else last
    signs = {True: ", with determinants of opposite sign", False: ", with determinants of one sign", None: ""}
    plural = len(meeting.others) > 1
    return f"{own} {listed} meets mode{'s' if plural else ''} {others}{signs[None if plural else meeting.opposite_signs]}"
