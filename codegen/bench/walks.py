"""Do controllers that call the generated C a thousand times a second get stuck, or lost? Smooth random walks and standing still.

    python codegen/bench/walks.py [NAME|FILE ...] [--given A,B --find C,D] [--paths 100] [--steps 400] [--seed 0] [--real float]

Without names: machines of all kinds (closes.py), maps both ways. Goals move on smooth random paths within limits. Each goal is asked for from
the last answer that was OK, then once more from its own answer: standing still must be OK. Beside it the same lines are walked finely
(walk.c) from the last configuration that was OK. Wrong is an OK on a line that is not regular, or that leads elsewhere; stuck is a
regular line, far from singularities, that is refused. Exit status 1 where anything is wrong, stuck, or does not stand still.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import tempfile
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from closes import Machine, asked, built, drawn, named
from continuation import Walker
from lines import REGULAR, Lines
from symkin.codegen.c_emitter import Real
from symkin.codegen.joint_map import JointMap
from symkin.codegen.options import Options
from symkin.codegen.program import build_program
from symkin.codegen.serial_arm import SerialArm
from symkin.errors import InputError
from symkin.formats.load import load
from symkin.position.problem import Problem

_WAVES = 3
_LONGEST = 0.02
"""Length of a step of a path, at most (rad, or of the size)."""
_OUT_OF_RANGE = 4
_REACH = 0.9
"""How far paths go from home (rad, or of the size), where no limits are nearer."""
_HARD = 50.0
"""Condition from which on a refusal beside a singularity is not held against the code: bounds are kept from it."""
_PLAIN = 0.25
"""Step of the fine walk, as a part of a line, which lines that nothing is beside take."""


@dataclass(frozen=True)
class State:
    """Where each path is: unknowns and known values of the last configuration that was OK, and the code's guess."""

    unknowns: np.ndarray
    known: np.ndarray
    guesses: np.ndarray


@dataclass
class Tally:
    steps: int = 0
    ok: int = 0
    wrong: int = 0
    stuck: int = 0
    moved: int = 0
    examples: list[str] | None = None

    @property
    def failures(self) -> int:
        return self.wrong + self.stuck + self.moved


