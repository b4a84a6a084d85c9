"""Tilt and torsion: R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth), and what each of them says of a
quaternion.

The unit quaternion is (cos t/2 cos s/2, -sin t/2 sin(a - s/2), sin t/2 cos(a - s/2), cos t/2 sin
s/2) with azimuth a, tilt t and torsion s. Source: I. A. Bonev, D. Zlatanov, C. M. Gosselin,
Advantages of the modified Euler angles in the design and control of PKMs, Parallel Kinematic
Machines International Conference 2002.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from symkin.spatial.backend import Array, atan2, sqrt, where


def tilt_and_torsion(quaternion: np.ndarray) -> tuple[float, float, float]:
    """Azimuth, tilt and torsion (radians) of a unit quaternion; without a tilt the azimuth is 0."""
    return tuple(
        float(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))
        for angle in tilt_and_torsion_of(quaternion)
    )  # type: ignore[return-value]


def tilt_and_torsion_of(quaternion: Array) -> tuple[Array, Array, Array]:
    """Azimuth, tilt and torsion of a unit quaternion, numbers or expressions, up to whole turns."""
    w, x, y, z = (quaternion[i] for i in range(4))
    across = x * x + y * y
    tilt = 2.0 * atan2(sqrt(across), sqrt(w * w + z * z))
    torsion = 2.0 * atan2(z, w)
    azimuth = where(across > 0.0, atan2(-x, y) + 0.5 * torsion, 0.0)
    return azimuth, tilt, torsion


def rotation_conditions(
    quaternion: ca.SX, given: Mapping[str, ca.SX]
) -> tuple[list[ca.SX], list[ca.SX]]:
    """Rows that vanish where a quaternion has the azimuth, tilt and torsion that are `given`, and
    their checks, which vanish nowhere else; numbers of order one.

    With z' the platform's third axis: tilt is the angle of z' with z; azimuth, where it is given
    alone, the half plane of z'; both together say z' itself; torsion is 2 atan2(q3, q0).
    """
    w, x, y, z = (quaternion[i] for i in range(4))
    axis = ca.vertcat(2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z)
    norm = w * w + x * x + y * y + z * z
    rows: list[ca.SX] = []
    checks: list[ca.SX] = []
    if "azimuth" in given and "tilt" in given:
        a, t = given["azimuth"], given["tilt"]
        wanted = ca.vertcat(ca.sin(t) * ca.cos(a), ca.sin(t) * ca.sin(a), ca.cos(t))
        rows += ca.vertsplit(axis - norm * wanted)
    elif "tilt" in given:
        rows.append(axis[2] - norm * ca.cos(given["tilt"]))
    elif "azimuth" in given:
        c, s = ca.cos(given["azimuth"]), ca.sin(given["azimuth"])
        rows.append(s * axis[0] - c * axis[1])
        # the row vanishes on both sides of the axis, the check on that of the azimuth alone
        checks.append(ca.sqrt(axis[0] ** 2 + axis[1] ** 2) - c * axis[0] - s * axis[1])
    if "torsion" in given:
        rows.append(2 * (w * ca.sin(0.5 * given["torsion"]) - z * ca.cos(0.5 * given["torsion"])))
    return rows, [*rows, *checks]
