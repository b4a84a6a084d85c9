"""How many inverse solutions has a six-joint arm? Counts by joint types and by special axes, and an
arm with 16 real ones.

Notation: an arm is six screw axes; for a pose of its tool the inverse problem has as many complex
solutions as a generic pose of it. Counts hold for one arm at one random pose: the pose of random
joint values, so that one real solution is known.

  - MANSEUR_DOTY: DH table and hand matrix of an arm all of whose 16 solutions are real; the matrix
    has six decimals and is replaced by the nearest rotation;
  - gluon_6l3 (axes 2, 3, 4 parallel) and yao2020 (5R1P), as their files describe them;
  - with --arms all: axes from normal random numbers for 6R, for three parallel or three concurrent
    axes, and for a slide in different places.

Lengths of the DH table have no unit (m here); angles in degrees. Sources: Primrose 1986, Lee and
Liang 1988 (16, general 6R); Pieper 1968 (8, three parallel or concurrent axes); Raghavan and Roth
1993 (16 for 5R1P, 8 for 4R2P, 2 for 3R3P); Manseur and Doty, A robot manipulator with 16 real
inverse kinematic solution sets, International Journal of Robotics Research 8(5), 1989, 75-79.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import symkin
from symkin import Modes, Solution
from symkin.spatial.rotation import quaternion_from_matrix

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, options_parser
from studies.shared.small_multiples import draw_small_multiples
from studies.shared.words import certified, largest_residual, statement

DH = ((0.0, 0.3, 90), (0.0, 1.0, 1), (0.2, 0.0, 90), (0.0, 1.5, 1), (0.0, 0.0, 90), (0.0, 0.0, 1))
"""d, a, alpha of each row of Manseur and Doty's arm."""
HAND = (
    (-0.760117, -0.641689, 0.102262, -1.140175),
    (0.133333, 0.0, 0.991071, 0.0),
    (-0.635959, 0.766965, 0.085558, 0.0),
)
SEED = 0


@dataclass(frozen=True)
class Case:
    """An arm, the count that is known, and how its axes are special."""

    name: str
    arm: symkin.Mechanism
    known: int


def manseur_doty() -> symkin.Mechanism:
    rows = [
        symkin.DHRow(f"q{i}", "R", d=d, a=a, alpha=math.radians(twist))
        for i, (d, a, twist) in enumerate(DH, start=1)
    ]
    return symkin.serial_arm_from_dh(
        "manseur_doty", symkin.DHTable("standard", rows), length_unit="m", angle_unit="deg"
    )


def hand_pose() -> symkin.Pose:
    """The printed hand with the rotation nearest to its matrix."""
    hand = np.array(HAND)
    left, _, right = np.linalg.svd(hand[:, :3])
    return symkin.Pose(hand[:, 3], quaternion_from_matrix(left @ right))


def random_arm(
    types: str,
    rng: np.random.Generator,
    parallel: tuple[int, ...] = (),
    concurrent: tuple[int, ...] = (),
) -> symkin.Mechanism:
    """Points and directions of the axes from normal random numbers, some with one direction or one
    point (counted from 1).
    """
    points, axes = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    for places, rows in ((parallel, axes), (concurrent, points)):
        rows[[i - 1 for i in places]] = rows[places[0] - 1] if places else 0.0
    joints = [
        symkin.Joint(f"q{i + 1}", kind, points[i], axes[i], actuated=True)
        for i, kind in enumerate(types)
    ]  # type: ignore[arg-type]
    return symkin.Mechanism(
        "arm", [symkin.Limb("arm", joints)], platform_position=rng.normal(size=3), serial=True
    )


def cases(which: str, rng: np.random.Generator) -> list[Case]:
    shipped = [
        Case("gluon_6l3: 6R, axes 2, 3, 4 parallel", symkin.load("gluon_6l3"), 8),
        Case("yao2020: 5R1P, axes 1, 2, 3 concurrent", symkin.load("yao2020"), 8),
    ]
    if which == "few":
        return shipped
    return [
        *shipped,
        Case("random 6R", random_arm("RRRRRR", rng), 16),
        Case("random 6R, axes 2, 3, 4 parallel", random_arm("RRRRRR", rng, parallel=(2, 3, 4)), 8),
        Case(
            "random 6R, axes 4, 5, 6 concurrent", random_arm("RRRRRR", rng, concurrent=(4, 5, 6)), 8
        ),
        Case("random PRRRRR", random_arm("PRRRRR", rng), 16),
        Case("random RRPRRR", random_arm("RRPRRR", rng), 16),
        Case("random PPRRRR", random_arm("PPRRRR", rng), 8),
        Case("random PPPRRR", random_arm("PPPRRR", rng), 2),
    ]


