"""Build the loop closure F(q, x, X, p) = 0 of a mechanism, once and symbolically (its rows: see
`closure.rows`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakValueDictionary

import casadi as ca
import numpy as np

from symkin.closure.bodies import PoseForm
from symkin.closure.partition import ALL_JOINTS, Partition
from symkin.closure.rows import Row, RowBuilder
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import MechanismError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import stacked
from symkin.spatial.pose import Pose

_ZERO_ROW = 1e-11


@dataclass(frozen=True, eq=False)
class Closure:
    """Rows F and their full check over the variables (q, x, X) and the geometry p.

    `variables` stacks the coordinates in the order actuated, passive, pose; a quaternion takes four
    numbers, and its norm is not among the rows. `errors` restates every constraint without squares
    and with whole rotation matrices: distances for the distance rows, axis and frame vectors times
    the size for the others (length unit). `pose` is the platform's pose as an expression of the
    pose coordinates (or of the joints that carry it); `row_numbers` are the places of the rows
    among all that the branches write; `forward` that of the joints, where a limb has no passive
    joint (a serial arm); `idle` names the freedoms that the closure does not hold; `vanishing`
    counts the rows that are left out since they vanish at every configuration, as those of a planar
    loop out of its plane.
    """

    mechanism: Mechanism
    partition: Partition
    coordinates: tuple[Coordinate, ...]
    variables: ca.SX
    parameters: ca.SX
    parameter_names: tuple[str, ...]
    parameter_values: np.ndarray
    rows: ca.SX
    row_sources: tuple[Row, ...]
    row_numbers: tuple[int, ...]
    errors: ca.SX
    error_sources: tuple[Row, ...]
    pose: Pose
    forward: Pose | None
    idle: tuple[str, ...]
    vanishing: int = 0

    @property
    def characteristic_length(self) -> float:
        """The mechanism's characteristic length, by which angles become lengths."""
        return self.mechanism.characteristic_length

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where each coordinate stands in `variables`."""
        places, start = {}, 0
        for coordinate in self.coordinates:
            places[coordinate.name] = slice(start, start + coordinate.width)
            start += coordinate.width
        return places

    @cached_property
    def owners(self) -> tuple[Coordinate, ...]:
        """The coordinate of each rate, in the order of the columns of Jacobians."""
        return tuple(c for c in self.coordinates for _ in range(c.freedom))

    @cached_property
    def reference(self) -> np.ndarray:
        """Values of `variables` at the reference configuration."""
        return np.concatenate([np.array(c.reference) for c in self.coordinates])

    def bound(self, expression: ca.SX) -> ca.SX:
        """The expression with the nominal geometry in place of p; constants fold."""
        return ca.substitute(expression, self.parameters, ca.SX(ca.DM(self.parameter_values)))

    def symbols(self, coordinates: Iterable[Coordinate]) -> ca.SX:
        """The symbols of some coordinates, one below the other."""
        places = (self.slices[c.name] for c in coordinates)
        return stacked(self.variables[place] for place in places)

    def role(self, *roles: str) -> tuple[Coordinate, ...]:
        return tuple(c for c in self.coordinates if c.role in roles)

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as the mechanism: symbols and functions stay in their process and are built anew
        from it.
        """
        return build_closure, (self.mechanism, self.partition)


def build_closure(mechanism: Mechanism, partition: Partition = ALL_JOINTS) -> Closure:
    """The closure of a mechanism, for what is given; mechanisms are frozen, so that it is built
    once for each.
    """
    return _closure(mechanism, partition)


_living: WeakValueDictionary[tuple[Mechanism, Partition], Closure] = WeakValueDictionary()
"""Closures that something holds: one of them is never built anew, for the expressions of a kept
problem know nothing of other symbols.
"""


@lru_cache(maxsize=128)
def _closure(mechanism: Mechanism, partition: Partition) -> Closure:
    key = mechanism, partition
    return _living.get(key) or _living.setdefault(key, _assemble(built_rows(mechanism, partition)))


@lru_cache(maxsize=16)
def built_rows(mechanism: Mechanism, partition: Partition) -> RowBuilder:
    """The builder that has written the rows of a closure, and knows where its links are."""
    builder = RowBuilder(mechanism, partition=partition)
    builder.build_rows()
    if partition.geometry:
        builder.declare_geometry()
    return builder


