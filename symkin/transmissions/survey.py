"""What a transmission does over its whole range: how far joints go and what stops them, the torques
and rates that they give at least and at most, ratios, and backlash.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.result import Summary
from symkin.transmissions.linkage import Linkage
from symkin.transmissions.motors import Motors
from symkin.transmissions.polytope import facets
from symkin.transmissions.states import States, direction

_COUNTS = {1: 201, 2: 33, 3: 9}
"""Samples of each of so many coordinates; of more, `_RANDOM` random ones."""
_RANDOM = 400
_WIDEST = 2.0 * np.pi
"""Radians of a range that is swept as a whole; wider limits are none."""
_ABOUT = 1.0
"""Radians, and sizes, on both sides of the reference where no limits say how far to look."""
_ROUNDING = 1e-12
"""Share of the largest ratio up to which one is 0."""
_HALVINGS = 40
_SAME = 1e-6
"""Radians, and sizes, by which one configuration is found again."""


class Extreme(NamedTuple):
    """A value over the range, the joints (radians, lengths) at which it stands, and whose limit
    binds there.
    """

    value: float
    at: tuple[float, ...]
    by: str


class End(NamedTuple):
    """Where the range of a joint ends, and what stops it there."""

    value: float
    by: str


@dataclass(frozen=True, eq=False)
class Survey:
    """Samples of a transmission within all limits: configurations of the reference's mode, at
    which nothing is singular. Angles are in radians.

    The first sample is the reference. `ends` are the two ends of each joint's range. `alone` is
    the largest torque of each joint (samples, n) in the weaker of its two directions while the
    others give none, `together` the largest that it gives while others may give any; `rates` the
    largest rate of each alone. All samples but the first lie on a grid of the coordinates `grid`.
    """

    states: States
    data: Motors
    ends: tuple[tuple[End, End], ...]
    grid: tuple[str, ...]

    @property
    def linkage(self) -> Linkage:
        return self.states.linkage

    @cached_property
    def _planes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[str, ...]]:
        """Torques are low <= N tau <= high: N (samples, f, n), low and high (samples, f), and whose
        limit each row is.
        """
        linkage, (low, high) = self.linkage, self.data.torque_limits.T
        count = len(self.states.w)
        if len(linkage.motors) == linkage.mobility:
            normals = self.states.jacobian.transpose(0, 2, 1)
            return normals, *np.broadcast_to([[low], [high]], (2, count, len(low))), linkage.motors
        middle, half, g = 0.5 * (low + high), 0.5 * (high - low), self.states.inverse_jacobian
        found = [facets(one * half[:, None]) for one in g]
        most = max(len(heights) for _, heights in found)
        normals = np.zeros((count, most, linkage.mobility))
        bounds = np.full((2, count, most), np.inf) * np.array([-1.0, 1.0])[:, None, None]
        for k, (normal, heights) in enumerate(found):
            offset = normal @ (middle @ g[k])
            normals[k, : len(heights)] = normal
            bounds[:, k, : len(heights)] = offset - heights, offset + heights
        return normals, *bounds, ("several motors",) * most

    @cached_property
    def _alone(self) -> tuple[np.ndarray, np.ndarray]:
        """Largest torques alone (samples, n), and the row of `_planes` that binds each."""
        normals, low, high, _ = self._planes
        return _along_axes(normals, low[..., None], high[..., None])

    @property
    def alone(self) -> np.ndarray:
        return self._alone[0]

    @cached_property
    def together(self) -> np.ndarray:
        low, high = self.data.torque_limits.T
        g = self.states.inverse_jacobian
        most = np.einsum("nai,a->ni", np.abs(g), 0.5 * (high - low))
        return most - np.abs(np.einsum("nai,a->ni", g, 0.5 * (high + low)))

    @cached_property
    def rates(self) -> np.ndarray:
        low, high = self.data.speed_limits.T
        return _along_axes(self.states.inverse_jacobian, low[:, None], high[:, None])[0]

    @cached_property
    def backlash(self) -> np.ndarray | None:
        """The largest play (n,) of each joint while the motors stay within their resolutions."""
        if self.data.resolutions is None:
            return None
        play = np.einsum("nia,a->ni", np.abs(self.states.jacobian), self.data.resolutions)
        return np.asarray(play.max(axis=0))

    @cached_property
    def weakest(self) -> tuple[Extreme, str] | None:
        """The smallest torque that any direction of the joints has, and which; None where joints
        turn and slide, so that no direction is longer than another.
        """
        if len({c.is_length for c in self._joints}) > 1:
            return None
        normals, low, high, names = self._planes
        lengths = np.linalg.norm(normals, axis=2)
        lengths = np.where(lengths > 0.0, lengths, np.nan)
        found = np.minimum(high, -low) / lengths
        row, k = np.unravel_index(np.nanargmin(found), found.shape)
        way = normals[row, k] / np.abs(normals[row, k]).max()
        least = Extreme(float(found[row, k]), self._at(row), names[k])
        return least, direction(self.linkage.joints, way)

    def smallest(self, joint: int) -> Extreme:
        """The smallest torque of a joint alone over the range."""
        return self._extreme(joint, self._alone[0][:, joint].argmin())

    def largest(self, joint: int) -> Extreme:
        """The largest torque of a joint alone over the range."""
        return self._extreme(joint, self._alone[0][:, joint].argmax())

    def _extreme(self, joint: int, row: np.intp) -> Extreme:
        value, which = (table[row, joint] for table in self._alone)
        return Extreme(float(value), self._at(row), self._planes[3][which])

    def _at(self, row: np.intp) -> tuple[float, ...]:
        return tuple(self.states.joints[row].tolist())

    @property
    def _joints(self) -> list[Coordinate]:
        return self.linkage.coordinates_of(self.linkage.joints)

    # --- as text and as JSON ----------------------------------------------------------------------

    def summary(self, name: str, notes: Sequence[str]) -> Summary:
        """The table: ranges and torques of each joint; what holds of all of them below."""
        linkage, told = self.linkage, self.to_dict()
        header = ["joint", "from", "to", "torque", "least", "most", "with others", "rate", "to"]
        rows, below = [], []
        for joint, own in told["joints"].items():
            low, high = own["from"], own["to"]
            small, large = own["smallest_torque"], own["largest_torque"]
            numbers = [
                low["value"],
                high["value"],
                own["torque_at_reference"],
                small["value"],
                large["value"],
                own["largest_torque_with_others"],
                *own["rate"],
            ]
            rows.append([joint, *(f"{number:.4g}" for number in numbers)])
            below.append(
                f"{joint}: ends at {low['by']} and at {high['by']}; weakest at {_place(small)}, "
                f"where {small['by']} binds; strongest at {_place(large)} ({large['by']})"
            )
        weakest = told["weakest"]
        if weakest is not None and len(rows) > 1:
            below.append(
                f"weakest direction: {weakest['direction']}: {weakest['value']:.4g} at "
                f"{_place(weakest)} ({weakest['by']})"
            )
        for motor, ratios in told["ratios"].items():
            spans = (f"{low:.4g} to {high:.4g} by {n}" for n, (low, high) in ratios.items())
            below.append(f"ratio of {motor}: {', '.join(spans)}")
        if self.backlash is not None:
            plays = (f"{n} {own['backlash']:.3g}" for n, own in told["joints"].items())
            below.append(f"play within the motors' resolution, at most: {', '.join(plays)}")
        units = (
            f"angles in {linkage.mechanism.angle_unit}, lengths in {linkage.mechanism.length_unit}"
        )
        above = [
            f"{name}, driven by {', '.join(linkage.motors)}: {told['samples']} configurations "
            f"within limits, {units}",
            "torque and rate: of one joint alone, in its weaker direction, at the reference, at "
            "least and at most; with others: at most, where they give any",
        ]
        return Summary(
            above, header, rows, [*below, *(f"note: {n}" for n in (*notes, *self.data.notes))]
        )

    def to_dict(self) -> dict[str, Any]:
        """What holds over the range, by joint and motor; angles in the mechanism's unit."""
        linkage, ratios = self.linkage, _without_rounding(self.states.inverse_jacobian)
        joints = {}
        for i, name in enumerate(linkage.joints):
            begin, end = ({"value": self.out(i, e.value), "by": e.by} for e in self.ends[i])
            least, most = self._told(self.smallest(i)), self._told(self.largest(i))
            joints[name] = {
                "from": begin,
                "to": end,
                "torque_at_reference": float(self.alone[0, i]),
                "smallest_torque": least,
                "largest_torque": most,
                "largest_torque_with_others": float(self.together[:, i].max()),
                "rate": [float(self.rates[:, i].min()), float(self.rates[:, i].max())],
                "backlash": None if self.backlash is None else self.out(i, self.backlash[i]),
            }
        weakest = None
        if self.weakest is not None:
            weakest = {"direction": self.weakest[1], **self._told(self.weakest[0])}
        return {
            "samples": len(self.states.w),
            "joints": joints,
            "ratios": {
                motor: {
                    joint: [float(ratios[:, a, i].min()), float(ratios[:, a, i].max())]
                    for i, joint in enumerate(linkage.joints)
                }
                for a, motor in enumerate(linkage.motors)
            },
            "weakest": weakest,
        }

    def _told(self, one: Extreme) -> dict[str, Any]:
        at = {n: self.out(i, one.at[i]) for i, n in enumerate(self.linkage.joints)}
        return {"value": one.value, "at": at, "by": one.by}

    def out(self, joint: int, value: float) -> float:
        """A joint's value in the mechanism's unit."""
        mechanism = self.linkage.mechanism
        return mechanism.value_out(self._joints[joint], float(value))


