"""The pose that a machine reaches when its joints move in straight lines: many lines at once, in many small steps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from symkin.numeric.system import System
from symkin.position.problem import Problem

_LANES = 256
"""Most lines that one mapped CasADi call evaluates."""
_LONGEST, _SHORTEST = 1.0 / 400, 2.0**-13 / 400
"""Longest and shortest steps as parts of a line."""


@dataclass(frozen=True, eq=False)
class Walker:
    """Fine continuation of a direct problem, geometry nominal. Where rows are more than unknowns, steps are least squares over all, and
    a singularity is told by steps that no longer converge alone."""

    problem: Problem

    @property
    def system(self) -> System:
        return self.problem.system

    @cached_property
    def _mapped(self) -> dict[int, ca.Function]:
        """Rows and matrices of 4, 32 or 256 points a call."""
        system = self.system
        outputs = [ca.densify(system.rows), ca.densify(system.jacobian)]
        single = ca.Function("linearised", [system.unknown, system.known], outputs, {"cse": True})
        return {width: single.map(width) for width in (4, 32, _LANES)}

    def linearised(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (count, m) and dF/dd (count, m, n) at z (count, width), each with its own known values."""
        count, n, m = len(z), self.system.freedom, int(self.system.rows.shape[0])
        rows, matrices = np.empty((count, m)), np.empty((count, m, n))
        for begin in range(0, count, _LANES):
            part = slice(begin, min(begin + _LANES, count))
            used = part.stop - begin
            width = min(w for w in self._mapped if w >= used)
            pad = [np.concatenate([v[part], np.repeat(v[part][-1:], width - used, 0)]).T for v in (z, known)]
            f, j = (np.asarray(out) for out in self._mapped[width](*pad))
            rows[part] = f.T[:used]
            matrices[part] = j.reshape(m, width, n).transpose(1, 0, 2)[:used]
        return rows, matrices

    def newton(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """One step from each point: the points after it, signs of det before it, lengths of the steps."""
        rows, matrices = self.linearised(z, known)
        if matrices.shape[1] > matrices.shape[2]:
            sign, steps = np.ones(len(z)), -(np.linalg.pinv(matrices) @ rows[..., None])[..., 0]
        else:
            sign, _ = np.linalg.slogdet(matrices)
            matrices[sign == 0] = np.eye(matrices.shape[1])
            steps = np.linalg.solve(matrices, -rows[..., None])[..., 0]
        lengths = np.linalg.norm(steps, axis=1)
        steps *= np.minimum(1.0, 0.1 * self.system.characteristic_length / np.maximum(lengths, 1e-300))[:, None]
        return self.system.move(z, steps), sign, lengths

    def reached(self, start: np.ndarray, begin: np.ndarray, goals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns at the ends of the lines from known values `begin` (unknowns `start`; one for each line, or one for all) to
        `goals`, and the shortest step that each line needed, as a part of it: 0 where it met a singularity. A step is accepted
        where det keeps its sign and a second Newton step is below a tenth of the first; it is halved elsewhere, and doubled again
        up to 1/400."""
        size, count = self.system.characteristic_length, len(goals)
        begin = np.broadcast_to(begin, goals.shape)
        z, done, step = np.array(np.broadcast_to(start, (count, start.shape[-1]))), np.zeros(count), np.full(count, _LONGEST)
        sign0 = self.newton(z, begin)[1]
        shortest = step.copy()
        going = np.arange(count)
        while len(going):
            part = np.minimum(1.0, done[going] + step[going])
            known = begin[going] + part[:, None] * (goals[going] - begin[going])
            once, sign, first = self.newton(z[going], known)
            twice, after, second = self.newton(once, known)
            fine = (sign == sign0[going]) & (after == sign0[going]) & (second < 0.1 * first + 1e-12 * size)
            z[going[fine]], done[going[fine]] = twice[fine], part[fine]
            step[going] = np.where(fine, np.minimum(_LONGEST, 2 * step[going]), 0.5 * step[going])
            shortest = np.minimum(shortest, step)
            going = going[(done[going] < 1.0) & (step[going] > _SHORTEST)]
        for _ in range(3):
            z, sign, length = self.newton(z, begin + done[:, None] * (goals - begin))
        whole = (done == 1.0) & (sign == sign0) & (length < 1e-9 * size)
        return z, np.where(whole, shortest, 0.0)
