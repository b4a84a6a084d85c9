"""The Gluon-6L3's inverse problem by iteration: CasADi's solvers on T(q) = T, the Jacobian's
iteration, and symkin's enumeration.

The page's closure is T(q) = T: twelve equations of six unknowns, those of the rotation times the
size L. IPOPT minimises the squares of all twelve. The rootfinder wants six: the position's three,
and the rotation's error e = (n x n* + o x o* + a x a*) / 2 = sin(w) k, as numeric inverse
kinematics has it (columns of R and of the given R*, w the angle and k the axis from one to the
other). It vanishes at half a turn too; divided by (1 + cos w) / 2, 1 + 2 cos w = tr(R^T R*), it is
2 tan(w / 2) k, which does not. An end counts only if all twelve vanish. Guesses are uniform in a
turn. Units: mm, radians. Source: see `study`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

import symkin
from studies.gluon_6l3.model import (
    SIZE,
    closed_form,
    forward,
    pose_error,
    symbolic_jacobian,
    tool_expression,
    wrap,
)
from studies.shared.guesses import ROOTFINDER, Closure, Search, Trial
from symkin import Modes

STARTS = {"batched": 300, "newton": 300, "ipopt": 40}
"""Starts of symkin's multistart by inner solver; IPOPT takes a tenth of a second for each."""
FEW, MANY = 200, 2000
"""Starts of multistart at random poses, and where these miss a solution."""
TWIN = 1e-3
"""Solutions nearer to each other than this (rad) are nearly a double root, where only residuals
tell anything.
"""


@dataclass(frozen=True, eq=False)
class Equations:
    """All twelve rows, given the pose as twelve numbers by columns; six with the rotation's error
    e; six with 2 tan(w / 2) k.
    """

    twelve: Closure
    sines: ca.SX
    tangents: ca.SX


def equations() -> Equations:
    """The closure T(q) = T in joint values q, rows in mm."""
    q, u = ca.SX.sym("q", 6), ca.SX.sym("T", 12)
    given, T = ca.reshape(u, 3, 4), tool_expression(q)
    position, rotation = T[:3, 3] - given[:, 3], SIZE * ca.vec(T[:3, :3] - given[:, :3])
    e = -SIZE / 2 * sum((ca.cross(T[:3, k], given[:, k]) for k in range(3)), ca.SX.zeros(3))
    half = (1 + ca.trace(ca.mtimes(T[:3, :3].T, given[:, :3]))) / 4
    twelve = Closure(q, u, ca.vertcat(rotation, position), [True] * 6, SIZE)
    return Equations(twelve, ca.vertcat(position, e), ca.vertcat(position, e / half))


def given_numbers(T: np.ndarray) -> np.ndarray:
    """A pose as the closure takes it."""
    return np.asarray(T[:3, :].T.ravel())


def rootfinder_of_six(twelve: Closure, six: ca.SX, name: str = "rootfinder") -> Search:
    """CasADi's Newton on six rows, judged by the twelve."""
    find = ca.rootfinder("newton", "newton", {"x": twelve.X, "p": twelve.u, "g": six}, ROOTFINDER)
    return Search(
        name, twelve, lambda X, u: find(x0=X, p=u)["x"], lambda: int(find.stats()["iter_count"])
    )


def ends_at_half_turns(trial: Trial, T: np.ndarray) -> int:
    """Ends that have the given position but another rotation whose error e vanishes."""
    return sum(
        not end.closed
        and bool(np.all(np.isfinite(end.X)))
        and float(np.abs(pose_difference(end.X, T)).max()) < 1e-6
        for end in trial.ends
    )


def newton_step(twelve: Closure, six: ca.SX) -> ca.Function:
    """One step of Newton's method on six rows as one expression, to count its operations."""
    step = twelve.X - ca.solve(ca.jacobian(six, twelve.X), six)
    return ca.Function("newton_step", [twelve.X, twelve.u], [step], {"cse": True})


# --- the page's numeric inverse -------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Iteration:
    """q <- q + J^T (J J^T + damping)^-1 e, e the error (rotation; position over L), the damping
    halved after a step that lessens
    |e| and doubled, the step taken back, after one that does not; 0: the pseudo-inverse.
    """

    arm: symkin.Mechanism
    damping: float
    steps: int = 200

    @cached_property
    def jacobian(self) -> ca.Function:
        return symbolic_jacobian(self.arm)[0]

    def evidence(self) -> dict[str, object]:
        name = f"damping {self.damping}" if self.damping else "pseudo-inverse"
        return {
            "by": f"{__name__}.Iteration",
            "method": "jacobian",
            "text": f"Jacobian's iteration, {name}",
        }

    def solve(self, T: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, int]:
        """The joint values reached and the steps taken."""
        damping, error = self.damping, pose_difference(q, T)
        for step in range(self.steps):
            if pose_error(q, T) < 1e-9:
                return wrap(q), step
            J = np.asarray(self.jacobian(q)) / np.repeat([1.0, SIZE], 3)[:, None]
            moved = q + np.linalg.pinv(J) @ error
            if self.damping:
                moved = q + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error)
            new = pose_difference(moved, T)
            worse = self.damping > 0 and np.linalg.norm(new) >= np.linalg.norm(error)
            damping *= 2.0 if worse else 0.5
            if not worse:
                q, error = moved, new
        return wrap(q), self.steps


