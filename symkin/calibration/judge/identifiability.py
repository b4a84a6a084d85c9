"""Determine what the readings can tell: rank and null space of the identification Jacobian, named
in parameter terms.

Moving the base frame or the platform frame, stretching everything, shifting a joint's point along
its axis, shifting the offsets of parallel axes: each is a velocity of every parameter of the
mechanism. A direction that lies in the null space of the identification Jacobian is what the
readings cannot tell, and has a name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.data.observables import observables
from symkin.calibration.data.parameters import (
    AXES,
    MEASURING_FRAMES,
    Velocity,
    nominal_parameters,
    vector_values,
    vector_velocity,
    written_freedoms,
)
from symkin.calibration.data.reference_motions import IN_FRAME, moved, reference_motions
from symkin.calibration.estimate.configuration_model import ConfigurationModel
from symkin.calibration.estimate.configurations import newton_configurations, solve_configurations
from symkin.calibration.estimate.joint_lines import NEARLY_PARALLEL, parallel_axes
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.state import (
    UNTOLD,
    WELL_TOLD,
    Linear,
    State,
    error_free_state,
    evaluate,
    spectrum,
    unbound,
)
from symkin.closure.branches import edges_of
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.numeric.linear_algebra import largest_of
from symkin.numeric.rank import independent_rows
from symkin.spatial.rotation import euler_from_quaternion, multiply, rotate

_NULL_SPACE_TOLERANCE = 1e-5
"""A unit direction belongs to the null space when its part outside is shorter than this."""
_SAME_ANGLE = np.radians(2.0)
"""Inclinations or yaws (radians) that spread by less count as one."""
_SPARSE_DRAWS, _LEAST_PIVOT = 60, 0.03
"""Draws of parameters in the search for sparse combinations, and the least part of a unit direction
that a parameter of its own may have.
"""
OPEN_LOOPS = (
    "loops that are redundant close at the postures measured and need not close at others; add "
    "postures"
)
"""What is said of a fit of too few postures."""
_FREE_FRAMES = ("base frame translation", "base frame yaw", "platform frame", "tool frame")
"""Combinations that inclinations never determine."""
_OFF_PLANE = ("translation z", "about x", "about x)", "about y", "about y)")
"""Ends of the names of frames in which a planar mechanism cannot be used."""
_MAX_LISTED_PARAMETERS = 4
"""Most parameters that a combination without a name of its own lists."""
_JOINTS_BESIDE = 0.1
"""How far joints are moved (radians, of the size) to see whether loops close beside the postures
measured, too.
"""
_MAX_BESIDE = 200
"""Most postures beside those measured that are looked at."""
_OPEN_SLOPE = 1e-6
"""Rows left over that a unit step changes by less (length unit) stay closed but for rounding."""


@dataclass(frozen=True, eq=False)
class Identifiability:
    """Rank of the identification Jacobian (residuals over their standard deviations, columns per
    length unit, angles and directions times the size), its singular values and null space (P, k)
    over `names`; `unobservable` names k independent combinations that no reading determines,
    `advice` says what to measure besides. `blind` (P, j) is that part of the null space which no
    reading tells at all, whatever its noise. `weak` names combinations that the readings tell
    hardly better than the prior, each with its standard deviation by the readings over the prior's.
    `opens` says that redundant loops which close at these configurations need
    not close at others: they ask more of the parameters there.
    """

    names: tuple[str, ...]
    singular_values: np.ndarray
    null_space: np.ndarray
    unobservable: tuple[str, ...]
    advice: tuple[str, ...]
    blind: np.ndarray
    weak: tuple[tuple[str, float], ...] = ()
    opens: bool = False

    @cached_property
    def base_set(self) -> tuple[str, ...]:
        """As many parameters as the rank, that the readings determine when the others are held: of
        the null space, by elimination with pivots, the parameters that span it best are left out.
        """
        last_first = range(len(self.names))[::-1]
        dropped = independent_rows(self.null_space, 0.0, groups=[last_first])
        return tuple(n for k, n in enumerate(self.names) if k not in dropped)

    @property
    def rank(self) -> int:
        return len(self.names) - self.null_space.shape[1]

    @property
    def drowned(self) -> np.ndarray:
        """The rest of the null space (P, k - j): told by readings without noise alone."""
        rest = self.null_space - self.blind @ (self.blind.T @ self.null_space)
        left, lengths, _ = np.linalg.svd(rest, full_matrices=False)
        return left[:, lengths > 0.5]

    @property
    def condition(self) -> float:
        """Largest over smallest kept singular value."""
        values = self.singular_values
        return float(values[0] / values[self.rank - 1]) if self.rank else float("inf")


def identifiability(
    mechanism: Mechanism, measurements: Measurements, **options: Any
) -> Identifiability:
    """Determine the identifiability at the nominal geometry, over the configurations whose direct
    problem is solved there; `options` are those of `build_calibration`. Where standard deviations
    are known, what the readings tell ten times worse than the prior (see `estimate.state`) counts
    as not told.
    """
    problem = build_calibration(mechanism, measurements, **options)
    nominal = problem.model.nominal
    configurations = solve_configurations(problem.model, measurements, nominal)
    solved = configurations.solved
    if not solved.any():
        raise InputError(
            f"{mechanism.name}: the direct problem of no posture has a solution at the nominal "
            f"geometry"
        )
    problem = problem.of(solved)
    state = evaluate(problem.by_means, nominal, configurations.z[solved])
    return identifiability_at(problem, state, 1.0 if problem.readings.known else 0.0)


def identifiability_at(problem: CalibrationProblem, state: State, weight: float) -> Identifiability:
    """Determine the identifiability at a state with closed configurations: what the readings
    determine beside a prior of some weight, 0 for none.
    """
    state = error_free_state(problem, state)
    values, blind, null_space, weak = _told(problem, state, weight)
    named, opens = name_null_space(problem, state.p, null_space), _opens_beside(problem, state)
    return Identifiability(
        names=problem.names,
        singular_values=values,
        null_space=null_space,
        blind=blind,
        weak=weak,
        unobservable=named,
        advice=tuple(_advice(problem, state, named, opens=opens)),
        opens=opens,
    )


def told_rank(problem: CalibrationProblem, state: State) -> int:
    """Count what a fit of readings without error would determine beside the prior: directions that
    they tell, and those that redundant loops hold.
    """
    untold = _told(problem, error_free_state(problem, state), 1.0)[2]
    return len(problem.names) - untold.shape[1]


def _told(
    problem: CalibrationProblem, state: State, weight: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[tuple[str, float], ...]]:
    """Return the singular values of the identification Jacobian and its null space, the directions
    (P, k) of which the readings tell nothing beside the prior, and those of which they tell little,
    named.
    """
    values, blind = spectrum(state)
    null_space = blind
    if weight == 0.0:
        return values, blind, null_space, ()
    told = replace(Linear.of(problem, state), weight=weight).told()
    ratios, directions = told.ratios, told.columns
    untold = ratios < UNTOLD
    if untold.sum() > null_space.shape[1]:
        null_space = np.linalg.qr(directions[:, untold])[0]
    little = np.flatnonzero(~untold & (ratios < WELL_TOLD))
    weak = [(_combination(problem.names, directions[:, k]), 1.0 / ratios[k]) for k in little]
    return values, blind, null_space, tuple((text, float(share)) for text, share in weak[::-1])


def _opens_beside(problem: CalibrationProblem, state: State) -> bool:
    """Tell whether redundant loops ask more of the parameters at joints beside those measured. They
    are looked at in the file's geometry, of which they close everywhere.
    """
    model = problem.model
    if state.leftover is None:
        return False
    some = spread_rows(len(state.z), _MAX_BESIDE)
    joints, quaternions = problem.joints[some], problem.quaternions[some]
    size, rng = model.size, np.random.default_rng(0)
    units = np.array([c.unit(size) for c in model.closure.role("actuated")])
    moved = _JOINTS_BESIDE * units * rng.uniform(-1.0, 1.0, joints.shape)

    def left_over(q: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            z, closed = newton_configurations(model, state.z[some], q, model.nominal)
            left = model.evaluate(z, q, model.nominal, quaternions).left_over
        return left[closed].reshape(-1, len(problem.names))

    open_steps = left_over(joints + moved) @ unbound(left_over(joints))
    return bool(largest_of(open_steps) > _OPEN_SLOPE)


def name_null_space(
    problem: CalibrationProblem, p: np.ndarray, null_space: np.ndarray
) -> tuple[str, ...]:
    """Name independent directions that span the null space: single parameters without effect,
    frames and other known motions, then sparse combinations of parameters.
    """
    names, taken = list[str](), np.zeros((len(p), 0))
    alone = zip((f"{name} (no effect)" for name in problem.names), np.eye(len(p)), strict=True)
    sparse = ((_combination(problem.names, v), v) for v in _sparse_directions(null_space))
    known = list(named_motions(problem.model, p))
    mixed = _mixed_frames(problem, known, null_space)
    for name, direction in chain(known, alone, mixed, sparse):
        if taken.shape[1] == null_space.shape[1]:
            break
        outside = direction - null_space @ (null_space.T @ direction)
        fresh = direction - taken @ (taken.T @ direction)
        length = np.linalg.norm(fresh)
        if np.linalg.norm(outside) <= _NULL_SPACE_TOLERANCE and length > 1e-3:
            names.append(name)
            taken = np.column_stack([taken, fresh / length])
    return tuple(names)


def _mixed_frames(
    problem: CalibrationProblem, known: Sequence[tuple[str, np.ndarray]], null_space: np.ndarray
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield motions of base and platform frame, or numbers of an arm's first and last row, each
    with what of the frame between the mechanism and what is measured there makes up for it: as far
    as may be a direction of the null space.
    """
    table, names, moves = problem.mechanism.dh, np.array(problem.names), dict(known)
    sides = [] if table is not None else list(frame_names(problem.mechanism))
    for row, beside in () if table is None else ((1, "world"), (len(table.rows), "target")):
        for own in (f"dh.{row}.{key}" for key in ("theta", "d", "a", "alpha")):
            moves |= {own: 1.0 * (names == own)} if own in problem.names else {}
            sides.append((own, beside, f"{beside} frame with {own}"))
    for text, beside, mixed in sides:
        frame = np.eye(len(names))[:, np.char.startswith(names, f"{beside}.")]
        if text in moves and frame.size:
            both = np.column_stack([frame, moves[text]])
            outside = both - null_space @ (null_space.T @ both)
            made = np.linalg.lstsq(outside[:, :-1], -outside[:, -1], rcond=1e-9)[0]
            direction = both @ np.append(made, 1.0)
            yield mixed, direction / np.linalg.norm(direction)


