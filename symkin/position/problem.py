"""A position problem: a partition of the closure's variables into known and unknown.

direct: known q, unknown (x, X); inverse: known X, unknown (q, x); given: any coordinates known, by
name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, build_closure, numbered_rows, random_values
from symkin.closure.partition import POSE_COORDINATES, Partition
from symkin.computed_once import cached_property, lru_cache
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.system import System, constant_rows, split_blocks

if TYPE_CHECKING:
    from symkin.elimination.implied_rows import PointRow
    from symkin.elimination.product_rows import ProductRow

Kind = Literal["direct", "inverse", "given"]
KNOWN: dict[Kind, str] = {"direct": "actuated", "inverse": "pose"}
"""Role of the known coordinates; all others are unknown. Those of a "given" problem have names."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A position problem of one mechanism; values of the known coordinates are bound at each solve.
    `row_places` are the rows of the closure that its system holds, None for all of them; `implied`
    are rows behind these that follow from the closure's.
    """

    closure: Closure
    kind: Kind
    system: System
    known_coordinates: tuple[Coordinate, ...]
    row_places: tuple[int, ...] | None = None
    implied: tuple[PointRow | ProductRow, ...] = ()

    @property
    def by_name(self) -> bool:
        """Whether any coordinates are known, told by their names."""
        return self.kind == "given"

    @property
    def of_joints(self) -> bool:
        """Whether the actuated joints of limbs are known: the direct problem."""
        return self.kind == "direct"

    @property
    def of_pose(self) -> bool:
        """Whether the pose of limbs is known: the inverse problem."""
        return self.kind == "inverse"

    @property
    def mechanism(self) -> Mechanism:
        return self.closure.mechanism

    @property
    def places_of_rows(self) -> tuple[int, ...]:
        """The place in the closure of each row of the system, but for implied ones."""
        return (
            tuple(range(int(self.system.rows.shape[0])))
            if self.row_places is None
            else self.row_places
        )

    @property
    def name(self) -> Kind:
        """The kind as users read it: a problem whose coordinates are told by name is direct where
        these are all actuated joints, inverse where they are the whole pose.
        """
        if not self.by_name or not self.known_coordinates:
            return self.kind
        if all(c.role == "pose" for c in self.known_coordinates):
            return "inverse"
        return (
            "direct"
            if {c.name for c in self.known_coordinates} == {c.name for c in self.mechanism.actuated}
            else "given"
        )

    @cached_property
    def reference_known(self) -> np.ndarray:
        """The known values at the reference."""
        return self.select_values(self.closure.reference, self.known_coordinates)

    @cached_property
    def blocks(self) -> tuple[System, ...]:
        """Independent parts of the system: limbs decouple once the pose is given. A rotation that
        is sought stays with all other unknowns, and the joints of a limb that is not cut stay
        together, as over the complex numbers, where the position belongs to the rotation's
        coordinates and such a limb is cut at another joint.
        """
        return split_blocks(self.system, self._together)

    @cached_property
    def independent(self) -> tuple[Problem, ...]:
        """Its blocks, each a problem of its own, without the rows that no unknown enters."""
        conditions = self.conditions
        if len(self.blocks) == 1 and not (conditions.errors.shape[0] or conditions.rows.shape[0]):
            return (self,)
        return tuple(replace(self, system=block) for block in self.blocks)

    @property
    def _together(self) -> list[set[int]]:
        """Places of unknowns that make one part whatever the rows hold."""
        unknowns = self.system.unknowns
        if self.by_name or any(c.role == "pose" and c.is_rotation for c in unknowns):
            return [set(range(len(unknowns)))]
        whole = {row.limb for row in self.closure.row_sources if row.relation == "frame"}
        owners = {
            c.name: limb.name for limb, joint in self.mechanism.joints for c in joint.coordinates
        }
        return [
            {k for k, c in enumerate(unknowns) if owners.get(c.name) == limb}
            for limb in sorted(whole)
        ]

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
    def _forward(self) -> ca.Function | None:
        """Pose of the platform from the joints alone, where a limb of actuated joints only carries
        it.
        """
        pose = self.closure.forward
        if pose is None:
            return None
        known = self.closure.symbols(self.known_coordinates)
        return ca.Function(
            "forward", [known], [self.closure.bound(ca.vertcat(pose.position, pose.quaternion))]
        )

    @property
    def is_explicit(self) -> bool:
        """The pose is a function of the joints: the direct problem of a serial arm."""
        return (
            self.of_joints and self.closure.forward is not None and not self.closure.role("passive")
        )

    def forward(self, known: np.ndarray) -> np.ndarray | None:
        """(x, y, z, qw, qx, qy, qz) where the pose is a function of the joints, else None."""
        if not self.of_joints or self._forward is None or self.mechanism.motion != "spatial":
            return None
        return np.asarray(self._forward(known)).ravel()

    def select_values(self, values: np.ndarray, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
        """The part of full vectors of variables (..., variables) that belongs to some
        coordinates.
        """
        return np.asarray(values[..., self.places(coordinates)])

    def join_values(self, unknown: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Full vectors of variables (..., variables) from their unknown and known parts."""
        values = np.empty((*unknown.shape[:-1], int(self.closure.variables.shape[0])))
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
        """Pickle as the mechanism and the kind, from which the symbols are built anew."""
        if not self.by_name:
            held = tuple(sorted(self.closure.partition.kept))
            return build_problem, (self.mechanism, self.kind, (), held)
        names = tuple(c.name for c in self.known_coordinates if c.role != "geometry")
        return build_problem, (self.mechanism, self.kind, names, self._held(names))

    def _held(self, names: tuple[str, ...]) -> tuple[str, ...] | None:
        """What the closure holds beside known coordinates of these names; None where the geometry
        is known.
        """
        partition = self.closure.partition
        if partition.geometry:
            return None
        told = {name for name in names if name.startswith("pose.")}
        pose = (
            [f"pose.{name}" for name, _ in POSE_COORDINATES[self.mechanism.motion]]
            if partition.pose and not told
            else []
        )
        held = tuple(
            name
            for name in (*sorted(partition.kept), *partition.pose_conditions, *pose)
            if name not in names
        )
        return held or (None if names else ())


