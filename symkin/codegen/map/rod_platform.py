"""Describe a platform on six rods for code generation: its options, geometry, kernel and poses
about home.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.signature import LINE, PLATFORM, PLATFORM_SPEEDS, Function
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.newton_kernel import Kernel, sampled
from symkin.codegen.steps.rod_kernel import Rods, rod_geometry, rod_kernel
from symkin.codegen.text.c import Real, indexed
from symkin.codegen.text.templates import fill
from symkin.computed_once import cached_property
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply


@dataclass(frozen=True, eq=False)
class RodGeometry(Geometry):
    """Numbers of six rods, limb by limb: base, platform, offset."""

    @cached_property
    def symbols(self) -> ca.SX:
        return ca.SX.sym("g", 42) if self.at_run_time else ca.SX(0, 1)

    @property
    def rows(self) -> np.ndarray:
        """Nominal numbers of each rod (6, 7)."""
        bars = self.closure.mechanism.bars
        return np.array([[*bar.start.point, *bar.end.point, bar.offset] for bar in bars])

    @property
    def values(self) -> np.ndarray:
        return self.rows.ravel() if self.at_run_time else np.zeros(0)

    @cached_property
    def members(self) -> list[str]:
        if not self.at_run_time:
            return []
        parts = (("base[{}]", 3), ("platform[{}]", 3))
        return [
            text
            for k in range(6)
            for part, count in parts
            for text in (*indexed(part.format(k), count), *[f"offset[{k}]"] * (part[0] == "p"))
        ]

    def check(self, real: Real) -> None:
        """Nothing to refuse: numbers in the code would be as coarse."""

    def declaration(self, name: str, real: Real) -> str:
        rows = self.rows
        base, ends = (
            ", ".join(f"{{ {', '.join(map(real.literal, row))} }}" for row in part.tolist())
            for part in (rows[:, :3], rows[:, 3:6])
        )
        offsets = ", ".join(map(real.literal, rows[:, 6].tolist()))
        own = {"p": name, "P": name.upper(), "base": base, "ends": ends, "offsets": offsets}
        return fill("rod_geometry.h", {**own, "largest": self.largest})


@dataclass(frozen=True, eq=False, kw_only=True)
class RodPlatform(LimbPlatform):
    """A platform on six rods with its options: a Newton iteration of its own, without trigonometry,
    about a home; its limbs are explicit.
    """

    home: Pose

    can_be_compact = True
    is_closed = False
    core = None
    direct_formulas = None
    blocks = ()

    def check(self) -> None:
        """Nothing to refuse: `home_pose` has refused homes at which no solver could work."""

    @cached_property
    def geometry(self) -> RodGeometry:
        return RodGeometry(self.closure, self.options.geometry == "struct")

    @property
    def has_limits(self) -> bool:
        """Whether a joint has limits, which are checked along lines too."""
        return any(c.limits is not None for c in self.actuated)

    @cached_property
    def rods(self) -> Rods:
        """The rods over the geometry's symbols, or as numbers."""
        symbols = self.geometry.symbols if self.geometry.at_run_time else None
        return rod_geometry(
            self.mechanism, self.home, relative=self.options.home_relative, parameters=symbols
        )

    @cached_property
    def direct_kernel(self) -> Kernel:
        return rod_kernel(self.mechanism, self.rods, self.geometry.symbols, self.home)

    @cached_property
    def sampled_direct(self) -> tuple[np.ndarray, float]:
        """Matrices at poses within a seventh of the size and 0.3 rad of home, and kappa there."""
        size = self.size
        states = [self.stated(pose) for pose in sample_poses(self.home, 100, size / 7, 0.3, 1)]
        known = [np.zeros(6)] * len(states)
        return sampled(self.direct_kernel, states, known, self.geometry.values)

    @property
    def middle(self) -> np.ndarray:
        return np.asarray(self.home.position)

    def lengths(self, pose: Pose) -> np.ndarray:
        """Joint values at an absolute pose (length unit)."""
        return rod_values(self.mechanism, pose)

    def stated(self, pose: Pose) -> np.ndarray:
        """The seven numbers by which generated code knows a pose: the pose, or its change from
        home.
        """
        if not self.options.home_relative:
            return np.array([*pose.position, *pose.quaternion])
        turn = multiply(pose.quaternion, conjugate(self.home.quaternion))
        return np.array([*(np.asarray(pose.position) - self.home.position), *turn])

    def joint_values(self, pose: Pose) -> np.ndarray:
        """Joint values as generated code takes them."""
        return self.lengths(pose) - self.zero

    @property
    def functions(self) -> tuple[Function, ...]:
        return (*PLATFORM, *([LINE] if self.has_limits else []), *PLATFORM_SPEEDS)

    @property
    def about_values(self) -> list[str]:
        if not self.options.home_relative:
            return []
        home = ", ".join(f"{float(v):.6g}" for v in (*self.home.position, *self.home.quaternion))
        return [
            "Joint values and positions are changes from home, orientations turns from home's (R "
            "= R_turn R_home), in base",
            f"axes. Home: {home}.",
        ]

    @property
    def zero(self) -> np.ndarray | float:
        return self.lengths(self.home) if self.options.home_relative else 0.0

    @property
    def home_values(self) -> np.ndarray:
        """All variables of the closure at home."""
        return np.concatenate([self.lengths(self.home), self.home.position, self.home.quaternion])

    def inverse_at(self, numbers: np.ndarray, near: np.ndarray) -> np.ndarray:  # noqa: ARG002 - other platforms begin at `near`
        """Joint values at a pose as stated, by the closed form of rods."""
        place, turn = numbers[:3], numbers[3:] / np.linalg.norm(numbers[3:])
        if self.options.home_relative:
            place, turn = place + self.middle, multiply(turn, np.asarray(self.home.quaternion))
        return self.joint_values(Pose(place, turn))

    @property
    def singular_starts(self) -> np.ndarray:
        """A pose with all six rods in one plane, where base and platform are plane; else
        nothing.
        """
        heights = [abs(bar.start.point[2]) + abs(bar.end.point[2]) for bar in self.mechanism.bars]
        if self.options.home_relative or max(heights) > 0.0:
            return np.zeros((0, 7))
        return np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])


def rod_values(mechanism: Mechanism, pose: Pose) -> np.ndarray:
    """Joint values |p + R a - b| - offset of the rods at a pose (length unit)."""
    rods = [
        pose.apply(np.array(bar.end.point)) - np.array(bar.start.point) for bar in mechanism.bars
    ]
    return np.array(
        [float(np.linalg.norm(d)) - bar.offset for d, bar in zip(rods, mechanism.bars, strict=True)]
    )


def sample_poses(home: Pose, count: int, reach: float, tilt: float, seed: int) -> list[Pose]:
    """Random poses about home: positions within `reach`, rotation vectors within `tilt` (both per
    component).
    """
    rng = np.random.default_rng(seed)
    poses = []
    for _ in range(count):
        shift, c = rng.uniform(-reach, reach, 3), 0.5 * rng.uniform(-tilt, tilt, 3)
        q = multiply(np.array([1.0, *c]), np.asarray(home.quaternion))
        poses.append(Pose(np.asarray(home.position) + shift, q / np.linalg.norm(q)))
    return poses
