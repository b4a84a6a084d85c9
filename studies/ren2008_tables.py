"""What XJ-HEXAS's paper prints, and what is assumed where it prints nothing: shared by the studies of it.

Notation: |t + R m_i - b_i| = dl_i + l_i; m_i platform joints, b_i base joints in the paper's joint frames, dl_i the fixed
rod length, l_i the measured extension; R = Rz(gamma) Ry(beta) Rx(alpha), turns about fixed axes ('xyz'). Units: m, deg.
Source: Ren, Feng, Su, Journal of Xi'an Jiaotong University 42(12), 2008, tables 1 (nominal), 2 (true), 3 (deviations).

Every entry of table 1 is read. In table 2 two are illegible in our copy and assumed; hidden zeros are zero by the frames.
The workspace is not printed and is assumed: centre of the platform's joint circle within 0.25 m in x and y of the centre of
the base's, z 1.15 to 1.45 m, angles within 20 deg, extensions 0 to 0.55 m.
"""

from __future__ import annotations

import numpy as np

import symkin
from symkin.calibration.data.parameters import joint_frames

NOMINAL = {
    "base": [(0, 0, 0), (0.1504, 0, 0), (0.6283, 0.8278, 0), (0.5531, 0.958, 0), (-0.4027, 0.958, 0), (-0.4779, 0.8278, 0)],
    "platform": [(0, 0, 0), (0.7687, 0, 0), (0.8255, 0.0984, 0), (0.4412, 0.7642, 0), (0.3275, 0.7642, 0), (-0.0568, 0.0984, 0)],
    "offset": [1.2] * 6,
}
TRUE = {
    "base": [
        (0, 0, 0), (0.1543, 0, 0.0025), (0.6233, 0.8256, -0.005),
        (0.5506, 0.9599, 0.003), (-0.4068, 0.9549, 0.0049), (-0.4761, 0.8251, 0.004),
    ],
    "platform": [
        (0, 0, 0), (0.7637, 0, 0), (0.8295, 0.0993, 0.002),
        (0.4436, 0.7672, 0.005), (0.3233, 0.7612, -0.003), (-0.0587, 0.0964, 0),
    ],
    "offset": [1.2037, 1.1981, 1.205, 1.1963, 1.2026, 1.1969],
}  # fmt: skip
DEVIATIONS = {
    "base": [
        (0, 0, 0), (-3.6e-11, 0, -6.6e-12), (3.5e-10, 7.1e-10, -7.9e-10),
        (-3.7e-10, 2.1e-10, 1e-11), (-2.8e-10, -9.9e-11, -2.3e-10), (-3.4e-10, -8.7e-11, 1.8e-10),
    ],
    "platform": [
        (0, 0, 0), (-3.6e-11, 0, 0), (-1.7e-10, 1.3e-10, 6.1e-10),
        (-1.3e-10, 1.1e-10, 3.2e-10), (-6.6e-11, -3.1e-11, -2.4e-10), (-1.7e-10, 1.7e-10, 0),
    ],
    "offset": [-1.8e-11, -5.2e-11, -8.6e-11, -5.5e-11, -1.1e-11, -2.4e-10],
}  # fmt: skip
"""Table 3: identified less true without noise."""
ASSUMED = {"z of M5": -0.0030, "z of B2": 0.0025}
"""The two true values that are illegible: z of M5 is negative, z of B2 positive, each at most 5 mm."""
BY_FRAME = ("leg1", "leg2", "leg6"), ("leg1", "leg2")
"""Joints in which the paper's platform and base frames stand: ten entries are zero by definition."""
HEIGHTS, ASIDE, TILT, EXTENSIONS = (1.15, 1.45), 0.25, 20.0, (0.0, 0.55)


def circle(points: list) -> tuple[np.ndarray, float, float]:
    """Centre, radius and largest distance from the circle of points in the xy plane: |x|^2 = 2 c.x + k."""
    xy = np.array(points)[:, :2]
    solution = np.linalg.lstsq(np.column_stack([2 * xy, np.ones(len(xy))]), (xy**2).sum(axis=1), rcond=None)[0]
    distances = np.linalg.norm(xy - solution[:2], axis=1)
    radius = float(distances.mean())
    return np.append(solution[:2], 0.0), radius, float(np.abs(distances - radius).max())


PLATFORM_CENTRE, BASE_CENTRE = circle(NOMINAL["platform"])[0], circle(NOMINAL["base"])[0]


def held_names(mechanism: symkin.Mechanism) -> tuple[str, ...]:
    """The ten parameters that are zero by the paper's frames."""
    return joint_frames(mechanism, *BY_FRAME)