def build_problem(
    mechanism: Mechanism,
    kind: Kind,
    names: tuple[str, ...] = (),
    held: tuple[str, ...] | None = None,
) -> Problem:
    """The problem of a mechanism; built once for each closure and kind, so that problems of one
    closure share its symbols.

    `names` are the known coordinates of a "given" one, in the order of their values; `held` are
    others that the closure must hold, where they tell a start or have limits. Without `names` and
    `held` the geometry is what is known.
    """
    return _problem(build_closure(mechanism, _partition(mechanism, kind, names, held)), kind, names)


@lru_cache(maxsize=128)
def _problem(closure: Closure, kind: Kind, names: tuple[str, ...]) -> Problem:
    if kind in KNOWN:
        known = closure.role(KNOWN[kind])
    else:
        named = {c.name: c for c in closure.coordinates}
        known = tuple(named[name] for name in names) or closure.role("geometry")
    unknowns = tuple(c for c in closure.coordinates if c not in known)
    system = System(
        unknowns,
        closure.symbols(unknowns),
        closure.symbols(known),
        numbered_rows(closure)
        if kind not in KNOWN and not closure.partition.geometry
        else closure.bound(closure.rows),
        closure.bound(closure.errors),
        closure.characteristic_length,
        closure.mechanism.farthest,
    )
    return Problem(closure, kind, system, known)


@lru_cache(maxsize=128)
def _partition(
    mechanism: Mechanism, kind: Kind, names: tuple[str, ...], held: tuple[str, ...] | None
) -> Partition:
    """What the closure must hold for the known coordinates and those that are held beside them."""
    joints = frozenset(c.name for joint in mechanism.all_joints for c in joint.coordinates)
    if kind in KNOWN:
        return Partition(frozenset(held or ()) & joints)
    wanted = (*names, *(held or ()))
    conditions = tuple(name for name in POSE_CONDITIONS if name in wanted and name not in joints)
    whole = any(name.startswith("pose.") for name in wanted)
    geometry = not names and held is None
    return Partition(
        frozenset(wanted) & joints, pose=whole, pose_conditions=conditions, geometry=geometry
    )
