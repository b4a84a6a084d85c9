"""The platform of Dietmaier with 40 real modes, and all complex roots of known problems."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

import numpy as np

import symkin
from helpers.inside import (
    AlgebraicSystem,
    Problem,
    build_problem,
    instance,
    known_values,
    merge,
    start_of,
    system_of,
)
from symkin import Mechanism, RodLimb

DIETMAIER = json.loads((Path(__file__).parents[1] / "data" / "dietmaier1998.json").read_text())


def dietmaier() -> Mechanism:
    """The platform with 40 real modes (P. Dietmaier, Advances in Robot Kinematics 1998, 1-10)."""
    pairs = zip(DIETMAIER["base"], DIETMAIER["platform"], strict=True)
    return Mechanism(
        "dietmaier1998", [RodLimb(f"leg{i}", b, p) for i, (b, p) in enumerate(pairs, start=1)]
    )


Case = tuple[Problem, AlgebraicSystem, np.ndarray, np.ndarray]
"""Problem, system, known values k and roots z."""


@lru_cache(maxsize=16)
def case(name: str) -> Case:
    """All complex roots of a shipped mechanism's (or Dietmaier's) example: by paths, those of an
    arm by random starts.
    """
    mechanism = dietmaier() if name == "dietmaier" else symkin.load(name)
    if mechanism.serial:
        pose = symkin.modes(mechanism, method="multistart", starts=300)[0].pose
        kind, values = "inverse", np.concatenate([pose.position, pose.quaternion])
    else:
        kind, values = (
            "direct",
            np.array(
                DIETMAIER["legs"] if name == "dietmaier" else mechanism.example.joints, dtype=float
            ),
        )
    problem = build_problem(mechanism, kind)
    system = system_of(problem)
    k = known_values(problem, values)
    if kind == "inverse":
        return problem, system, k, complex_roots(system, k)
    start, _ = start_of(problem, system)
    return problem, system, k, instance(system, start, k).z


def complex_roots(system: AlgebraicSystem, k: np.ndarray, starts: int = 6000) -> np.ndarray:
    """Regular roots that Newton's method reaches from random complex angles."""
    rng = np.random.default_rng(0)
    z = rng.uniform(-np.pi, np.pi, (system.width, starts)) + 1j * rng.normal(
        size=(system.width, starts)
    )
    with np.errstate(all="ignore"):
        for _ in range(40):
            f, j = system.linearise(z, np.repeat(k[:, None], z.shape[1], axis=1))
            fine = np.isfinite(j).all(axis=(1, 2)) & (np.max(np.abs(z.imag), axis=0) < 12)
            z, f, j = z[:, fine], f[fine], j[fine]
            step = np.linalg.solve(j, f[:, :, None])[:, :, 0].T
            z = system.normalise(z - step * np.minimum(1.0, 1.0 / np.max(np.abs(step), axis=0)))
    z = z[:, np.max(np.abs(step), axis=0) < 1e-10]
    features = system.features(z)
    return z[:, merge(np.hstack([features.real, features.imag]), 1e-6)[0]]
