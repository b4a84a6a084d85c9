"""What CasADi's C and symkin's C answer to the same inputs: good goals, and inputs that have no
answer.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from bench_cases import cases_of, vectors_of
from goals import MIDDLE, goals_about
from plain_casadi import PlainCasadi
from symkin.codegen.folder import write_folder
from symkin.codegen.rod_platform import RodPlatform
from symkin.position.solution import pose_of
from symkin.spatial.pose import Pose

STATUSES = ("OK", "MAX_ITERATIONS", "SINGULAR", "NONFINITE", "OUT_OF_RANGE", "WRONG_BRANCH")
CLOSED, SAME = 1e-8, 1e-6
"""Parts of the size: largest row of an answer that closes the loops; difference of answers that are
the same one.
"""
FLAGS = ["-O2", "-std=c99", "-fno-math-errno", "-ffp-contract=off", "-shared", "-fPIC"]


@dataclass(frozen=True)
class Answer:
    """What one call came to. `code` is CasADi's return value or symkin's status; `values` the
    platform's position and rotation matrix times the size, or the arm's joint values; `row` the
    largest row over the size, NaN where it is not finite.
    """

    code: int
    values: np.ndarray
    row: float

    @property
    def closed(self) -> bool:
        return bool(self.row <= CLOSED)


def _numbers(values: np.ndarray) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * len(values))(*values)


@dataclass(frozen=True, eq=False)
class Both:
    """The two solvers of one mechanism, compiled for this machine."""

    plain: PlainCasadi

    @property
    def serial(self) -> bool:
        return self.plain.mechanism.serial

    @cached_property
    def _libraries(self) -> tuple[ctypes.CDLL, ctypes.CDLL]:
        folder, name = Path(tempfile.mkdtemp()), self.plain.name
        write_folder(self.plain.mechanism, folder, self.plain.program.options)
        self.plain.generate(folder)
        for source in (name, self.plain.source):
            subprocess.run(
                ["gcc", *FLAGS, f"{source}.c", "-o", f"{source}.so", "-lm"], cwd=folder, check=True
            )
        return ctypes.CDLL(str(folder / f"{name}.so")), ctypes.CDLL(
            str(folder / f"{self.plain.source}.so")
        )

    def symkin(self, start: np.ndarray, known: np.ndarray) -> Answer:
        """NAME_direct from a pose, or NAME_inverse from joint values; the answer's rows are those
        that CasADi is asked for.
        """
        library, name, info = self._libraries[0], self.plain.name, (ctypes.c_ubyte * 64)()
        if self.serial:
            joints = _numbers(np.zeros(len(start)))
            code = getattr(library, f"{name}_inverse")(
                None, _numbers(known), _numbers(start), joints, info
            )
            return Answer(code, np.array(joints[:]), self._row(np.array(joints[:]), known))
        pose = _numbers(np.zeros(7))
        code = getattr(library, f"{name}_direct")(
            None, _numbers(known), _numbers(start), pose, info
        )
        found = np.array(pose[:])
        return Answer(code, self._of_pose(found), 0.0 if code == 0 else np.nan)

    def casadi(self, z0: np.ndarray, known: np.ndarray) -> Answer:
        """NAME_newton from unknowns."""
        function, z = self.plain.newton, _numbers(np.zeros(len(z0)))
        pointers = ctypes.POINTER(ctypes.c_double)
        given, taken = [_numbers(z0), _numbers(known)], [z]
        arg, res = (pointers * function.sz_arg())(), (pointers * function.sz_res())()
        for array, values in ((arg, given), (res, taken)):
            for k, v in enumerate(values):
                array[k] = ctypes.cast(v, pointers)
        work, integers = (
            _numbers(np.zeros(function.sz_w() + 1)),
            (ctypes.c_longlong * (function.sz_iw() + 1))(),
        )
        code = getattr(self._libraries[1], function.name())(arg, res, integers, work, 0)
        found = np.array(z[:])
        row = self._row(found, known)
        if self.serial:
            return Answer(code, found, row)
        return Answer(
            code, self._of_unknowns(found, known) if np.isfinite(row) else np.full(12, np.nan), row
        )

    def _row(self, z: np.ndarray, known: np.ndarray) -> float:
        largest = (
            float(np.abs(np.array(self.plain.rows(z, known))).max())
            / self.plain.problem.closure.characteristic_length
        )
        return largest if np.isfinite(largest) else np.nan

    def _of_pose(self, pose: np.ndarray) -> np.ndarray:
        return self._flat(Pose(pose[:3], pose[3:])) if np.any(pose[3:]) else np.zeros(12)

    def _of_unknowns(self, z: np.ndarray, known: np.ndarray) -> np.ndarray:
        problem = self.plain.problem
        return self._flat(pose_of(problem.closure, problem.join_values(z, known)))

    def _flat(self, pose: Pose) -> np.ndarray:
        return np.concatenate(
            [
                pose.position,
                self.plain.problem.closure.characteristic_length * pose.rotation.ravel(),
            ]
        )

    def same(self, one: Answer, other: Answer) -> bool:
        """Angles of arms are compared as they are: a turn more is another command."""
        scale = 1.0 if self.serial else self.plain.problem.closure.characteristic_length
        gap = np.abs(one.values - other.values)
        if self.serial:
            sliding = np.array([not c.is_angular for c in self.plain.mechanism.actuated])
            gap[sliding] /= self.plain.problem.closure.characteristic_length
        return bool(gap.max() <= SAME * scale)

    # --- starts and goals -------------------------------------------------------------------------

    @cached_property
    def start(self) -> np.ndarray:
        """Home of a platform, the first guess of an arm's own vectors."""
        cases = cases_of(self.plain.program.kind)
        return cases["guesses" if self.serial else "cold"][0]

    def unknowns(self, start: np.ndarray) -> np.ndarray:
        return start if self.serial else self.plain.unknowns_at(start)

    def goals(self, count: int, seed: int) -> np.ndarray:
        """As `branches` asks for; of an arm the poses of joint values about the start."""
        kind, rng = self.plain.program.kind, np.random.default_rng(seed)
        if not self.serial:
            return goals_about(kind, count, MIDDLE, rng)
        mechanism = self.plain.mechanism
        spread = [
            1.0 if c.is_angular else MIDDLE.part * mechanism.characteristic_length
            for c in mechanism.actuated
        ]
        joints = self.start + np.array(spread) * rng.uniform(-1, 1, (count, len(spread)))
        return np.array([kind.forward_at(q) for q in joints])  # type: ignore[union-attr]

    def without_answer(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """(start, known values) of inputs that have no answer, or a start from which Newton's
        method has no step.
        """
        cases, start = cases_of(self.plain.program.kind), self.start
        known = cases["poses" if self.serial else "joints"][0]
        far, bad = known.copy(), known.copy()
        if self.serial:
            far[:3] *= 10.0
        elif isinstance(self.plain.program.kind, RodPlatform):
            far[0] += 5.0 * self.plain.problem.closure.characteristic_length
        else:
            far[[not c.is_angular for c in self.plain.mechanism.actuated]] *= 1e-3
        bad[0] = np.nan
        singular = vectors_of(self.plain.program.kind).singular
        return {
            "out of reach": (start, far),
            "NaN": (start, bad),
            **({"singular start": (singular[0][: len(start)], known)} if len(singular) else {}),
        }


@dataclass(frozen=True)
class Tally:
    """Goals; OK of symkin; CasADi's zeros; of these no solution, symkin's solution, another one
    although symkin is OK, one where symkin refuses.
    """

    goals: int
    ok: int
    zeros: int
    unsolved: int
    same: int
    other: int
    refused: int


def tally(both: Both, count: int, seed: int) -> Tally:
    """Random goals about the start, asked of both."""
    z0 = both.unknowns(both.start)
    pairs = [
        (both.symkin(both.start, goal), both.casadi(z0, goal)) for goal in both.goals(count, seed)
    ]

    def number(test: Callable[[Answer, Answer], bool]) -> int:
        return sum(test(own, plain) for own, plain in pairs)

    return Tally(
        count,
        number(lambda own, _: own.code == 0),
        number(lambda _, plain: plain.code == 0),
        number(lambda _, plain: not plain.closed),
        number(lambda own, plain: plain.closed and own.code == 0 and both.same(own, plain)),
        number(lambda own, plain: plain.closed and own.code == 0 and not both.same(own, plain)),
        number(lambda own, plain: plain.closed and own.code != 0),
    )
