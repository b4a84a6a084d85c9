"""Find how the reference configuration of a mechanism may be chosen: what else describes the same
machine.

Points and axes are those of the reference configuration, where joints have their zeros. Any other
configuration of the joints is a reference as good, rods and couplings left aside (they need not
hold there: lengths and zeros are numbers of their own): links move by twists V with V_b - V_a = sum
of S_k q'_k at each joint, points and axes go along, and zeros advance by q'. A link that only rods
hold has its frame anywhere. Joints that have no zero and are actuated, read or coupled stay as they
are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.observables import point_path
from symkin.closure.branches import Branch, Element, edges_of
from symkin.model.joint import BASE, Joint
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import multiply

_RANK_TOLERANCE = 1e-9
"""Singular values (lengths over the size) below this share of the largest are zero: geometry is
written with more digits.
"""
_PIVOT = 1e-6
"""Smallest share of a rate, in a space of unit directions, by which it can be chosen."""


@dataclass(frozen=True)
class _Rate:
    """A unit rate of a joint at the reference: its name, its screw (linear at the base origin,
    angular), the key path of the zero that advances with it, if any.
    """

    name: str
    screw: tuple[float, ...]
    zero: str | None
    free: bool = True


def reference_motions(
    mechanism: Mechanism, values: Mapping[str, float], read: Sequence[str] = ()
) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield each independent change of the reference with the rates of parameters (key paths) that
    describe it.
    """
    if mechanism.dh is not None:
        return
    edges = list(edges_of(mechanism))
    links = list(dict.fromkeys(link for edge in edges for link in edge.ends if link != BASE))
    rates = {k: _rates(mechanism, edge.elements[0], values, read) for k, edge in enumerate(edges)}
    names = [rate.name for own in rates.values() for rate in own if rate.free]
    size = mechanism.characteristic_length
    moves = _null_space(_constraints(edges, links, rates, size))
    labels = [f"reference configuration by {name}" for name in names]
    labels += [
        f"reference place of {link}, {k}"
        for link in links
        for k in ("x", "y", "z", "about x", "about y", "about z")
    ]
    order = [*range(len(names)), *(len(names) + k for k in range(6 * len(links)))]
    for column, move in _independent(moves, order):
        twists = {BASE: np.zeros(6)} | {
            link: np.array(move[len(names) + 6 * k : len(names) + 6 * k + 6])
            * ([size] * 3 + [1.0] * 3)
            for k, link in enumerate(links)
        }
        advances = dict(zip(names, move[: len(names)], strict=True))
        yield (
            labels[column],
            _parameter_rates(mechanism, edges, values, twists) | _zero_rates(rates, advances),
        )


def _rates(
    mechanism: Mechanism, element: Element, values: Mapping[str, float], read: Sequence[str]
) -> list[_Rate]:
    """The rates of one joint; none of a rod, which does not join frames at the reference."""
    joint, path = element.part, element.path
    if not isinstance(joint, Joint) or joint.type == "weld":
        return []
    point = _vector(values, f"{path}.point", joint.point)
    if joint.type == "S":
        return [
            _Rate(f"{joint.name} about {k}", _turn(point, np.eye(3)["xyz".index(k)]), None)
            for k in "xyz"
        ]
    axis = _direction(values, f"{path}.axis", joint.axis)
    coupled = {name for c in mechanism.couplings for name in (c.joint, *c.names)}
    held = joint.actuated or bool({c.name for c in joint.coordinates} & (set(read) | coupled))
    slide = (*axis, 0.0, 0.0, 0.0)
    match joint.type:
        case "P":
            screws = [slide]
        case "H":
            pitch = values.get(f"{path}.pitch", joint.pitch) / (2.0 * np.pi)
            screws = [tuple(np.array(_turn(point, axis)) + pitch * np.array(slide))]
        case "C":
            screws = [_turn(point, axis), slide]
        case "U":
            screws = [
                _turn(point, axis),
                _turn(point, _direction(values, f"{path}.axis2", joint.axis2)),
            ]
        case _:
            screws = [_turn(point, axis)]
    zero = f"{path}.zero" if joint.freedom == 1 else None
    named = zip((c.name for c in joint.coordinates), screws, strict=True)
    return [_Rate(name, screw, zero, free=zero is not None or not held) for name, screw in named]


def _turn(point: np.ndarray, axis: np.ndarray) -> tuple[float, ...]:
    return (*np.cross(point, axis), *axis)


