"""What the bench solves: joint values as generated code reads them, starts, and the answers to
those numbers.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from subjects import HOME
from symkin.codegen.joint_map import JointMap
from symkin.codegen.program import Kind
from symkin.codegen.rod_platform import RodPlatform, sample_poses
from symkin.codegen.samples import rounded_to
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.vectors import build_vectors
from symkin.position.problem import build_problem
from symkin.spatial.rotation import multiply

vectors_of = lru_cache(maxsize=8)(build_vectors)
"""A folder's own vectors; kinds compare by identity."""


@lru_cache(maxsize=8)
def cases_of(kind: Kind) -> dict[str, np.ndarray]:
    """Tables by name: 64 poses about home for a platform whose home is HOME, the folder's own
    vectors for all others.
    """
    if isinstance(kind, RodPlatform) and kind.options.home == HOME:
        return platform_cases(kind)
    if isinstance(kind, JointMap):
        return map_cases(kind)
    vectors = vectors_of(kind)
    told = vectors.answers
    if isinstance(kind, SerialArm):
        return {"guesses": told["guesses"], "poses": told["poses"], "expected": told["inverse"]}
    return {
        "joints": told["joints"][1::2],
        "cold": np.tile(vectors.places["home"], (len(told["joints"]) // 2, 1)),
        "warm": told["guesses"][1::2],
        "expected": told["poses"][1::2],
    }


def map_cases(kind: JointMap) -> dict[str, np.ndarray]:
    """The map's own vectors that start next to their answers; `cold_...` is the reference, where
    the first starts.
    """
    derived = ("jacobians", "seconds")
    tables = {k: v for k, v in vectors_of(kind).answers.items() if k not in derived}
    cases = {name: table[1::2] for name, table in tables.items()}
    return cases | {
        "cold_guesses": tables["guesses"][:1],
        "cold_joint_guesses": tables["joint_guesses"][:1],
    }


def platform_cases(platform: RodPlatform) -> dict[str, np.ndarray]:
    """64 poses within 60 mm and 0.25 rad of home; warm starts lie within 0.2 mm and 1 mrad of the
    answer.
    """
    system = build_problem(platform.mechanism, "direct").system
    rng = np.random.default_rng(3)
    zero = platform.lengths(platform.home) if platform.options.home_relative else 0.0
    joints, warm, answers = [], [], []
    for pose in sample_poses(platform.home, 64, 60.0, 0.25, 7):
        given = rounded_to(platform.real, platform.joint_values(pose))
        z = np.array([*pose.position, *pose.quaternion])
        for _ in range(2):
            z = system.polish(z, given + zero, 8)
        origin = np.array(platform.home.position) if platform.options.home_relative else np.zeros(3)
        q = multiply(np.array([1.0, *(0.5 * rng.uniform(-1e-3, 1e-3, 3))]), z[3:])
        joints.append(given)
        warm.append([*(z[:3] + rng.uniform(-0.2, 0.2, 3) - origin), *(q / np.linalg.norm(q))])
        answers.append([*(z[:3] - origin), *z[3:]])
    home = np.tile(platform.stated(platform.home), (64, 1))
    return {
        "joints": np.array(joints),
        "cold": home,
        "warm": np.array(warm),
        "expected": np.array(answers),
    }
