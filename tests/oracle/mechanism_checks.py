"""Every verb on one mechanism file through the command line, each answer judged by the plain
closure.

A finding has a kind: "traceback" (anything on stderr but the one line of a refusal and those of
progress, a status that is not of the contract, output that is no JSON), "lost mode" (the plain
search finds a regular mode that a proved list, or one of probability one, has not), "wrong answer"
(what does not close, is listed twice, ends on no mode, or differs from differences of the closure).
"""

from __future__ import annotations

import inspect
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.random_files import to_toml
from oracle.plain_closure import PlainMechanism
from oracle.plain_search import (
    Found,
    closed_configurations,
    features,
    found_at,
    freedom_at,
    named_places,
    random_configurations,
    solutions,
    solve,
)

STARTS = 160
"""Random starts of the plain search for one problem."""
CLOSED = 1e-7
"""Largest closure error of an answer, over the size: symkin's own bound is 1e-9 in its rows."""
SAME = 1e-5
"""Largest difference of features of equal modes."""
SHARES = {
    "random": 0.4,
    "multistart": 0.3,
    "solve": 0.7,
    "ipopt": 0.1,
    "latex": 0.15,
    "singularities": 0.6,
    "jacobians": 0.6,
    "language": 0.15,
    "track": 0.5,
    "firmware": 0.3,
}
"""In what share of mechanisms a verb or an option is tried, so that one mechanism takes about three
seconds.
"""
COMPLETE = ("proved", "probability one")


@dataclass(frozen=True)
class Finding:
    kind: str
    text: str
    command: str


@dataclass(frozen=True)
class Run:
    """One command's end."""

    command: str
    status: int
    out: str
    error: str

    def json(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.out)
        return found


_PROGRESS = re.compile(r"symkin: .+ \(\d+ s\)")
"""A line of a command that takes long."""


