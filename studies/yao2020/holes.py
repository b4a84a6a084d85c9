"""Section 3.3 as far as the printed data go: a seat brought to the cutting head, and 86 holes on a
face, followed by `track`.

The reach of the wrist: a pose has a real inverse (F between axis 5 and O) where e = R^T E0
satisfies

    margin = a2 + sqrt(a1^2 - e_z^2) - |e_y| >= 0,   |e_z| <= a1,

and L6 = e_x +- sqrt((a2 + sqrt(a1^2 - e_z^2))^2 - e_y^2) lies in the stroke. With the drill square
to the face, R = 1 and e differs from A by a constant: the reach on the face is a stadium of 2 (a1 +
a2) by 2 a1, whatever the depth.

The paper prints no hole, no size of the product, no stroke: the pattern, the face's distance and
the feed are ours, the lengths those of the worked example. Units: mm; degrees where printed.
Source: Yao Haifeng et al. 2020 (see `study`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

import symkin
from studies.shared.report import Report
from studies.yao2020.inverse import axis5_origin
from studies.yao2020.model import A1, A2, D1, STROKE, TIP, goal_rotation, symkin_pose
from symkin.following.track_result import Track
from symkin.position.solution import Solution
from symkin.velocity.jacobian import Jacobian

HOLES = 86
COLUMNS, ROWS, SPACING = 10, 9, 60.0
"""A grid of 90 places 60 mm apart, less its four corners."""
FACE = -570.0
"""x of the face: in front of the robot, which reaches along -x."""
RETREAT, FEED = 20.0, 60.0
"""How far the drill stands off the face between holes, and how deep it goes."""
LARGEST_OFFSET, ALLOWED = 27.6, 30.0
"""Figure 11's largest error and the mine's bound, mm."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """A track as the evidence of a row."""

    track: Track

    def evidence(self) -> dict[str, object]:
        how = "certified" if self.track.certified else "not certified"
        return {
            "by": "symkin.track",
            "method": "track",
            "text": f"track: {len(self.track.trajectory)} poses, {how}",
        }


def holes() -> np.ndarray:
    """Centres (y, z) on the face, row by row in alternating directions, about the middle of the
    reach.
    """
    rows = []
    for r in range(ROWS):
        columns = range(1, COLUMNS - 1) if r in (0, ROWS - 1) else range(COLUMNS)
        row = [
            (SPACING * (c - (COLUMNS - 1) / 2), D1 + SPACING * (r - (ROWS - 1) / 2))
            for c in columns
        ]
        rows += row if r % 2 == 0 else row[::-1]
    return np.array(rows)


def drilling_path() -> np.ndarray:
    """Poses (n, 7), three a hole: before it, at its bottom, before it again."""
    square = (1.0, 0.0, 0.0, 0.0)
    depths = (RETREAT, -FEED, RETREAT)
    return np.array([(FACE + depth, y, z, *square) for y, z in holes() for depth in depths])


def track_seat(arm: symkin.Mechanism) -> Track:
    """Figure 8: the seat, turned first, goes along the tool's own axis to the printed pose, from 40
    mm before it.
    """
    R = goal_rotation()
    path = [symkin_pose(TIP + away * R[:, 0], R) for away in (40.0, 20.0, 0.0)]
    return symkin.track(arm, poses=path, start=first_mode(arm, path[0]))


def reach_margin(A: np.ndarray, R: np.ndarray) -> float:
    """How far axis 5 is inside the wrist's reach; negative outside."""
    e = axis5_origin(A, R)
    return -math.inf if abs(e[2]) > A1 else A2 + math.sqrt(A1**2 - e[2] ** 2) - abs(e[1])


def stroke_margin(slides) -> float:
    """How far the values of L6 stay inside the interval that the paper searches."""
    return float(min(np.min(slides) - STROKE[0], STROKE[1] - np.max(slides)))


def outward(z: float, beyond: float) -> np.ndarray:
    """A on the face at height z, `beyond` the edge of the reach."""
    return np.array([FACE, A2 + math.sqrt(A1**2 - (z - D1) ** 2) + beyond, z])


def track_holes(arm: symkin.Mechanism) -> Track:
    """The whole path of 86 holes on one working mode, by steps that are proved."""
    return symkin.track(arm, poses=drilling_path(), start=first_mode(arm, drilling_path()[0]))


def track_outward(arm: symkin.Mechanism, z: float) -> Track:
    """Straight out of the wrist's reach along y, at height z on the face."""
    square = (1.0, 0.0, 0.0, 0.0)
    path = [(FACE, 0.0, z, *square), (*outward(z, 50.0), *square)]
    return symkin.track(arm, poses=path, start=first_mode(arm, path[0]))


def first_mode(arm: symkin.Mechanism, pose) -> Solution:
    """The mode that the paper's answer belongs to: L6 the larger, theta1 within a quarter turn."""
    return max(
        symkin.modes(arm, pose=pose), key=lambda m: (round(m.actuated[5], 6), -abs(m.actuated[0]))
    )


def tip_errors(jacobian: Jacobian, solution: Solution) -> np.ndarray:
    """|dA| in mm for an error of 1 degree in each of joints 1 to 5."""
    matrix = np.asarray(jacobian.at(solution))[:3, :5]
    return np.linalg.norm(matrix, axis=0) * math.pi / 180.0


