"""What each way to L6 takes, over many poses: the printed loop, the chord in place of its midpoint,
Newton's method, no loop.

Poses are those of random joint values: theta1 to theta5 within 60 degrees, L6 between -300 and 0.
Every way is given the same poses; an end counts as right where it is the L6 that the pose was
computed from, as another root where it is one, else as none. Rows of section 2.2.1 and conclusions
2 to 4: planes, (4) to (8), the loop, its steps over many poses, the closed form.

Units: mm, deg. Source: Yao Haifeng et al. 2020 (see `study`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from studies.shared.guesses import Search, rootfinder
from studies.shared.report import Report
from studies.shared.words import written
from studies.yao2020.inverse import (
    TOLERANCE,
    about,
    angle_of_planes,
    axis5_origin,
    distance_function,
    f_iteration,
    full_angle_of_planes,
    inverse,
    misses,
    paper_search,
    plane_closure,
    plane_vectors,
    retreated,
    returned,
    secant_search,
    slides,
)
from studies.yao2020.model import (
    A1,
    A2,
    FORWARD,
    PRINTED,
    SEED,
    STROKE,
    TIP,
    goal_rotation,
    pose_of,
)

LARGEST_ANGLE, LONGEST = 60.0, -300.0
SAME = 1e-6
"""Difference of two values of L6, mm, below which they are one root."""
Way = Callable[[np.ndarray, np.ndarray], tuple[float, int]]


@dataclass(frozen=True, eq=False)
class Runs:
    """The ends of one way over the poses: which of right, other, none; the steps where it ended at
    a root; seconds a pose.
    """

    name: str
    ends: list[str]
    steps: list[int]
    seconds: float

    def evidence(self) -> dict[str, object]:
        return {
            "by": "study",
            "method": self.name,
            "poses": len(self.ends),
            "text": f"{self.name}, {len(self.ends)} poses",
        }

    @property
    def iterates(self) -> bool:
        return any(self.steps)

    @property
    def counts(self) -> list[int]:
        return [self.ends.count(kind) for kind in ("right", "other", "none")]

    @property
    def spread(self) -> list[int]:
        """Least, median and most steps."""
        return [min(self.steps), int(np.median(self.steps)), max(self.steps)]


def random_poses(seed: int, count: int) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """L6, A and R of each."""
    rng, poses = np.random.default_rng(seed), []
    for _ in range(count):
        joints = np.append(rng.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, 5), rng.uniform(LONGEST, 0.0))
        poses.append((float(joints[5]), *pose_of(joints)))
    return poses


def printed_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The loop in the order that finds the printed answer, with (6) as the text says it."""
    return paper_search(f_iteration(A, R), "right")


def mended_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The same with the angle of the planes between -180 and 180 degrees."""
    return paper_search(f_iteration(A, R, full_angle_of_planes), "right")


def chord_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The chord's zero in place of the midpoint, on the part of the interval right of e_x, where f
    rises.
    """
    f, low = f_iteration(A, R, full_angle_of_planes), max(STROKE[0], float(axis5_origin(A, R)[0]))
    return (
        secant_search(f, low, STROKE[1])
        if low < STROKE[1] and f(low) * f(STROKE[1]) < 0
        else (math.nan, 0)
    )


