"""Make test vectors: inputs that generated code reads exactly, and the answers of the Python
solvers to those inputs.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np

from symkin.codegen.arm_vectors import canonical, followed_lines, singular_joints
from symkin.codegen.folder.refused_vectors import (
    MOST,
    beyond_passive,
    infeasible,
    joints_past,
    off_motion,
)
from symkin.codegen.map.joint_map import JointMap, map_configurations
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.rates import derivatives, step_columns
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.steps.passive_limits import keeps_limits
from symkin.codegen.steps.pose_coordinates import COLUMNS
from symkin.codegen.steps.samples import (
    Configuration,
    all_followed,
    configurations,
    rounded_to,
    tidied,
    tidied_pose,
)
from symkin.codegen.text.c import Real
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import units_of
from symkin.numeric.rank import null_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.problem import Problem, actuated_names, build_problem, pose_names
from symkin.position.solution import pose_of

_PARTS = (1.0, 0.25, 0.0625)
"""Shares of the usual way from home that are tried where limits of passive joints or singularities
leave few configurations.
"""
_SPREAD = 0.06
"""How far joints go from home, in sizes."""
_NEAR = 2e-4
"""How far every other guess is from its answer: in radians, and in sizes."""
_LARGEST_CONDITION = 1e4
"""Condition from which on errors allowed do not grow."""
_HIDDEN = 2e-4
"""Largest condition of a map's case, times roundings: beyond it a hundred of them are as far as a
singularity may be away.
"""
_PLAIN, _HARDER = 50.0, 1.5
"""Condition of a platform's case that is never hard, and of the others how many times that of home.
"""
_FAR = 600.0
"""Largest condition at home and at a platform's case from which lines from home to it are asked:
code cuts those of larger ones into many parts, some into more than it may take.
"""
_SEED = 20
DOUBLED = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0])
"""Of a pose, for a quaternion of length 2."""
COUNT = 24
JACOBIANS = 4


@dataclass(frozen=True)
class Vectors:
    """Arrays by the name of their table: `answers` are cases, one a row, and what is right of them
    (derivatives of the first ones), `refused` what code refuses, `places` single rows. `bounds` are
    the errors allowed of the cases (length unit, angles times the size), `blamed` the joint that is
    beyond a limit in each of the rows of joints that are.
    """

    answers: dict[str, np.ndarray]
    refused: dict[str, np.ndarray]
    places: dict[str, np.ndarray]
    bounds: np.ndarray
    blamed: list[int]


def build_vectors(kind: LimbPlatform | SerialArm | JointMap) -> Vectors:
    """The vectors of a machine, the same bytes on every computer, because answers are rounded.
    Raises InputError where there is not one case.
    """
    vectors = _of_arm(kind) if isinstance(kind, SerialArm) else _of_loops(_Sides(kind))
    if not len(vectors.bounds):
        where = "home" if isinstance(kind, RodPlatform) else "the reference"
        raise InputError(
            f"{kind.name}: no regular configuration was found near {where} to test generated code "
            "with; check the geometry by `symkin show`, joints' limits and the pose of [platform]"
            + ("; --real double has more digits" if kind.real.name == "float" else "")
        )
    return vectors


def _bound(real: Real, size: float, condition: float, *, of_map: bool = False) -> float:
    """Error allowed: what rounding and the tolerance leave of the rows, times the condition; of
    platforms and arms the tolerance is that of the answer.
    """
    worst, tolerance = min(condition, _LARGEST_CONDITION), real.epsilon * size
    tolerance *= 1.0 if real.name == "float" else 1e4
    rounding = real.epsilon * size * (16 + 4 * worst)
    return (4 + worst) * tolerance + 2 * rounding if of_map else 4 * tolerance + rounding


# --- machines with loops --------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Sides:
    """The two sides of a machine with loops: joints, and a pose or the found values of a map."""

    kind: LimbPlatform | JointMap

    @cached_property
    def direct(self) -> Problem:
        kind = self.kind
        if isinstance(kind, JointMap):
            return kind.direct.problem
        return build_problem(kind.mechanism, actuated_names(kind.mechanism))

    @cached_property
    def inverse(self) -> Problem:
        kind = self.kind
        if isinstance(kind, JointMap):
            return kind.inverse.problem
        return build_problem(kind.mechanism, pose_names(kind.mechanism))

    @property
    def home(self) -> np.ndarray:
        """All variables of the closure at home."""
        return self.kind.reference if isinstance(self.kind, JointMap) else self.kind.home_values

    @property
    def size(self) -> float:
        return self.kind.mechanism.characteristic_length

    @property
    def units(self) -> np.ndarray:
        """Of the joints."""
        return np.array(units_of(self.direct.known_coordinates, self.size))

    def joints(self, values: np.ndarray) -> np.ndarray:
        """Joint values of a configuration, as code takes them."""
        known = self.direct.select_values(values, self.direct.known_coordinates)
        return tidied(known - self.kind.zero, self.units)

    def found(self, values: np.ndarray) -> np.ndarray:
        """What code finds at a configuration: a pose as stated, or found values."""
        kind = self.kind
        if isinstance(kind, JointMap):
            return tidied(
                self.inverse.select_values(values, kind.found), units_of(kind.found, self.size)
            )
        return tidied_pose(kind.stated(pose_of(self.direct.closure, values)), self.size)

    def back(self, found: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Joint values of what was found, as code reads it, next to a configuration."""
        kind, read = self.kind, rounded_to(self.kind.real, found)
        if isinstance(kind, JointMap):
            return self.joints(_moved(self.inverse, values, read))
        return tidied(kind.inverse_at(read, values), self.units)

    def derivatives(self, values: np.ndarray) -> dict[str, np.ndarray]:
        """Rows of derivatives at a configuration."""
        kind = self.kind
        if isinstance(kind, JointMap):
            first, second = (np.round(part, 9).ravel() + 0.0 for part in derivatives(kind, values))
            return {"jacobians": first, "seconds": second}
        rates, feasible = _rates(self.inverse, values)
        # turned on both sides, as the twists that it takes and gives are
        feasible = kind.told_rates(kind.told_rates(feasible).T).T
        rates = tidied(kind.told_rates(rates) @ feasible, self.size)
        return {"jacobians": rates.ravel(), "feasible": tidied(feasible, 1.0).ravel()}

    @cached_property
    def home_condition(self) -> float:
        return self.condition(self.home)

    def condition(self, values: np.ndarray) -> float:
        """The larger condition of the two directions."""
        return max(_condition(problem, values) for problem in (self.direct, self.inverse))

    @cached_property
    def cases(self) -> list[np.ndarray]:
        """Configurations whose joint values are numbers of the type, within limits of passive
        joints, none of which code may refuse because it is hard: about home, and nearer ones if
        they are few. Of a platform all of whose are hard, these.
        """
        kind, found, hard = self.kind, list[np.ndarray](), list[np.ndarray]()
        for part in _PARTS:
            spread = _SPREAD * part
            if isinstance(kind, JointMap):
                near = map_configurations(kind, COUNT, _SEED, spread, 0.3 * part)
            else:
                near = configurations(self.direct, self.home, COUNT, _SEED, spread, 0.15 * part)
            for case, plain in zip(near, self._plain(near), strict=True):
                if keeps_limits(kind.passive_limits, self.direct.closure, case.values):
                    (found if plain else hard).append(case.values)
            if len(found) >= COUNT:
                break
        if not found and not isinstance(kind, JointMap):
            found = hard
        read = (
            rounded_to(kind.real, self.joints(values)) + self.kind.zero for values in found[:COUNT]
        )
        return [_moved(self.direct, v, known) for v, known in zip(found, read, strict=False)]

    def _plain(self, near: list[Configuration]) -> list[bool]:
        """Which cases code is bound to answer: of a map those where roundings of the type cannot
        hide a singularity; of a platform those not much nearer to one than home is, and whose limbs
        without formulas can be followed along the line of poses.
        """
        kind, conditions = self.kind, [self.condition(case.values) for case in near]
        if isinstance(kind, JointMap):
            return [condition * kind.real.epsilon <= _HIDDEN for condition in conditions]
        most = _HARDER * max(self.home_condition, _PLAIN)
        plain = np.array([condition <= most for condition in conditions], bool)
        if len(near) and not kind.tells_branch:
            begin, start = (
                self.home[p] for p in (self.inverse.unknown_places, self.inverse.known_places)
            )
            poses = np.array([case.values[self.inverse.known_places] for case in near])
            plain &= all_followed(self.inverse, begin, start, poses)[1]
        return list(plain)