@dataclass(frozen=True, eq=False)
class AlgebraicRows:
    """Rows of a closure over its variables and the `symbols` of some floating bodies' poses: Study
    coordinates (e; g), or position and a quaternion of any length, in which rows are homogeneous.
    `eliminated` gives the values of actuated joints that were cut by the others.
    """

    rows: ca.SX
    symbols: dict[str, ca.SX]
    eliminated: tuple[tuple[Coordinate, ca.SX], ...]


@lru_cache(maxsize=16)
def algebraic_rows(
    closure: Closure, forms: tuple[tuple[str, PoseForm], ...] = (), *, eliminate: bool = False
) -> AlgebraicRows:
    """The rows of a closure with some floating bodies in an algebraic form, geometry bound as
    numbers: joints that it places to rounding (a point at 1e-14, an axis off by 1e-17) are where
    they are meant to be. Bodies are named as their coordinates are: "pose" is the platform. With
    `eliminate`, limbs without a passive joint to cut are cut at an actuated one, which must then be
    unknown.
    """
    bound, platform = not closure.partition.geometry, closure.mechanism.platform_link or ""
    links = {name: platform if name == "pose" else name for name, _ in forms}
    by_link = {links[name]: form for name, form in forms}
    builder = RowBuilder(
        closure.mechanism,
        bound=bound,
        partition=closure.partition,
        body_forms=by_link,
        eliminate=eliminate,
    )
    builder.build_rows()
    symbols = {name: builder.body_symbols[link] for name, link in links.items()}
    names = [c.name for c in closure.coordinates if c.name in builder.coordinates]
    ours = [builder.coordinates[name][1] for name in names]
    theirs = [closure.variables[closure.slices[name]] for name in names]
    kept = closure.row_numbers
    if builder.eliminated:
        gone = {c.name for c, _ in builder.eliminated}
        left = tuple(c for c in closure.coordinates if c.name not in gone)
        variables = ca.vertcat(*ours, *symbols.values())
        kept = _nonzero_rows(builder, left, variables, ca.SX(0, 1), np.zeros(0))
    if not bound:
        numbers = dict(zip(closure.parameter_names, closure.parameter_values, strict=True))
        for name, symbol, value in zip(
            builder.table.names, builder.table.symbols, builder.table.values, strict=True
        ):
            known = name in closure.slices
            ours.append(symbol)
            theirs.append(
                closure.variables[closure.slices[name]]
                if known
                else ca.SX(float(numbers.get(name, value)))
            )
    every = ca.vertcat(*(builder.rows[k] for k in kept))
    angles = ca.vertcat(*(angle for _, angle in builder.eliminated))
    rows, told = ca.substitute([every, angles], [ca.vertcat(*ours)], [ca.vertcat(*theirs)])
    cut = tuple((c, told[i]) for i, (c, _) in enumerate(builder.eliminated))
    return AlgebraicRows(rows, symbols, cut)


def _assemble(builder: RowBuilder) -> Closure:
    order = {"actuated": 0, "passive": 1, "body": 2, "pose": 3, "condition": 4, "geometry": 5}
    pairs = sorted(builder.coordinates.values(), key=lambda pair: order[pair[0].role])
    actuated = {c.name: k for k, c in enumerate(builder.mechanism.actuated)}
    in_file_order = sorted(
        (p for p in pairs if p[0].role == "actuated"), key=lambda p: actuated[p[0].name]
    )
    pairs = in_file_order + [p for p in pairs if p[0].role != "actuated"]
    coordinates = tuple(pair[0] for pair in pairs)
    if not coordinates:
        raise MechanismError(
            f"{builder.mechanism.name}: no coordinate is left to find; a link on two S joints is a "
            "rod, whose spin moves nothing else: a machine needs a joint that moves another link"
        )
    variables = ca.vertcat(*(pair[1] for pair in pairs))
    symbols, names, values = _used_parameters(builder)
    kept = _nonzero_rows(builder, coordinates, variables, symbols, values)
    return Closure(
        mechanism=builder.mechanism,
        partition=builder.partition,
        coordinates=coordinates,
        variables=variables,
        parameters=symbols,
        parameter_names=names,
        parameter_values=values,
        rows=ca.vertcat(*(builder.rows[k] for k in kept)),
        row_sources=tuple(builder.sources[k] for k in kept),
        row_numbers=kept,
        errors=_without_unused(builder, names),
        error_sources=tuple(builder.error_sources),
        pose=builder.pose,
        forward=builder.forward,
        idle=tuple(text for text in builder.idle if text),
        vanishing=len(builder.rows) - len(kept),
    )