@dataclass
class Checks:
    """One mechanism: its file, its plain closure, and what was found."""

    file: Path
    data: dict[str, Any]
    seed: tuple[int, ...]
    compile_c: bool = False
    sweep: bool = False
    stage: Callable[[str], None] = lambda _: None
    findings: list[Finding] = field(default_factory=list)
    statuses: dict[str, int] = field(default_factory=dict)
    times: dict[str, float] = field(default_factory=dict)
    refusals: list[str] = field(default_factory=list)
    compared: int = 0
    sampled: int = 0

    def __post_init__(self) -> None:
        self.file.write_text(to_toml(self.data))
        self.plain = PlainMechanism(self.data)
        self.rng = np.random.default_rng(self.seed)
        self.actuated, self.pose = self.plain.places("actuated"), self.plain.places("pose")
        self.closed = np.zeros((0, self.plain.reference.size))

    # --- running ----------------------------------------------------------------------------------

    def run(self, *arguments: str) -> Run | None:
        """A command of the contract; None where it was refused, or is a finding."""
        full = [arguments[0], str(self.file), *arguments[1:]]
        command = "symkin " + " ".join(full)
        self.stage(command)
        begin = time.process_time()
        run = command_line(full, command)
        self.times[arguments[0]] = self.times.get(arguments[0], 0.0) + time.process_time() - begin
        key = f"{arguments[0]} {run.status}"
        self.statuses[key] = self.statuses.get(key, 0) + 1
        lines = [
            line
            for line in run.error.strip().splitlines()
            if not _PROGRESS.fullmatch(line) and not line.startswith("symkin: note: ")
        ]
        if run.status == 2:
            if len(lines) != 1 or not lines[0].startswith("symkin: ") or run.out:
                self.found(
                    "traceback",
                    f"status 2 with {len(lines)} lines on stderr: {_short(run.error)}",
                    run,
                )
            elif re.search(r"Error\b|Exception|object at 0x|Traceback|NoneType", lines[0]):
                self.found("traceback", f"a message that is none: {_short(lines[0])}", run)
            else:
                self.refusals.append(
                    f"{arguments[0]}: "
                    + re.sub(r"-?\d[\d.e+-]*", "#", lines[0].replace(str(self.file), "F"))
                )
            return None
        told = run.status == 3 and len(lines) == 1 and lines[0].startswith("symkin: ")
        if lines and not told:
            self.found("traceback", f"stderr of status {run.status}: {_short(run.error)}", run)
            return None
        if run.status not in (0, 3):
            self.found("traceback", f"status {run.status}", run)
            return None
        if "--json" in arguments:
            try:
                run.json()
            except ValueError as error:
                self.found("traceback", f"no JSON: {error}", run)
                return None
        return run

    def found(self, kind: str, text: str, run: Run) -> None:
        self.findings.append(Finding(kind, text, run.command))

    # --- all verbs --------------------------------------------------------------------------------

    def all(self) -> None:
        m = self.plain
        closed = closed_configurations(m, 6, float(self.rng.choice([0.05, 0.3, 1.0])), self.rng)
        self.closed = closed
        self.show(closed)
        here = closed[0] if len(closed) else m.reference
        anywhere = random_configurations(m, m.reference[None], range(len(m.numbers)), self.rng)[0]
        for kind in ("joints", "pose") if self.actuated else ("pose",):
            self.position(kind, here, feasible=len(closed) > 0)
            if self.sometimes("random"):
                self.position(kind, anywhere, feasible=False)
        for verb in ("singularities", "jacobians", "track"):
            if len(closed) and self.sometimes(verb) and (self.actuated or verb != "track"):
                getattr(self, verb)(here)
        if self.sometimes("firmware") or self.compile_c:
            self.firmware()
        if self.sweep and self.actuated:
            self.swept(here)

    def sometimes(self, what: str) -> bool:
        return bool(self.rng.uniform() < SHARES[what])

    def show(self, closed: np.ndarray) -> None:
        run = self.run("show")
        if self.sometimes("latex"):
            self.run("show", "--latex")
        if run is None or not len(closed) or "at the open reference" in run.out:
            return
        stated = re.search(r"mobility = \d+ - \d+ = (-?\d+)", run.out)
        near = closed_configurations(self.plain, 6, 0.05, np.random.default_rng(0))
        mobilities = [freedom_at(self.plain, x) for x in (*closed, *near)]
        if None in mobilities:
            return
        # another assembly may be of another mobility; the statement is about that of the reference
        if stated and int(stated[1]) not in mobilities and "H" not in _types(self.data):
            self.found(
                "wrong answer", f"mobility {stated[1]}, by the plain closure {set(mobilities)}", run
            )

    def position(self, kind: str, x: np.ndarray, feasible: bool) -> None:
        """Modes by both methods and a solution, at the joints or the pose of a configuration."""
        m = self.plain
        given = self.joints_text(x) if kind == "joints" else self.pose_text(x)
        free = [
            i
            for i in range(len(m.numbers))
            if i not in (self.actuated if kind == "joints" else self.pose)
        ]
        brute = solutions(m, x, free, STARTS, self.rng)
        if feasible:
            brute.append(found_at(m, x, free))
        run = self.run("modes", f"--{kind}={given}", "--json")
        lists = [] if run is None else [self.judge_modes(run, x, kind, brute, complete=None)]
        formula = m.serial and kind == "joints"
        if self.sometimes("multistart"):
            starts = [] if formula else ["--starts", "100"]
            again = self.run(
                "modes", f"--{kind}={given}", "--json", "--method", "multistart", *starts
            )
            if again is not None:
                some = self.judge_modes(again, x, kind, brute, complete=False)
                if lists and lists[0] is not None and some is not None:
                    self.judge_contained(run, lists[0], some)
        if not self.sometimes("solve"):
            return
        solver = ["--solver", "ipopt"] if self.sometimes("ipopt") and not formula else []
        solved = self.run("solve", f"--{kind}={given}", "--json", *solver)
        if solved is not None:
            solution = solved.json()["solution"]
            if (solved.status == 0) != (solution is not None):
                self.found(
                    "wrong answer",
                    f"status {solved.status} with solution {solution is not None}",
                    solved,
                )
            if solution is not None:
                self.judge_closed(solved, solution, x, kind)

    # --- judges -----------------------------------------------------------------------------------

    def judge_modes(
        self, run: Run, x: np.ndarray, kind: str, brute: list[Found], *, complete: bool | None
    ) -> np.ndarray | None:
        """Every mode closes, none twice; a complete list holds every regular root of the plain
        search. Returns the modes.
        """
        m, result = self.plain, run.json()
        if (run.status == 0) != bool(result["modes"] or _positive(result)):
            self.found(
                "wrong answer", f"status {run.status} with {len(result['modes'])} modes", run
            )
        closed = [self.judge_closed(run, mode, x, kind) for mode in result["modes"]]
        if any(c is None for c in closed):
            return None
        listed = self.listed_places(result["modes"])
        if listed is None:
            listed = named_places(m)
        f = features(m, np.array(closed).reshape(len(closed), m.reference.size), listed)
        apart = (
            np.max(np.abs(f[:, None] - f[None]), axis=2) + np.eye(len(f))
            if len(f)
            else np.ones((0, 0))
        )
        if (apart < 1e-9).any():
            self.found("wrong answer", "a mode is listed twice", run)
        claims = result["completeness"] in COMPLETE if complete is None else complete
        if _positive(result) and not result["modes"] and any(b.regular for b in brute):
            self.found(
                "lost mode",
                "a set that is not isolated is said to be all, the plain search finds a regular "
                "mode",
                run,
            )
        regular = [b for b in brute if b.regular]
        self.compared += claims
        self.sampled += not claims
        if claims and regular:
            theirs = features(m, np.array([b.x for b in regular]), listed)
            missing = [
                t for t in theirs if not len(f) or np.min(np.max(np.abs(f - t), axis=1)) > SAME
            ]
            if missing:
                self.found(
                    "lost mode",
                    f"{len(missing)} regular modes are not among the {len(f)} of a list said to "
                    f"be {result['completeness']}",
                    run,
                )
        return f if claims else None

    def judge_contained(self, run: Run | None, complete: np.ndarray, some: np.ndarray) -> None:
        lost = [
            t
            for t in some
            if not len(complete) or np.min(np.max(np.abs(complete - t), axis=1)) > SAME
        ]
        if lost and run is not None:
            self.found(
                "lost mode", f"{len(lost)} modes of multistart are not in the complete list", run
            )

    def judge_closed(
        self, run: Run, mode: dict[str, Any], x: np.ndarray, kind: str
    ) -> np.ndarray | None:
        """The whole configuration of a printed one: given values kept, cut joints fitted; a finding
        where it does not close.
        """
        m = self.plain
        y, cut = self.configuration(mode)
        if kind == "joints":
            off = max((self._apart(i, y, x) for i in self.actuated), default=0.0)
            if off > 1e-9:
                self.found(
                    "wrong answer",
                    f"a mode has other joint values than those given, by {off:.1g}",
                    run,
                )
        else:
            off = float(np.max(np.abs(features(m, y[None], [])[0] - features(m, x[None], [])[0])))
            if off > CLOSED + self.told_projection(run):
                self.found(
                    "wrong answer", f"a mode has another pose than the one given, by {off:.1g}", run
                )
        fitted = y[None]
        if cut:
            begin = np.concatenate(
                [
                    y[None],
                    random_configurations(m, np.tile(y, (12, 1)), cut, np.random.default_rng(0)),
                ]
            )
            steps = 40 + int(2 * np.max(np.abs(y)) / m.size)  # a step is no longer than the size
            fitted = solve(m, begin, m.tangent(cut), min(steps, 4000))
        left = m.residual(fitted)
        best = int(np.argmin(left))
        if not left[best] < CLOSED:
            self.found(
                "wrong answer", f"a mode does not close, by {left[best]:.1g} of the size", run
            )
            return None
        return np.asarray(fitted[best])

    def told_projection(self, run: Run) -> float:
        """How far, over the size, the answer says that the given pose was projected; twice that in
        features.
        """
        told = re.search(r"the pose was projected onto [^,\"]*, by ([\d.e+-]+)", run.out)
        return 2.0 * float(told[1]) / self.plain.size if told else 0.0

    def _apart(self, i: int, y: np.ndarray, x: np.ndarray) -> float:
        kind, place = self.plain.numbers[i].kind, self.plain.slices[i]
        if self._is_rod(i):
            return abs(abs(y[place][0]) - abs(x[place][0])) / self.plain.size
        gap = float(y[place][0] - x[place][0])
        if kind == "angle":
            return abs(np.angle(np.exp(1j * gap)))
        return abs(gap) / (self.plain.size if kind == "length" else 1.0)

    def configuration(self, mode: dict[str, Any]) -> tuple[np.ndarray, list[int]]:
        """Values of a printed configuration, and the places of coordinates that it does not
        print.
        """
        m = self.plain
        pose = mode["pose"]
        x = m.with_pose(
            m.reference[None], np.array(pose["position"]), np.array(pose["quaternion"])
        )[0]
        cut = []
        for i, number in enumerate(m.numbers):
            if number.role == "pose":
                continue
            if number.name not in mode["joints"]:
                cut.append(i)
            else:
                value = np.array(mode["joints"][number.name], dtype=float).ravel()
                x[m.slices[i]] = value * (m.unit if number.kind in ("angle", "turns") else 1.0)
        return x, cut

    def listed_places(self, modes: list[dict[str, Any]]) -> list[int] | None:
        if not modes:
            return None
        # idle coordinates make no mode
        return [
            i for i in named_places(self.plain) if self.plain.numbers[i].name in modes[0]["joints"]
        ]

    # --- other verbs ------------------------------------------------------------------------------

    def singularities(self, x: np.ndarray) -> None:
        kind, given = (
            ("joints", self.joints_text(x)) if self.actuated else ("pose", self.pose_text(x))
        )
        run = self.run("singularities", f"--{kind}={given}", "--json")
        if run is None or run.status != 0:
            return
        result = run.json()
        if result.get("configuration") is None:
            return
        y = self.judge_closed(run, result["configuration"], x, kind)
        if y is None:
            return
        m = self.plain
        columns = m.tangent([i for i in range(len(m.numbers)) if i not in self.actuated])
        j = m.closure(y[None])[1][0][:, columns]
        _, s, right = np.linalg.svd(j, full_matrices=True)
        null = right[int(np.sum(s > 1e-9 * max(s[0], 1e-300))) :]
        pose = np.isin(columns, m.tangent(self.pose))
        moves = len(null) > 0 and float(np.max(np.abs(null[:, pose]), initial=0.0)) > 1e-4
        held = "type 2" in result["kinds"] or "type 2" in result["everywhere"]
        says = held or "constraint" in result["kinds"]
        if moves and not says:
            self.found(
                "wrong answer",
                f"the platform moves with joints held, singularities says {result['kinds']}",
                run,
            )
        if held and not len(null) and len(s) and s[-1] > 1e-4 * s[0]:
            self.found(
                "wrong answer",
                f"{result['kinds']}, everywhere {result['everywhere']}, where joints determine all",
                run,
            )
        if "constraint" in result["kinds"] and self.has_generic_rank(y):
            self.found(
                "wrong answer",
                f"{result['kinds']} where the rows are as independent as elsewhere",
                run,
            )

    def has_generic_rank(self, x: np.ndarray) -> bool:
        """Whether the rows, every coordinate free, are far from losing the rank that they have at
        some closed configuration.
        """
        shares = [
            np.linalg.svd(self.plain.closure(c[None])[1][0], compute_uv=False)
            for c in (*self.closed, x)
        ]
        shares = [s / max(float(s[0]), 1e-300) for s in shares if len(s)]
        rank = max((int(np.sum(s > 1e-8)) for s in shares), default=0)
        return rank > 0 and bool(shares[-1][rank - 1] > 1e-4)

    def jacobians(self, x: np.ndarray) -> None:
        """The NumPy file of one kind, at a closed configuration, beside differences of the
        closure.
        """
        kind = str(self.rng.choice(["direct", "inverse", "analytic", "passive"]))
        run = self.run("jacobian", "--kind", kind, "--format", "numpy")
        if self.sometimes("language"):
            self.run(
                "jacobian",
                "--kind",
                kind,
                "--format",
                str(self.rng.choice(["c", "casadi", "sympy", "latex"])),
            )
        if run is None:
            return
        m = self.plain
        rates = self.rates(x)
        if rates is None:
            return
        q, twist = rates
        names: dict[str, Any] = {}
        exec(compile(run.out, "jacobian", "exec"), names)
        values = self.inputs(list(inspect.signature(names["jacobian"]).parameters), x)
        if values is None:
            return
        with np.errstate(all="ignore"):
            matrix = names["jacobian"](*values)
        scale = np.array([1 / m.size] * 3 + [1.0] * 3)
        if kind == "direct":
            off = np.max(np.abs((matrix @ q - twist) * scale[:, None]), initial=0.0)
        elif kind == "inverse":
            units = np.array(
                [m.size if m.numbers[i].kind == "length" else 1.0 for i in self.actuated]
            )
            off = np.max(np.abs((matrix @ twist - q) / units[:, None]), initial=0.0)
        else:
            return
        if not off < 1e-6:
            self.found(
                "wrong answer",
                f"the {kind} Jacobian differs from differences of the closure by {off:.1g}",
                run,
            )

    def rates(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Feasible rates of actuated joints, and twists, as columns, by differences; None where
        joints or pose do not determine each other clearly.
        """
        m = self.plain
        h = 1e-6 * m.size
        steps = h * np.eye(m.freedom)
        base = np.tile(x, (m.freedom, 1))
        j = ((m.closure(m.move(base, steps))[0] - m.closure(m.move(base, -steps))[0]) / (2 * h)).T
        _, s, right = np.linalg.svd(j, full_matrices=True)
        if not len(s) or np.any((s > 1e-8 * s[0]) & (s < 1e-3 * s[0])):
            return None
        free = right[int(np.sum(s > 1e-6 * s[0])) :].T
        joints, pose = m.tangent(self.actuated), m.tangent(self.pose)
        twist = self._twist(free[pose])
        scaled = twist * np.array([1.0] * 3 + [m.size] * 3)[:, None]
        named = free[m.tangent(named_places(m))]
        rank = np.linalg.matrix_rank(named, tol=1e-6)
        for part in (free[joints], scaled):
            values = np.linalg.svd(part, compute_uv=False) if part.size else np.zeros(1)
            if np.sum(values > 1e-6) != rank or np.sum(values > 1e-2) != rank:
                return None
        units = np.array([1.0 if m.numbers[i].kind == "length" else m.size for i in self.actuated])
        return free[joints] / units[:, None], twist

    def _twist(self, pose: np.ndarray) -> np.ndarray:
        m = self.plain
        moved, turned = m._pose_derivatives(np.eye(3)[None])
        columns = m.tangent(self.pose)
        return np.concatenate([moved[0][:, columns] @ pose, turned[0][:, columns] @ pose])

    def inputs(self, names: list[str], x: np.ndarray) -> list[float] | None:
        """Values of a Jacobian's inputs by their names."""
        m, known = self.plain, {}
        for i, number in enumerate(m.numbers):
            values = x[m.slices[i]]
            stem = re.sub(r"[^0-9A-Za-z]+", "_", number.name.removeprefix("pose."))
            if number.kind == "quaternion":
                parts = (
                    ["qw", "qx", "qy", "qz"]
                    if number.role == "pose"
                    else [f"{stem}_{c}" for c in "wxyz"]
                )
                known |= dict(zip(parts, values.tolist(), strict=True))
            else:
                known[stem] = float(values[0])
        return [known[name] for name in names] if all(name in known for name in names) else None

    def track(self, x: np.ndarray) -> None:
        """From the configuration's joints to those of a closed one nearby; the end is one of the
        modes there.
        """
        m = self.plain
        step = 0.1 * m.size * self.rng.normal(size=(1, m.freedom))
        end = solve(m, m.move(x[None], step), np.arange(m.freedom), 40)[0]
        if not m.residual(end[None])[0] < 1e-12:
            return
        run = self.run(
            "track",
            f"--from={self.joints_text(x)}",
            f"--to={self.joints_text(end)}",
            *([] if m.serial else [f"--start={self.pose_text(x)}"]),
            "--samples",
            "5",
            "--json",
        )
        if run is None:
            return
        result = run.json()
        if (run.status == 0) != result["reached"]:
            self.found("wrong answer", f"status {run.status}, reached {result['reached']}", run)
        if result["samples"]:
            self.judge_closed(run, result["samples"][0], x, "joints")
        if result["reached"]:
            self.judge_closed(run, result["samples"][-1], end, "joints")

    def firmware(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            run = self.run("firmware", "-o", f"{folder}/out")
            if run is None or run.status != 0 or not self.compile_c:
                return
            flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O0"]
            for source in Path(folder, "out").glob("*.c"):
                built = subprocess.run(
                    ["cc", *flags, "-c", str(source), "-o", f"{folder}/x.o"],
                    capture_output=True,
                    text=True,
                    check=False,
                )
                if built.returncode:
                    self.found(
                        "wrong answer",
                        f"{source.name} does not compile: {_short(built.stderr)}",
                        run,
                    )

    def swept(self, x: np.ndarray) -> None:
        i = self.actuated[int(self.rng.integers(len(self.actuated)))]
        number, value = self.plain.numbers[i], float(x[self.plain.slices[i]][0])
        width = 0.1 * self.plain.size if number.kind == "length" else 0.2
        low, high = (self._out(i, value + d) for d in (-width, width))
        with tempfile.TemporaryDirectory() as folder:
            low = max(low, 0.0) if number.name.startswith("leg") else low
            grid = f"--grid={number.name}={low!r}:{high!r}:3"
            starts = [] if self.plain.serial else ["--starts", "100"]
            at = [] if len(self.actuated) == 1 else [f"--at={self.joints_text(x)}"]
            self.run("sweep", grid, *at, "-o", f"{folder}/map", "--workers", "0", *starts)

    # --- texts ------------------------------------------------------------------------------------

    def _out(self, i: int, value: float) -> float:
        return (
            value / self.plain.unit if self.plain.numbers[i].kind in ("angle", "turns") else value
        )

    def joints_text(self, x: np.ndarray) -> str:
        values = [self._out(i, float(x[self.plain.slices[i]][0])) for i in self.actuated]
        return ",".join(
            repr(abs(v) if self._is_rod(i) else v)
            for i, v in zip(self.actuated, values, strict=True)
        )

    def _is_rod(self, i: int) -> bool:
        """Whether a coordinate is a rod's length, whose sign the plain closure does not tell."""
        return self.plain.numbers[i].name.startswith("leg")

    def pose_text(self, x: np.ndarray) -> str:
        from oracle.plain_closure import matrix_quaternion

        position, rotation = self.plain.pose(x[None])
        return ",".join(repr(float(v)) for v in (*position[0], *matrix_quaternion(rotation[0])))


def _positive(result: dict[str, Any]) -> bool:
    return any(
        "positive-dimensional" in note or "not isolated" in note or "set of solutions" in note
        for note in result["notes"]
    )


def _types(data: dict[str, Any]) -> str:
    joints = [j for limb in data.get("limb", []) for j in limb.get("joint", [])]
    return "".join(
        j["type"] for j in [*joints, *data.get("joint", []), *data.get("dh", {}).get("rows", [])]
    )


def _short(text: str) -> str:
    lines = text.strip().splitlines()
    return " | ".join(lines[-6:])[:600]


# --- a command in this process --------------------------------------------------------------------


def command_line(arguments: list[str], command: str) -> Run:
    """Run `symkin` in this process, with both streams captured as the system sees them."""
    from helpers.inside import main

    with _captured() as streams:
        try:
            main(arguments)
            status = 0
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        except BaseException:
            import traceback

            traceback.print_exc()
            status = 1
    return Run(command, status, streams[0], streams[1])


@contextmanager
def _captured() -> Any:
    """Streams 1 and 2 go to files; their texts are in the list that is given, afterwards."""
    texts = ["", ""]
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [os.dup(1), os.dup(2)]
    with tempfile.TemporaryFile() as first, tempfile.TemporaryFile() as second:
        for number, file in enumerate((first, second), start=1):
            os.dup2(file.fileno(), number)
        try:
            yield texts
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, old in enumerate(saved, start=1):
                os.dup2(old, number)
                os.close(old)
            for k, file in enumerate((first, second)):
                file.seek(0)
                texts[k] = file.read().decode(errors="replace")
