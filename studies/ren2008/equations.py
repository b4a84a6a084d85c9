"""Rows on what the method can tell and how: parameters and frames (1.2), equations (3) to (8), and
the measuring procedure (1.5).

Source: Ren, Feng, Su 2008 (see `study`); mathematics in `identification` and `procedure`.
"""

from __future__ import annotations

import numpy as np

import symkin
from studies.ren2008.identification import (
    Identified,
    causes,
    difference_slopes,
    frame_motions,
    identify,
    jacobian,
    neighbours,
    normal_jacobian,
    residuals,
    rms,
    spectrum,
)
from studies.ren2008.method import BEST, EXACT, Fits, fit, inclinations, measure, postures_in_groups
from studies.ren2008.model import (
    NAMES,
    NOMINAL,
    TRUE,
    Case,
    angles_of,
    direct,
    eta_from,
    eta_of,
    free_columns,
    held_names,
    inverse,
    slopes,
)
from studies.shared.report import Report
from symkin.calibration.judge.identifiability import identifiability

GROUPS, EACH = 10, 4


def group_numbers(groups: int, each: int = EACH) -> np.ndarray:
    return np.repeat(np.arange(groups), each)


def by_parameters(eta: np.ndarray, X: np.ndarray) -> np.ndarray:
    """dX/deta (n, 6, 42)."""
    return slopes(X, inverse(X, eta), eta).by_eta


# --- 1.1, 1.2 -------------------------------------------------------------------------------------


def report_machine(report: Report, case: Case) -> None:
    """Figure 1 in numbers: six actuated rods, the frames, 42 parameters."""
    found = symkin.mobility(case.nominal)
    report.row(
        "freedoms of the platform: none is lost, no joint is passive",
        6,
        found.mobility,
        place="1.1",
        run=symkin.mobility,
    )
    report.row("geometric parameters: 6 (3 + 3 + 1)", 42, len(NAMES), place="1.2", run=eta_of)
    zero_names = held_names(case.nominal)
    report.row(
        "of these zero by the frames {M1} and {B1}",
        10,
        len(zero_names),
        place="1.2, figure 1",
        run=held_names,
    )
    report.row("left to be identified", 32, len(case.free), place="1.2", run=free_columns)
    zeros = [abs(eta[NAMES.index(name)]) for eta in (case.eta, case.truth) for name in zero_names]
    report.row(
        "the ten entries in tables 1 and 2, largest",
        0,
        max(zeros),
        "m",
        place="1.2, tables 1, 2",
        run=held_names,
    )


def report_identifiable(report: Report, case: Case) -> None:
    """1.2's argument from physics, as numbers: ten motions of the frames, and nothing else, leave
    the constraint as it is.
    """
    X = postures_in_groups(case.eta, inclinations(GROUPS, case.rng(12)), case.rng(13))
    by_eta, groups = by_parameters(case.eta, X), group_numbers(GROUPS)
    whole, place = jacobian(by_eta, groups), "1.2"
    report.row(
        "rank of dC/deta, 32 columns, 40 postures",
        32,
        spectrum(whole[:, case.free]).rank,
        place=place,
        run=jacobian,
    )
    report.row(
        "rank of dC/deta, all 42 columns", 32, spectrum(whole).rank, place=place, run=jacobian
    )
    motions = frame_motions(case.eta)
    report.row(
        "motions of the platform frame (6), shifts and yaw of the base frame (4): rank",
        10,
        int(np.linalg.matrix_rank(motions)),
        place=place,
        run=frame_motions,
    )
    report.row(
        "what they change in C, largest",
        0,
        float(np.abs(whole @ motions).max()),
        place=place,
        run=(jacobian, frame_motions),
        tolerance=1e-12,
    )
    measured = measure(case.truth, GROUPS, EACH, BEST, case.rng(14))
    named = identifiability(case.nominal, measured)
    report.row("symkin.identifiability: rank", 32, named.rank, place=place, run=identifiability)
    report.row(
        "symkin.identifiability: condition (rows over their noise, columns per length)",
        None,
        named.condition,
        place=place,
        run=identifiability,
    )
    report.row(
        "symkin.identifiability: what no reading tells",
        None,
        "; ".join(named.unobservable),
        place=place,
        run=identifiability,
    )
    counts = []
    for s in range(2, 8):
        X = postures_in_groups(case.eta, inclinations(s, case.rng(15)), case.rng(16, s))
        counts.append(
            spectrum(jacobian(by_parameters(case.eta, X)[:, :, case.free], group_numbers(s))).rank
        )
    report.row(
        "rank with 2, 3, 4, 5, 6, 7 groups of 4 postures",
        None,
        counts,
        place="1.3, (3)",
        run=jacobian,
    )
    report_meaning(report, case)


