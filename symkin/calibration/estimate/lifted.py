"""Solve the lifted form by IPOPT: poses are unknowns and the closure of every configuration a
constraint.

min sum |W (h(z_i, p) - m_i - G_i g)|^2 over p, z_1 ... z_n and the inclinations g of the groups,
subject to F(z_i, p) = 0, unit quaternions and N^T (p - nominal) = 0 for the directions N that no
reading determines; exact derivatives by CasADi.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import Readings, deviations, neighbours, whitening
from symkin.calibration.estimate.solver import Estimate, estimate
from symkin.calibration.estimate.state import (
    State,
    closed_state,
    error_free_design,
    joint_covariance,
    null_directions,
)
from symkin.position.least_squares import IPOPT

_IPOPT_OPTIONS = {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": False,
    "calc_lam_p": False,
    "ipopt.tol": 1e-10,
    "ipopt.nlp_scaling_method": "none",
    "ipopt.mu_strategy": "adaptive",
}
_POLISHING_STEPS = 3
"""Gauss-Newton steps that remove what IPOPT's tolerance leaves."""


@dataclass(frozen=True, eq=False)
class NonlinearProgram:
    """A nonlinear program: solver, start, and how many numbers of the unknowns are scaled parameter
    changes.
    """

    solver: ca.Function
    start: np.ndarray
    rows: int
    parameters: int


def estimate_by_ipopt(
    problem: CalibrationProblem,
    z: np.ndarray,
    *,
    max_iterations: int = 200,
    p: np.ndarray | None = None,
) -> Estimate:
    """Minimise by IPOPT from p (default: nominal) and configurations z, polished by Gauss-Newton;
    maximum likelihood takes the covariance of joint noise at the estimate by the means.
    """
    state = closed_state(problem, problem.model.nominal if p is None else p, z, "means", None)
    steps = 0
    if problem.form == "maximum likelihood":
        first = estimate_by_ipopt(
            replace(problem, form="means"), z, max_iterations=max_iterations, p=p
        )
        state, steps = first.state, first.iterations
    covariance = joint_covariance(problem, state) if problem.form == "maximum likelihood" else None
    program = build_program(problem, state, covariance, max_iterations)
    with IPOPT:
        found = program.solver(x0=program.start, lbg=0.0, ubg=0.0)
        stats = program.solver.stats()
    values = np.asarray(found["x"]).ravel()
    p = problem.model.nominal + problem.model.scales * values[: program.parameters]
    z = values[program.parameters : program.parameters + z.size].reshape(z.shape)
    end = estimate(problem, z, p=p, max_iterations=_POLISHING_STEPS)
    status = "ok" if end.status in ("ok", "max_iterations") and stats["success"] else "stalled"
    return Estimate(end.state, status, steps + int(stats["iter_count"]), end.null_space)


def build_program(
    problem: CalibrationProblem, state: State, covariance: np.ndarray | None, limit: int
) -> NonlinearProgram:
    """Build the program at a start with closed configurations; `covariance` is that of joint noise
    for maximum likelihood.
    """
    model, readings = problem.model, problem.readings
    count, width = state.z.shape
    step, z = ca.MX.sym("dp", len(model.names)), ca.MX.sym("z", width, count)
    means = ca.MX.sym("g", 2, readings.groups)
    p = ca.DM(model.nominal) + ca.DM(model.scales) * step
    f = ca.Function(
        "posture",
        [model.system.unknown, model.joints, model.parameters, model.quaternion],
        [model.system.rows, model.readings],
    )
    joints, quaternions = ca.DM(problem.measurements.joints.T), ca.DM(problem.quaternions.T)
    rows, h = f.map(count)(z, joints, ca.repmat(p, 1, count), quaternions)
    h0 = model.evaluate(state.z, problem.measurements.joints, state.p, problem.quaternions).readings
    residual = _residual(problem, h, h0, means, covariance)
    unit = [
        ca.sum1(z[place, :] ** 2) - 1
        for c, place in zip(model.system.unknowns, model.system.slices, strict=True)
        if c.width == 4
    ]
    held = ca.mtimes(ca.DM(null_directions(error_free_design(problem, state)).T), step)
    constraints = ca.vertcat(
        ca.vec(rows) / model.closure.characteristic_length, *(ca.vec(u) for u in unit), held
    )
    unknown = ca.vertcat(step, ca.vec(z), ca.vec(means))
    weight = 1.0 / max(readings.count, 1)
    if problem.prior is not None:
        residual = ca.vertcat(residual, step / ca.DM(problem.prior))
    nlp = {"x": unknown, "f": 0.5 * weight * ca.sumsqr(residual), "g": constraints}
    solver = ca.nlpsol("lifted", "ipopt", nlp, _IPOPT_OPTIONS | {"ipopt.max_iter": limit})
    changed = (state.p - model.nominal) / model.scales
    centres = (
        h0[np.ix_(readings.first, np.flatnonzero(readings.grouped))]
        if readings.groups
        else np.zeros(0)
    )
    start = np.concatenate([changed, state.z.reshape(-1), centres.reshape(-1)])
    return NonlinearProgram(solver, start, int(constraints.shape[0]), len(model.names))