def _condition(problem: Problem, values: np.ndarray) -> float:
    """The condition of a problem at a configuration: of one unknown, which alone tells nothing, by
    how much it changes with the known values.
    """
    system, known = problem.system, values[problem.known_places]
    unknown = values[problem.unknown_places]
    if system.freedom > 1:
        return system.condition(unknown, known)
    own = system.linearise_one(unknown, known)[1]
    given = system.exchanged(problem.known_coordinates).linearise_one(known, unknown)[1]
    least = np.linalg.norm(own)
    return float(np.hypot(least, np.linalg.norm(given)) / least) if least else np.inf


def _moved(problem: Problem, values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The configuration next to another that has these known values."""
    found = values.copy()
    found[problem.known_places] = known
    found[problem.unknown_places] = problem.system.polish(values[problem.unknown_places], known, 6)
    return found


def _rates(inverse: Problem, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Actuated joint rates by the twist (velocity; angular velocity), N x 6, from the closure's
    differential; and the projection (6, 6) of twists on those that the platform can take.
    """
    system, mechanism = inverse.system, inverse.mechanism
    size = mechanism.characteristic_length
    unknown, known = values[inverse.unknown_places], values[inverse.known_places]
    by_joints = system.linearise_one(unknown, known)[1]
    by_pose = system.exchanged(inverse.known_coordinates).linearise_one(known, unknown)[1]
    solved = np.linalg.lstsq(by_joints, -by_pose, rcond=1e-12)[0]
    full, columns = np.zeros((len(mechanism.actuated), 6)), COLUMNS[mechanism.motion]
    for i, (row, scale) in enumerate(step_columns(system.unknowns, mechanism.actuated, size)):
        full[i, columns] = scale * solved[row]
    full[:, 3:] *= size
    # what no joint rates balance is not feasible; twists outside the motion have no rates at all
    free = null_space(by_pose + by_joints @ solved, RANK_TOLERANCE)
    feasible = np.eye(6)
    feasible[np.ix_(columns, columns)] = tidied(free.T @ free, 1.0)
    feasible[:3, 3:] *= size
    feasible[3:, :3] /= size
    return full, feasible


def _of_loops(sides: _Sides) -> Vectors:
    """Every other case starts next to its answer, as a servo loop does; the others at home, where
    nothing singular is near.
    """
    kind, tables, bounds = sides.kind, dict[str, list[np.ndarray]](), list[float]()
    is_map = isinstance(kind, JointMap)
    target = "found" if is_map else "poses"
    for number, values in enumerate(sides.cases):
        beside = values[sides.direct.known_places] + _NEAR * sides.units
        worst = max(sides.condition(values), 0.0 if is_map else sides.home_condition)
        far = not number % 2 and (is_map or worst <= _FAR)
        near = sides.home if far else _moved(sides.direct, values, beside)
        found = sides.found(values)
        row = {
            "guesses": sides.found(near),
            "joints": sides.joints(values),
            target: found,
            "inverse": sides.back(found, values),
            **({"joint_guesses": sides.joints(near)} if is_map else {}),
            **(sides.derivatives(values) if number < JACOBIANS else {}),
        }
        for name, numbers in row.items():
            tables.setdefault(name, []).append(numbers)
        bounds.append(_bound(kind.real, sides.size, sides.condition(values), of_map=is_map))
    if not bounds:
        return Vectors({}, {}, {}, np.zeros(0), [])
    answers = {name: np.array(rows) for name, rows in tables.items()}
    if not is_map and np.all(answers["feasible"] == np.eye(6).ravel()):
        del answers["feasible"]
    past, blamed = joints_past(sides.direct.known_coordinates, answers["joints"][0], kind.zero)
    home, told = sides.found(sides.home), answers[target]
    if isinstance(kind, JointMap):
        refused = {
            "infeasible_joints": np.array(
                [sides.joints(v) for v in infeasible(sides.direct, sides.cases)]
            ),
            "past_joints": past,
            "infeasible_found": np.array(
                [sides.found(v) for v in infeasible(sides.inverse, sides.cases)]
            ),
            "past_found": joints_past(kind.found, told[0])[0],
        }
        places = {"home_joints": sides.joints(sides.home), "home_found": home}
    else:
        away = np.linalg.norm(told[:, :3] - told[0][:3], axis=1)
        refused = {
            "singular": kind.singular_starts,
            "infeasible": _infeasible_poses(sides, kind),
            "past": past,
            "doubled": told[:1] * DOUBLED,
        }
        places = {"home": home, "far": told[int(np.argmax(away))]}
    return Vectors(answers, refused, places, np.array(bounds), blamed)


def _infeasible_poses(sides: _Sides, kind: LimbPlatform) -> np.ndarray:
    """Poses (n, 7) that the platform cannot take: off its motion, open in a limb, or with a passive
    joint beyond its limits.
    """
    found = [tidied_pose(kind.stated(p), sides.size) for p in off_motion(kind, sides.cases)]
    values = infeasible(sides.inverse, sides.cases, MOST - len(found))
    found += map(sides.found, (*values, *beyond_passive(kind)))
    return np.array(found).reshape(-1, 7)


# --- arms -----------------------------------------------------------------------------------------


def _of_arm(arm: SerialArm) -> Vectors:
    """Lines of poses that are followed from guess to goal."""
    real, size = arm.real, arm.mechanism.characteristic_length
    rows, bounds, jacobians = list[tuple[np.ndarray, ...]](), list[float](), list[np.ndarray]()
    for line, end in islice(followed_lines(arm, COUNT), COUNT):
        inverse = (
            end if arm.is_redundant else arm.inverse.system.polish(line.joints, line.target, 6)
        )
        pose = tidied_pose(canonical(arm.forward_at(line.joints)), size)
        rows.append((line.guess, line.joints, pose, tidied(inverse, units_of(arm.actuated, size))))
        bounds.append(_bound(real, size, line.condition))
        if len(jacobians) < JACOBIANS:
            jacobians.append(tidied(arm.jacobian_at(line.joints), size).ravel())
    if not rows:
        return Vectors({}, {}, {}, np.zeros(0), [])
    tables = zip(("guesses", "joints", "poses", "inverse"), zip(*rows, strict=True), strict=True)
    answers = {name: np.array(table) for name, table in tables}
    past, blamed = joints_past(arm.actuated, answers["joints"][0])
    refused = {
        "singular": singular_joints(arm),
        "infeasible": np.zeros((0, 7)),
        "past": past,
        "doubled": answers["poses"][:1] * DOUBLED,
    }
    answers["jacobians"] = np.array(jacobians)
    return Vectors(answers, refused, {}, np.array(bounds), blamed)