def _sparse_directions(null_space: np.ndarray) -> list[np.ndarray]:
    """Find unit directions of a space (P, k) with few parameters in each, fewest first: bases in
    which k parameters, drawn again and again, are 1 in one direction and 0 in the others.
    """
    width, count = null_space.shape
    rng, found = np.random.default_rng(0), list[np.ndarray]()
    for _ in range(_SPARSE_DRAWS if count else 0):
        pivots = independent_rows(null_space, _LEAST_PIVOT, groups=rng.permutation(width))
        if len(pivots) == count:
            found.extend((null_space @ np.linalg.inv(null_space[pivots])).T)
    found = [v / np.linalg.norm(v) for v in found]
    return sorted(found, key=lambda v: np.sum(np.abs(v) > 1e-6))


def _combination(names: Sequence[str], direction: np.ndarray) -> str:
    """Write 'dh.2.d - dh.3.d': the largest components, with their weights where they are not
    one.
    """
    order = np.argsort(-np.abs(direction), kind="stable")
    weights = direction / direction[order[0]]
    kept = [k for k in order if abs(weights[k]) > 1e-6]
    text = ""
    for k in kept[:_MAX_LISTED_PARAMETERS]:
        size = "" if abs(abs(weights[k]) - 1) < 1e-4 else f"{abs(weights[k]):.3g} "
        text += f" {'-' if weights[k] < 0 else '+'} {size}{names[k]}"
    more = len(kept) - _MAX_LISTED_PARAMETERS
    return text.removeprefix(" + ") + (f" and {more} more" if more > 0 else "")


