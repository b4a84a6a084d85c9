"""Describe a platform on six rods for code generation: its options, geometry, kernel and poses
about home.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from symkin.codegen.newton_kernel import Kernel, sampled
from symkin.codegen.options import Options
from symkin.codegen.rod_kernel import Rods, rod_geometry, rod_kernel
from symkin.codegen.text.c import Real, indexed
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply


@dataclass(frozen=True, eq=False)
class RodPlatform:
    """A platform on six rods with its options: what its C is written from."""

    mechanism: Mechanism
    options: Options
    home: Pose
    real: Real
    templates: ClassVar[str] = "parallel"
    is_redundant: ClassVar[bool] = False
    has_dead_centres: ClassVar[bool] = False
    can_be_compact: ClassVar[bool] = True
    """Whether there is code that --compact makes shorter."""

    @property
    def name(self) -> str:
        return self.mechanism.name

    def check(self) -> None:
        """Nothing to refuse: `home_pose` has refused homes at which no solver could work."""

    @property
    def has_limits(self) -> bool:
        """Whether a joint has limits, which are checked along lines too."""
        return any(c.limits is not None for c in self.mechanism.actuated)

    @property
    def parameters(self) -> ca.SX:
        """Symbols of the geometry struct, limb by limb: base, platform, offset; none where the
        geometry is fixed.
        """
        return ca.SX.sym("g", 42) if self.options.geometry == "struct" else ca.SX(0, 1)

    @property
    def geometry_values(self) -> np.ndarray:
        """The struct's nominal numbers in its order."""
        return np.array(
            [[*bar.start.point, *bar.end.point, bar.offset] for bar in self.mechanism.bars]
        ).ravel()

    @property
    def geometry_names(self) -> list[str]:
        """C text of each symbol of the geometry."""
        if self.options.geometry != "struct":
            return []
        names: list[str] = []
        for k in range(6):
            names += (
                indexed(f"geometry->base[{k}]", 3)
                + indexed(f"geometry->platform[{k}]", 3)
                + [f"geometry->offset[{k}]"]
            )
        return names

    def rods(self, parameters: ca.SX) -> Rods:
        """The rods over the geometry's symbols, or as numbers."""
        symbols = parameters if self.options.geometry == "struct" else None
        return rod_geometry(
            self.mechanism, self.home, relative=self.options.home_relative, parameters=symbols
        )

    def kernel(self) -> Kernel:
        """The Newton iteration of the direct problem."""
        parameters = self.parameters
        return rod_kernel(self.mechanism, self.rods(parameters), parameters, self.home)

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
        return np.asarray(self.lengths(pose) - self.zero)

    @property
    def zero(self) -> np.ndarray | float:
        """Joint values at home, where joints are changes from there."""
        return self.lengths(self.home) if self.options.home_relative else 0.0

    @property
    def home_values(self) -> np.ndarray:
        """All variables of the closure at home."""
        return np.concatenate([self.lengths(self.home), self.home.position, self.home.quaternion])

    def inverse_at(self, numbers: np.ndarray, near: np.ndarray) -> np.ndarray:  # noqa: ARG002 - other platforms begin at `near`
        """Joint values at a pose as stated, by the closed form of rods."""
        pose = Pose(numbers[:3], numbers[3:] / np.linalg.norm(numbers[3:]))
        if self.options.home_relative:
            turned = Pose(np.zeros(3), pose.quaternion) @ Pose(
                np.zeros(3), np.asarray(self.home.quaternion)
            )
            pose = Pose(pose.position + self.home.position, turned.quaternion)
        return self.joint_values(pose)

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


def sampled_about_home(platform: RodPlatform, kernel: Kernel) -> tuple[np.ndarray, float]:
    """Matrices at poses within a seventh of the size and 0.3 rad of home, and kappa there."""
    size = platform.mechanism.characteristic_length
    poses = sample_poses(platform.home, 100, size / 7, 0.3, 1)
    geometry = platform.geometry_values if platform.options.geometry == "struct" else np.zeros(0)
    states = [platform.stated(pose) for pose in poses]
    return sampled(kernel, states, [np.zeros(6)] * len(states), geometry)