def _place(told: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {value:.3g}" for name, value in told["at"].items())


def _without_rounding(ratios: np.ndarray) -> np.ndarray:
    """Ratios (n, motors, joints), 0 those of pairs that are rounding beside the largest."""
    largest = np.abs(ratios).max(axis=0, keepdims=True)
    return np.where(largest > _ROUNDING * largest.max(initial=0.0), ratios, 0.0)


def survey(linkage: Linkage, data: Motors) -> Survey:
    """Sample the range: the joints' where they all have limits, else the motors', else about the
    reference; what is within all limits, regular, and reached from the reference by motors and by
    joints alike is kept.
    """
    names, goals = _goals(linkage)
    found = linkage.moved(names, linkage.reference, goals)
    within = (linkage.beyond_limits(found.points) <= 0.0).all(axis=1)
    w = found.points[found.reached & within]
    others = linkage.joints if names == linkage.motors else linkage.motors
    if len(linkage.motors) == linkage.mobility:
        w = w[_is_led_back(linkage, w, others)]
    states = States(linkage, np.vstack([linkage.reference[None], w]))
    regular = np.isfinite(states.inverse_jacobian).all(axis=(1, 2))
    regular &= np.isfinite(states.jacobian).all(axis=(1, 2))
    kept = States(linkage, states.w[regular])
    return Survey(kept, data, _ends(linkage, kept), names)


def _is_led_back(linkage: Linkage, w: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    """Whether the values of these coordinates lead to the configurations as well (n,): beyond a
    dead centre of a motor the joints are those of another one, and no map from joints reaches this.
    """
    back = linkage.moved(names, linkage.reference, w[:, linkage.places_of(names)])
    off = np.abs((back.points - w) / linkage.units).max(axis=1, initial=0.0)
    return back.reached & (off < _SAME)


def _goals(linkage: Linkage) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and a grid of values (k, names) that are looked at."""
    is_square = len(linkage.motors) == linkage.mobility
    names = linkage.motors if is_square else linkage.joints
    for chosen in (linkage.joints, names):
        coordinates = linkage.coordinates_of(chosen)
        spans = [_span(c) for c in coordinates]
        if None not in spans:
            break
    else:
        coordinates, chosen = linkage.coordinates_of(names), names
        reach = [_ABOUT * c.unit(linkage.size) for c in coordinates]
        spans = [
            _span(c) or (c.reference[0] - r, c.reference[0] + r)
            for c, r in zip(coordinates, reach, strict=True)
        ]
    low, high = np.array(spans, dtype=float).T
    n = len(chosen)
    if n not in _COUNTS:
        return chosen, np.random.default_rng(0).uniform(low, high, (_RANDOM, n))
    axes = [np.linspace(a, b, _COUNTS[n]) for a, b in zip(low, high, strict=True)]
    return chosen, np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, n)


def _span(c: Coordinate) -> tuple[float, float] | None:
    wide = c.limits is None or (c.is_angular and c.limits[1] - c.limits[0] > _WIDEST)
    return None if wide else c.limits


def _ends(linkage: Linkage, states: States) -> tuple[tuple[End, End], ...]:
    """Where each joint's range ends: from the outermost sample on along this joint alone, up to a
    singularity, or to the first limit before it, found by halving.
    """
    joints, n = states.joints, len(linkage.joints)
    rows = [k for i in range(n) for k in (joints[:, i].argmin(), joints[:, i].argmax())]
    starts = states.w[rows]
    begin = joints[rows]
    reach = np.maximum(np.ptp(joints, axis=0), 0.1 * linkage.units[linkage.joint_places])
    ways = np.zeros((2 * n, n))
    for k in range(2 * n):
        ways[k, k // 2] = reach[k // 2] * (1.0 if k % 2 else -1.0)
    final = linkage.moved(linkage.joints, starts, begin + ways)
    low, high = np.zeros(2 * n), final.shares.copy()
    over = linkage.beyond_limits(final.points)
    stopped = np.any(over > 0.0, axis=1)
    for _ in range(_HALVINGS if stopped.any() else 0):
        middle = np.where(stopped, 0.5 * (low + high), high)
        w = linkage.moved(linkage.joints, starts, begin + middle[:, None] * ways).points
        here = linkage.beyond_limits(w)
        out = np.any(here > 0.0, axis=1)
        over[out] = here[out]
        starts = np.where(out[:, None], starts, w)
        low, high = np.where(out, low, middle), np.where(out, middle, high)
    low = np.where(stopped, low, final.shares)
    values = begin + low[:, None] * ways
    told = []
    for k in range(2 * n):
        by = "a singularity" if not final.reached[k] else "the end of what was looked at"
        if stopped[k]:
            by = f"the limit of {linkage.limited[over[k].argmax()].name}"
        told.append(End(float(values[k, k // 2]), by))
    return tuple((told[2 * i], told[2 * i + 1]) for i in range(n))


def _along_axes(
    normals: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The largest t (k, n) with low <= N t e_i <= high for both signs of t, normals N (k, f, n),
    bounds that broadcast to them; and the row f that binds.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(normals == 0.0, np.inf, np.minimum(high, -low) / np.abs(normals))
    return found.min(axis=1), found.argmin(axis=1)
