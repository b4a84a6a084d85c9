"""The problems of generated C that take a guess, asked many at once: of platforms, arms and maps
between joints.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from asked import asked
from closes import Machine, built
from continuation import Walker
from lines import Lines, Starts
from symkin.codegen.joint_map import JointMap
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.options import Options
from symkin.codegen.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.c import Real
from symkin.position.problem import Problem, build_problem

OUT_OF_RANGE = 4
PLAIN = 0.25
"""Step of the fine walk, as a part of a line, which lines that nothing is beside take."""
HARD = 50.0
"""Condition from which on a refusal beside a singularity is not held against the code: bounds are
kept from it.
"""
_FIRM = 0.02
"""Condition of a limb at a given pose, times the root of rounding, from which on the limb is beside
a dead centre: an error t of the pose is one of sqrt(t) there, and code keeps bounds of some such.
"""
_WAVES = 3
_REACH = 0.9
"""How far paths go from home (rad, or of the size), where no limits are nearer."""


@dataclass(frozen=True, eq=False)
class Direction:
    """One problem of one machine's code: a function of ask.c and the closure that it solves."""

    machine: Machine
    real: str
    library: ctypes.CDLL
    function: ctypes._CFuncPtr
    problem: Problem
    home: Starts
    lines: Lines
    places: np.ndarray | None
    solved_by: str
    back: Direction | None = None

    @cached_property
    def walker(self) -> Walker:
        return Walker(self.problem, PLAIN)

    @property
    def size(self) -> float:
        return self.machine.mechanism.characteristic_length

    def rounded(self, values: np.ndarray) -> np.ndarray:
        """Values as the code's numbers are."""
        return values.astype(np.float32 if self.real == "float" else np.float64).astype(float)

    def answers(self, goals: np.ndarray, guesses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Statuses and what is found."""
        found, status, _ = asked(
            self.function, self.real, [goals, guesses], [guesses.shape[1]], "iiosn"
        )
        return status, found

    def stated(self, unknowns: np.ndarray, known: np.ndarray) -> np.ndarray:
        if self.places is not None:
            return unknowns[:, self.places]
        return self.lines.stated(unknowns, known)

    def gives_back(self, found: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Whether the code's limbs, on the reference's branches, reach a pose with these joint
        values: else one is past a dead centre.
        """
        if self.places is not None or self.machine.mechanism.serial:
            return np.ones(len(found), bool)
        number = len(self.machine.mechanism.actuated)
        joints, status = asked(self.library.back_all, self.real, [found], [number], "ios")
        units = np.array(
            [1.0 if c.is_angular else self.size for c in self.problem.known_coordinates]
        )
        away = joints - known
        away[:, units == 1.0] = np.angle(np.exp(1j * away[:, units == 1.0]))
        # beside a dead centre joints differ by the root of the pose's rounding
        near = np.sqrt(Real(self.real).epsilon)  # type: ignore[arg-type]
        return np.asarray((status == 0) & (np.max(np.abs(away / units), axis=1) < near))

    def is_firm(self, unknowns: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Whether rounded poses tell on which side of their dead centres limbs stand: those of
        configurations at which the limbs' rows, the pose given, are far from singular.
        """
        if self.places is not None or self.machine.mechanism.serial:
            return np.ones(len(unknowns), bool)
        values = self.problem.join_values(unknowns, known)
        limbs = build_problem(self.machine.mechanism, "inverse")
        parts = (limbs.system.unknowns, limbs.known_coordinates)
        conditions = limbs.system.conditions(*(limbs.select_values(values, c) for c in parts))
        return np.asarray(conditions * np.sqrt(Real(self.real).epsilon) < _FIRM)  # type: ignore[arg-type]

    def tells(self, guesses: np.ndarray, known: np.ndarray, *, easily: bool = False) -> np.ndarray:
        """Whether guesses alone tell the code that it stands at these known values: those of a map
        hold one side's values only, and mean the configuration to which these lead from home;
        `easily`: by a line far from singularities.
        """
        if self.back is None:
            return np.ones(len(guesses), bool)
        home = self.back.home
        begin = (np.repeat(part, len(guesses), axis=0) for part in (home.unknowns, home.known))
        ends = self.back.walker.reached(*begin, guesses)
        away = self.back.off(self.back.stated(ends.unknowns, guesses), known)
        near = 10 * np.sqrt(Real(self.real).epsilon)  # type: ignore[arg-type]
        told = (ends.shortest > 0.0) & (away < near)
        if easily:
            conditions = self.back.problem.system.conditions(ends.unknowns, guesses)
            told &= (ends.shortest >= PLAIN) & (conditions < HARD)
        return np.asarray(told)

    def off(self, found: np.ndarray, reached: np.ndarray) -> np.ndarray:
        """Differences (n,), over the size or in rad; of maps by whole turns."""
        if self.places is None:
            return self.lines.distance(found, reached) / self.size
        units = np.array(
            [1.0 if c.is_angular else self.size for c in self.problem.system.unknowns]
        )[self.places]
        away = found - reached
        turns = units == 1.0
        away[:, turns] = np.angle(np.exp(1j * away[:, turns]))
        return np.asarray(np.max(np.abs(away / units), axis=1))


def solved_by(kind: object, way: object = None) -> str:
    """What solves a problem: six rods, an arm, limbs by formulas or by Newton's method, a map by
    either.
    """
    if isinstance(kind, JointMap):
        return "map, formulas" if way.is_closed else "map, Newton"  # type: ignore[attr-defined]
    if isinstance(kind, RodPlatform):
        return "six rods"
    if isinstance(kind, SerialArm):
        return "arm"
    return (
        "limbs, Newton"
        if not isinstance(kind, LimbPlatform) or kind.direct_formulas is None
        else "limbs, formulas"
    )


def directions(machine: Machine, real: str, folder: Path) -> list[Direction]:
    """The problems of a machine's code that take a guess."""
    library = built(machine, real, folder)
    options = Options(real, home=machine.home, given=machine.given, find=machine.find)  # type: ignore[arg-type]
    lines = Lines(machine.mechanism, options)
    kind = lines.kind
    if not isinstance(kind, JointMap):
        start = lines.home(1)
        home = Starts(start.unknowns, start.known, start.guesses)
        return [
            Direction(
                machine,
                real,
                library,
                library.ask_all,
                lines.problem,
                home,
                lines,
                None,
                solved_by(kind),
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
        home = Starts(unknowns[None], known[None], unknowns[None][:, places])
        found.append(
            Direction(
                machine, real, library, function, problem, home, lines, places, solved_by(kind, way)
            )
        )
    direct, inverse = found
    return [replace(direct, back=inverse), replace(inverse, back=direct)]


def paths_of(direction: Direction, paths: int, steps: int, rng: np.random.Generator) -> np.ndarray:
    """Goals (steps, paths, known): sums of sines about home within limits; poses of an arm are
    those of such joints.
    """
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
            rng.uniform(-1, 1, paths) * np.sin(2 * np.pi * (w * time + rng.uniform(0, 1, paths)))
            for w in range(1, _WAVES + 1)
        )
        waves = (waves - waves[0]) / (2.0 * np.abs(waves).max() + 1e-30)
        goals.append(
            home[k] + np.where(waves > 0, (high - home[k]) * waves, (home[k] - low) * waves) * 0.98
        )
    found = np.stack(goals, axis=-1)
    if not arm:
        return found
    kind: SerialArm = direction.lines.kind  # type: ignore[assignment]
    return np.array([[kind.forward_at(q) for q in row] for row in found])
