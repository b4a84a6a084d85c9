"""A position problem: a partition of the closure's variables into known and unknown, by the names
of the known ones. Where these are all actuated joints it is direct, where they are the whole pose
inverse, as answers say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, algebraic_rows, build_closure, random_values
from symkin.closure.partition import POSE_COORDINATES, Partition
from symkin.computed_once import cached_property, lru_cache
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.mapped import Mapped
from symkin.numeric.rank import Rank
from symkin.numeric.system import System, constant_rows

if TYPE_CHECKING:
    from symkin.elimination.implied_rows import PointRow
    from symkin.elimination.product_rows import ProductRow

Kind = Literal["direct", "inverse", "given"]
"""What answers call a problem."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A position problem of one mechanism; values of the known coordinates are bound at each solve.
    `by_name`: whether any coordinates are known, not all actuated joints or the pose of limbs.
    `row_places` are the rows of the closure that its system holds; `implied` are rows behind these
    that follow from the closure's.
    """

    closure: Closure
    system: System
    known_coordinates: tuple[Coordinate, ...]
    row_places: tuple[int, ...]
    by_name: bool = True
    implied: tuple[PointRow | ProductRow, ...] = ()

    @property
    def of_joints(self) -> bool:
        """Whether the actuated joints of limbs are known."""
        return self._are_known("actuated")

    @property
    def of_pose(self) -> bool:
        """Whether the pose of limbs is known, all of it: parts may read less, as a flat arm's do of
        its height.
        """
        whole = len(self.known_coordinates) == len(self.closure.role("pose"))
        return whole and self._are_known("pose")

    def _are_known(self, role: str) -> bool:
        return not self.by_name and {c.role for c in self.known_coordinates} == {role}

    @property
    def mechanism(self) -> Mechanism:
        return self.closure.mechanism

    @cached_property
    def gives_pose(self) -> bool:
        """Whether the known coordinates are those of a pose, of limbs or of a graph."""
        return {c.role for c in self.known_coordinates} == {"pose"}

    @cached_property
    def gives_joints(self) -> bool:
        """Whether they are all actuated joints, of limbs or of a graph."""
        known = {c.name for c in self.known_coordinates}
        return known == {*actuated_names(self.mechanism)} != set()

    @property
    def name(self) -> Kind:
        """The kind as users read it."""
        if self.gives_pose:
            return "inverse"
        return "direct" if self.gives_joints else "given"

    @cached_property
    def carries_pose(self) -> bool:
        """Whether joints carry the platform: its pose is no variable."""
        return not self.closure.role("pose")

    @cached_property
    def reference_known(self) -> np.ndarray:
        """The known values at the reference."""
        return self.select_values(self.closure.reference, self.known_coordinates)

    def put_known(self, values: np.ndarray, known: np.ndarray) -> None:
        """Put known values (n, numbers) into full vectors of variables (n, variables). Where
        nothing is given, of a structure, the geometry is.
        """
        values[:, self.known_places] = known if known.shape[1] else self.reference_known

    @cached_property
    def conditions(self) -> System:
        """Rows without unknowns: what the given values alone must satisfy."""
        return constant_rows(self.system)

    @cached_property
    def generic_rank(self) -> int:
        """Rank of the rows' tangent Jacobian at a random point: below `system.freedom`, no solution
        is isolated.
        """
        rng = np.random.default_rng(1)
        ranks = []
        for _ in range(2):
            values = random_values(
                self.closure.coordinates, self.closure.characteristic_length, rng
            )
            _, jacobian = self.system.linearise_one(
                self.select_values(values, self.system.unknowns),
                self.select_values(values, self.known_coordinates),
            )
            ranks.append(Rank.of(jacobian).value)
        return max(ranks)

    @cached_property
    def _forward(self) -> Mapped | None:
        """Pose of the platform from the joints alone, where a limb of actuated joints only carries
        it.
        """
        pose = self.closure.forward
        if pose is None:
            return None
        known = self.closure.symbols(self.known_coordinates)
        told = self.closure.bound(ca.vertcat(pose.position, pose.quaternion))
        return Mapped.of([known], [told])

    @property
    def is_explicit(self) -> bool:
        """The pose is a function of the joints: the direct problem of a serial arm."""
        return (
            self.of_joints and self.closure.forward is not None and not self.closure.role("passive")
        )

    def forward(self, known: np.ndarray) -> np.ndarray | None:
        """(x, y, z, qw, qx, qy, qz) of joints (known,), or (n, 7) of many, (n, known), where these
        tell the pose; else None.
        """
        if not self.of_joints or self._forward is None:
            return None
        found = self._forward(known)[0][:, :, 0]
        return found if known.ndim == 2 else found[0]

    def select_values(self, values: np.ndarray, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
        """The part of full vectors of variables (..., variables) that belongs to some
        coordinates.
        """
        return values[..., self.places(coordinates)]

    def join_values(self, unknown: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Full vectors of variables (..., variables) from their unknown and known parts."""
        values = np.empty((*unknown.shape[:-1], self.closure.variables.shape[0]))
        values[..., self.unknown_places] = unknown
        values[..., self.known_places] = known
        return values

    @cached_property
    def unknown_places(self) -> np.ndarray:
        """Places of the unknowns in a full vector of variables."""
        return self.places(self.system.unknowns)

    @cached_property
    def known_places(self) -> np.ndarray:
        """Places of the known values in a full vector of variables."""
        return self.places(self.known_coordinates)

    def places(self, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
        """Places of the numbers of some coordinates in a full vector of variables."""
        slices = self.closure.slices
        return np.array(
            [i for c in coordinates for i in range(slices[c.name].start, slices[c.name].stop)],
            dtype=int,
        )

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as the mechanism and the names, from which the symbols are built anew."""
        names = tuple(c.name for c in self.known_coordinates if c.role != "geometry")
        if not self.by_name:
            kept = tuple(sorted(self.closure.partition.kept))
            return build_problem, (self.mechanism, names, None, kept)
        return build_problem, (self.mechanism, names, self._held(names))

    def _held(self, names: tuple[str, ...]) -> tuple[str, ...] | None:
        """What the closure holds beside known coordinates of these names; None where the geometry
        is known.
        """
        partition = self.closure.partition
        if partition.geometry:
            return None
        told = any(name.startswith("pose.") for name in names)
        pose = pose_names(self.mechanism) if partition.pose and not told else ()
        held = (*sorted(partition.kept), *partition.pose_conditions, *pose)
        return tuple(name for name in held if name not in names)


def actuated_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the coordinates of all actuated joints, in file order."""
    return tuple(c.name for c in mechanism.actuated)


def pose_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the coordinates of the platform's pose."""
    return _POSE_NAMES[mechanism.motion]


_POSE_NAMES = {
    motion: tuple(f"pose.{name}" for name, _ in coordinates)
    for motion, coordinates in POSE_COORDINATES.items()
}


@lru_cache(maxsize=256)
def are_joints_of_limbs(mechanism: Mechanism, names: tuple[str, ...]) -> bool:
    """Whether known coordinates are all actuated joints of limbs, in any order."""
    return {*names} == {*actuated_names(mechanism)} and are_of_limbs(mechanism, names)


@lru_cache(maxsize=256)
def are_of_limbs(mechanism: Mechanism, names: tuple[str, ...]) -> bool:
    """Whether known coordinates are all actuated joints or the whole pose of limbs."""
    if mechanism.is_graph or not names:
        return False
    whole = names == ("pose",) and all(c.name != "pose" for c in mechanism.coordinates)
    return whole or {*names} in ({*pose_names(mechanism)}, {*actuated_names(mechanism)})


@lru_cache(maxsize=256)
def build_problem(
    mechanism: Mechanism,
    names: tuple[str, ...],
    held: tuple[str, ...] | None = None,
    limited: tuple[str, ...] = (),
) -> Problem:
    """The problem whose known coordinates have these names, in the order of their values; built
    once for each closure and names, so that problems of one closure share its symbols.

    All actuated joints of limbs, or their whole pose, are in the closure's own order, unless some
    are `held`: others, or none, that a closure of names must hold. Without `names` and `held` the
    geometry is what is known. A closure of
    limbs holds joints that are `limited`.
    """
    by_name = held is not None or not are_of_limbs(mechanism, names)
    plain = Partition(frozenset(limited), pose=bool(limited))
    partition = _partition(mechanism, names, held) if by_name else plain
    return _problem(build_closure(mechanism, partition), names, by_name)


@lru_cache(maxsize=128)
def _problem(closure: Closure, names: tuple[str, ...], by_name: bool) -> Problem:
    named = {c.name: c for c in closure.coordinates}
    known = tuple(named[name] for name in (names if by_name else named) if name in names)
    known = known or closure.role("geometry")
    unknowns = tuple(c for c in closure.coordinates if c not in known)
    system = System(
        unknowns,
        closure.symbols(unknowns),
        closure.symbols(known),
        closure.bound(closure.rows) if closure.partition.geometry else algebraic_rows(closure).rows,
        closure.bound(closure.errors),
        closure.characteristic_length,
        closure.mechanism.farthest,
    )
    return Problem(closure, system, known, tuple(range(system.rows.shape[0])), by_name)


@lru_cache(maxsize=128)
def _partition(
    mechanism: Mechanism, names: tuple[str, ...], held: tuple[str, ...] | None
) -> Partition:
    """What the closure must hold for the known coordinates and those that are held beside them."""
    joints = frozenset(c.name for joint in mechanism.all_joints for c in joint.coordinates)
    wanted = (*names, *(held or ()))
    conditions = tuple(name for name in POSE_CONDITIONS if name in wanted and name not in joints)
    whole = any(name.startswith("pose.") for name in wanted)
    geometry = not names and held is None
    return Partition(
        frozenset(wanted) & joints, pose=whole, pose_conditions=conditions, geometry=geometry
    )
