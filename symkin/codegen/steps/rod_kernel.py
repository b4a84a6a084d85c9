"""State the Newton iteration of a platform on six rods: no trigonometry, constant moments, few
operations.

A rod of length L from the base point b to the platform point a spans d = p + R a - b; its row is
L^2 - d.d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.codegen.steps.newton_kernel import Kernel, Meaning
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import cross, dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, rotate

_ABSOLUTE = Meaning(
    state="position p and unit quaternion q (w, x, y, z) of the platform",
    known="squared rod lengths L_i^2",
    rows="L_i^2 - d_i . d_i, d_i = p + R(q) a_i - b_i",
    step="(2 v, h): velocity v of the platform where the base's origin is, and half its turn h",
    shared="rod vectors d_i, from the base point to the platform point",
)
_RELATIVE = Meaning(
    state="displacement p and turn q (w, x, y, z) of the platform from home",
    known="(2 L0_i + dL_i) dL_i of the rods' changes dL_i from their lengths L0_i at home",
    rows="k_i - (2 d0_i + delta_i) . delta_i, delta_i the change of rod vector d_i from home",
    step="(2 v, h): velocity v of the platform where the base's origin is, and half its turn h",
    shared="rod vectors d_i, from the base point to the platform point",
)


@dataclass(frozen=True, eq=False)
class Rods:
    """Geometry of a platform on six rods: |p + R a - b| = offset + joint; numbers, or symbols of a
    struct.

    In the home-relative form p and R are displacements from home and `points` are R_home a; `home`
    holds the rods' vectors d0 there.
    """

    bases: tuple[ca.SX, ...]
    points: tuple[ca.SX, ...]
    offsets: tuple[ca.SX, ...]
    home_position: ca.SX
    home: tuple[ca.SX, ...] | None

    @property
    def home_lengths(self) -> tuple[ca.SX, ...]:
        assert self.home is not None  # noqa: S101 - asked for in the home-relative form only
        return tuple(ca.sqrt(dot(d, d)) for d in self.home)


def is_rod_platform(mechanism: Mechanism) -> bool:
    """Six rods and a free pose: the fast kernel without trigonometry."""
    joints = any(limb.joints for limb in mechanism.limbs)
    return not joints and len(mechanism.limbs) == 6 and mechanism.motion == "spatial"


def rod_geometry(
    mechanism: Mechanism, home: Pose, *, relative: bool, parameters: ca.SX | None
) -> Rods:
    """The rods as snapped numbers, or as entries of `parameters` (base, platform, offset of each
    limb).
    """
    bases, points, offsets, size = [], [], [], mechanism.characteristic_length
    for k, bar in enumerate(mechanism.bars):
        if parameters is not None:
            g = parameters[7 * k : 7 * k + 7]
            base, end, offset = g[:3], g[3:6], g[6]
        else:
            base, end, offset = (
                _snapped(bar.start.point, size),
                _snapped(bar.end.point, size),
                ca.SX(snap(float(bar.offset), size)),
            )
        bases.append(base)
        points.append(end)
        offsets.append(offset)
    position = _snapped(home.position, size)
    if not relative:
        return Rods(tuple(bases), tuple(points), tuple(offsets), position, None)
    turned = [rotate(_snapped(home.quaternion, 1.0), a) for a in points]
    if parameters is None:
        turned = [_snapped(np.asarray(ca.DM(a)).ravel(), size) for a in turned]
    starts = tuple(position + a - b for a, b in zip(turned, bases, strict=True))
    return Rods(tuple(bases), tuple(turned), tuple(offsets), position, starts)


def _snapped(values: Sequence[float] | np.ndarray, scale: float) -> ca.SX:
    return ca.SX(ca.DM([snap(float(v), scale) for v in values]))


def _times(c: ca.SX, x: ca.SX) -> ca.SX:
    """c x with the sign of a constant outside, so that +-c x is computed once."""
    if c.is_constant() and float(c) < 0:
        return -(ca.SX(-float(c)) * x)
    return c * x


def _rotation_rows(q: ca.SX, *, less_identity: bool) -> list[list[ca.SX]]:
    """R(q), or R(q) - 1 without cancellation, entry by entry."""
    w, x, y, z = (q[k] for k in range(4))
    # R = 1 + 2 w [u] + 2 [u]^2 with u = (x, y, z); without the 1 nothing cancels near home
    x2, y2, z2 = 2 * x, 2 * y, 2 * z
    xx, yy, zz = x2 * x, y2 * y, z2 * z
    xy, xz, yz, wx, wy, wz = x2 * y, x2 * z, y2 * z, x2 * w, y2 * w, z2 * w
    diagonal = [-(yy + zz), -(xx + zz), -(xx + yy)]
    if not less_identity:
        diagonal = [1 - (yy + zz), 1 - (xx + zz), 1 - (xx + yy)]
    return [
        [diagonal[0], xy - wz, xz + wy],
        [xy + wz, diagonal[1], yz - wx],
        [xz - wy, yz + wx, diagonal[2]],
    ]


def _rotated(r: Sequence[Sequence[ca.SX]], a: ca.SX) -> ca.SX:
    return ca.vertcat(
        *(_times(a[0], row[0]) + _times(a[1], row[1]) + _times(a[2], row[2]) for row in r)
    )


def _moved_points(
    r: Sequence[Sequence[ca.SX]], points: Sequence[ca.SX], position: ca.SX
) -> list[ca.SX]:
    """position + R a, the terms that points share summed first."""
    # platforms have points with equal coordinates: products with these are summed first, once for
    # all
    keys = [[str(a[k]) for k in range(3)] for a in points]
    moved = []
    for a, own in zip(points, keys, strict=True):
        shared = [sum(other[k] == own[k] for other in keys) for k in range(3)]
        order = sorted(range(3), key=lambda k: -shared[k])
        parts = []
        for i, row in enumerate(r):
            total = position[i]
            for k in order:
                total = total + _times(a[k], row[k])
            parts.append(total)
        moved.append(ca.vertcat(*parts))
    return moved


def rod_vectors(
    rods: Rods, position: ca.SX, quaternion: ca.SX
) -> tuple[list[ca.SX], list[ca.SX], list[ca.SX]]:
    """(R a, d, delta) of each rod; R a and d less their home values are exact near home in the
    home-relative form.
    """
    r = _rotation_rows(quaternion, less_identity=rods.home is not None)
    arms = [_rotated(r, a) for a in rods.points]
    changes = _moved_points(r, rods.points, position)
    if rods.home is None:
        ends = [change - b for change, b in zip(changes, rods.bases, strict=True)]
        return arms, ends, ends
    whole = [arm + a for arm, a in zip(arms, rods.points, strict=True)]
    return whole, [d0 + change for d0, change in zip(rods.home, changes, strict=True)], changes


def rod_kernel(mechanism: Mechanism, rods: Rods, geometry: ca.SX, home: Pose) -> Kernel:
    """Rows L^2 - d.d over the pose; unknowns are (2 v0, w / 2), v0 the velocity of the platform at
    the base origin, because d.(v0 + w x (b + d)) = d.v0 + (b x d).w has the constant b: J = [d, 4 b
    x d].

    Home-relative: d.d - L^2 = (2 d0 + delta).delta - (2 L0 + dL) dL. `known` holds L^2 or (2 L0 +
    dL) dL.
    """
    position, quaternion, known = ca.SX.sym("p", 3), ca.SX.sym("q", 4), ca.SX.sym("k", 6)
    step, d_symbols = ca.SX.sym("s", 6), ca.SX.sym("d", 18)
    _, d, delta = rod_vectors(rods, position, quaternion)
    if rods.home is None:
        rows = [known[i] - dot(d[i], d[i]) for i in range(6)]
    else:
        rows = [known[i] - dot(2 * rods.home[i] + delta[i], delta[i]) for i in range(6)]
    # half the derivative of d.d is d.v0 + (b x d).w; by (2 v0, w / 2) its row is (d, 4 b x d), the
    # factor 1/2 cancelled
    jacobian = []
    for i, base in enumerate(rods.bases):
        di, b4 = d_symbols[3 * i : 3 * i + 3], 4 * base
        m = [_times(b4[j], di[k]) - _times(b4[k], di[j]) for j, k in ((1, 2), (2, 0), (0, 1))]
        jacobian.append(ca.horzcat(di.T, *m))
    # v = v0 + w x p at the platform's origin, by s = (2 v0, h = w / 2): v = (s[:3] + 4 h x p) / 2
    half = step[3:]
    where = position if rods.home is None else position + rods.home_position
    velocity = 0.5 * (step[:3] + cross(4 * half, where))
    turned = multiply(ca.vertcat(1, half), quaternion)
    # |(1, h) q| = sqrt(1 + h.h) for a unit quaternion q
    inverse = 1 / ca.sqrt(1 + dot(half, half))
    # L^2 - d.d is 2 L times the error of a length: the mean length turns rows into lengths
    size = mechanism.characteristic_length
    lengths = [
        float(np.linalg.norm(home.apply(np.array(limb.platform)) - np.array(limb.base)))  # type: ignore[union-attr]
        for limb in mechanism.limbs
    ]
    return Kernel(
        name="direct",
        state=ca.vertcat(position, quaternion),
        known=known,
        geometry=geometry,
        step=step,
        shared_symbols=d_symbols,
        rows=ca.vertcat(*rows),
        shared=ca.vertcat(*d),
        jacobian=ca.vertcat(*jacobian),
        moved=ca.vertcat(position + velocity, *(turned[k] * inverse for k in range(4))),
        norm=dot(velocity, velocity) + 4 * size * size * dot(half, half),
        row_length=0.5 / float(np.mean(lengths)),
        characteristic_length=size,
        meaning=replace(
            _ABSOLUTE if rods.home is None else _RELATIVE,
            each_row=tuple(c.name for c in mechanism.actuated),
        ),
        is_pose=True,
    )
