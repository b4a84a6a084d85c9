"""Where and why a track ends before its path does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.following.block_follower import MOST_EFFORT
from symkin.following.follow import Branch
from symkin.following.joint_limits import Limit
from symkin.following.machine_path import MachinePath
from symkin.following.meeting_modes import Meeting, meeting_modes
from symkin.following.sample import Sample, make_sample
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import SINGULAR_VALUE, SUSPECT_CONDITION
from symkin.position.problem import Problem, build_problem
from symkin.position.transfer import variables_elsewhere
from symkin.result import json_fields, json_value
from symkin.singularities.classification import classify
from symkin.singularities.singular_groups import SingularGroup, singular_groups
from symkin.velocity.roles import Roles, roles_of

_AT_START = 1e-6
"""A singular point found at a smaller parameter than this is that of the start."""
_SINGULAR_TEXT = "the start is singular: modes meet there, and which one to follow is not defined"


@dataclass(frozen=True, eq=False)
class Stop:
    """Where and why a track ended before the path.

    `kind`: turning point, bifurcation, degenerate, limit, open loops, unproved, singular start, no
    start. `row` and `u` are the interval and the share of it, `place` the configuration there,
    `text` a sentence where the stop is no singularity. `type` is what the followed problem loses,
    `kinds` all that `symkin.singularity` names there, `meeting` the modes that meet there; `error`
    bounds the place on its interval (share of it) where that is proved; `blocks` counts the
    independent parts (limbs whose platform pose is given) that stop there together; `groups` are
    the structure groups, of coordinates told by name, that are singular there.
    """

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
    groups: tuple[SingularGroup, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The stop in the JSON of `symkin track`."""
        return {
            **json_fields(self, "kind", "type", "kinds"),
            "row": self.row + 1,
            "share": self.u,
            **json_fields(self, "place", "error"),
            "limit": None if self.limit is None else self.limit.name,
            **json_fields(self, "meeting"),
            **({"blocks": json_value(self.groups)} if self.groups else {}),
            "text": str(self),
        }

    def __str__(self) -> str:
        """Why the track ended, in words."""
        if self.text:
            return self.text
        place = "" if self.place is None else f" at {self.place.parameter:.12g} of the path"
        kinds = ", ".join(self.kinds or ([self.type] if self.type else []))
        named = f"{self.kind} ({kinds})" if kinds else self.kind
        named += f" of {self.blocks} limbs at once" if self.blocks > 1 and not self.groups else ""
        named += f" of {'; '.join(str(group) for group in self.groups)}" if self.groups else ""
        what = {
            "turning point": "the mode ends there",
            "bifurcation": "branches meet there, and which one goes on is not defined",
        }.get(self.kind, "the Jacobian loses rank and the branch is flat there")
        return f"{named}{place}: {what}" + (f"; {self.meeting}" if self.meeting is not None else "")


def stop_of(path: MachinePath, branch: Branch, kept: list[Sample], name_modes: bool) -> Stop | None:
    """Why a branch ends before its path; None where it does not. `kept` are the samples before the
    end.
    """
    if branch.ending == "reached":
        return None
    last, singular = branch.last, branch.ending == "singular" and bool(branch.stopped)
    if singular and path.written.parameter(last.row, last.u) > _AT_START:
        return _singular_stop(path, branch, kept, name_modes)
    last = branch.places[0] if singular else last
    place = make_sample(path, last, kept[-1], branch.way(last.row, last.u))
    reasons = {"singular": "singular start", "open": "open loops"}
    kind = reasons.get(branch.ending, branch.ending)
    text = _why(branch, path.written.mechanism)
    if branch.ending == "unproved" and branch.steps == 0 and place.condition > SUSPECT_CONDITION:
        kind, text = "singular start", _SINGULAR_TEXT
    return Stop(kind, last.row, last.u, place, text, limit=branch.limit)


def _why(branch: Branch, mechanism: Mechanism) -> str:
    unit = mechanism.length_unit
    match branch.ending:
        case "singular":
            return _SINGULAR_TEXT
        case "open":
            left = max(b.stop.residual for b in branch.stopped if b.stop is not None)
            return (
                f"the loops open: a step further {left:.3g} {unit} are left; the mechanism cannot "
                f"take what the path asks"
            )
        case "unproved" if all(b.stop is not None and b.stop.is_spent for b in branch.stopped):
            return (
                f"{MOST_EFFORT} steps, as many as one interval between two samples may take, are "
                f"made, and no singularity is near: give "
                "more samples (--samples N), and the path goes on from here"
            )
        case "unproved":
            return (
                "no further step could be proved, and no singular point was located: a singularity "
                "is very near"
            )
        case _:
            return "" if branch.limit is None else branch.limit.text(mechanism)


def _singular_stop(path: MachinePath, branch: Branch, kept: list[Sample], name_modes: bool) -> Stop:
    problem, last = path.written.problem, branch.last
    stops = [b.stop for b in branch.stopped if b.stop is not None]
    points = [s.singular for s in stops if s.singular is not None]
    folds = [s.fold for s in stops] if branch.suffices else [None]
    place = make_sample(path, last, kept[-1], branch.way(last.row, last.u))
    found = classify(place.solution, roles=roles_followed(problem))
    return Stop(
        kind=next(
            (k for k in ("bifurcation", "degenerate") if any(p.kind == k for p in points)),
            "turning point",
        ),
        row=last.row,
        u=last.u,
        place=place,
        text="",
        type=_type(branch),
        kinds=found.kinds,
        groups=_groups(problem, place),
        meeting=meeting_modes(path, branch) if name_modes else None,
        error=None if None in folds else max(fold.error for fold in folds if fold is not None),
        blocks=len(points),
    )


def _groups(problem: Problem, place: Sample) -> tuple[SingularGroup, ...]:
    """The structure groups of coordinates told by name that are singular at a stop, as `modes`
    numbers them.
    """
    if not problem.by_name:
        return ()
    names = tuple(c.name for c in problem.known_coordinates)
    listed = build_problem(problem.mechanism, names)
    return singular_groups(listed, variables_elsewhere(listed.closure, place.solution))


def roles_followed(problem: Problem) -> Roles:
    """What drives along a path: the coordinates that it tells by name, or the actuated joints."""
    names = [c.name for c in problem.known_coordinates]
    drives = problem.gives_joints or problem.gives_pose
    return roles_of(problem.mechanism, None if drives else names)


def _type(branch: Branch) -> str:
    """Type 2 (direct problem) or type 1 (inverse problem), or passive where neither platform nor
    actuated joints move. Of values by name all others are the output.
    """
    followed = branch.blocks[0].system.problem
    if followed.by_name:
        return "type 1" if followed.gives_pose else "type 2"
    largest = 0.0
    for block in branch.stopped:
        problem, system = block.system.problem, block.system.system
        moving = "pose" if problem.of_joints else "actuated"
        for c, place in zip(system.unknowns, system.slices, strict=True):
            if c.role == moving and block.stop is not None and block.stop.singular is not None:
                largest = max(largest, float(np.max(np.abs(block.stop.singular.null[place]))))
    if largest < SINGULAR_VALUE:
        return "passive"
    return "type 2" if problem.of_joints else "type 1"