def pose_difference(q: np.ndarray, T: np.ndarray) -> np.ndarray:
    """(half the sum of the columns' cross products; position over L)."""
    own = forward(q)
    turn = 0.5 * np.cross(own[:3, :3].T, T[:3, :3].T).sum(axis=0)
    return np.concatenate([turn, (T[:3, 3] - own[:3, 3]) / SIZE])


# --- enumeration against the closed form ----------------------------------------------------------


def joint_lists(found: Modes) -> list[np.ndarray]:
    return [np.radians(s.actuated) for s in found]


def continued(arm: symkin.Mechanism, T: np.ndarray) -> Modes:
    return symkin.modes(arm, pose=symkin.Pose.from_matrix(T), method="continuation")


def sampled(arm: symkin.Mechanism, T: np.ndarray, solver: str, starts: int, seed: int) -> Modes:
    pose = symkin.Pose.from_matrix(T)
    return symkin.modes(
        arm, pose=pose, method="multistart", solver=solver, starts=starts, seed=seed
    )


def furthest(exact: list[np.ndarray], found: Modes) -> float:
    """Largest difference of two lists of joint values in rad, each to the nearest of the other;
    infinite where counts differ.
    """
    own = joint_lists(found)
    if len(exact) != len(own):
        return np.inf
    return max(min(float(np.abs(wrap(a - b)).max()) for b in own) for a in exact)


def has_twin(q: np.ndarray, solutions: list[np.ndarray]) -> bool:
    """Whether another of the solutions lies within TWIN of the one nearest to q."""
    gaps = [np.abs(wrap(q - other)).max() for other in solutions]
    nearest = solutions[int(np.argmin(gaps))] if solutions else q
    return any(
        other is not nearest and np.abs(wrap(nearest - other)).max() < TWIN for other in solutions
    )


def missed(exact: list[np.ndarray], found: Modes) -> int:
    """Solutions of the closed form that a list lacks: none within 1e-10 rad times the condition,
    1e-2 rad for twins.
    """
    own = [(np.radians(s.actuated), s.condition) for s in found]
    count = 0
    for q in exact:
        near = [(np.abs(wrap(q - p)).max(), 1e-10 * c) for p, c in own]
        count += not any(
            gap <= max(allowed, 1e-2 if has_twin(q, exact) else 0.0) for gap, allowed in near
        )
    return count


def surplus(exact: list[np.ndarray], found: Modes, T: np.ndarray) -> int:
    """Listed solutions that leave more than 1e-6 mm, and those beyond the closed form's count where
    it has no twins.
    """
    wrong = sum(pose_error(q, T) > 1e-6 for q in joint_lists(found))
    return wrong + (
        0 if any(has_twin(q, exact) for q in exact) else max(0, len(found) - len(exact))
    )


@dataclass(frozen=True, eq=False)
class Comparison:
    """One method's lists at many poses beside the closed form's: evidence is read off the lists,
    all of one method.
    """

    exact: list[list[np.ndarray]]
    lists: list[Modes]
    poses: list[np.ndarray]

    def evidence(self) -> dict[str, object]:
        """The method, starts and seed that every list names."""
        ((method, starts, seed),) = {
            (found.method, found.starts, found.seed) for found in self.lists
        }
        text = f"modes: {method}" if starts is None else f"modes: {method}, {starts} starts"
        return {
            "by": "symkin.modes",
            "method": method,
            "starts": starts,
            "seed": seed,
            "text": f"{text}, at each pose",
        }

    @cached_property
    def missed(self) -> list[int]:
        """Solutions missed at each pose."""
        return [missed(exact, found) for exact, found in zip(self.exact, self.lists, strict=True)]

    @cached_property
    def equal(self) -> int:
        """Poses where both lists are the same set."""
        extra = [
            surplus(e, f, T) for e, f, T in zip(self.exact, self.lists, self.poses, strict=True)
        ]
        return sum(m == 0 and s == 0 for m, s in zip(self.missed, extra, strict=True))

    @cached_property
    def solutions(self) -> int:
        return sum(len(found) for found in self.lists)


def compare(
    arm: symkin.Mechanism, poses: list[np.ndarray], starts: int | None, seed: int
) -> Comparison:
    """Continuation (`starts` None) or batched multistart at each pose."""
    lists = [
        continued(arm, T) if starts is None else sampled(arm, T, "batched", starts, seed)
        for T in poses
    ]
    return Comparison([closed_form(T) for T in poses], lists, poses)
