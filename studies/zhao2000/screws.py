"""Screws of the 3-TRT + SPS platform: the five of each limb, their reciprocal couple, mobility, the
choice of inputs; their rows.

Twists are rows (s; s0), direction and moment about O, in (1; mm). Limb i has the revolutes a_i z,
a_i h, b_i h, c_i h, c_i z, h horizontal across the limb; the SPS limb exerts one force along OP and
lets its slide follow. Source: see `study`.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

import symkin
from studies.shared.report import Report
from studies.shared.screws import reciprocal_product
from studies.zhao2000.model import BASE, LINK, SIZE, TABLE_1, corners, inverse
from symkin.model.limb import Limb
from symkin.plots.figures import figure_of_sketch

if TYPE_CHECKING:
    from matplotlib.figure import Figure
from symkin.position.limb_screws import reciprocal_system
from symkin.spatial.screw import revolute_screw

PLATFORM_NAME, LINKS_NAME = "zhao2000", "zhao2000_links"
INDEPENDENT = 1e-9
"""Singular values below this, rows normalised, count as zero."""
JOINTS = ("base R", "lower R", "elbow R", "upper R", "platform R")
"""The five revolutes of a TRT limb, from the base."""


def elbow(pose, i: int, *, outward: bool) -> np.ndarray:
    """b_i at 70 mm from a_i and C_i in the limb's plane."""
    a, c = np.array([*BASE[i], 0.0]), corners(pose)[i]
    across = np.cross(c - a, [*(c - a)[1::-1] * (1, -1), 0.0])
    offset = math.sqrt(LINK**2 - np.dot(c - a, c - a) / 4) * across / np.linalg.norm(across)
    return (a + c) / 2 + (offset if (across[:2] @ BASE[i] > 0) == outward else -offset)


def limb_twists(pose, i: int) -> np.ndarray:
    """The five revolutes of limb i, elbow outward, as rows of twists about O."""
    a, c = np.array([*BASE[i], 0.0]), corners(pose)[i]
    theta, up = math.radians(inverse(pose)[i]), np.array([0.0, 0.0, 1.0])
    level = np.array([math.sin(theta), -math.cos(theta), 0.0])
    places = [(a, up), (a, level), (elbow(pose, i, outward=True), level), (c, level), (c, up)]
    return np.array([revolute_screw(point, axis) for point, axis in places])


def couple(pose, i: int) -> np.ndarray:
    """The wrench (force; moment) reciprocal to limb i's twists, of unit moment: a couple."""
    (wrench,) = reciprocal_system(limb_twists(pose, i), SIZE)
    return np.asarray(wrench / np.linalg.norm(wrench[3:]))


def work(twists: np.ndarray, wrench: np.ndarray) -> float:
    """Largest work of a wrench on the twists."""
    return max(abs(float(reciprocal_product(t, wrench))) for t in twists)


def rank(rows: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(rows, tol=INDEPENDENT))


def freedoms_left(pose, locked: tuple[int, ...]) -> int:
    """Freedoms of the platform with these joints locked: 5 i + k is revolute k of limb i, 15 the
    slide of the SPS limb.
    """
    wrenches = []
    for i in range(3):
        kept = [k for k in range(5) if 5 * i + k not in locked]
        wrenches.append(reciprocal_system(limb_twists(pose, i)[kept], SIZE) if kept else np.eye(6))
    if 15 in locked:
        wrenches.append(np.array([[*pose[:3], 0.0, 0.0, 0.0]]))
    stacked = np.vstack(wrenches)
    stacked[:, 3:] /= SIZE
    return 6 - rank(stacked / np.linalg.norm(stacked, axis=1, keepdims=True))


def input_choices(pose) -> list[tuple[int, ...]]:
    """All sets of four joints that hold the platform when they are locked."""
    return [choice for choice in combinations(range(16), 4) if freedoms_left(pose, choice) == 0]


