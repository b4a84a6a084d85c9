"""Does NAME_OK mean the branch? Random poses about home, started from home, against a fine continuation.

For each pose the rods' lengths are followed along the straight line from home in many small steps, all poses at once in
NumPy (double), with two Newton steps each; a line is regular where det J keeps its sign and every step converges. The
generated C is then asked for the same lengths with home as the guess.

    python codegen/bench/branches.py [--poses 5000] [--reach 180] [--tilt 1.0] [--real double] [--seed 0]
"""

from __future__ import annotations

import argparse
import ctypes
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from symkin.firmware.folder import write_folder
from symkin.firmware.options import Options
from symkin.model.file import load
from symkin.model.limb import RodLimb

HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
STEPS = 400


def rotations(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q.T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
        ],
        1,
    )


def turned(q: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(1, half) q, of unit length."""
    w, u = q[:, :1], q[:, 1:]
    new = np.concatenate([w - np.sum(half * u, 1, keepdims=True), u + w * half + np.cross(half, u)], 1)
    return np.asarray(new / np.linalg.norm(new, axis=1, keepdims=True))


def vectors(x: np.ndarray, base: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    arms = np.einsum("nij,kj->nki", rotations(x[:, 3:]), end)
    return arms, x[:, None, :3] + arms - base


def newton(x: np.ndarray, lengths: np.ndarray, base: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    arms, d = vectors(x, base, end)
    matrix = np.concatenate([d, np.cross(arms, d)], 2)
    rows = 0.5 * (lengths**2 - np.sum(d * d, 2))
    sign, _ = np.linalg.slogdet(matrix)
    bad = sign == 0
    matrix[bad] = np.eye(6)
    step = np.linalg.solve(matrix, rows[..., None])[..., 0]
    step *= np.minimum(1.0, 50.0 / np.maximum(1e-9, np.linalg.norm(step[:, :3], axis=1)))[:, None]
    moved = np.concatenate([x[:, :3] + step[:, :3], turned(x[:, 3:], 0.5 * step[:, 3:])], 1)
    return moved, sign, np.max(np.abs(rows), 1)


def continued(lengths: np.ndarray, base: np.ndarray, end: np.ndarray, home: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses at the ends of the lines from home, and which lines are regular; lines that fail are walked ever finer."""
    x, regular = walked(lengths, base, end, home, STEPS)
    for finer in (8, 64):
        again = np.flatnonzero(~regular)
        if len(again):
            x[again], regular[again] = walked(lengths[again], base, end, home, finer * STEPS)
    return x, regular


def walked(lengths: np.ndarray, base: np.ndarray, end: np.ndarray, home: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    x = np.repeat(home[None], len(lengths), 0)
    _, d = vectors(x, base, end)
    start = np.linalg.norm(d, axis=2)
    regular = np.ones(len(lengths), dtype=bool)
    sign0 = newton(x[:1], start[:1], base, end)[1][0]
    for k in range(1, steps + 1):
        target = start + k / steps * (lengths - start)
        once, sign, _ = newton(x, target, base, end)
        twice, after, _ = newton(once, target, base, end)
        first = np.linalg.norm(once - x, axis=1)
        second = np.linalg.norm(twice - once, axis=1)
        regular &= (sign == sign0) & (after == sign0) & (second < 0.1 * first + 1e-9)
        x = np.where(regular[:, None], twice, home)
    for _ in range(3):
        x, sign, rows = newton(x, lengths, base, end)
    return x, regular & (rows < 1e-6) & (sign == sign0)


def generated(real: str, home: tuple[float, ...]) -> ctypes.CDLL:
    folder = Path(tempfile.mkdtemp())
    write_folder(load("zhang2009"), folder, Options(real, home=home))  # type: ignore[arg-type]
    command = [
        "gcc",
        "-O2",
        "-std=c99",
        "-fno-math-errno",
        "-ffp-contract=off",
        "-shared",
        "-fPIC",
        "zhang2009.c",
        "-o",
        "z.so",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "z.so"))


def study(poses: int, reach: float, tilt: float, real: str, seed: int = 0) -> dict[str, float]:
    mechanism = load("zhang2009")
    limbs = [limb for limb in mechanism.limbs if isinstance(limb, RodLimb)]
    base, end = np.array([limb.base for limb in limbs]), np.array([limb.platform for limb in limbs])
    rng = np.random.default_rng(seed)
    home = np.array(HOME)
    goal = np.repeat(home[None], poses, 0)
    goal[:, :3] += rng.uniform(-reach, reach, (poses, 3))
    r = rng.uniform(-tilt, tilt, (poses, 3))
    angle = np.linalg.norm(r, axis=1, keepdims=True)
    goal[:, 3:] = np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * r / angle], 1)
    number = np.float32 if real == "float" else np.float64
    lengths = np.linalg.norm(vectors(goal, base, end)[1], axis=2).astype(number).astype(float)
    reached, regular = continued(lengths, base, end, home)
    library = generated(real, HOME)
    c = ctypes.c_float if real == "float" else ctypes.c_double
    guess, joints, pose = (c * 7)(*HOME), (c * 6)(), (c * 7)()
    ok, right, iterations = np.zeros(poses, bool), np.zeros(poses, bool), np.zeros(poses, int)
    statuses: dict[int, int] = {}
    info = (ctypes.c_ubyte * 64)()
    for k in range(poses):
        joints[:] = lengths[k].tolist()
        status = library.zhang2009_direct(None, joints, guess, pose, info)
        statuses[status] = statuses.get(status, 0) + 1
        ok[k], iterations[k] = status == 0, info[0]
        right[k] = np.max(np.abs(np.array(pose[:3]) - reached[k, :3])) < (1e-2 if real == "float" else 1e-4)
    return {
        "poses": poses, "regular": int(regular.sum()), "ok": int(ok.sum()), "ok but another pose": int((ok & ~(right & regular)).sum()),
        "ok of regular, %": 100.0 * float((ok & regular).sum()) / float(regular.sum()),
        "mean steps": float(iterations.mean()), "most steps": int(iterations.max()), "statuses": str(dict(sorted(statuses.items()))),
    }  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--poses", type=int, default=5000)
    parser.add_argument("--reach", type=float, default=180.0)
    parser.add_argument("--tilt", type=float, default=1.0)
    parser.add_argument("--real", default="double")
    parser.add_argument("--seed", type=int, default=0)
    for key, value in study(**vars(parser.parse_args())).items():
        print(f"{key}: {value}")