def _used_parameters(builder: RowBuilder) -> tuple[ca.SX, tuple[str, ...], np.ndarray]:
    """Only parameters on which the closure or the tool pose depends."""
    table = builder.table
    everything = ca.vertcat(*table.symbols)
    # axes that cancel in the rows are no parameters: nothing could be said of them by measuring
    depends = ca.which_depends(
        ca.vertcat(*builder.rows, builder.pose.position, builder.pose.quaternion),
        everything,
        1,
        False,
    )
    used = [
        k for k, flag in enumerate(depends) if flag and table.names[k] not in builder.coordinates
    ]
    symbols = ca.vertcat(*(table.symbols[k] for k in used)) if used else ca.SX(0, 1)
    return symbols, tuple(table.names[k] for k in used), np.array([table.values[k] for k in used])


def _without_unused(builder: RowBuilder, names: Sequence[str]) -> ca.SX:
    """The checks with the nominal values of parameters that the rows do not depend on: axes that
    cancel in them, say.
    """
    table, kept = builder.table, set(names)
    unused = [
        k
        for k, name in enumerate(table.names)
        if name not in kept and name not in builder.coordinates
    ]
    errors = ca.vertcat(*builder.errors)
    symbols, values = [table.symbols[k] for k in unused], [table.values[k] for k in unused]
    return ca.substitute(errors, ca.vertcat(*symbols), ca.SX(ca.DM(values))) if unused else errors


def _nonzero_rows(
    builder: RowBuilder,
    coordinates: Sequence[Coordinate],
    variables: ca.SX,
    symbols: ca.SX,
    values: np.ndarray,
) -> tuple[int, ...]:
    """Numbers of the rows that a restricted motion leaves, or a loop that is planar or spherical:
    those that vanish identically at the nominal geometry are dropped.
    """
    if builder.mechanism.motion == "spatial" and all(
        branch.carries or set(branch.ends) & set(builder.layout.floating)
        for branch in builder.layout.branches
    ):
        # rows that hold a body of six freedoms depend on its pose
        return tuple(range(len(builder.rows)))
    evaluate = ca.Function("rows", [variables, symbols], [ca.vertcat(*builder.rows)])
    size = builder.mechanism.characteristic_length
    return nonzero_rows(lambda sample: evaluate(sample, values), coordinates, size)


def nonzero_rows(
    evaluate: Callable[[np.ndarray], Any], coordinates: Sequence[Coordinate], size: float
) -> tuple[int, ...]:
    """Numbers of the rows that do not vanish at random points: those that do are zero everywhere,
    with probability one.
    """
    rng = np.random.default_rng(0)
    samples = [np.asarray(evaluate(random_values(coordinates, size, rng))) for _ in range(3)]
    largest = np.max(np.abs(samples), axis=0).ravel()
    return tuple(int(k) for k in np.flatnonzero(largest > _ZERO_ROW * size))


def random_values(
    coordinates: Sequence[Coordinate], size: float, rng: np.random.Generator
) -> np.ndarray:
    """Random coordinate values about the reference: lengths by the size, angles and rotations
    anywhere.
    """
    parts = [np.zeros(0)]
    for c in coordinates:
        match c.kind:
            case "length":
                parts.append(np.array(c.reference) + size * rng.uniform(-1, 1, 1))
            case "quaternion":
                q = rng.normal(size=4)
                parts.append(q / np.linalg.norm(q))
            case _:
                parts.append(np.array(c.reference) + rng.uniform(-np.pi, np.pi, 1))
    return np.concatenate(parts)


def random_points(coordinates: Sequence[Coordinate], size: float, count: int) -> np.ndarray:
    """So many random coordinate values (count, width), the same in every run."""
    rng = np.random.default_rng(0)
    return np.array([random_values(coordinates, size, rng) for _ in range(count)])