def _constraints(
    edges: Sequence[Branch], links: Sequence[str], rates: Mapping[int, list[_Rate]], size: float
) -> np.ndarray:
    """Rows V_b - V_a - sum of S q' = 0 of all joints, lengths over the size."""
    count = sum(rate.free for own in rates.values() for rate in own)
    unit, rows, column = np.array([1.0 / size] * 3 + [1.0] * 3), [], 0
    for k, edge in enumerate(edges):
        part = edge.elements[0].part
        if not isinstance(part, Joint):
            continue
        block = np.zeros((6, count + 6 * len(links)))
        for link, sign in ((edge.ends[0], -1.0), (edge.ends[1], 1.0)):
            if link != BASE:
                begin = count + 6 * links.index(link)
                block[:, begin : begin + 6] += sign * np.eye(6)
        for rate in rates[k]:
            if rate.free:
                block[:, column] = -unit * np.array(rate.screw)
                column += 1
        rows.append(block)
    return np.vstack([np.zeros((0, count + 6 * len(links))), *rows])


def _null_space(matrix: np.ndarray) -> np.ndarray:
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, singular, right = np.linalg.svd(matrix)
    rank = int(np.sum(singular > _RANK_TOLERANCE * singular[0]))
    return np.asarray(right[rank:].T)


def _independent(space: np.ndarray, order: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
    """A basis of a space (width, k): each direction is 1 in one number, the first of the order that
    can be, 0 in those of the others.
    """
    pivots: list[int] = []
    rest = space.copy()
    for k in order:
        size = float(np.linalg.norm(rest[k]))
        if len(pivots) < space.shape[1] and size > _PIVOT:
            pivots.append(k)
            rest = rest - np.outer(rest @ rest[k], rest[k]) / size**2
    if pivots:
        basis = space @ np.linalg.inv(space[pivots])
        yield from zip(pivots, basis.T, strict=True)


# --- rates of parameters --------------------------------------------------------------------------


def _parameter_rates(
    mechanism: Mechanism,
    edges: Sequence[Branch],
    values: Mapping[str, float],
    twists: Mapping[str, np.ndarray],
) -> dict[str, float]:
    """How points and directions of links move with their links."""
    rates: dict[str, float] = {}
    for edge in edges:
        (element,), (first, last) = edge.elements, (twists[link] for link in edge.ends)
        part, path = element.part, element.path
        if isinstance(part, Joint):
            rates |= _moved(values, f"{path}.point", part.point, first)
            if part.axis is not None:
                rates |= _turned(values, f"{path}.axis", part.axis, first)
            if part.axis2 is not None:
                rates |= _turned(values, f"{path}.axis2", part.axis2, last)
            continue
        for end, twist in ((part.start, first), (part.end, last)):
            rates |= {} if end.in_platform_frame else _moved(values, end.path, end.point, twist)
    for point in mechanism.link_points:
        rates |= _moved(values, point_path(point), point.point, twists[point.link])
    if mechanism.platform_link is not None:
        twist = twists[mechanism.platform_link]
        frame = mechanism.frame_name
        rates |= _moved(values, f"{frame}.position", mechanism.platform_position, twist)
        q = [
            values.get(f"{frame}.quaternion.{k}", v)
            for k, v in zip("wxyz", mechanism.platform_quaternion, strict=True)
        ]
        turned = 0.5 * np.asarray(multiply(np.array([0.0, *twist[3:]]), np.array(q)))
        rates |= {f"{frame}.quaternion.{k}": float(v) for k, v in zip("wxyz", turned, strict=True)}
    return rates


def _zero_rates(
    rates: Mapping[int, list[_Rate]], advances: Mapping[str, float]
) -> dict[str, float]:
    return {
        rate.zero: float(advances[rate.name])
        for own in rates.values()
        for rate in own
        if rate.zero is not None
    }


def _moved(
    values: Mapping[str, float], path: str, nominal: Sequence[float], twist: np.ndarray
) -> dict[str, float]:
    rate = twist[:3] + np.cross(twist[3:], _vector(values, path, nominal))
    return {f"{path}.{k}": float(v) for k, v in zip("xyz", rate, strict=True)}


def _turned(
    values: Mapping[str, float], path: str, nominal: Sequence[float], twist: np.ndarray
) -> dict[str, float]:
    rate = np.cross(twist[3:], _vector(values, path, nominal))
    return {f"{path}.{k}": float(v) for k, v in zip("xyz", rate, strict=True)}


def _vector(values: Mapping[str, float], path: str, nominal: Sequence[float] | None) -> np.ndarray:
    return np.array(
        [values.get(f"{path}.{k}", v) for k, v in zip("xyz", nominal or (), strict=True)]
    )


def _direction(
    values: Mapping[str, float], path: str, nominal: Sequence[float] | None
) -> np.ndarray:
    vector = _vector(values, path, nominal)
    return np.asarray(vector / np.linalg.norm(vector))