def _residual(
    problem: CalibrationProblem,
    h: ca.MX,
    h0: np.ndarray,
    means: ca.MX,
    covariance: np.ndarray | None,
) -> ca.MX:
    """Write residuals over their standard deviations; whole turns of angles are those of the
    start.
    """
    readings = problem.readings
    columns = np.flatnonzero(readings.grouped)
    gap = h - ca.DM(np.nan_to_num(readings.values).T) + ca.DM(_turns(readings, h0).T)
    weight = np.where(readings.taken, 1.0 / readings.sigma, 0.0)
    if problem.form == "differences" and readings.groups:
        return _differences(readings, gap, weight)
    if readings.groups:
        spread = np.zeros((readings.groups, len(h0)))
        inside = np.flatnonzero(readings.group >= 0)
        spread[readings.group[inside], inside] = 1.0
        place = np.zeros((gap.shape[0], 2))
        place[columns, [0, 1]] = 1.0
        gap = gap - ca.mtimes([ca.sparsify(ca.DM(place)), means, ca.sparsify(ca.DM(spread))])
    if covariance is None:
        return ca.vec(ca.DM(weight.T) * gap)
    blocks = [ca.DM(block) for block in whitening(readings, covariance)]
    return ca.mtimes(ca.diagcat(*blocks), ca.vec(gap))


def _differences(readings: Readings, gap: ca.MX, weight: np.ndarray) -> ca.MX:
    columns = np.flatnonzero(readings.grouped)
    before, after = neighbours(readings)
    take = np.zeros((len(weight), len(before)))
    take[after, np.arange(len(before))], take[before, np.arange(len(before))] = 1.0, -1.0
    s = 1.0 / np.hypot(
        readings.sigma[np.ix_(before, columns)], readings.sigma[np.ix_(after, columns)]
    )
    grouped = ca.DM(s.T) * ca.mtimes(gap[columns.tolist(), :], ca.sparsify(ca.DM(take)))
    others = [k for k in range(weight.shape[1]) if k not in columns]
    if not others:
        return ca.vec(grouped)
    return ca.vertcat(ca.vec(grouped), ca.vec(ca.DM(weight[:, others].T) * gap[others, :]))


def _turns(readings: Readings, h0: np.ndarray) -> np.ndarray:
    """Return the multiples of a turn that bring h - m (and a group's h) to the shorter way round at
    the start.
    """
    plain = np.where(readings.taken, h0 - np.nan_to_num(readings.values), 0.0)
    wrapped = deviations(readings, h0)
    inside = np.flatnonzero(readings.group >= 0)
    columns = np.flatnonzero(readings.grouped)
    if readings.groups:
        plain[np.ix_(inside, columns)] -= h0[
            np.ix_(readings.first[readings.group[inside]], columns)
        ]
    return np.asarray(wrapped - plain)