def random_pose(arm: symkin.Mechanism, rng: np.random.Generator) -> symkin.Pose:
    """The pose of random joint values."""
    joints = [
        arm.angle_out(rng.uniform(-math.pi, math.pi))
        if c.is_angular
        else arm.characteristic_length * rng.uniform(-0.3, 0.3)
        for c in arm.actuated
    ]
    return symkin.solve(arm, joints=joints).solution.pose


# --- report ---------------------------------------------------------------------------------------


def report_sixteen(report: Report) -> Modes:
    arm, pose = manseur_doty(), hand_pose()
    change = np.abs(np.asarray(pose.rotation) - np.array(HAND)[:, :3]).max()
    report.row("printed hand less the nearest rotation, largest entry", 0.0, float(change))
    begin = time.perf_counter()
    found = symkin.modes(arm, pose=pose)
    report.row("Manseur and Doty's arm: complex solutions", 16, found.complex_count)
    report.row("Manseur and Doty's arm: real solutions", 16, len(found))
    report.row("its completeness", None, statement(found))
    report.row("its largest residual", None, largest_residual(found), "m")
    report.row(
        "its conditions: best, worst",
        None,
        [min(m.condition for m in found), max(m.condition for m in found)],
    )
    report.row(
        "its forward kinematics at the 16 less the pose",
        None,
        forward_error(arm, found, pose),
        "m, 1",
    )
    report.row("time of that answer", None, round(time.perf_counter() - begin, 2), "s")
    return found


def forward_error(arm: symkin.Mechanism, found: Modes, pose: symkin.Pose) -> float:
    """Largest difference of a pose computed forwards, entry by entry of position and rotation."""
    worst = 0.0
    for mode in found:
        end = symkin.solve(arm, joints=mode.actuated_values).solution
        parts = (end.position - np.asarray(pose.position), end.rotation - np.asarray(pose.rotation))
        worst = max(worst, *(float(np.abs(part).max()) for part in parts))
    return worst


def report_counts(report: Report, which: str, poses: int, rng: np.random.Generator) -> None:
    for case in cases(which, rng):
        found = [symkin.modes(case.arm, pose=random_pose(case.arm, rng)) for _ in range(poses)]
        counts = sorted({f.complex_count for f in found if f.complex_count is not None})
        report.row(
            f"{case.name}: complex solutions", case.known, counts[0] if len(counts) == 1 else counts
        )
        real = np.bincount([len(f) for f in found])
        text = ", ".join(f"{n}: {k}" for n, k in enumerate(real) if k)
        words = "; ".join(sorted({f.completeness for f in found}))
        unresolved, proved = (
            sum(f.unresolved_paths or 0 for f in found),
            sum(certified(f) for f in found),
        )
        report.row(f"{case.name}: real ones and poses that have so many", None, text)
        report.row(
            f"{case.name}: completeness",
            None,
            f"{words}, {unresolved} paths unresolved, {proved} of {sum(map(len, found))} certified",
        )


def caption(mode: Solution) -> str:
    """Joint values in degrees, three in a line."""
    values = [f"{round(v, 1) + 0.0:.1f}°" for v in mode.actuated_values]
    return ", ".join(values[:3]) + "\n" + ", ".join(values[3:])


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0], SEED)
    parser.add_argument(
        "--arms",
        choices=("few", "all"),
        default="few",
        help="all: random arms too, up to half a minute each",
    )
    parser.add_argument(
        "--poses", type=int, default=20, help="random poses of each arm (default: 20)"
    )
    options = parser.parse_args()
    report = Report("general_6r", "Inverse solutions of six-joint arms", options.seed)
    found = report_sixteen(report)
    report_counts(report, options.arms, options.poses, np.random.default_rng(options.seed))
    title = f"Manseur and Doty's arm: {len(found)} real inverse solutions of one pose"
    captions = [caption(mode) for mode in found]
    report.finish(
        draw_small_multiples(
            found, title, statement(found), columns=8, width=2.1, scale=0.7, captions=captions
        ),
        options.output,
    )


if __name__ == "__main__":
    main()