@dataclass(frozen=True, eq=False)
class Direction:
    """One problem of one machine's code: a function of ask.c and the closure that it solves."""

    machine: Machine
    real: str
    library: ctypes.CDLL
    function: ctypes._CFuncPtr
    problem: Problem
    home: State
    places: np.ndarray | None

    @cached_property
    def walker(self) -> Walker:
        return Walker(self.problem, _PLAIN)

    @property
    def size(self) -> float:
        return self.machine.mechanism.characteristic_length

    def answers(self, goals: np.ndarray, guesses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Statuses and what is found."""
        found, status, _ = asked(self.function, self.real, [goals, guesses], [guesses.shape[1]], "iiosn")
        return status, found

    def stated(self, unknowns: np.ndarray, known: np.ndarray) -> np.ndarray:
        if self.places is not None:
            return unknowns[:, self.places]
        return self._lines.stated(unknowns, known)

    @cached_property
    def _lines(self) -> Lines:
        return Lines(self.machine.mechanism, Options(self.real, home=self.machine.home))  # type: ignore[arg-type]

    def gives_back(self, found: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Whether the code's limbs, on the reference's branches, reach a pose with these joint values: else one is past a dead centre."""
        if self.places is not None or self.machine.mechanism.serial:
            return np.ones(len(found), bool)
        number = len(self.machine.mechanism.actuated)
        joints, status = asked(self.library.back_all, self.real, [found], [number], "ios")
        units = np.array([1.0 if c.is_angular else self.size for c in self.problem.known_coordinates])
        away = joints - known
        away[:, units == 1.0] = np.angle(np.exp(1j * away[:, units == 1.0]))
        return np.asarray((status == 0) & (np.max(np.abs(away / units), axis=1) < 1e-3))

    def off(self, found: np.ndarray, reached: np.ndarray) -> np.ndarray:
        """Differences (n,), over the size or in rad; of maps by whole turns."""
        if self.places is None:
            return self._lines._distance(found, reached) / self.size
        units = np.array([1.0 if c.is_angular else self.size for c in self.problem.system.unknowns])[self.places]
        away = found - reached
        turns = units == 1.0
        away[:, turns] = np.angle(np.exp(1j * away[:, turns]))
        return np.asarray(np.max(np.abs(away / units), axis=1))


def directions(machine: Machine, real: str, folder: Path) -> list[Direction]:
    """The problems of a machine's code that take a guess."""
    library, _ = built(machine, real, folder)
    options = Options(real, home=machine.home, given=machine.given, find=machine.find)  # type: ignore[arg-type]
    kind = build_program(machine.mechanism, options).kind
    if not isinstance(kind, JointMap):
        lines = Lines(machine.mechanism, options)
        start = lines.home(1)
        return [
            Direction(
                machine, real, library, library.ask_all, lines.problem, State(start.unknowns, start.known, start.guesses), None
            )
        ]
    found = []
    for way, function, wanted in (
        (kind.direct, library.ask_all, machine.find),
        (kind.inverse, library.ask_inverse, machine.given),
    ):
        problem, reference = way.problem, kind.reference
        unknowns, known = (problem.select_values(reference, c) for c in (way.unknown, way.known))
        names = [c.name for c in way.unknown]
        places = np.array([way.problem.system.slices[names.index(n)].start for n in wanted])
        home = State(unknowns[None], known[None], unknowns[None][:, places])
        found.append(Direction(machine, real, library, function, problem, home, places))
    return found


def paths_of(direction: Direction, paths: int, steps: int, rng: np.random.Generator) -> np.ndarray:
    """Goals (steps, paths, known): sums of sines about home within limits; poses of an arm are those of such joints."""
    mechanism = direction.machine.mechanism
    arm = mechanism.serial
    coordinates = mechanism.actuated if arm else direction.problem.known_coordinates
    home = direction.home.unknowns[0] if arm else direction.home.known[0]
    time, goals = np.linspace(0.0, 1.0, steps)[:, None], []
    for k, c in enumerate(coordinates):
        unit = 1.0 if c.is_angular else direction.size
        reach = _REACH * unit * (1.0 if c.is_angular else 0.4)
        low, high = (
            (home[k] - reach, home[k] + reach)
            if c.limits is None
            else (max(c.limits[0], home[k] - reach), min(c.limits[1], home[k] + reach))
        )
        waves = sum(
            rng.uniform(-1, 1, paths) * np.sin(2 * np.pi * (w * time + rng.uniform(0, 1, paths))) for w in range(1, _WAVES + 1)
        )
        waves = (waves - waves[0]) / (2.0 * np.abs(waves).max() + 1e-30)
        goals.append(home[k] + np.where(waves > 0, (high - home[k]) * waves, (home[k] - low) * waves) * 0.98)
    found = np.stack(goals, axis=-1)
    if not arm:
        return found
    kind: SerialArm = direction._lines.kind  # type: ignore[assignment]
    return np.array([[kind.forward_at(q) for q in row] for row in found])


def walked(direction: Direction, paths: int, steps: int, rng: np.random.Generator) -> Tally:
    """Follow the paths."""
    tally, home = Tally(examples=[]), direction.home
    number = np.float32 if direction.real == "float" else np.float64
    goals = paths_of(direction, paths, steps, rng).astype(number).astype(float)
    at = State(*(np.repeat(part, paths, axis=0) for part in (home.unknowns, home.known, home.guesses)))
    epsilon = Real(direction.real).epsilon
    for goal in goals:
        status, found = direction.answers(goal, at.guesses)
        begin, end = at.known, goal
        if direction.places is None:
            begin, end = direction._lines._line(at.known, goal)
        ends = direction.walker.reached(at.unknowns, begin, end)
        ok, regular = status == 0, ends.shortest >= REGULAR
        reached = direction.stated(ends.unknowns, end)
        away = np.where(ok, direction.off(found, reached), 0.0)
        conditions = direction.problem.system.conditions(ends.unknowns, end)
        allowed = 2e-7 + 64 * epsilon * np.minimum(conditions, 1e6) + 2e-3 * (direction.real == "float")
        wrong = ok & ((ends.shortest <= 0.0) | (away > allowed))
        easy = regular & (conditions < _HARD)
        stuck = ~ok & (status != _OUT_OF_RANGE) & easy & (ends.shortest >= _PLAIN) & direction.gives_back(reached, end)
        tally.steps, tally.ok = tally.steps + paths, tally.ok + int(ok.sum())
        tally.wrong, tally.stuck = tally.wrong + int(wrong.sum()), tally.stuck + int(stuck.sum())
        again, _ = direction.answers(goal, np.where(ok[:, None], found, at.guesses))
        moved = ok & ~wrong & (again != 0) & regular
        tally.moved += int(moved.sum())
        for what, which in (("wrong", wrong), ("stuck", stuck), ("does not stand still", moved)):
            for k in np.flatnonzero(which)[:1]:
                if len(tally.examples) < 4:
                    tally.examples.append(
                        f"{what}: from {at.guesses[k].tolist()} ({begin[k].tolist()}) to {end[k].tolist()}: status {status[k]}, {found[k].tolist()}; "
                        f"walked {reached[k].tolist()}, shortest {ends.shortest[k]:.2g}, condition {conditions[k]:.2g}"
                    )
        good = ok & ~wrong
        at = State(
            *(
                np.where(good[:, None], new, old)
                for new, old in zip((ends.unknowns, end, found), (at.unknowns, at.known, at.guesses), strict=True)
            )
        )
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--given")
    parser.add_argument("--find")
    parser.add_argument("--paths", type=int, default=100)
    parser.add_argument("--steps", type=int, default=400)
    parser.add_argument("--random", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--real", choices=("float", "double"))
    chosen = parser.parse_args()
    total = Tally()
    with tempfile.TemporaryDirectory() as scratch:
        machines = [
            Machine(load(n), *(tuple(v.split(",")) if v else () for v in (chosen.given, chosen.find))) for n in chosen.names
        ]
        if not machines:
            machines = [*named(), *(m for m, _ in zip(drawn(chosen.seed, Path(scratch)), range(chosen.random), strict=False))]
        for machine in machines:
            for real in (chosen.real,) if chosen.real else ("float", "double"):
                try:
                    with tempfile.TemporaryDirectory() as folder:
                        found = directions(machine, real, Path(folder))
                except InputError as reason:
                    print(f"{machine.mechanism.name} {real}: left out: {str(reason)[:120]}", flush=True)
                    continue
                for way, direction in zip(("direct", "inverse"), found, strict=False):
                    tally = walked(direction, chosen.paths, chosen.steps, np.random.default_rng(chosen.seed))
                    print(
                        f"{machine.mechanism.name:24} {real:6} {'' if len(found) == 1 else way:7} steps {tally.steps:8,} OK {tally.ok:8,} "
                        f"wrong {tally.wrong} stuck {tally.stuck} moved {tally.moved}",
                        *(f"\n    {e}" for e in tally.examples or []),
                        flush=True,
                    )
                    total = replace(
                        total, **{n: getattr(total, n) + getattr(tally, n) for n in ("steps", "ok", "wrong", "stuck", "moved")}
                    )
    print(
        f"{total.steps:,} steps, {total.ok:,} OK: {total.wrong} wrong, {total.stuck} stuck, {total.moved} that do not stand still"
    )
    return 1 if total.failures else 0


if __name__ == "__main__":
    sys.exit(main())
