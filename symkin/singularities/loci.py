"""The singularity loci that were found over a plane of two coordinates, as values, text and
dict.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.position.solution import Solution
from symkin.position.varied_pose import angle_meaning, turn_text
from symkin.result import Result, Summary, json_fields
from symkin.singularities.locus import Locus
from symkin.singularities.locus_system import Plane
from symkin.text import counted, plain

MISSING = "some curves were met by one or two starts only: curves may be missing; raise --starts"
"""What is said where some curve was met by few starts, in the text and in the picture."""
NONE_MET = (
    "no curve was met, which does not prove that there is none: curves may be missing; raise "
    "--starts"
)
"""What is said where curves were sought and none was found."""
LOST_OVER_PLANE = "the rank is lost everywhere over this plane; there are no curves"
"""What is said of a kind that every configuration over the plane has."""
_THIN = (
    "thin lines in the picture are parts in other working modes: there a limb's inverse problem "
    "has another solution than in "
    "the configuration"
)


@dataclass(frozen=True, eq=False, repr=False)
class Loci(Result):
    """All curves found over a plane through a configuration; made by `singular_loci`.

    `ranges` are the window's sides in the mechanism's units. `starts` says how many random
    configurations there were and `seed` which; a closed curve that no start reaches is missed.
    `notes` say what the search cannot: that curves may be missing, that a rank is lost all over the
    plane. `plot()` draws the window.

    >>> import symkin
    >>> here = symkin.solve(symkin.load("zhao2000")).solution
    >>> window = [(20.0, 150.0), (1.0, 200.0)]
    >>> found = symkin.singular_loci(here, ("theta1", "op"), ranges=window, starts=10)
    >>> found.units, found.starts
    (('deg', 'mm'), 10)
    """

    plane: Plane
    ranges: tuple[tuple[float, float], ...]
    curves: tuple[Locus, ...]
    starts: int
    seed: int
    notes: tuple[str, ...]

    @property
    def solution(self) -> Solution:
        """The configuration through which the plane goes."""
        return self.plane.solution

    def of(self, kind: str) -> tuple[Locus, ...]:
        """The curves of a kind: "type 1", "type 2" or "passive"."""
        return tuple(curve for curve in self.curves if curve.kind == kind)

    @property
    def units(self) -> tuple[str, ...]:
        """The units of the plane's coordinates."""
        m = self.plane.mechanism
        return tuple(m.unit_of(c) for c in self.plane.coordinates)

    @property
    def angles(self) -> str | None:
        """What the plane's angles mean where it is one of poses; None without any."""
        return angle_meaning(self.plane.names) if self.plane.of_pose else None

    def given(self, point: Sequence[float]) -> dict[str, Any]:
        """The arguments of `symkin.modes`, `symkin.solve` and `symkin.singularity` at a point of
        the plane (mechanism's units).
        """
        return self.plane.given(point)

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `symkin singularities --plane`: the window and, for each curve, kind, limb,
        points and cusps in the mechanism's units.
        """
        return {
            "mechanism": self.plane.mechanism.name,
            "plane": list(self.plane.names),
            **json_fields(self, "units", "ranges", "angles"),
            "configuration": self.solution.to_dict(),
            "curves": [
                {**curve.to_dict(), "loose_ends": curve.loose_ends(self.ranges).tolist()}
                for curve in self.curves
            ],
            **json_fields(self, "starts", "seed", "notes"),
        }

    def summary(self, most_rows: int | None = None) -> Summary:
        """The window, one line for each curve, then what the picture's marks mean, the search and
        its notes.
        """
        window = " and ".join(
            f"{name} {low:g} to {high:g} {unit}"
            for name, (low, high), unit in zip(
                self.plane.names, self.ranges, self.units, strict=True
            )
        )
        lines = [f"{self.plane.mechanism.name}: singularity loci over {window}; {self.held}"]
        lines += [] if self.angles is None else [self.angles]
        lines += [
            f"{k}: {_curve_line(curve, self.ranges)}"
            for k, curve in enumerate(self.curves[:most_rows], start=1)
        ]
        if most_rows is not None and len(self.curves) > most_rows:
            lines.append(f"and {len(self.curves) - most_rows} more")
        lines += [] if self.curves else [self.without_curves]
        lines += (
            [_THIN]
            if any(not curve.in_mode.all() for curve in self.curves if not curve.is_point)
            else []
        )
        what = "curve" if len(self.ranges) == 2 else "point"
        lines.append(
            f"{self.starts} starts, seed {self.seed}; a {what} that no start reaches is not listed"
        )
        notes = (
            self.notes
            if what == "curve"
            else tuple(note.replace("curve", "point") for note in self.notes)
        )
        return Summary([*lines, *(f"note: {note}" for note in notes)])

    @property
    def without_curves(self) -> str:
        """What loci without a curve mean."""
        if any(note.endswith(LOST_OVER_PLANE) for note in self.notes):
            return "every configuration in this window is singular"
        return "no locus was met in this window"

    @property
    def held(self) -> str:
        """What is held, with names and units: the other pose coordinates, actuated joints, or given
        coordinates.
        """
        plane, mechanism = self.plane, self.plane.mechanism
        held = []
        for c in plane.family:
            name = c.name.removeprefix("pose.")
            if c.is_rotation:
                quaternion = ", ".join(f"{plain(float(v)):.4g}" for v in self.solution.quaternion)
                held.append(f"orientation ({quaternion}){turn_text(plane.names)}")
            elif name not in plane.names:
                size = mechanism.characteristic_length
                shown = plain(mechanism.value_out(c, float(plane.value(c)[0])), c.unit(size))
                more = "rz + " if plane.of_pose and name == "gamma" and "rz" in plane.names else ""
                held.append(f"{name} = {more}{shown:.5g} {mechanism.unit_of(c)}")
        return "held: " + ", ".join(held) if held else "nothing else is held"


def _curve_line(curve: Locus, ranges: Sequence[Sequence[float]]) -> str:
    head = curve.kind + (f" of {curve.limb}" if curve.limb else "")
    if len(ranges) == 1:
        return f"{head} at {_place(curve.points[0])}, met by {counted(curve.hits, 'start')}"
    if curve.is_point:
        what = (
            "a motion with both coordinates held"
            if curve.self_motion
            else "curves that nearly touch or cross"
        )
        return f"{head}, {what}, at {_place(curve.points[0])}"
    cusps = "".join(f", cusp at {_place(point)}" for point in curve.cusps)
    ends = "".join(
        f", its tracing ends inside the window at {_place(point)}"
        for point in curve.loose_ends(ranges)
    )
    return (
        f"{head}, {'closed' if curve.closed else 'open'}, {len(curve.points)} points, met by "
        f"{counted(curve.hits, 'start')}{cusps}{ends}"
    )


def _place(point: np.ndarray) -> str:
    numbers = ", ".join(f"{plain(float(x)):.9g}" for x in point)
    return f"({numbers})" if len(point) > 1 else numbers
