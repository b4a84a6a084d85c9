"""Rank, mobility and reciprocal screws of a mechanism at a closed configuration.

With the closure's rows F(q, x, X) = 0 differentiated, A twist + B rates = 0 for each limb. A wrench of the limb's
constraint system is A^T y for y^T B = 0: it does no work on any twist that the limb's joints, cut ones included, allow.
With the actuated joints locked, only the passive columns of B count.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.branches import Bar, edges_of
from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate, Joint
from symkin.model.limb import RodLimb
from symkin.model.mechanism import MOTIONS, Mechanism, Motion
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.linear_algebra import null_space
from symkin.numeric.rank import Rank
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLEAR_GAP, CLOSED_CONFIGURATION, CLOSURE_TOLERANCE, RANK_TOLERANCE
from symkin.position.loops import Loop, loops_at
from symkin.position.solution import pose_of
from symkin.result import Result, Summary
from symkin.spatial.rotation import conjugate, multiply
from symkin.spatial.screw import tidy_rows

_DIGITS = 1e-5
"""Of the size: loops that leave less at least-squares configurations are closed to the digits of a file; and the share of the
largest singular value below which others are zero to these digits. Files are written with five digits and more."""

_STARTS, _FEW_STARTS, _MANY_FREEDOMS = 8, 2, 40
"""Random steps of each of three lengths; of a graph of many freedoms, whose single steps take long, fewer."""
_BLUR = 30.0
"""Singular values that are zero but for a misfit, over it (a share of the size): what loops are larger than their shortest links."""


@dataclass(frozen=True)
class ToDigits:
    """What holds to the digits of a file: the largest closure error (length unit) of least-squares configurations, and the rank
    there."""

    misfit: float
    rank: int


@dataclass(frozen=True)
class Misfit:
    """How far loops stay open: the largest closure error at the best configuration found, and the loop that has it."""

    length: float
    loop: str


@dataclass(frozen=True, eq=False)
class LimbScrews:
    """Wrenches (force; moment about the base origin), as rows: those that a limb always exerts on the platform, and
    those with its actuated joints locked."""

    limb: str
    constraints: np.ndarray
    locked: np.ndarray

    @property
    def counts(self) -> tuple[int, int]:
        return len(self.constraints), len(self.locked)


@dataclass(frozen=True, eq=False, repr=False)
class Mobility(Result):
    """What the closure's differential says at one closed configuration.

    mobility = freedoms of all coordinates - rank; redundant = rows - rank; of a graph the rows that vanish at every configuration
    count as well. `values` are the closure's variables there;
    `at_reference` says that it is the reference configuration, `reference_rank` is the rank there, None where it is open.
    `platform_constraints` spans the wrenches of all limbs together and `platform_twists` the instantaneous platform motions
    reciprocal to them (rows, base origin). `loops` are those of a graph, `digits` is set where they close only to the digits of the
    file, `misfit` where they do not close at all. `gruebler` is the Gruebler-Kutzbach count, which knows nothing of geometry and
    counts idle freedoms.

    >>> import symkin
    >>> found = symkin.mobility(symkin.load("zhao2000_links"))
    >>> [limb.counts for limb in found.limbs], len(found.platform_constraints)
    ([(1, 2), (1, 2), (1, 2), (0, 1)], 2)
    """

    closure: Closure
    values: np.ndarray
    at_reference: bool
    closed: bool
    freedoms: int
    rows: int
    rank: Rank
    direct_rank: Rank
    limbs: tuple[LimbScrews, ...]
    platform_constraints: np.ndarray
    platform_twists: np.ndarray
    gruebler: int
    reference_rank: Rank | None = None
    loops: tuple[Loop, ...] = ()
    digits: ToDigits | None = None
    misfit: Misfit | None = None

    @property
    def mobility(self) -> int:
        """Freedoms that the loops leave."""
        return self.freedoms - self.rank.value

    @property
    def redundant(self) -> int:
        """Rows of the closure that the others imply."""
        return self.rows - self.rank.value

    @property
    def actuated(self) -> int:
        """Count of actuated joints."""
        return len(self.closure.mechanism.actuated)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is doubtful: an unclear rank, actuated joints that are not as many as the mobility or do not decide it."""
        found = [*self._closing]
        if self.rank.gap < CLEAR_GAP:
            found.append(f"the rank is not clear, the singular values beside the cut differ by only {self.rank.gap:.3g}")
        if self.misfit is not None:
            return tuple(found)
        mobility = self.mobility if self.digits is None else self.freedoms - self.digits.rank
        if self.actuated != mobility:
            more = "some motion stays free" if self.actuated < mobility else "the inputs cannot be chosen freely"
            found.append(
                f"{self.actuated} actuated joint{'' if self.actuated == 1 else 's'} for a mobility of {mobility}: {more}"
            )
        elif self.digits is None and self.direct_rank.value < self.freedoms - self.actuated:
            found.append("the actuated joints do not determine the configuration, although their number is the mobility")
        return tuple(found)

    @property
    def is_graph(self) -> bool:
        """Whether the mechanism is a graph of links."""
        return self.closure.mechanism.is_graph

    @property
    def _closing(self) -> tuple[str, ...]:
        """What is said of loops that do not close, or not exactly."""
        unit = self.closure.mechanism.length_unit
        if self.misfit is not None:
            return (
                f"no configuration closes the loops: the best one found leaves {self.misfit.length:.3g} {unit}, most of it in the loop "
                f"of {self.misfit.loop}; what is said here holds at the open reference",
            )
        if self.digits is None:
            return ()
        rank = self.digits.rank
        where, exactly = ("away from the reference ", f"; exactly, it is {self.mobility}") if self.closed else ("", "")
        return (
            f"{where}the loops close only to the digits of the file: least-squares configurations leave {self.digits.misfit:.1e} "
            f"{unit}; to these digits the mobility is {self.freedoms - rank}, with {self.rows - rank} redundant constraints{exactly}",
        )

    def summary(self, most_rows: int | None = None) -> Summary:
        """Mobility and redundant constraints, then the count of constraint wrenches that each limb exerts."""
        name, where = self.closure.mechanism.name, "" if self.closed else " (no closed configuration was found)"
        above = [
            f"{name}: mobility {self.mobility} = {self.freedoms} freedoms of the coordinates - rank {self.rank.value} of "
            f"{self.rows} rows; redundant constraints: {self.redundant}{where}"
        ]
        if self.is_graph:
            cells = [[loop.name, str(loop.rows), str(loop.rank), str(loop.redundant)] for loop in self.loops]
            below = [f"warning: {warning}" for warning in self.warnings]
            return Summary(above, ["loop", "rows", "rank", "redundant"], cells[:most_rows], below)
        rows = [[limb.limb, *map(str, limb.counts)] for limb in self.limbs]
        rows.append(["platform", str(len(self.platform_constraints)), ""])
        header = ["limb", "constraint wrenches", "with actuated joints locked"]
        return Summary(above, header, rows[:most_rows], [f"warning: {warning}" for warning in self.warnings])

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of `symkin show --json`; wrenches are (force; moment), twists (angular velocity; velocity), about the
        base origin."""
        mechanism, reference = self.closure.mechanism, self.reference_rank
        links, joints, _ = _counts(mechanism)
        described = {
            "mechanism": mechanism.name,
            "length_unit": mechanism.length_unit,
            "angle_unit": mechanism.angle_unit,
            "links": links,
            "joints": joints,
            "loops": joints - links + 1,
            "rows": self.rows,
            "rank": None if reference is None else reference.value,
            "mobility": None if reference is None else self.freedoms - reference.value,
            "redundant": None if reference is None else self.rows - reference.value,
            "generic": {"rank": self.rank.value, "mobility": self.mobility, "redundant": self.redundant, "closed": self.closed},
            "gruebler": self.gruebler,
            "actuated": [c.name for c in mechanism.actuated],
            "limbs": [
                {"name": limb.limb, "constraints": limb.constraints.tolist(), "locked": limb.locked.tolist()}
                for limb in self.limbs
            ],
            "platform_constraints": self.platform_constraints.tolist(),
            "platform_twists": self.platform_twists.tolist(),
            "screws_at_reference": self.at_reference,
            "notes": list(self.warnings),
        }
        return described | (self._of_graph() if self.is_graph else {})

    def _of_graph(self) -> dict[str, Any]:
        """What the JSON object of a graph has beside that of limbs."""
        closure = self.closure
        unknown = [c.name for c in closure.coordinates if c.role != "actuated"]
        return {
            "rods": len(closure.mechanism.link_rods),
            "couplings": len(closure.mechanism.couplings),
            "each_loop": [
                {
                    "joints": list(loop.joints), "links": list(loop.links), "rows": loop.rows, "rank": loop.rank,
                    "redundant": loop.redundant,
                }
                for loop in self.loops
            ],
            "unknowns": unknown,
            "idle": list(closure.idle),
            "misfit": None if self.misfit is None else self.misfit.length,
            "to_digits": None
            if self.digits is None
            else {"misfit": self.digits.misfit, "rank": self.digits.rank, "mobility": self.freedoms - self.digits.rank},
        }  # fmt: skip


def mobility(mechanism: Mechanism, *, seed: int = 0) -> Mobility:
    """Count the freedoms of a mechanism: rank of the closure at generic closed configurations near its reference.

    mobility = freedoms of all coordinates - rank of dF / d(q, x, X) (the singular values below 1e-8 of the largest count as
    zero). Constraint wrenches of the limbs and the platform's twists, reciprocal to them, are those at the reference where its
    rank is the generic one, else at a configuration beside it. `seed` is that of the random steps off the reference. Raises
    MechanismError for what is no Mechanism. Screws: Hunt, Kinematic Geometry of Mechanisms, 1978.

    >>> import symkin
    >>> found = symkin.mobility(symkin.load("zhao2000"))
    >>> found.mobility, found.redundant, found.gruebler
    (4, 0, 1)
    """
    if mechanism.is_graph:
        return _mobility_of_graph(mechanism, seed)
    closure = build_closure(mechanism)
    system = whole_system(closure)
    nothing = np.zeros(0)
    candidates = closed_configurations(closure, seed)
    ranks = [Rank.of(system.linearise_one(z, nothing)[1]) for z in candidates]
    best = max(range(len(ranks)), key=lambda k: ranks[k].value)
    generic = ranks[best]
    reference = closure.reference
    limbs, values = _limb_screws(closure, candidates[best]), candidates[best]
    is_closed = system.residual(reference, nothing) <= CLOSURE_TOLERANCE * closure.characteristic_length
    reference_rank = Rank.of(system.linearise_one(reference, nothing)[1]) if is_closed else None
    at_reference = reference_rank is not None and reference_rank.value == generic.value
    if at_reference:
        there = _limb_screws(closure, reference)
        at_reference = [s.counts for s in there] == [s.counts for s in limbs]
        limbs, values = (there, reference) if at_reference else (limbs, values)
    constraints = _row_space(np.vstack([limb.constraints for limb in limbs]), closure.characteristic_length)
    jacobian = system.linearise_one(candidates[best], nothing)[1]
    unknown = [k for k, c in enumerate(_per_freedom(closure.coordinates)) if c.role != "actuated"]
    return Mobility(
        closure=closure,
        values=values,
        at_reference=at_reference,
        closed=system.residual(values, nothing) <= CLOSURE_TOLERANCE * closure.characteristic_length,
        freedoms=system.freedom,
        rows=int(closure.rows.shape[0]),
        rank=generic,
        direct_rank=Rank.of(jacobian[:, unknown]),
        limbs=limbs,
        platform_constraints=constraints,
        platform_twists=_row_space(reciprocal_system(constraints, closure.characteristic_length), closure.characteristic_length)
        if len(constraints)
        else np.eye(6),
        gruebler=gruebler_kutzbach(mechanism),
        reference_rank=reference_rank,
    )


@lru_cache(maxsize=64)
def open_loops_note(mechanism: Mechanism) -> str | None:
    """What is said of a graph that has no solution, whatever is given: how far its loops stay open, and which; else None."""
    if not mechanism.is_graph:
        return None
    closure = build_closure(mechanism)
    size = closure.characteristic_length
    if whole_system(closure).residual(closure.reference, np.zeros(0)) <= CLOSURE_TOLERANCE * size:
        return None
    misfit = mobility(mechanism).misfit
    if misfit is None:
        return None
    return (
        f"no configuration closes the loops, whatever is given: the best one found leaves {misfit.length:.3g} {mechanism.length_unit}, "
        f"most of it in the loop of {misfit.loop}; check its lengths and couplings"
    )


def _mobility_of_graph(mechanism: Mechanism, seed: int) -> Mobility:
    closure = build_closure(mechanism)
    system, nothing, size = whole_system(closure), np.zeros(0), closure.characteristic_length
    reference = closure.reference
    is_closed = system.residual(reference, nothing) <= CLOSURE_TOLERANCE * size
    ends = _least_squares_ends(closure, seed)
    misfits = system.residuals(ends, nothing)
    candidates = [*ends[misfits <= CLOSED_CONFIGURATION * size]] or [reference]
    ranks = [Rank.of(system.linearise_one(z, nothing)[1]) for z in candidates]
    best = max(range(len(ranks)), key=lambda k: ranks[k].value)
    generic, values = ranks[best], candidates[best]
    reference_rank = Rank.of(system.linearise_one(reference, nothing)[1]) if is_closed else None
    at_reference = reference_rank is not None and reference_rank.value == generic.value
    values = reference if at_reference else values
    closed = is_closed or bool((misfits <= CLOSED_CONFIGURATION * size).any())
    digits = _to_digits(system, ends, misfits, generic.value if closed else None)
    if not closed and digits is not None:
        values = ends[int(np.argmin(misfits))]
    jacobian = system.linearise_one(values, nothing)[1]
    unknown = [k for k, c in enumerate(_per_freedom(closure.coordinates)) if c.role != "actuated"]
    twists = _platform_twists(closure, system, values) if mechanism.platform_link is not None else np.zeros((0, 6))
    wrenches = reciprocal_system(twists, size) if len(twists) else np.eye(6)
    return Mobility(
        closure=closure,
        values=values,
        at_reference=at_reference,
        closed=closed,
        freedoms=system.freedom,
        rows=int(closure.rows.shape[0]) + closure.vanishing,
        rank=generic,
        direct_rank=Rank.of(jacobian[:, unknown]),
        limbs=(),
        platform_constraints=_row_space(wrenches, size) if mechanism.platform_link is not None else np.zeros((0, 6)),
        platform_twists=twists,
        gruebler=gruebler_kutzbach(mechanism),
        reference_rank=reference_rank,
        loops=loops_at(closure, values, RANK_TOLERANCE if digits is None else _DIGITS),
        digits=digits,
        misfit=None if closed or digits is not None else _misfit(closure, system, ends, misfits),
    )


def _to_digits(system: System, ends: np.ndarray, misfits: np.ndarray, rank: int | None) -> ToDigits | None:
    """What holds at ends that close the loops only to the digits of a file, where more moves there than exactly (`rank`), or where
    nothing closes exactly."""
    size = system.characteristic_length
    near = np.flatnonzero((misfits > CLOSED_CONFIGURATION * size) & (misfits <= _DIGITS * size))
    if not near.size:
        return None
    _, jacobians = system.linearise(ends[near], np.zeros(0))
    values = np.linalg.svd(jacobians, compute_uv=False)
    zero = np.maximum(_DIGITS, _BLUR * misfits[near] / size)[:, None] * values[:, :1]
    found = int(np.median(np.sum(values > zero, axis=1)))
    return ToDigits(float(misfits[near].max()), found) if rank is None or found < rank else None


def _misfit(closure: Closure, system: System, ends: np.ndarray, misfits: np.ndarray) -> Misfit:
    """The least of the misfits, and the smallest loop through the joint or rod whose row has most of it."""
    points = np.vstack([closure.reference, ends])
    errors = np.concatenate([system.residuals(closure.reference[None], np.zeros(0)), misfits])
    best = int(np.argmin(errors))
    rows, _ = system.linearise_one(points[best], np.zeros(0))
    worst = closure.row_sources[int(np.argmax(np.abs(rows)))].limb
    loops = [loop for loop in loops_at(closure, points[best]) if worst in loop.joints]
    return Misfit(float(errors[best]), min(loops, key=lambda loop: len(loop.joints)).name if loops else worst)


def _platform_twists(closure: Closure, system: System, values: np.ndarray) -> np.ndarray:
    """Twists (angular velocity; velocity at the base origin) of the platform link that the closed loops leave, as rows."""
    free = null_space(system.linearise_one(values, np.zeros(0))[1], RANK_TOLERANCE, relative=True)
    pose = ca.vertcat(closure.pose.position, closure.pose.quaternion)
    rates = ca.mtimes(ca.jacobian(closure.bound(pose), closure.variables), system.tangent)
    evaluate = ca.Function("platform", [closure.variables], [closure.bound(pose), rates])
    at, moved = (np.asarray(part) for part in evaluate(values))
    moved = moved @ free.T
    position, quaternion = at[:3, 0], at[3:, 0]
    twists = []
    for rate in moved.T:
        angular = 2.0 * np.asarray(multiply(rate[3:], conjugate(quaternion)))[1:]
        twists.append(np.concatenate([angular, rate[:3] - np.cross(angular, position)]))
    size = closure.characteristic_length
    return _row_space(np.array(twists), size) if twists else np.zeros((0, 6))


def fewer_rows(found: Mobility) -> tuple[Motion, int] | None:
    """The motion of a platform declared spatial that the joints leave it anyway and that removes most redundant rows, with
    the number of those left; None where there is none. Declared, it changes no solution of the same assembly."""
    mechanism = found.closure.mechanism
    if mechanism.serial or mechanism.is_graph or mechanism.motion != "spatial" or not found.redundant or not found.closed:
        return None
    restricted = [(m, mobility(replace(mechanism, motion=m))) for m in MOTIONS if m != "spatial"]
    kept = [(m, other.redundant) for m, other in restricted if other.closed and other.mobility == found.mobility]
    best = min(kept, key=lambda pair: pair[1], default=None)
    return best if best is not None and best[1] < found.redundant else None


def implied_motion(mechanism: Mechanism) -> Motion | None:
    """The motion of a platform declared spatial that its joints leave it anyway, each pose coordinate free: declared, no pose has
    to satisfy conditions. None where there is none, so that what moves is no group of motions, or tied within one."""
    if mechanism.serial or mechanism.is_graph or mechanism.motion != "spatial":
        return None
    spatial = mobility(mechanism)
    for motion in MOTIONS:
        restricted = mechanism if motion == "spatial" else replace(mechanism, motion=motion)
        coordinates = sum(c.freedom for c in build_closure(restricted).role("pose"))
        if motion == "spatial" or coordinates != spatial.mobility:
            continue
        found = mobility(restricted)
        if found.closed and found.mobility == spatial.mobility:
            return motion
    return None


def whole_system(closure: Closure) -> System:
    """The closure with every coordinate unknown."""
    rows, errors = closure.bound(closure.rows), closure.bound(closure.errors)
    return System(closure.coordinates, closure.variables, ca.SX(0, 1), rows, errors, closure.characteristic_length)


def gruebler_kutzbach(mechanism: Mechanism) -> int:
    """6 (n - g - 1) + sum f over links n, joints g and their freedoms f."""
    links, joints, freedoms = _counts(mechanism)
    return 6 * (links - joints - 1) + freedoms


def _counts(mechanism: Mechanism) -> tuple[int, int, int]:
    """Links, joints, and the freedoms of the joints; of a graph a rod is one joint, of five freedoms, and a coupling takes one."""
    if mechanism.is_graph:
        return _counts_of_graph(mechanism)
    links, joints, freedoms = 2, 0, 0
    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            links, joints, freedoms = links + 2, joints + 3, freedoms + (7 if limb.type == "SPS" else 6)
            continue
        links += len(limb.joints) - 1 + (1 + len(limb.rods) if limb.rods else 0)
        joints += len(limb.joints) + 2 * len(limb.rods)
        freedoms += sum(joint.freedom for joint in limb.joints) + 6 * len(limb.rods)
    return links, joints, freedoms


def _counts_of_graph(mechanism: Mechanism) -> tuple[int, int, int]:
    parts = [(edge.ends, edge.elements[0].part) for edge in edges_of(mechanism)]
    links = {link for ends, _ in parts for link in ends}
    bars = [part for _, part in parts if isinstance(part, Bar)]
    freedoms = sum(part.freedom for _, part in parts if isinstance(part, Joint))
    # a rod takes the distance of its ends; one whose length is a coordinate takes nothing
    freedoms += sum(5 if bar.coordinate is None else 6 for bar in bars) - len(mechanism.couplings)
    return len(links), len(parts), freedoms


def closed_configurations(closure: Closure, seed: int) -> list[np.ndarray]:
    """Closed configurations from random steps off the reference; the reference itself where none closes."""
    system, nothing = whole_system(closure), np.zeros(0)
    ends = _least_squares_ends(closure, seed)
    closed = list(ends[system.residuals(ends, nothing) <= CLOSED_CONFIGURATION * closure.characteristic_length])
    return closed or [closure.reference]


def _least_squares_ends(closure: Closure, seed: int) -> np.ndarray:
    """Where least squares from random steps off the reference end: closed configurations (n, width), and for graphs those that are
    closed to the digits of a file, or to none."""
    system = whole_system(closure)
    rng = np.random.default_rng(seed)
    each = _FEW_STARTS if closure.mechanism.is_graph and system.freedom > _MANY_FREEDOMS else _STARTS
    begin = np.tile(closure.reference, (3 * each, 1))
    radii = np.repeat([0.03, 0.1, 0.3], each)[:, None] * closure.characteristic_length
    starts = system.move(begin, radii * rng.normal(size=(3 * each, system.freedom)))
    nothing = np.zeros(0)
    batch = levenberg_marquardt(system, starts, nothing, max_iterations=200)
    kept = batch.points if closure.mechanism.is_graph else batch.points[batch.converged]
    return system.polish_many(kept, nothing).points


def _per_freedom(coordinates: tuple[Coordinate, ...]) -> list[Coordinate]:
    return [c for c in coordinates for _ in range(c.freedom)]


def _limb_screws(closure: Closure, values: np.ndarray) -> tuple[LimbScrews, ...]:
    """Constraint wrenches of each limb against a free platform, whatever motion is declared."""
    spatial = build_closure(replace(closure.mechanism, motion="spatial"))
    system = whole_system(spatial)
    z = _with_free_platform(closure, spatial, values)
    _, jacobian = system.linearise_one(z, np.zeros(0))
    columns = _per_freedom(spatial.coordinates)
    joints = [k for k, c in enumerate(columns) if c.role != "pose"]
    passive = [k for k, c in enumerate(columns) if c.role == "passive"]
    position = z[spatial.slices["pose.x"].start :][:3]
    screws = []
    for limb in closure.mechanism.limbs:
        rows = [k for k, row in enumerate(spatial.row_sources) if row.limb == limb.name]
        twist_rows = jacobian[rows][:, [k for k, c in enumerate(columns) if c.role == "pose"]]
        systems = []
        for kept in (joints, passive):
            wrenches = null_space(jacobian[np.ix_(rows, kept)].T, RANK_TOLERANCE, relative=True) @ twist_rows
            systems.append(
                _row_space(_at_base_origin(wrenches, position, closure.characteristic_length), closure.characteristic_length)
            )
        screws.append(LimbScrews(limb.name, systems[0], systems[1]))
    return tuple(screws)


def _with_free_platform(closure: Closure, spatial: Closure, values: np.ndarray) -> np.ndarray:
    pose = pose_of(closure, values)
    z = spatial.reference.copy()
    for c in spatial.coordinates:
        if c.role != "pose":
            z[spatial.slices[c.name]] = values[closure.slices[c.name]]
    z[spatial.slices["pose.x"].start :][:7] = np.concatenate([pose.position, pose.quaternion])
    return z


def _at_base_origin(wrenches: np.ndarray, position: np.ndarray, size: float) -> np.ndarray:
    """From (force, moment / size about the platform origin) to (force; moment about the base origin)."""
    force, moment = wrenches[:, :3], size * wrenches[:, 3:]
    return np.hstack([force, moment + np.cross(position, force)])


def reciprocal_system(screws: np.ndarray, size: float = 1.0) -> np.ndarray:
    """Basis (rows) of the screws reciprocal to every row of `screws`; moments are weighed by the length `size`."""
    weights = np.array([1.0, 1.0, 1.0, 1 / size, 1 / size, 1 / size])
    scaled = np.atleast_2d(screws) * weights
    swapped = np.hstack([scaled[:, 3:], scaled[:, :3]])
    return np.asarray(tidy_rows(null_space(swapped, RANK_TOLERANCE, relative=True)) / weights)


def _row_space(wrenches: np.ndarray, size: float) -> np.ndarray:
    """A readable basis of the span of wrenches: unit forces, and unit couples where there is no force. Moments are
    weighed by the size in judging rank."""
    weights = np.array([1.0, 1.0, 1.0, 1 / size, 1 / size, 1 / size])
    scaled = wrenches * weights
    rank = Rank.of(scaled).value
    if rank == 0:
        return np.zeros((0, 6))
    _, _, right = np.linalg.svd(scaled)
    rows = tidy_rows(right[:rank]) / weights
    forces, moments = np.linalg.norm(rows[:, :3], axis=1), np.linalg.norm(rows[:, 3:], axis=1)
    return np.asarray(rows / np.where(forces > 1e-9, forces, moments)[:, None])