# --- advice ---------------------------------------------------------------------------------------


def _advice(
    problem: CalibrationProblem, state: State, unobservable: Sequence[str], *, opens: bool
) -> Iterator[str]:
    """Yield what to measure besides, from what the configurations have in common."""
    if opens:
        yield OPEN_LOOPS
    readings, kinds = problem.readings, {kind for kind, _ in problem.model.columns}
    size = any(text.startswith("size of") for text in unobservable)
    unusual = any(
        not text.startswith(_FREE_FRAMES) and "size of" not in text for text in unobservable
    )
    turns = problem.model.poses(state.z, problem.joints, state.p)[:, 3:].T
    angles = euler_from_quaternion(turns, "xyz").T
    inclinations = angles[readings.first, :2]
    if unusual and readings.groups and np.all(np.ptp(inclinations, axis=0) < _SAME_ANGLE):
        yield (
            "all groups have the same inclination; add groups at other inclinations (a wedge "
            "under the inclinometer)"
        )
    yaws = np.unwrap(angles[:, 2])
    if unusual and kinds <= {"group", "inclination"} and np.ptp(yaws) < _SAME_ANGLE:
        yield (
            "the yaw (rotation about the vertical) is the same in all postures; vary the yaw "
            "within each group"
        )
    if size:
        yield (
            "no reading fixes the size: hold one length or factor, or measure a distance, a "
            "position or a known length"
        )
    flat = problem.mechanism.motion == "planar"
    if any("frame" in text and not (flat and text.endswith(_OFF_PLANE)) for text in unobservable):
        found = {o.kind for o in observables(problem.mechanism).values()}
        others = " or of links, or by positions of points" if found & {"point", "position"} else ""
        yield (
            "frames are free: they are chosen by the least change, by `fixed` parameters, or "
            "measured by positions and "
            f"orientations of the platform{others}"
        )
    if readings.count < len(problem.names) - len(unobservable):
        yield (
            f"{readings.count} independent readings for {len(problem.names)} parameters; "
            f"add postures"
        )