def limbs_of(choice: tuple[int, ...]) -> tuple[int, ...]:
    """How many of a choice's joints each TRT limb has, most first, then whether the slide is among
    them.
    """
    counts = Counter(k // 5 for k in choice if k < 15)
    return (*sorted((counts[i] for i in range(3)), reverse=True), int(15 in choice))


def on_base(choice: tuple[int, ...]) -> bool:
    """Whether every motor of a choice stands on the base, or pushes the central leg, whose foot
    does.
    """
    return all(k == 15 or k % 5 == 0 for k in choice)


# --- rows of section 2 ----------------------------------------------------------------------------


def report_screws(report: Report) -> None:
    """The five screws of a limb beside their reciprocal couple, at the initial position and at
    table 1's second pose.
    """
    for pose, _ in TABLE_1:
        for i in range(3):
            twists, wrench = limb_twists(pose, i), couple(pose, i)
            where = f"at {pose}, limb {i + 1}"
            if i == 0:
                for k, twist in enumerate(twists, start=1):
                    report.row(
                        f"{where}: screw {k} (s; s0)",
                        None,
                        twist + 0.0,
                        place="2.1",
                        run=limb_twists,
                    )
                form = bool(
                    np.allclose(twists[[0, 4], :3], (0, 0, 1)) and np.allclose(twists[1:4, 2], 0)
                )
                item = f"{where}: screws 1 and 5 along Z; 2, 3 and 4 parallel and horizontal"
                report.row(item, True, form, place="2.1", run=limb_twists)
            report.row(
                f"{where}: reciprocal couple (0; l^r, m^r, 0)",
                None,
                wrench + 0.0,
                place="2.1",
                run=couple,
            )
            check = [twists[1, :3] @ wrench[3:], work(twists, wrench)]
            report.row(
                f"{where}: l l^r + m m^r; most work on its five screws",
                [0, 0],
                check,
                place="2.1",
                run=(couple, work),
                tolerance=1e-9,
            )
    start = couple(TABLE_1[0][0], 0)
    report.row(
        "initial position, limb 1: |l^r|, |m^r| of the couple",
        [0, 1],
        np.abs(start[3:5]),
        place="2.1",
        run=couple,
        tolerance=1e-9,
    )


def report_figure_1(report: Report) -> Figure:
    """Figure 1: the mechanism with its real limbs, T joints as two hinges each."""
    mechanism = symkin.load(LINKS_NAME)
    joints = [limb.joints for limb in mechanism.limbs if isinstance(limb, Limb)]
    crossed = [
        math.degrees(math.acos(abs(np.dot(a.axis, b.axis))))
        for chain in joints
        for a, b in (chain[:2], chain[-2:])
    ]
    report.row(
        "figure 1 drawn: limbs of hinges, hinges of each, and least angle of the two axes of a T "
        "[deg]",
        [3, 5, 90],
        [len(joints), min(map(len, joints)), min(crossed)],
        place="1, figure 1",
        run=figure_of_sketch,
        tolerance=1e-9,
    )
    return figure_of_sketch(mechanism)


def report_mobility(report: Report) -> None:
    links, joints, freedoms = 2 + 3 * 4 + 2, 3 * 5 + 3, 3 * 5 + 7
    report.row(
        "n, g, sum of f",
        [16, 18, 22],
        [links, joints, freedoms],
        place="2.2",
        run="count of figure 1",
    )
    report.row(
        "M = 6 (n - g - 1) + sum f + 1 redundant couple - 1 idle spin",
        4,
        6 * (links - joints - 1) + freedoms + 1 - 1,
        place="2.2, (1)",
        run="formula (1)",
    )
    for pose, _ in TABLE_1:
        twists = [limb_twists(pose, i) for i in range(3)]
        couples = np.array([couple(pose, i) for i in range(3)])
        free = reciprocal_system(couples, SIZE)
        report.row(
            f"at {pose}: rank of the three couples; of their forces",
            [2, 0],
            [rank(couples), rank(couples[:, :3])],
            place="2.1",
            run=couple,
        )
        common = len(reciprocal_system(np.vstack(twists), SIZE))
        report.row(
            f"at {pose}: screws reciprocal to all twists (common constraints)",
            0,
            common,
            place="2.2",
            run=limb_twists,
        )
        report.row(
            f"at {pose}: platform freedoms; those that tilt it",
            [4, 0],
            [len(free), rank(free[:, :2])],
            place="2.1",
            run=couple,
        )
    for name in (PLATFORM_NAME, LINKS_NAME):
        found = symkin.mobility(symkin.load(name))
        numbers = [found.freedoms, found.rows, found.rank.value, found.implied_rows, found.mobility]
        paper = [None, None, None, 1, 4] if name == LINKS_NAME else None
        verdict = "reproduced" if paper is not None and numbers[3:] == [1, 4] else None
        report.row(
            f"{name}, closure Jacobian: freedoms, rows, rank, redundant rows, mobility",
            paper,
            numbers,
            place="2.2",
            run=symkin.mobility,
            verdict=verdict,
        )


def report_inputs(report: Report) -> None:
    """Why these four inputs: what locking them leaves free, and how many other sets of four joints
    would hold the platform.
    """
    for pose, _ in TABLE_1:
        left = [freedoms_left(pose, locked) for locked in ((), (0, 5, 10), (0, 5, 10, 15))]
        report.row(
            f"at {pose}: freedoms with nothing, theta_1..3, theta_1..3 and l_op locked",
            [4, 1, 0],
            left,
            place="2.1",
            run=freedoms_left,
        )
        choices = input_choices(pose)
        counts = Counter(limbs_of(choice) for choice in choices)
        report.row(
            f"at {pose}: sets of 4 of the 16 joints that hold the platform, of 1820",
            None,
            len(choices),
            place="2.1",
            run=input_choices,
        )
        report.row(
            f"at {pose}: of these with one joint in each limb",
            None,
            counts[1, 1, 1, 1],
            place="2.1",
            run=(input_choices, limbs_of),
        )
        ours = [choice for choice in choices if on_base(choice)]
        report.row(
            f"at {pose}: of these with every motor on the base (the paper's four: 0, 5, 10, 15)",
            [[0, 5, 10, 15]],
            [list(choice) for choice in ours],
            place="2.1",
            run=(input_choices, on_base),
        )
