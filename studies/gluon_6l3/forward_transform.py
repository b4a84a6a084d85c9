"""The pose of a serial chain in sines and cosines of sums of angles: turns about parallel axes add
up to one turn.

Joint k turns by t_k about the axis s_k through a point, or slides by t_k along it; v_k is the
vector from its point to the next joint's (the tool's for the last), v_0 that from the base to the
first, N the tool's rotation, all at t = 0. Within a run of joints whose axes of rotation are
parallel, s_k = +-s, the rotations from the first to joint k are one, R(s, +-t_i ... +-t_k), so that
a point x behind the run moves to

    x' = sum_k R(s, t_i..k) (v_k + t_k s_k where k slides) + R(s, t_i..j) x,
    R(s, t) = cos t (I - s s^T) + sin t [s x] + s s^T.

Runs are found from the axes. Symbols are named as in textbooks: c234 = cos(t_2 + t_3 + t_4), s2-3 =
sin(t_2 - t_3).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

import symkin
from symkin.spatial.rotation import matrix_from_quaternion

PARALLEL = 1e-9
"""Largest component of s_i x s_k of axes that count as parallel."""
EXACT = 1e-12
"""Components this near to -1, 0 or 1 are these: what remains of cos(90 deg)."""


def snapped(numbers: np.ndarray) -> np.ndarray:
    whole = np.round(numbers)
    return np.where(np.abs(numbers - whole) < EXACT, whole, numbers) + 0.0


@dataclass(frozen=True, eq=False)
class Chain:
    """Kinds ("R", "P") and axes (n x 3) of the joints, the n + 1 link vectors, and the tool's
    rotation, all at t = 0; `first` is the number of the first joint.
    """

    kinds: Sequence[str]
    axes: np.ndarray
    links: Sequence[ca.SX]
    home: np.ndarray
    first: int = 1


def chain_of_dh(
    d: Sequence[object], a: Sequence[object], alpha: Sequence[float], first: int = 1
) -> Chain:
    """Revolutes by standard DH, angles t_k the DH angles themselves; lengths are numbers or
    symbols, alpha in radians.
    """
    R, axes, links = np.eye(3), [], [ca.SX.zeros(3)]
    for length, shift, twist in zip(d, a, alpha, strict=True):
        axes.append(R[:, 2])
        links.append(ca.mtimes(ca.SX(R), ca.vertcat(shift, 0, length)))
        c, s = np.cos(twist), np.sin(twist)
        R = snapped(R @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]))
    return Chain("R" * len(axes), np.array(axes), links, R, first)


def chain_of(arm: symkin.Mechanism) -> Chain:
    """The joints of a serial mechanism, lengths as numbers; t_k are its joint values."""
    joints = [joint for _, joint in arm.joints]
    points = [
        np.zeros(3),
        *(np.array(j.point, float) for j in joints),
        np.array(arm.platform_position, float),
    ]
    axes = np.array([np.array(j.axis, float) / np.linalg.norm(j.axis) for j in joints])
    home = np.array(matrix_from_quaternion(arm.reference_pose.quaternion), float)
    return Chain(
        [j.type for j in joints],
        snapped(axes),
        [ca.SX(v) for v in np.diff(points, axis=0)],
        snapped(home),
    )


@dataclass(frozen=True, eq=False)
class Transform:
    """T (4 x 4) in the symbols of `sums`, name -> (cosine, sine, angle as an expression of t), and
    in slides t_k.
    """

    chain: Chain
    t: ca.SX
    T: ca.SX
    runs: list[list[int]]
    sums: dict[str, tuple[ca.SX, ca.SX, ca.SX]] = field(default_factory=dict)

    def function(self) -> ca.Function:
        """t -> T."""
        symbols = ca.vertcat(*(part for c, s, _ in self.sums.values() for part in (c, s)))
        values = ca.vertcat(
            *(f(angle) for _, _, angle in self.sums.values() for f in (ca.cos, ca.sin))
        )
        return ca.Function(
            "T", [self.t], [ca.substitute(self.T, symbols, values)], ["t"], ["T"], {"cse": True}
        )

    def evidence(self) -> dict[str, object]:
        """What was run, for a row of a report."""
        return {
            "by": f"{__name__}.forward_transform",
            "method": "forward_transform",
            "text": "forward_transform()",
        }


def runs_of(chain: Chain) -> Iterator[list[int]]:
    """Neighbouring joints whose revolutes are parallel; slides belong to the run that they stand
    in.
    """
    run: list[int] = []
    axis = None
    for k, (kind, s) in enumerate(zip(chain.kinds, chain.axes, strict=True)):
        if kind == "R" and axis is not None and np.abs(np.cross(axis, s)).max() > PARALLEL:
            yield run
            run, axis = [], None
        run.append(k)
        axis = s if kind == "R" else axis
    yield run


def forward_transform(chain: Chain) -> Transform:
    """The tool's pose, from the last run inwards."""
    count = len(chain.kinds)
    t = ca.vertcat(*(ca.SX.sym(f"t{k + chain.first}") for k in range(count)))
    found = Transform(chain, t, ca.SX(4, 4), list(runs_of(chain)))
    x, R = ca.SX.zeros(3), ca.SX(chain.home)
    for run in reversed(found.runs):
        x, R = _carried(found, run, x, R)
    found.T[:3, :3], found.T[:3, 3], found.T[3, 3] = R, chain.links[0] + x, 1
    return found


def _carried(found: Transform, run: list[int], x: ca.SX, R: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Point and rotation behind a run, carried in front of it."""
    chain, signs = found.chain, dict[int, int]()
    axis, position = None, ca.SX.zeros(3)
    for k in run:
        step = chain.links[k + 1]
        if chain.kinds[k] == "R":
            axis = chain.axes[k] if axis is None else axis
            signs[k] = 1 if chain.axes[k] @ axis > 0 else -1
        else:
            step = step + found.t[k] * chain.axes[k]
        if k == run[-1]:
            step = step + x
        position += _turned(found, axis, signs, step)
    return position, _turned(found, axis, signs, R)


def _turned(found: Transform, axis: np.ndarray | None, signs: dict[int, int], x: ca.SX) -> ca.SX:
    """R(axis, sum of the angles so far) x; rotations that leave x need no symbol."""
    if axis is None:
        return x
    along = ca.mtimes(ca.SX(np.outer(axis, axis)), x)
    across, quarter = (
        ca.mtimes(ca.SX(snapped(np.eye(3) - np.outer(axis, axis))), x),
        ca.mtimes(ca.skew(ca.SX(axis)), x),
    )
    if across.is_zero():
        return x
    c, s = _symbols(found, signs)
    return c * across + s * quarter + along


def _symbols(found: Transform, signs: dict[int, int]) -> tuple[ca.SX, ca.SX]:
    """Cosine and sine of a sum of angles, named by its joints."""
    gap = "" if found.chain.first + len(found.chain.kinds) <= 10 else "+"
    name = "".join(
        ("-" if sign < 0 else gap) + str(k + found.chain.first) for k, sign in signs.items()
    ).removeprefix("+")
    if name not in found.sums:
        angle = ca.sum1(ca.vertcat(*(sign * found.t[k] for k, sign in signs.items())))
        found.sums[name] = ca.SX.sym(f"c{name}"), ca.SX.sym(f"s{name}"), angle
    c, s, _ = found.sums[name]
    return c, s
