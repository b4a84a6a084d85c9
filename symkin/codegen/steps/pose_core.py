"""Find the rows of the direct problem over the pose alone, limb by limb; None where a limb's
passive joints stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.codegen.steps.pose_kernel import PlatformPose, PoseKernel, TiedPoint, pose_kernel
from symkin.elimination.implied_rows import PointRow, pose_rows
from symkin.model.joint import Coordinate
from symkin.numeric.system import System


@dataclass(frozen=True, eq=False)
class PoseCore:
    """The direct problem over the pose alone; the limbs that are left for a given pose, and
    conditions on the pose alone. `steps` are the derivation, a sentence for each row.
    """

    direct: PoseKernel
    limbs: tuple[System, ...]
    conditions: System
    steps: tuple[str, ...]


@dataclass
class _Gathered:
    """Rows so far: planes and spheres of points, and others."""

    pose: PlatformPose
    joints: ca.SX
    actuated: Sequence[Coordinate]
    planes: list[TiedPoint]
    spheres: list[TiedPoint]
    others: list[ca.SX]
    limbs: list[System] = field(default_factory=list)
    conditions: list[ca.SX] = field(default_factory=list)
    steps: list[str] = field(default_factory=list)

    def add_condition(self, row: ca.SX) -> None:
        """A row of the pose alone."""
        found = self.pose.plane(PointRow(row, ca.SX(1), ca.SX(0), is_sphere=False))
        if found is None:
            self.others.append(row)
        else:
            self.planes.append(found)
            self.steps.append(_told(found, []))

    def add_limb(self, system: System, poses: np.ndarray) -> bool:
        """The rows of a limb; whether they are found."""
        if all(c.role == "actuated" for c in system.unknowns):
            self.limbs.append(system)
            return all(self._add_rod(system.rows[i]) for i in range(system.rows.numel()))
        found = pose_rows(system, poses)
        if found is None:
            return False
        planes = [self.pose.plane(row) for row in found if not row.is_sphere]
        self.planes += [plane for plane in planes if plane is not None]
        spheres = [self.pose.sphere(row, self.planes) for row in found if row.is_sphere]
        self.spheres += [sphere for sphere in spheres if sphere is not None]
        if None in planes or None in spheres:
            return False
        gone = [c.name for c in system.unknowns if c.role != "actuated"]
        self.steps += [_told(point, gone) for point in (*planes, *spheres) if point is not None]
        return self._add_reduced(
            system, [self.pose.row(point) for point in (*planes, *spheres) if point is not None]
        )

    def _add_reduced(self, system: System, rows: list[ca.SX]) -> bool:
        """The limb's rows without passive joints as a system: the one that its actuated joint
        enters. Whether there is one.
        """
        own = [row for row in rows if any(ca.which_depends(row, self.joints, 1, False))]
        joints = [k for k, c in enumerate(system.unknowns) if c.role == "actuated"]
        self.conditions += [
            row for row in rows if not any(ca.which_depends(row, self.joints, 1, False))
        ]
        if len(joints) != len(own) or len(own) > 1:
            return False
        if own:
            row, k = own[0], joints[0]
            unknown = system.unknown[system.slices[k]]
            self.limbs.append(
                System(
                    (system.unknowns[k],),
                    unknown,
                    system.known,
                    row,
                    row,
                    system.characteristic_length,
                )
            )
        return True

    def _add_rod(self, row: ca.SX) -> bool:
        found = self.pose.rod(row, self.joints, self.actuated)
        if found is not None:
            self.spheres.append(found)
            self.steps.append(_told(found, []))
        return found is not None


def pose_core(
    closure: Closure,
    blocks: Sequence[System],
    conditions: System,
    poses: np.ndarray,
    actuated: Sequence[Coordinate],
) -> PoseCore | None:
    """The rows of the direct problem over the pose alone: of limbs (`blocks`, systems of a given
    pose) and rows of the pose. None where a limb's passive joints are not taken out, or rows are
    not as many as the platform's freedoms.
    """
    pose = PlatformPose(closure)
    if not pose.is_supported:
        return None
    joints = closure.symbols(actuated)
    gathered = _Gathered(pose, joints, actuated, [], [], [])
    for i in range(conditions.rows.numel()):
        gathered.add_condition(conditions.rows[i])
    if not all(gathered.add_limb(system, poses) for system in blocks):
        return None
    points = [*gathered.spheres, *gathered.planes]
    if len(points) + len(gathered.others) != sum(c.freedom for c in pose.coordinates):
        return None
    reference = np.concatenate([np.asarray(c.reference, dtype=float) for c in actuated])
    alone = ca.vertcat(conditions.rows, *gathered.conditions)
    errors = ca.vertcat(conditions.errors, *gathered.conditions)
    return PoseCore(
        pose_kernel(pose, points, gathered.others, actuated, reference),
        tuple(gathered.limbs),
        System((), ca.SX(0, 1), conditions.known, alone, errors, closure.characteristic_length),
        tuple(gathered.steps),
    )


def _told(point: TiedPoint, gone: Sequence[str]) -> str:
    """What a row says, and which passive joints have been taken out for it."""
    arm = ", ".join(f"{v:.6g}" for v in point.arm)
    of = ", ".join(_text(point.of[i]) for i in range(point.of.numel()))
    free = f"free of {', '.join(gone)}: " if gone else ""
    what = "on a sphere about A" if point.is_sphere else "in a plane of normal n"
    names = ("A", "squared radius") if point.is_sphere else ("n", "level")
    return (
        f"{free}the point a = ({arm}) lies {what}; {names[0]} = ({of}), {names[1]} "
        f"{_text(point.level)}"
    )


def _text(value: ca.SX) -> str:
    return "0" if value.is_zero() else str(value)