def newton_way() -> Way:
    """Newton's method by CasADi on (5) to (8) in L6 and theta5, from zero joints."""
    search: Search = rootfinder(plane_closure())

    def newton(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
        end = search.end(np.zeros(2), axis5_origin(A, R))
        return (float(end.X[0]), end.iterations) if end.closed else (math.nan, end.iterations)

    return newton


def without_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The closed form's largest root."""
    return max(slides(A, R)), 0


def run(name: str, way: Way, poses: list[tuple[float, np.ndarray, np.ndarray]]) -> Runs:
    """Take one way over the poses."""
    begin = time.perf_counter()
    found = [way(A, R) for _, A, R in poses]
    seconds = (time.perf_counter() - begin) / len(poses)
    ends = [
        _kind(slide, wanted, A, R) for (slide, _), (wanted, A, R) in zip(found, poses, strict=True)
    ]
    return Runs(
        name, ends, [n for (_, n), end in zip(found, ends, strict=True) if end != "none"], seconds
    )


def _kind(slide: float, wanted: float, A: np.ndarray, R: np.ndarray) -> str:
    if abs(slide - wanted) < SAME:
        return "right"
    roots = [x for s in (1, -1) for x in slides(A, R, s)]
    return "other" if any(abs(slide - x) < SAME for x in roots) else "none"


def all_ways(seed: int, count: int) -> list[Runs]:
    """Every way over the same poses."""
    poses = random_poses(seed, count)
    ways = {
        "printed loop": printed_loop,
        "loop with the full angle": mended_loop,
        "chord": chord_loop,
        "rootfinder": newton_way(),
        "closed form": without_loop,
    }
    return [run(name, way, poses) for name, way in ways.items()]


def minima(A: np.ndarray, R: np.ndarray) -> int:
    """How many minima |OF2| has along the retreat, counted on a fine grid about e_x."""
    f, e = distance_function(A, R), axis5_origin(A, R)
    values = np.array([f(e[0] + x) for x in np.arange(-400.0, 400.5, 0.5)])
    return int(np.sum((values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:])))


def minima_of_poses(seed: int, count: int) -> tuple[list[int], int]:
    """Poses whose |OF2| has one minimum and two, and those with |e_y| < a2."""
    poses = random_poses(seed, count)
    numbers = [minima(A, R) for _, A, R in poses]
    near = sum(bool(abs(axis5_origin(A, R)[1]) < A2) for _, A, R in poses)
    return [numbers.count(1), numbers.count(2)], near


# --- rows -----------------------------------------------------------------------------------------

POSES = 100
"""Poses over which steps and minima are counted."""


def report_search(report: Report) -> None:
    """Section 2.2.1."""
    report_planes(report)
    report_shorter_way(report)
    report_angle_by_sine(report)
    report_shape(report)
    report_loop(report)


def report_planes(report: Report) -> None:
    """(4) to (8) as written, in the worked example."""
    A, R = pose_of(FORWARD)
    label, angle = "forward example: angle of planes I and II", angle_of_planes(A, R, FORWARD[5])
    report.row(
        label,
        FORWARD[4],
        angle,
        "deg",
        place="2.2.1, fig. 5; 4 (3)",
        run=angle_of_planes,
        tolerance=1e-9,
    )
    A, R, root = TIP, goal_rotation(), max(slides(TIP, goal_rotation()))
    p, (ad, normal, _) = retreated(A, R, root), plane_vectors(A, R, root)
    for name, point in p.items():
        report.row(
            f"(4): {name}1 at the root L6", None, point, "mm", place="2.2.1, (4)", run=retreated
        )
    report.row("(5): AD, unit vector", None, ad, place="2.2.1, (5)", run=plane_vectors)
    report.row(
        "(5): normal of plane II, OE1 x OD1, unit vector",
        None,
        normal,
        place="2.2.1, (5)",
        run=plane_vectors,
    )
    angle = angle_of_planes(A, R, root)
    report.row(
        "(6): 90 less the angle of AD with the normal, at the root",
        PRINTED[4],
        angle,
        "deg",
        place="2.2.1, (6)",
        run=angle_of_planes,
    )
    F2 = about(p["F"], p["E"], p["D"], -angle)
    report.row("(7): F2", None, F2, "mm", place="2.2.1, (7)", run=about)
    report.row(
        "(8): |OF2| less a1",
        0,
        float(np.linalg.norm(F2)) - A1,
        "mm",
        place="2.2.1, (8)",
        run=about,
        tolerance=1e-9,
    )


