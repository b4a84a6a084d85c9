"""Configurations of symkin on the rows of `tests/oracle/plain_graph.py`, which gives every link and
every joint coordinates of its own.
"""

from pathlib import Path

import numpy as np

from helpers.inside import Closure, joint_readings, link_poses
from oracle.plain_graph import Graph, read

ROOT = Path(__file__).resolve().parents[2]
MECHANISMS = ROOT / "symkin" / "mechanisms"


def plain_gap(path: Path, closure: Closure, values: np.ndarray) -> float:
    """The largest row (share of the size, rad) of the plain graph at full vectors of variables (m,
    variables) of a closure.
    """
    g, x = plain_configurations(path, closure, values)
    return float(np.max(np.abs(g.closure(x)[0])))


def plain_configurations(
    path: Path, closure: Closure, values: np.ndarray
) -> tuple[Graph, np.ndarray]:
    """The plain graph of a file, and its coordinates (m, all) at full vectors of variables of a
    closure.
    """
    g = read(path)
    poses = link_poses(closure, values)
    joints = joint_readings(closure, poses) | {
        c.name: values[:, closure.slices[c.name].start] for c in closure.role("actuated")
    }
    x = np.tile(g.reference(), (len(values), 1))
    for i, name in enumerate(g.names):
        x[:, 7 * i : 7 * i + 3] = poses[name].apply(g.size * g.centres[i][:, None]).T / g.size
        x[:, 7 * i + 3 : 7 * i + 7] = poses[name].quaternion.T
    for k, c in enumerate(g.coordinates):
        x[:, 7 * len(g.names) + k] = joints[c.name] / (1.0 if c.angle else g.size)
    return g, x
