"""What can be chosen about generated code, and the home configuration that it is tuned about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from symkin.errors import InputError
from symkin.firmware.kernel import is_rod_platform
from symkin.model.mechanism import Mechanism
from symkin.position.given import Given, pose_from
from symkin.position.problem import build_problem
from symkin.position.starts import is_singular, off_singularity, start_values
from symkin.spatial.pose import Pose


@dataclass(frozen=True)
class Options:
    """`real`: the C type of numbers. `home_relative`: joint values and positions are changes from home. `geometry`:
    numbers in the code, or a struct that is given with each call. `home`: the platform's pose about which the order
    of pivots is chosen and test poses lie (x, y, z, qw, qx, qy, qz)."""

    real: Literal["float", "double"] = "double"
    home_relative: bool = False
    geometry: Literal["fixed", "struct"] = "fixed"
    home: tuple[float, ...] | None = None

    def check(self, mechanism: Mechanism) -> None:
        if self.home_relative and not is_rod_platform(mechanism):
            raise InputError(f"{mechanism.name}: --home-relative is made for platforms on six rods with a spatial pose")
        if self.home is not None and not is_rod_platform(mechanism):
            raise InputError(f"{mechanism.name}: --home is made for platforms on six rods with a spatial pose")

    @property
    def arguments(self) -> str:
        """The options as on the command line."""
        parts = [f"--real {self.real}"]
        if self.home_relative:
            parts.append("--home-relative")
        if self.geometry != "fixed":
            parts.append(f"--geometry {self.geometry}")
        if self.home is not None:
            parts.append("--home " + ",".join(f"{v:g}" for v in self.home))
        return " ".join(parts)


def home_pose(mechanism: Mechanism, home: Sequence[float] | None) -> Pose:
    """The given home; else the reference; where that is singular the example's start, or a pose one size off."""
    if home is not None:
        return pose_from(home, "home")
    reference = mechanism.reference_pose
    problem = build_problem(mechanism, "direct")
    values = problem.closure.reference
    known = problem.take(values, problem.known_coordinates)
    if not is_singular(problem, problem.take(values, problem.system.unknowns), known):
        return reference
    example = mechanism.example
    if example is not None and example.start is not None and example.joints is not None:
        return pose_from(example.start)
    given = Given("direct", known, {})
    moved = off_singularity(problem, start_values(problem, given, None), known)
    return Pose(np.asarray(moved[-7:-4]), np.asarray(moved[-4:]))