# --- names of directions --------------------------------------------------------------------------


_TURNS = ("roll (about x)", "pitch (about y)", "yaw (about z)")

_HELD_STILL = 1e-9
"""A change leaves held parameters where they are when they move by less than this share of it."""


def named_motions(model: ConfigurationModel, p: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Yield (name, scaled direction over the model's parameters) of every known change at p, most
    telling first. What a change would need of parameters that are held is made up for by freedoms
    in how the file is written; a change that cannot be so is left out.
    """
    mechanism, read, values = model.mechanism, model.read, all_values(model, p)
    names, free = list(values), np.isin(list(values), model.names)
    order = [names.index(name) for name in model.names]
    table, size = nominal_parameters(mechanism, read), model.size
    units = np.where([table.get(name, ("", "length"))[1] == "length" for name in names], 1.0, size)

    def rows(changes: Iterable[tuple[str, Velocity]]) -> list[tuple[str, np.ndarray]]:
        return [(text, units * [v.get(name, 0.0) for name in names]) for text, v in changes]

    written = written_freedoms(mechanism, values, read)
    freedoms = rows((*written, *reference_motions(mechanism, values, read)))
    basis = np.array([one for _, one in freedoms]).reshape(-1, len(names)).T
    for text, direction in (*rows(_all_motions(model, values)), *freedoms):
        # shares of freedoms that move the held parameters as this change does
        shares = np.linalg.lstsq(basis[~free], direction[~free], rcond=1e-10)[0]
        made = direction - basis @ shares
        length = np.linalg.norm(made)
        if length > 0.0 and np.linalg.norm(made[~free]) <= _HELD_STILL * length:
            yield text, made[order] / length


def all_values(model: ConfigurationModel, p: np.ndarray) -> Velocity:
    """Return the values of all parameters by name: nominal, those of the model's as p has them;
    measuring frames only among these.
    """
    table = nominal_parameters(model.mechanism, model.read)
    values = {name: value for name, (value, _) in table.items() if name not in MEASURING_FRAMES}
    return values | dict(zip(model.names, map(float, p), strict=True))


def _all_motions(model: ConfigurationModel, values: Velocity) -> Iterator[tuple[str, Velocity]]:
    mechanism = model.mechanism
    if mechanism.dh is None:
        # base and platform frame by unit twists (t, w)
        links = {BASE, *(p.link for p in mechanism.link_points)}
        links |= {link for edge in edges_of(mechanism) for link in edge.ends}
        for k, (text, *_) in enumerate(frame_names(mechanism)):
            twist = np.eye(6)[k % 6]
            if k < 6:
                yield text, moved(mechanism, values, dict.fromkeys(links, twist))
            else:
                yield text, _platform_moved(mechanism, values, twist)
    table = nominal_parameters(mechanism, model.read)
    stretched = {
        name: value
        for name, value in values.items()
        if table.get(name, ("", ""))[1] == "length" and name not in MEASURING_FRAMES
    }
    yield "size of the whole mechanism", stretched
    lengths = [c.name for c in mechanism.actuated if not c.is_angular]
    lengths += [o.name for o in model.channels if o.kind == "joint" and not o.angular]
    if lengths:
        yield (
            "size of the whole mechanism with the factors of all length readings",
            stretched | {f"{name}.scale": 1.0 for name in lengths},
        )
    # the offset of an axis that is parallel to the next to rounding moves the tool as its does
    for k, twist in parallel_axes(mechanism, values, 1e-12):
        yield (
            f"parallel axes {_axes_named(mechanism, k)}: only the sum of their offsets "
            f"dh.{k}.d and dh.{k + 1}.d is told",
            {f"dh.{k}.d": 1.0, f"dh.{k + 1}.d": -1.0 if np.cos(twist) > 0 else 1.0},
        )


# --- frames ---------------------------------------------------------------------------------------


def frame_names(mechanism: Mechanism) -> Iterator[tuple[str, str, str]]:
    """Yield the names of unit twists of base and platform frame, translations first, each with the
    frame between the mechanism and what is measured there, and the name of what mixes both.
    """
    for frame, beside, fixed in (
        (BASE, "world", "base"),
        (mechanism.frame_name, "target", "platform"),
    ):
        for axis in AXES:
            mixed = f"{beside} frame position {axis} with the {fixed} frame"
            yield f"{frame} frame translation {axis}", beside, mixed
        for axis, turn in zip(AXES, _TURNS, strict=True):
            turn = turn if frame == BASE else f"rotation about {axis}"
            mixed = f"{beside} frame rotation {axis} with the {fixed} frame"
            yield f"{frame} frame {turn}", beside, mixed


def _platform_moved(mechanism: Mechanism, values: Velocity, twist: np.ndarray) -> Velocity:
    """Move the platform frame by a twist in its own axes; what is given in it moves the other
    way.
    """
    velocity, (t, w) = moved(mechanism, values, {IN_FRAME: -twist}), np.split(twist, 2)
    frame = mechanism.frame_name
    if f"{frame}.quaternion.w" in values:
        q = vector_values(values, f"{frame}.quaternion", "wxyz")
        shifted, turned = rotate(q / np.linalg.norm(q), t), multiply(q, np.array([0.0, *w]))
        velocity |= vector_velocity(f"{frame}.position", shifted)
        velocity |= vector_velocity(f"{frame}.quaternion", 0.5 * turned, "wxyz")
    return velocity


# --- parallel axes --------------------------------------------------------------------------------


def nearly_parallel(mechanism: Mechanism, values: Velocity) -> tuple[str, ...]:
    """Name pairs of neighbouring axes that are parallel or nearly so."""
    found = parallel_axes(mechanism, values, NEARLY_PARALLEL)
    return tuple(_axes_named(mechanism, k) for k, _ in found)


def _axes_named(mechanism: Mechanism, k: int) -> str:
    return " and ".join(mechanism.actuated[i].name for i in (k - 1, k))