def report_meaning(report: Report, case: Case) -> None:
    """Which angles alpha and beta are: about the fixed axes, last gamma. The other order would hold
    R e_z, and tells less.
    """
    X = postures_in_groups(case.eta, inclinations(GROUPS, case.rng(12)), case.rng(13))
    turned = X.copy()
    turned[:, 3:] = moving_axes(X[:, 3:])
    rank = spectrum(
        normal_jacobian(
            turned, by_parameters(case.eta, turned)[:, :, case.free], group_numbers(GROUPS)
        )
    ).rank
    report.row(
        "rank if alpha, beta were about moving axes: the platform's normal held in the base frame",
        None,
        rank,
        place="1.3",
        run=normal_jacobian,
    )


def moving_axes(angles: np.ndarray) -> np.ndarray:
    """(alpha, beta, gamma) about fixed axes of the turns Rx(a) Ry(b) Rz(c) of angles (n, 3)."""
    single = [symkin.Pose.from_euler(np.zeros(3), row, "XYZ").rotation for row in angles]
    return angles_of(np.array(single))


# --- 1.3 ------------------------------------------------------------------------------------------


def report_estimator(report: Report, case: Case) -> Identified:
    """(3) to (6) without noise, by Levenberg-Marquardt as the paper says; then the same minimum by
    symkin's own forms.
    """
    counts = [2 * len(neighbours(group_numbers(s))) for s in (10, 15, 20)]
    report.row(
        "(3): equations 2 s (t - 1) of 10, 15, 20 groups of 4",
        [60, 90, 120],
        counts,
        place="1.3, (3)",
        run=neighbours,
    )
    exact = measure(case.truth, GROUPS, EACH, EXACT, case.rng(20))
    X = direct(exact.joints, case.truth, np.tile(case.home, (len(exact), 1)))
    report.row(
        "(5): |C| at the true parameters",
        0,
        float(np.linalg.norm(residuals(X, exact.groups))),
        "rad",
        place="1.3, (5)",
        run=residuals,
        tolerance=1e-12,
    )
    C = residuals(direct(exact.joints, case.eta, X), exact.groups)
    report.row(
        "(5): |C| at the nominal parameters",
        None,
        float(np.linalg.norm(C)),
        "rad",
        place="1.3, (5)",
        run=residuals,
    )
    D = neighbours(exact.groups)
    angles = direct(exact.joints, case.eta, X)[:, 3:5]
    total = float(np.sum((D @ angles) ** 2))
    report.row(
        "(6): the sum of squares over |C|^2; over |C|, which our copy prints (an exponent may be "
        "lost)",
        None,
        [total / float(C @ C), total / float(np.linalg.norm(C))],
        place="1.3, (6)",
        run=residuals,
    )
    found = identify(exact.joints, exact.groups, case.eta, case.free, case.home)
    report.row(
        "cost (6) after each step of Levenberg-Marquardt: first five",
        None,
        found.costs[:5],
        "rad^2",
        place="1.3, (6)",
        run=found,
    )
    report.row(
        "steps until the parameters move by less than 1e-13 m",
        None,
        len(found.costs) - 1,
        place="1.3, (6)",
        run=found,
    )
    report_same_minimum(report, case)
    return found


def report_same_minimum(report: Report, case: Case) -> None:
    """With noise the minimum of (6) is no exact geometry: both forms must find the same one, though
    symkin's fit expects a geometry near nominal, which decides what readings hardly tell.
    """
    noisy = measure(case.truth, 20, EACH, BEST, case.rng(21))
    ours = identify(noisy.joints, noisy.groups, case.eta, case.free, case.home)
    found = fit(case.nominal, noisy, "differences")
    gap, run = float(np.abs(eta_from(found.values, case.eta) - ours.eta).max()), Fits([found])
    name, place = "80 noisy postures: symkin.calibrate, differences", "1.3, (6)"
    report.row(
        f"{name}, less the minimum of (6)",
        0,
        gap,
        "m",
        place=place,
        run=(ours, run),
        tolerance=1e-7,
    )
    report.row(f"{name}: iterations", None, found.iterations, place=place, run=run)
    report.row(f"{name}: time", None, found.elapsed_s, "s", place=place, run=run, volatile=True)
    report.row(
        "spread about nominal that symkin expects: decides what readings hardly tell",
        None,
        float(found.problem.prior.max()),
        "m",
        place=place,
        run=run,
    )


# --- 1.4 ------------------------------------------------------------------------------------------


