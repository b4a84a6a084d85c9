"""The peer: PHCpack's blackbox solver on the polynomial system of a platform on six legs.

In Study coordinates (e, g), with h_i = |2 g + e m_i - b_i e|^2 / 4 - L_i^2 |e|^2 / 4 for base
points b_i, platform points m_i and legs L_i (all over the largest coordinate), the eight equations
are

    e.g = 0,   h_1 = 0,   h_i - h_1 = 0 (i = 2..6),   c.e = 1 with random real c.

The last one picks one point of each ray and leaves out e = 0. Source of the peer: J. Verschelde,
Algorithm 795: PHCpack, ACM Transactions on Mathematical Software 25(2), 1999.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

import symkin
from symkin.spatial.rotation import multiply

NAMES = ("x0", "x1", "x2", "x3", "y0", "y1", "y2", "y3")
"""Names of e and g in PHCpack's text, where e and i are taken."""
_SETTLED, _POSE, _REAL = 1e-10, 1e-9, 1e-7
"""Largest last Newton step of a solution, relative; least |e.e| / |e|^2 of a pose; largest
imaginary part of a real one.
"""


@dataclass(frozen=True)
class Answer:
    """Wall time in seconds, distinct complex poses, real ones among them, and the solver's
    version.
    """

    seconds: float
    complex_count: int
    real: int
    version: str


def installed() -> bool:
    return shutil.which("phc") is not None


def solve(
    mechanism: symkin.Mechanism, joints: np.ndarray, seed: int, timeout: float
) -> Answer | None:
    """One blackbox run; None where it takes longer than `timeout` seconds. A leg is its joint value
    beyond its offset.
    """
    legs = np.asarray(joints) + [limb.offset for limb in mechanism.limbs]
    forms, patch = quadratic_forms(mechanism, legs), np.random.default_rng(seed).normal(size=4)
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "system", Path(folder) / "solutions"
        source.write_text(system_text(forms, patch))
        begin = time.perf_counter()
        try:
            subprocess.run(
                ["phc", "-b", str(source), str(target)],
                timeout=timeout,
                check=True,
                capture_output=True,
            )
        except subprocess.TimeoutExpired:
            return None
        seconds = time.perf_counter() - begin
        points = distinct(valid(read_solutions(target.read_text()), forms, patch))
    version = (
        subprocess.run(["phc", "--version"], capture_output=True, text=True, check=False)
        .stdout.split(" ")[0]
        .strip()
    )
    return Answer(
        seconds,
        len(points),
        int(np.sum(np.max(np.abs(points.imag), axis=1, initial=0.0) < _REAL)),
        version,
    )


def quadratic_forms(mechanism: symkin.Mechanism, legs: np.ndarray) -> list[np.ndarray]:
    """Symmetric matrices (8, 8) of the seven quadratic equations."""
    base, platform = (
        np.array([getattr(limb, side) for limb in mechanism.limbs]) for side in ("base", "platform")
    )
    scale = max(np.abs(base).max(), np.abs(platform).max())
    e, g = ca.SX.sym("e", 4), ca.SX.sym("g", 4)
    rows = [ca.dot(e, g)]
    for b, m, length in zip(base / scale, platform / scale, np.asarray(legs) / scale, strict=True):
        difference = 2 * g + multiply(e, ca.vertcat(0, *m)) - multiply(ca.vertcat(0, *b), e)
        rows.append((ca.sumsqr(difference) - length**2 * ca.sumsqr(e)) / 4)
    rows[2:] = [row - rows[1] for row in rows[2:]]
    return [np.asarray(ca.DM(ca.hessian(row, ca.vertcat(e, g))[0])) / 2 for row in rows]


def system_text(forms: list[np.ndarray], patch: np.ndarray) -> str:
    lines = []
    for form in forms:
        terms = [
            (form[i, j] * (1 if i == j else 2), f"{NAMES[i]}*{NAMES[j]}")
            for i in range(8)
            for j in range(i, 8)
        ]
        lines.append(
            "".join(f"{value:+.17g}*{name}" for value, name in terms if abs(value) > 1e-15)
        )
    lines.append("".join(f"{c:+.17g}*{name}" for c, name in zip(patch, NAMES, strict=False)) + "-1")
    return f"{len(lines)}\n" + "\n".join(f"{line};" for line in lines) + "\n"


def read_solutions(text: str) -> np.ndarray:
    """Points (n, 8) of the last list of solutions in PHCpack's output."""
    tail = text[text.rindex("THE SOLUTIONS") :]
    numbers = re.findall(r"^ (\w\d) :\s+(\S+)\s+(\S+)", tail, re.MULTILINE)
    values = {
        name: [complex(float(a), float(b)) for n, a, b in numbers if n == name] for name in NAMES
    }
    return np.array([values[name] for name in NAMES]).T


def valid(points: np.ndarray, forms: list[np.ndarray], patch: np.ndarray) -> np.ndarray:
    """Those that Newton's method settles on all equations, so settled, and that are poses."""
    row = np.concatenate([patch, np.zeros(4)])
    with np.errstate(all="ignore"):
        for _ in range(6):
            gradients = np.array(
                [points @ form for form in forms] + [np.broadcast_to(row, points.shape)]
            )
            errors = np.array(
                [np.sum(points * g, axis=1) for g in gradients[:-1]] + [points @ row - 1]
            )
            gradients[:-1] *= 2
            step = (np.linalg.pinv(gradients.transpose(1, 0, 2)) @ errors.T[:, :, None])[:, :, 0]
            points = points - step
        settled = np.max(np.abs(step), axis=1) <= _SETTLED * np.max(np.abs(points), axis=1)
        e = points[:, :4]
        pose = np.abs(np.sum(e * e, axis=1)) > _POSE * np.sum(np.abs(e) ** 2, axis=1)
    return np.asarray(points[settled & pose])


def distinct(points: np.ndarray) -> np.ndarray:
    kept: list[np.ndarray] = []
    for point in points:
        if all(
            np.max(np.abs(point - other)) > 1e-6 * max(1.0, np.abs(point).max()) for other in kept
        ):
            kept.append(point)
    return np.array(kept).reshape(len(kept), 8)
