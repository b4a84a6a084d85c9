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

import numpy as np

from symkin.calibration.data.observables import point_path
from symkin.calibration.data.parameters import (
    Velocity,
    described_parameters,
    vector_values,
    vector_velocity,
)
from symkin.closure.branches import Branch, edges_of
from symkin.model.joint import BASE, Joint
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import independent_rows, null_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.spatial.rotation import multiply

_PIVOT = 1e-6
"""Smallest share of a rate, in a space of unit directions, by which it can be chosen."""
IN_FRAME = "in the platform frame"
"""Stands for a link of what is given in the platform frame."""
_Rate = tuple[str, np.ndarray, str | None]
"""A rate of a joint that is free: its name, its screw (linear at the base origin, angular), the key
path of the zero that advances with it, if any.
"""


def reference_motions(
    mechanism: Mechanism, values: Mapping[str, float], read: Sequence[str] = ()
) -> Iterator[tuple[str, Velocity]]:
    """Yield each independent change of the reference with the rates of parameters (key paths) that
    describe it.
    """
    if mechanism.dh is not None:
        return
    values = {name: v for name, (v, _) in described_parameters(mechanism).items()} | dict(values)
    edges = list(edges_of(mechanism))
    links = list(dict.fromkeys(link for edge in edges for link in edge.ends if link != BASE))
    read = (*read, *(name for c in mechanism.couplings for name in (c.joint, *c.names)))
    rates = [(edge, rate) for edge in edges for rate in _rates(edge, values, read)]
    size, width = mechanism.characteristic_length, len(rates) + 6 * len(links)
    unit, rows = np.array([1.0 / size] * 3 + [1.0] * 3), [np.zeros((0, width))]
    # V_b - V_a - sum of S q' = 0 of all joints, lengths over the size
    for edge in (e for e in edges if isinstance(e.elements[0].part, Joint)):
        ends = [(link == edge.ends[1]) - (link == edge.ends[0]) for link in links]
        screws = [-unit * screw if own is edge else np.zeros(6) for own, (_, screw, _) in rates]
        rows.append(np.column_stack([*screws, np.kron(ends, np.eye(6))]))
    moves = null_space(np.vstack(rows), RANK_TOLERANCE, relative=True).T
    labels = [f"reference configuration by {name}" for _, (name, *_) in rates]
    labels += [
        f"reference place of {link}, {k}"
        for link in links
        for k in ("x", "y", "z", "about x", "about y", "about z")
    ]
    # each direction is 1 in one number, the first that can be, 0 in those of the others
    pivots = independent_rows(moves, _PIVOT, groups=range(width))
    basis = moves @ np.linalg.inv(moves[pivots]) if pivots else moves[:, :0]
    for column, move in zip(pivots, basis.T, strict=True):
        twists = move[len(rates) :].reshape(-1, 6) * ([size] * 3 + [1.0] * 3)
        velocity = moved(mechanism, values, dict(zip(links, twists, strict=True)))
        for advance, (_, (_, _, zero)) in zip(move, rates, strict=False):
            if zero is not None:
                velocity[zero] = float(advance)
        yield labels[column], velocity


def _rates(edge: Branch, values: Mapping[str, float], held: Sequence[str]) -> Iterator[_Rate]:
    """The free rates of one joint; none of a rod, which does not join frames at the reference."""
    joint, path = edge.elements[0].part, edge.elements[0].path
    if not isinstance(joint, Joint) or not joint.freedom:
        return
    zero = f"{path}.zero" if joint.freedom == 1 else None
    names = [c.name for c in joint.coordinates]
    if joint.type == "S":
        names = [f"{joint.name} about {k}" for k in "xyz"]
    elif zero is None and (joint.actuated or set(names) & set(held)):
        return
    point = vector_values(values, f"{path}.point")
    given = [f"{path}.{k}" for k in ("axis", "axis2") if getattr(joint, k) is not None]
    axes = [vector_values(values, name) for name in given]
    units = [axis / np.linalg.norm(axis) for axis in axes]
    for name, screw in zip(
        names, joint.form.screws(point, units, values.get(f"{path}.pitch", 0.0)), strict=True
    ):
        yield name, np.roll(screw, 3), zero


# --- rates of parameters --------------------------------------------------------------------------


def moved(
    mechanism: Mechanism, values: Mapping[str, float], twists: Mapping[str, np.ndarray]
) -> Velocity:
    """How the numbers given on links, in the base frame, move with their links: by twists (linear
    at the base origin, angular) of those that do. Of ends given in the platform frame `IN_FRAME` is
    the link.
    """
    velocity: Velocity = {}

    def put(path: str, link: str, *, point: bool = True) -> None:
        if link in twists:
            value, (v, w) = vector_values(values, path), np.split(twists[link], 2)
            velocity.update(vector_velocity(path, v * point + np.cross(w, value)))

    for edge in edges_of(mechanism):
        (element,), (first, last) = edge.elements, edge.ends
        part, path = element.part, element.path
        if not isinstance(part, Joint):
            for end, link in ((part.start, first), (part.end, last)):
                put(end.path, IN_FRAME if end.in_platform_frame else link)
            continue
        put(f"{path}.point", first)
        for key, link in (("axis", first), ("axis2", last)):
            if getattr(part, key) is not None:
                put(f"{path}.{key}", link, point=False)
    for one in mechanism.link_points:
        put(point_path(one), one.link)
    platform = mechanism.platform_link or ""
    if platform in twists:
        path = f"{mechanism.frame_name}.quaternion"
        q, w = vector_values(values, path, "wxyz"), twists[platform][3:]
        turned = 0.5 * multiply(np.array([0.0, *w]), q)
        velocity |= vector_velocity(path, turned, "wxyz")
        put(f"{mechanism.frame_name}.position", platform)
    return velocity