def report_shorter_way(report: Report) -> None:
    """(5) to (8) in two unknowns, and f through h, beside f through the points."""
    A, R, F = TIP, goal_rotation(), plane_closure().F
    e = axis5_origin(A, R)
    report.row("e = R^T E0, E in the tool's axes", None, e, "mm", place="2.2.1", run=axis5_origin)
    for k, what in enumerate(("O in the plane of F and axis 5", "|OF| - a1")):
        report.row(
            f"closure in L6 and theta5, {what}: 0 =",
            None,
            written(F[k]),
            "mm",
            place="2.2.1, (5)-(8)",
            run=plane_closure,
        )
    short, mended, printed = (
        distance_function(A, R),
        f_iteration(A, R, full_angle_of_planes),
        f_iteration(A, R),
    )
    parts = {
        "[e_x, 0]": np.linspace(e[0], STROKE[1], 200),
        "[-500, e_x]": np.linspace(STROKE[0], e[0], 200),
    }
    for where, values in parts.items():
        off = [max(abs(f(x) - short(x)) for x in values) for f in (printed, mended)]
        label = (
            f"f by (4)-(8) less f = sqrt((h - a2)^2 + e_z^2) - a1, largest on {where}: (6) as "
            f"told, (6) with its cosine"
        )
        report.row(
            label, None, off, "mm", place="2.2.1, (4)-(8)", run=(f_iteration, distance_function)
        )


def report_angle_by_sine(report: Report) -> None:
    """(6) as the text tells it has only the sine of theta5."""
    A, R = TIP, goal_rotation()
    printed, second = f_iteration(A, R), inverse(A, R)[2]
    false, seen = paper_search(printed, "left")[0], angle_of_planes(A, R, second[5])
    miss = misses(returned(A, R, false, 1), A, R)
    row = partial(report.row, place="2.2.1, (6)")
    row("f by (6) as told: its left root", None, false, "mm", run=(f_iteration, paper_search))
    row(
        "the pose missed by the return of the axes from it",
        None,
        miss,
        "mm",
        run=(returned, misses),
    )
    row(
        "(6) as told at the other true root, where theta5 is",
        second[4],
        seen,
        "deg",
        run=(inverse, angle_of_planes),
    )
    text = (
        f"the angle of AD with the normal of plane II tells only sin(theta5): at the second root "
        f"it gives {seen:.3f} for "
        f"{second[4]:.3f}, so that f has no root there and a false one at {false:.3f}, from which "
        f"the return of the axes misses the "
        f"pose by {miss:.0f} mm. (Formula (6) itself is missing in the copy at hand.)"
    )
    report.erratum(
        text, shown=abs(seen + second[4] - 180) < 1e-6 and abs(printed(second[5])) > 1 and miss > 1
    )


def report_shape(report: Report) -> None:
    """|OF| is said to fall, then to rise, while member 6 goes back."""
    row = partial(report.row, place="2.2.1")
    row(
        "|OF2| falls, then rises: its minima in the worked example",
        1,
        minima(TIP, goal_rotation()),
        run=minima,
    )
    (one, two), near = minima_of_poses(SEED, POSES)
    row(
        f"over {POSES} poses: |OF2| with one minimum, with two; poses with |e_y| < a2",
        None,
        [one, two, near],
        run=minima_of_poses,
    )
    text = (
        f"|OF| falls and then rises only where |e_y| >= a2: of {POSES} poses {two} have |e_y| < "
        f"a2, and two minima each."
    )
    report.erratum(text, shown=two == near > 0 and one + two == POSES)