def worst_of_equal_errors(jacobian: Jacobian, solution: Solution) -> float:
    """Largest |dA| in mm, to first order, for errors of 1 degree in joints 1 to 5, over their
    signs.
    """
    matrix = np.asarray(jacobian.at(solution))[:3, :5] * math.pi / 180.0
    signs = np.array(list(product((-1, 1), repeat=5)))
    return float(np.linalg.norm(signs @ matrix.T, axis=1).max())


# --- rows -----------------------------------------------------------------------------------------


def report_application(report: Report, arm: symkin.Mechanism) -> Track:
    """Rows of section 3.3; the track over the holes."""
    _report_seat(report, arm)
    _report_reach(report, arm)
    track = track_holes(arm)
    joints = np.array([s.actuated for s in track.samples])
    _report_path(report, track, joints)
    _report_errors(report, arm, track)
    report.outside(
        "the robot as built, figure 9",
        "3.3, fig. 9",
        "its lengths, strokes and joint ranges are not printed",
    )
    report.outside(
        "positions of the 86 holes",
        "3.3, fig. 10",
        "the mine's data are not printed; the pattern here is ours",
    )
    report.outside(
        "offset of each hole, figure 11",
        "3.3, fig. 11",
        "measured on the machine; only the largest, 27.6 mm, is printed",
    )
    return track


def _report_seat(report: Report, arm: symkin.Mechanism) -> None:
    track = track_seat(arm)
    moved = np.ptp(np.array([s.actuated for s in track.samples]), axis=0)
    label = "seat along its axis to the cutting head, 40 mm: joints 1 to 5 move by at most, L6 by"
    report.row(
        label,
        [0, 40],
        [moved[:5].max(), moved[5]],
        "deg, mm",
        place="3.2, fig. 8",
        run=Tracked(track),
        tolerance=1e-9,
    )


def _report_reach(report: Report, arm: symkin.Mechanism) -> None:
    """The stadium against enumeration just inside and outside of it, and against the place where a
    track stops.
    """
    for z in (D1, D1 + 150.0):
        here, place = (
            [
                symkin.modes(arm, pose=symkin_pose(outward(z, d), np.eye(3)), method="continuation")
                for d in (-1.0, 1.0)
            ],
            f"reach at z = {z:g}",
        )
        label = (
            f"{place}: solutions 1 mm inside and 1 mm outside of it on the face, by continuation"
        )
        report.row(label, None, [len(found) for found in here], place="3.3", run=here)
        track = track_outward(arm, z)
        off = float(track.end.pose.position[1]) - outward(z, 0.0)[1]
        label = (
            f"{place}: y where a track outward stops ({track.stop.kind}), less a2 + sqrt(a1^2 - "
            f"e_z^2)"
        )
        report.row(label, None, round(off, 9), "mm", place="3.3", run=(Tracked(track), outward))


def _report_path(report: Report, track: Track, joints: np.ndarray) -> None:
    margin = min(reach_margin(np.array([FACE, y, z]), np.eye(3)) for y, z in holes())
    report.row(
        "holes of our pattern", HOLES, len(holes()), place="3.3, fig. 10", run=holes, verdict="-"
    )
    report.row(
        "least margin of a hole inside the wrist's reach",
        None,
        margin,
        "mm",
        place="3.3",
        run=reach_margin,
    )
    row = partial(report.row, place="3.3", run=Tracked(track))
    row(
        "path of all holes, there and back in each: poses reached",
        None,
        f"{len(track.samples)}, {track.statement}",
    )
    row("ground of the path", None, track.ground)
    row("largest |A| error along the path", 0, track.residual, "mm", tolerance=1e-8)
    row("theta1 to theta5, L6: least", None, joints.min(axis=0).round(6) + 0.0, "deg, mm")
    row("theta1 to theta5, L6: most", None, joints.max(axis=0).round(6) + 0.0, "deg, mm")
    row("L6 stays inside [-500, 0] by", None, stroke_margin(joints[:, 5]), "mm")
    row("nearest singularity: distance, type 1 (0 to 1)", None, track.distances["type 1"])
    by_hole = joints.reshape(HOLES, 3, 6)
    fed = by_hole[:, 1] - by_hole[:, 0]
    moved = [
        float(np.abs(fed[:, :5]).max().round(9)),
        float(fed[:, 5].min()),
        float(fed[:, 5].max()),
    ]
    row("into a hole: joints 1 to 5 move by at most, L6 by (least, most)", None, moved, "deg, mm")


def _report_errors(report: Report, arm: symkin.Mechanism, track: Track) -> None:
    """What 27.6 mm would be in joint angles of this small arm, to first order."""
    jacobian, bottoms = (
        symkin.jacobian(arm, kind="direct"),
        [s.solution for s in track.samples[1::3]],
    )
    row = partial(report.row, place="3.3, fig. 11")
    row(
        "printed values: the largest offset is within the mine's bound",
        True,
        LARGEST_OFFSET < ALLOWED,
        run="27.6 < 30",
        verdict="-",
    )
    most = np.max([tip_errors(jacobian, s) for s in bottoms], axis=0)
    row(
        "A moves for 1 deg of error in joints 1 to 5, most over the holes",
        None,
        most,
        "mm",
        run=(jacobian.at, tip_errors),
    )
    worst = max(worst_of_equal_errors(jacobian, s) for s in bottoms)
    label = "equal errors of joints 1 to 5 that make 27.6 mm at the worst hole, with these lengths"
    row(label, None, LARGEST_OFFSET / worst, "deg", run=(jacobian.at, worst_of_equal_errors))
