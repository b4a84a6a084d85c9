"""Rows on the simulated machine (2): its tables, what is assumed, and the errors before calibration in each kind of frames.

Source: Ren, Feng, Su 2008, 2 (see `ren2008`; frames in `ren2008_errors`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from ren2008_errors import FRAMES, PoseErrors, pose_errors
from ren2008_method import inclinations, random_postures, unused_poses
from ren2008_model import NAMES, Case
from ren2008_tables import ASSUMED, circle
from ren2008_tables import NOMINAL as TABLE_1
from report import Report

BEFORE = (9.0, 0.8)
HIDDEN = tuple(product((-0.005, -0.0025, 0.0), (0.0, 0.0025, 0.005)))
"""Values tried of z of M5 and z of B2, m."""
SETS = 3
"""Sets of 200 unused poses over which errors before calibration are taken for each of them."""


def with_hidden(truth: np.ndarray, z_m5: float, z_b2: float) -> np.ndarray:
    """The true parameters with other values of the two illegible entries."""
    other = truth.copy()
    other[NAMES.index("leg5.platform.z")], other[NAMES.index("leg2.base.z")] = z_m5, z_b2
    return other


@dataclass(frozen=True, eq=False)
class Before:
    """Worst errors (choices x sets, 2) before calibration in each frame: mm, deg."""

    worst: dict[str, np.ndarray]

    def range(self, frame: str) -> tuple[np.ndarray, np.ndarray]:
        return self.worst[frame].min(axis=0), self.worst[frame].max(axis=0)


def errors_before(case: Case) -> Before:
    made: dict[str, list[list[float]]] = {frame: [] for frame in FRAMES}
    for choice, k in product(HIDDEN, range(SETS)):
        truth = with_hidden(case.truth, *choice)
        for frame, errors in pose_errors(case.eta, truth, case.eta, unused_poses(truth, case.seed + k)).items():
            made[frame].append(errors.worst)
    return Before({frame: np.array(rows) for frame, rows in made.items()})


def report_assumed(report: Report, case: Case) -> None:
    report.row(
        "true values illegible in our copy, assumed: z of M5, z of B2",
        None,
        list(ASSUMED.values()),
        "m",
        place="table 2",
        run="ren2008_tables",
    )
    for name in ("platform", "base"):
        centre, radius, off = circle(TABLE_1[name])
        report.row(
            f"{name} joint circle: centre x, y, radius, largest departure",
            None,
            [float(centre[0]), float(centre[1]), radius, off],
            "m",
            place="table 1",
            run=circle,
        )
    held = np.degrees(inclinations(10, case.rng(20))[:, 0])
    report.row("10 groups: alpha equally spaced over +-20 deg, beta the same in random order", [-20, 20], [float(held[0]), float(held[-1])],
               "deg", place="2.1", run=inclinations)  # fmt: skip
    poses, drawn = random_postures(case.eta, np.full((2000, 2), np.nan), case.rng(60))
    report.row("workspace, not printed, assumed: share of postures that the rods' range rejects", None, 100 * (1 - len(poses) / drawn), "%",
               place="2.1", run=random_postures)  # fmt: skip


def report_before(report: Report, case: Case, tests: np.ndarray) -> tuple[dict[str, PoseErrors], Before]:
    """9 mm and 0.8 deg: in which frames?"""
    report.row("unused poses at which errors are told", 200, len(tests), place="2.2", run=unused_poses)
    errors = pose_errors(case.eta, case.truth, case.eta, tests)
    for frame, error in errors.items():
        report.row(
            f"before calibration, {frame} frames, 200 poses: worst", None, error.worst, "mm, deg", place="2", run=pose_errors
        )
        report.row(f"before calibration, {frame} frames: mean", None, error.mean, "mm, deg", place="2", run=pose_errors)
    before = errors_before(case)
    for frame in FRAMES:
        low, high = before.range(frame)
        inside = bool(np.all((low <= BEFORE) & (high >= BEFORE)))
        name = f"before calibration, {frame} frames, {len(HIDDEN)} choices of the illegible entries, {SETS} sets of 200 poses"
        report.row(f"{name}: worst, least and most of them", BEFORE, [float(low[0]), float(high[0]), float(low[1]), float(high[1])], "mm, mm, deg, deg", place="2",
                   run=errors_before, verdict="reproduced" if inside else "differs")  # fmt: skip
    return errors, before