def report_loop(report: Report) -> None:
    A, R = TIP, goal_rotation()
    f, mended, roots = (
        distance_function(A, R),
        f_iteration(A, R, full_angle_of_planes),
        slides(A, R),
    )
    row, ends = partial(report.row, place="2.2.1"), [f(x) for x in (-500.0, -250.0, 0.0)]
    row("f at -500, -250, 0", None, ends, "mm", run=distance_function)
    found = {order: paper_search(mended, order) for order in ("left", "right", "both")}
    names = {
        "left": "f_min f_mid < 0 first",
        "right": "f_mid f_max < 0 first",
        "both": "both in turn, as printed",
    }
    for order, (slide, steps) in found.items():
        row(
            f"loop with the midpoint, {names[order]}: L6, steps",
            None,
            [slide, steps],
            run=paper_search,
        )
    text = (
        f"[-500, 0] is no bracket: f is {ends[0]:+.1f}, {ends[1]:+.1f}, {ends[2]:+.1f} at -500, "
        f"-250, 0 and both roots lie inside. The order "
        f"of the two sign tests decides: f_min f_mid first gives L6 = {found['left'][0]:.3f}, "
        f"f_mid f_max first {found['right'][0]:.3f}; "
        f"both in turn on the same values, as printed, stop at {found['both'][0]:.0f}, no root."
    )
    both_inside = (
        all(STROKE[0] < r < STROKE[1] for r in roots) and ends[0] > 0 > ends[1] and ends[2] > 0
    )
    each = abs(found["left"][0] - min(roots)) < 1e-6 and abs(found["right"][0] - max(roots)) < 1e-6
    report.erratum(text, shown=both_inside and each and abs(f(found["both"][0])) > 1)
    report_steps(report, found["right"][1])


def report_steps(report: Report, steps: int) -> None:
    """The seven iterations of the worked example."""
    chord, row = chord_loop(TIP, goal_rotation()), partial(report.row, place="3.2")
    row("steps to |f| < 1e-8, midpoint", 7, steps, run=paper_search)
    row(
        "steps to |f| < 1e-8, chord in place of the midpoint, on [e_x, 0]",
        7,
        chord[1],
        run=chord_loop,
    )
    text = (
        f"with the midpoint, which the name l_mid says and the copy at hand does not print, the "
        f"loop needs {steps} steps to 1e-8, not 7: "
        f"seven leave an interval of {500 / 2**7:.1f} mm. The chord's zero in its place needs "
        f"{chord[1]}, in a bracket of one root."
    )
    report.erratum(
        text,
        shown=steps > 25
        and chord[1] == 7
        and abs(distance_function(TIP, goal_rotation())(chord[0])) < TOLERANCE,
    )


def report_ways(report: Report) -> None:
    """'7 or 8 iterations', '10 ms', 'needs an iterative search', over many poses."""
    for runs in all_ways(SEED, POSES):
        row = partial(report.row, run=runs)
        row(
            f"over poses, {runs.name}: ends at the right L6, at another root, at none",
            None,
            runs.counts,
            place="4 (4)",
        )
        if runs.iterates:
            verdict = "reproduced" if set(runs.spread[1:]) <= {7, 8} else "differs"
            row(
                f"over poses, {runs.name}: steps, least, median, most",
                "7 or 8",
                runs.spread,
                place="4 (4)",
                verdict=verdict,
            )
        label = f"over poses, {runs.name}: time a pose, beside the paper's 8 to 10"
        row(label, None, 1e3 * runs.seconds, "ms", place="3.2, 4 (4)", volatile=True)


def report_closed_form(report: Report) -> None:
    """The conclusion that L6 needs an iterative search, against h = a2 + sqrt(a1^2 - e_z^2)."""
    A, R = TIP, goal_rotation()
    direct, f = slides(A, R), distance_function(A, R)
    label = "L6 = e_x -+ sqrt((a2 + sqrt(a1^2 - e_z^2))^2 - e_y^2)"
    report.row(
        label, "needs a search", direct, "mm", place="0, 4 (2)", run=slides, verdict="refuted"
    )
    searched = [
        paper_search(f_iteration(A, R, full_angle_of_planes), order)[0]
        for order in ("left", "right")
    ]
    text = (
        "L6 needs no iterative search: e_x -+ sqrt((a2 + sqrt(a1^2 - e_z^2))^2 - e_y^2) gives both "
        "roots, and so there is an analytic "
        "inverse, which the paper's references deny to wrists with offsets."
    )
    report.erratum(
        text,
        shown=bool(np.allclose(direct, searched, atol=1e-6))
        and max(abs(f(x)) for x in direct) < 1e-9,
    )
