"""Gluon-6L3: the singularities of the arm from its closed form, against the numeric ones.

Notation of `study`: standard DH with a_2, a_3, d_5 and theta_i = q_i + offset, s, c their sines and
cosines, sums as s_234:

    det J = -a_2 a_3 s_3 s_5 (a_2 c_2 + a_3 c_23 + d_5 s_234)

so that the arm is singular where the elbow is stretched or folded (s_3 = 0), the wrist's axis 6 is
parallel to axes 2, 3 and 4 (s_5 = 0), and the meeting point of axes 5 and 6 lies in the plane
through axis 1 parallel to axis 2 (shoulder). J maps joint rates to (angular velocity; velocity of
the tool point). Units: mm; degrees where printed, radians inside. The page does not treat
singularities: the column `paper` holds the closed form.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import symkin
from symkin.plots.loci_plot import draw_curves
from symkin.singularities.classification import classify, singularity
from symkin.singularities.loci import Loci
from symkin.singularities.locus import picture_distance
from symkin.singularities.singular_loci import singular_loci
from symkin.singularities.singularity_result import Singularity
from symkin.spatial.screw import revolute_screw

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.gluon_6l3.model import OFFSET, A, D, determinant, symbolic_jacobian
from studies.shared.report import Report, new_figure, options_parser
from studies.shared.screws import exponential, move_screw, reciprocal_product

SEED = 6
SLICE = (15.0, 15.0, 40.0, 30.0, 50.0, 20.0)
"""Joint values in degrees of the configuration whose q2, q3 vary in the picture."""
EXAMPLE_SLICE = np.radians(SLICE)


# --- closed form ----------------------------------------------------------------------------------


def conditions(q: np.ndarray) -> dict[str, np.ndarray]:
    """Elbow, wrist and shoulder: each a number that vanishes there, without units; q (..., 6) in
    radians.
    """
    t = q + OFFSET
    two, three, four = t[..., 1], t[..., 1] + t[..., 2], t[..., 1] + t[..., 2] + t[..., 3]
    reach = A[1] * np.cos(two) + A[2] * np.cos(three) + D[4] * np.sin(four)
    return {
        "elbow": np.sin(t[..., 2]),
        "wrist": np.sin(t[..., 4]),
        "shoulder": reach / (abs(A[1]) + abs(A[2]) + abs(D[4])),
    }


def shoulder_q2(q: np.ndarray) -> np.ndarray:
    """The q2 that solves the shoulder condition for the other joints of q: a cos(t_2) + b
    sin(t_2) = 0.
    """
    three, four = q[2] + OFFSET[2], q[2] + OFFSET[2] + q[3] + OFFSET[3]
    a = A[1] + A[2] * np.cos(three) + D[4] * np.sin(four)
    b = -A[2] * np.sin(three) + D[4] * np.cos(four)
    return np.array([q[0], np.arctan2(-a, b) - OFFSET[1], *q[2:]])


def named(kind: str, q: np.ndarray) -> np.ndarray:
    """The joint values with one of them moved so that the arm is singular."""
    if kind == "shoulder":
        return shoulder_q2(q)
    k = {"elbow": 2, "wrist": 4}[kind]
    moved = q.copy()
    moved[k] = -OFFSET[k]
    return moved


# --- report ---------------------------------------------------------------------------------------


def report_determinant(report: Report, arm: symkin.Mechanism, number: int) -> np.ndarray:
    """det J by the arm's screws over its factors, on random joint values."""
    evaluate, _ = symbolic_jacobian(arm)
    q = np.random.default_rng(SEED).uniform(-np.pi, np.pi, (number, 6))
    scale = abs(A[1] * A[2]) * (abs(A[1]) + abs(A[2]) + abs(D[4]))
    gaps = [
        abs(float(np.linalg.det(np.asarray(evaluate(one)))) - determinant(one)) / scale for one in q
    ]
    report.row(
        f"det J less the product of its factors, over its scale, {number} random q: largest",
        0.0,
        max(gaps),
    )
    return q


def report_distances(report: Report, arm: symkin.Mechanism, q: np.ndarray) -> None:
    """The closed form's conditions are numeric singularities, and none of the random configurations
    is one.
    """
    for kind in ("elbow", "wrist", "shoulder"):
        worst, others, works = 0.0, [], []
        for one in q[:40]:
            found = at(arm, named(kind, one))
            worst = max(worst, found.distances["type 1"])
            others.append(found.kinds == ("type 1",) and found.conditions == ("RI", "IO"))
            works.append(work(arm, found))
        report.row(
            f"{kind}: distance to type 1 at 40 random configurations of the closed form, largest",
            0.0,
            worst,
        )
        report.row(f"{kind}: classified as type 1 (RI, IO)", 40, sum(others))
        report.row(
            f"{kind}: work of the wrench that is borne on the joints' twists, largest over the "
            f"size",
            0.0,
            max(works),
        )
        example = at(arm, named(kind, EXAMPLE_SLICE))
        report.row(
            f"{kind}: wrench that is borne", None, "; ".join(str(w) for w in example.wrenches)
        )
        report.row(
            f"{kind}: joints that move with the tool at rest",
            None,
            ", ".join(f"{k} {v:.4f}" for k, v in example.inputs[0].items()),
        )
    regular = sum(not at(arm, one).is_singular for one in q[:40])
    report.row("random configurations that are regular", 40, regular)