def report_causes(report: Report, case: Case) -> dict[str, float]:
    """(8): both sides, the order of what it leaves out, and the sizes of the three causes; rms of
    each, deg.
    """
    rng, groups, place = case.rng(30), group_numbers(GROUPS), "1.4, (8)"
    X = postures_in_groups(case.truth, inclinations(GROUPS, rng), rng)
    rods, tilts = (
        rng.uniform(-1e-6, 1e-6, (len(X), 6)),
        np.radians(rng.uniform(-0.0005, 0.0005, (len(X), 2))),
    )
    posed = X.copy()
    posed[:, 3:5] += tilts
    seen = direct(inverse(posed, case.truth), case.truth, X)[:, 3:5] - tilts
    report.row(
        "(7): alpha, beta at the true rods, less what the inclinometer repeats: neighbour "
        "differences, largest",
        0,
        float(np.degrees(np.abs(neighbours(groups) @ seen).max())),
        "deg",
        place="1.4, (7)",
        run=(direct, neighbours),
        tolerance=1e-9,
    )
    errors = case.truth - case.eta
    shares = [
        causes(X, groups, case.truth - f * errors, f * errors, f * rods, f * tilts)
        for f in (1.0, 0.5)
    ]
    report.row(
        "(8): left less right over left, rms, table 2's errors",
        None,
        shares[0].remainder,
        place=place,
        run=causes,
    )
    ratio = shares[0].remainder / shares[1].remainder
    report.row(
        "(8): the same, all errors halved: it falls by (2 for first order)",
        2,
        ratio,
        place=place,
        run=causes,
        tolerance=0.1,
    )
    report_derivatives(report, case, X)
    by_errors = difference_slopes(X, groups, case.eta, case.free)
    report.row(
        "slope of alpha, beta by one extension: largest, rms",
        None,
        list(_slopes(X, case.eta)),
        "deg/mm",
        place=place,
        run=slopes,
    )
    report.row(
        "slope of a neighbour difference by one parameter: largest, rms",
        None,
        [float(np.degrees(np.abs(by_errors).max()) / 1e3), float(np.degrees(rms(by_errors)) / 1e3)],
        "deg/mm",
        place=place,
        run=difference_slopes,
    )
    sizes = {f"rods, {1e6 * e:g} um": rms_of_rods(X, groups, case.eta, e) for e in (2e-6, 20e-6)}
    sizes |= {
        f"inclinometer, {e:g} deg": float(np.sqrt(2) * e / np.sqrt(12)) for e in (0.001, 0.01)
    }
    sizes["parameters, table 2"] = float(np.degrees(rms(by_errors @ errors[case.free])))
    for cause, size in sizes.items():
        report.row(
            f"(8), cause: {cause}: neighbour difference, rms",
            None,
            size,
            "deg",
            place=place,
            run=(causes, slopes),
        )
    report.row(
        "(8): rods at 20 um over inclinometer at 0.001 deg; at 2 um",
        None,
        [
            sizes["rods, 20 um"] / sizes["inclinometer, 0.001 deg"],
            sizes["rods, 2 um"] / sizes["inclinometer, 0.001 deg"],
        ],
        place=place,
        run=(causes, slopes),
    )
    return sizes


def _slopes(X: np.ndarray, eta: np.ndarray) -> tuple[float, float]:
    at = slopes(X, inverse(X, eta), eta).by_rods[:, 3:5]
    return float(np.degrees(np.abs(at).max()) / 1e3), float(np.degrees(rms(at)) / 1e3)


def rms_of_rods(X: np.ndarray, groups: np.ndarray, eta: np.ndarray, precision: float) -> float:
    """Root mean square difference between neighbours [deg] that rods of a precision [m], uniform,
    make.
    """
    at = slopes(X, inverse(X, eta), eta).by_rods[:, 3:5]
    variance = (at**2).sum(axis=2) * precision**2 / 12
    return float(np.degrees(np.sqrt(np.mean(np.abs(neighbours(groups)) @ variance))))


def report_derivatives(report: Report, case: Case, X: np.ndarray) -> None:
    """The paper takes derivatives of f_alpha, f_beta numerically; here they are exact, and compared
    with central differences.
    """
    q, step = inverse(X, case.eta), 1e-6
    at = slopes(X, q, case.eta)
    by_rods = [
        (direct(q + step * e, case.eta, X) - direct(q - step * e, case.eta, X)) / (2 * step)
        for e in np.eye(6)
    ]
    by_eta = [
        (direct(q, case.eta + step * e, X) - direct(q, case.eta - step * e, X)) / (2 * step)
        for e in np.eye(len(NAMES))
    ]
    gaps = [
        np.abs(np.stack(a, axis=2) - b)[:, 3:5].max()
        for a, b in ((by_rods, at.by_rods), (by_eta, at.by_eta))
    ]
    report.row(
        "derivatives of alpha, beta by l, by eta: numerical less CasADi's, largest",
        [0, 0],
        [float(g) for g in gaps],
        "rad/m",
        place="1.4, (8)",
        run=(direct, slopes),
        tolerance=1e-6,
    )


def report_tables(report: Report, case: Case) -> None:
    """Tables 1 and 2 against the mechanism files, and the paper's 5 mm."""
    gaps = [
        np.abs(eta_of(m) - eta_from_table(t)).max()
        for m, t in ((case.nominal, NOMINAL), (case.true, TRUE))
    ]
    report.row(
        "mechanism files less tables 1 and 2",
        [0, 0],
        [float(g) for g in gaps],
        "m",
        place="tables 1, 2",
        run=eta_of,
    )
    largest = float(np.abs(eta_from_table(TRUE) - eta_from_table(NOMINAL)).max())
    report.row(
        "largest true less nominal value",
        0.005,
        largest,
        "m",
        place="2, tables 1, 2",
        run=eta_from_table,
    )


def eta_from_table(table: dict[str, list]) -> np.ndarray:
    return np.concatenate([np.ravel(table["platform"]), np.ravel(table["base"]), table["offset"]])