def at(arm: symkin.Mechanism, q: np.ndarray) -> Singularity:
    return singularity(arm, joints=np.degrees(q))


def work(arm: symkin.Mechanism, found: Singularity) -> float:
    """Largest reciprocal product of the wrenches with the joints' twists, over the size."""
    moved, worst = symkin.Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])), 0.0
    for _, joint in arm.joints:
        screw = revolute_screw(np.array(joint.point), np.array(joint.axis))
        twist = move_screw(moved, screw)
        worst = max(
            worst, *(abs(float(reciprocal_product(twist, w.vector))) for w in found.wrenches)
        )
        moved = moved @ exponential(screw, found.solution.values[joint.name] - joint.zero)
    return worst / arm.characteristic_length


def report_loci(report: Report, arm: symkin.Mechanism) -> Loci:
    solution = symkin.solve(arm, joints=SLICE).solution
    loci = singular_loci(
        solution, ("q2", "q3"), ranges=((-180, 180), (-180, 180)), starts=150, seed=SEED
    )
    worst = 0.0
    for curve in loci.curves:
        q = np.tile(EXAMPLE_SLICE, (len(curve.points), 1))
        q[:, 1:3] = np.radians(curve.points)
        factors = conditions(q)
        worst = max(
            worst, float(np.min(np.abs([factors["elbow"], factors["shoulder"]]), axis=0).max())
        )
    report.row("traced loci over q2, q3: smallest closed-form factor on them, largest", 0.0, worst)
    report.row(
        "closed-form points over q2, q3 farther than 0.2 deg from a traced locus", 0, missed(loci)
    )
    return loci


def missed(loci: Loci) -> int:
    """Points of s_3 = 0 and of the shoulder's curve that no traced polyline passes within 0.2
    degrees.
    """
    count = 0
    for value in np.linspace(-179, 179, 120):
        q = EXAMPLE_SLICE.copy()
        q[2] = np.radians(value)
        root = np.degrees(shoulder_q2(q)[1])
        wanted = [(value, -np.degrees(OFFSET[2])), *((root + turn, value) for turn in (0.0, 180.0))]
        points = np.remainder(np.array(wanted) + 180.0, 360.0) - 180.0
        away = [
            picture_distance(curve.points, curve.closed, np.ones(2), points)[0]
            for curve in loci.curves
        ]
        count += int(np.sum(np.min(away, axis=0) > 0.2))
    return count


def draw(arm: symkin.Mechanism, loci: Loci):
    figure = new_figure(13.5, 6.3)
    figure.suptitle("Gluon-6L3: singularities, closed form and traced", fontsize=15, weight="bold")
    left, right = figure.subplots(1, 2)
    grid = np.radians(np.linspace(-180, 180, 361))
    q = np.tile(EXAMPLE_SLICE, (361, 361, 1))
    q[..., 1], q[..., 2] = grid[None, :], grid[:, None]
    factors = conditions(q)
    value = factors["elbow"] * factors["wrist"] * factors["shoulder"]
    image = left.imshow(
        value, origin="lower", extent=(-180, 180, -180, 180), cmap="RdBu_r", vmin=-0.5, vmax=0.5
    )
    draw_curves(left, loci)
    left.grid(visible=False)
    left.set_title("det J over its scale, and traced loci")
    figure.colorbar(image, ax=left, shrink=0.75)
    turn = np.linspace(-np.pi, np.pi, 181)
    for k, name, colour in (
        (2, "q3 (elbow)", "#0072b2"),
        (4, "q5 (wrist)", "#d55e00"),
        (1, "q2 (shoulder)", "#009e73"),
    ):
        distances = []
        for angle in turn:
            joints = list(SLICE)
            joints[k] = np.degrees(angle)
            distances.append(
                classify(symkin.solve(arm, joints=joints).solution).distances["type 1"]
            )
        right.plot(np.degrees(turn), distances, color=colour, lw=1.8, label=name)
    right.set(
        xlabel="joint value [deg]",
        ylabel="distance to type 1",
        title="one joint varied",
        xlim=(-180, 180),
        ylim=(0, None),
    )
    right.legend(frameon=False)
    right.grid(color="0.9")
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--random", type=int, default=1000, help="random joint values compared (default: 1000)"
    )
    options = parser.parse_args()
    arm = symkin.load("gluon_6l3")
    report = Report(
        "gluon_singular", "Gluon-6L3: singularities from the closed form and numerically", SEED
    )
    q = report_determinant(report, arm, options.random)
    report_distances(report, arm, q)
    loci = report_loci(report, arm)
    report.finish(draw(arm, loci), options.output)


if __name__ == "__main__":
    main()
