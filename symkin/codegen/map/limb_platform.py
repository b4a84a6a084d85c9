"""Describe a parallel mechanism of any limbs for code generation: its Newton iterations, limb by
limb and all together.

The direct problem finds pose and passive joints together by Newton's method on the closure's rows.
Once the pose is given the limbs decouple. Rods are explicit; a limb that has a closed form takes
the reference's branch of it; others are solved from the reference configuration along the line of
poses to the given one, so that they stay on the reference's branch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.codegen.map.record import Described
from symkin.codegen.map.signature import PLATFORM, PLATFORM_SPEEDS, Function
from symkin.codegen.steps.direct_formulas import DirectFormulas, direct_formulas
from symkin.codegen.steps.formula_guards import free_divisors, is_firm, keeps_digits
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.limbwise import Held
from symkin.codegen.steps.linear_solver import is_unrolled
from symkin.codegen.steps.newton_kernel import Kernel, sampled, system_kernel
from symkin.codegen.steps.passive_limits import PassiveCheck, PassiveLimit, passive_limits
from symkin.codegen.steps.passive_reach import passive_reaches
from symkin.codegen.steps.pose_coordinates import restricted
from symkin.codegen.steps.pose_core import PoseCore, pose_core
from symkin.codegen.steps.samples import Configuration, configurations
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import ClosedForm, closed_form, samples_about
from symkin.elimination.implied_rows import unit_of
from symkin.errors import InputError
from symkin.machine.frame import Frames
from symkin.model.changed import scaled
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.rank import Rank
from symkin.numeric.system import System, constant_rows, split_blocks
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.determination import what_is_free
from symkin.position.mobility import mobility
from symkin.position.problem import Problem, actuated_names, build_problem, pose_names
from symkin.spatial.pose import Pose

_COMPARED = 4
"""Configurations at which the coefficients of a limb's rows are compared, to find its closed
form.
"""
_CHECKED = 5
"""Configurations at which it is checked that a solver can work."""
_LARGE = {"float": 2.0**12, "double": 2.0**60}
"""Size, and one over it, from which on direct formulas in a type of numbers are those of a machine
of a size next to 1: they hold up to the eighth power of lengths, their guards products of two.
"""
_ROUNDING = 1e-14
"""Known values, over the size or 1, of samples that are zero."""
_TINY = float(np.finfo(float).tiny)
_SINGULAR = 1e-9
"""Smallest singular value, over the largest, below which a solver's matrix is singular."""


@dataclass(frozen=True, eq=False)
class LimbBlock:
    """A limb once the pose is given: `rod` is the explicit value of its only coordinate, `formulas`
    give all of them, else `kernel` solves it. With both, the formulas give the joints, and the
    kernel's matrix their rates.

    `sides` are -dF/d(twist) (rows x freedom of the pose), the right-hand sides of the joint rates;
    for a rod d(rod)/d(twist). `name` begins the names of the limb's functions. `free_divisors` are
    numbers of the formulas' divisors that no discriminant guards; `is_checked`: the formulas'
    answer is put into the rows, some of which they leave over, or divide by what may be small.
    """

    name: str
    system: System
    kernel: Kernel | None
    rod: ca.SX | None
    formulas: ClosedForm | None
    sides: ca.SX
    free_divisors: tuple[int, ...] = ()
    is_checked: bool = False


@dataclass(frozen=True, eq=False)
class LimbPlatform(Described):
    """A parallel mechanism with its options: what its C is written from."""

    held: Held | None = None
    """How its limbs hold it in its motion, where the line has to be watched for that."""
    frames: Frames | None = None
    """The frames in which poses are told; None: those of the mechanism."""
    templates: ClassVar[str] = "parallel"

    @property
    def functions(self) -> tuple[Function, ...]:
        return (*PLATFORM, *PLATFORM_SPEEDS)

    @property
    def can_be_compact(self) -> bool:
        return not self.is_closed and is_unrolled(self.direct_kernel, compact=False)

    @property
    def is_closed(self) -> bool:
        return self.direct_formulas is not None

    @cached_property
    def direct(self) -> Problem:
        return build_problem(self.mechanism, actuated_names(self.mechanism))

    @cached_property
    def inverse(self) -> Problem:
        return build_problem(self.mechanism, pose_names(self.mechanism))

    @property
    def closure(self) -> Closure:
        return self.direct.closure

    @cached_property
    def geometry(self) -> Geometry:
        return Geometry(self.closure, self.options.geometry == "struct", self.frames)

    @cached_property
    def actuated(self) -> tuple[Coordinate, ...]:
        return self.closure.role("actuated")

    @property
    def passive(self) -> tuple[Coordinate, ...]:
        """Passive joints that stay unknowns of the direct problem."""
        return self.closure.role("passive") if self.core is None else ()

    @cached_property
    def samples(self) -> list[Configuration]:
        return configurations(self.direct, self.closure.reference, 40, 3)

    @cached_property
    def sampled_poses(self) -> np.ndarray:
        """Known values (n, known) of the inverse problem at the samples, those that are zero to
        rounding so: coefficients that consist of them vanish.
        """
        known = self.inverse.known_coordinates
        poses = np.array([self.inverse.select_values(s.values, known) for s in self.samples])
        units = np.array(units_of(known, self.size))
        return np.where(np.abs(poses) <= _ROUNDING * units, 0.0, poses)

    @cached_property
    def core(self) -> PoseCore | None:
        """The direct problem over the pose alone, where all passive joints are taken out of the
        limbs' rows and a limb's branch is told by the pose and its actuated joint. Passive joints
        with limits are not taken out, nor those of which it is not known where they exist.
        """
        if (
            self.geometry.at_run_time
            or not self.samples
            or self.direct_formulas is not None
            or self.passive_limits
            or self._reaches is None
        ):
            return None
        known = self.inverse.known_coordinates
        poses = np.array(
            [self.inverse.select_values(s.values, known) for s in self.samples[:_COMPARED]]
        )
        system = self.geometry.system(self.inverse)
        return pose_core(
            self.closure, split_blocks(system), constant_rows(system), poses, self.actuated
        )

    @cached_property
    def _reaches(self) -> list[PassiveCheck] | None:
        """Where the limbs' passive joints exist, once they are taken out; None where that is not
        known.
        """
        found = list[PassiveCheck]()
        for limb in split_blocks(self.geometry.system(self.inverse)):
            reaches = passive_reaches(self.direct, limb, self.samples, self.home_values, self.real)
            if reaches is None:
                return None
            found += reaches
        return found

    @cached_property
    def sampled_direct(self) -> tuple[np.ndarray, float]:
        """Matrices of the direct problem's iteration at the samples, and kappa there."""
        states, known = zip(*(self.direct_state(s.values) for s in self.samples), strict=True)
        return sampled(self.direct_kernel, states, known, self.geometry.values)

    @property
    def middle(self) -> np.ndarray | Sequence[float]:
        """A usual position of the platform."""
        return self.mechanism.platform_position

    def direct_state(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State and known values of the direct problem's iteration at a configuration, all
        variables of the closure.
        """
        if self.core is None:
            return self.direct.select_values(
                values, self.direct.system.unknowns
            ), self.direct.select_values(values, self.actuated)
        pose, joints = (
            self.direct.select_values(values, c) for c in (self.closure.role("pose"), self.actuated)
        )
        return pose, self.core.direct.known(joints)

    @cached_property
    def direct_kernel(self) -> Kernel:
        """The Newton iteration of the direct problem."""
        if self.core is not None:
            return self.core.direct.kernel
        return system_kernel(
            "direct",
            self.geometry.system(self.direct),
            self.direct.known_coordinates,
            self.geometry.symbols,
        )

    @cached_property
    def direct_formulas(self) -> DirectFormulas | None:
        """The closed form of the direct problem, where the geometry is constant and all limbs have
        one too.
        """
        if self.geometry.at_run_time or not _tells_branch(self._closure_blocks):
            return None
        size, large = self.size, _LARGE[self.real.name]
        if 1.0 / large <= size <= large:
            limbs = [block.system for block in self._closure_blocks]
            return direct_formulas(self.direct, limbs, self.samples, self.held)
        unit = unit_of(size)
        twin = LimbPlatform(
            scaled(self.mechanism, 1.0 / unit), self.options, self.real, frames=self.frames
        )
        if self.held is not None:
            twin = replace(twin, held=self.held.in_unit(1.0 / unit, self.direct, twin.direct))
        found = twin.direct_formulas
        return None if found is None else found.in_unit(unit)

    @cached_property
    def passive_limits(self) -> list[PassiveLimit]:
        """Limits of joints that are not actuated."""
        return passive_limits(self.closure, self.actuated, self.real)

    @property
    def passive_checks(self) -> Sequence[PassiveCheck]:
        """What is asked of joints that are not actuated: limits, and where they are taken out that
        they exist.
        """
        return self.passive_limits if self.core is None else self._reaches or []

    @property
    def has_dead_centres(self) -> bool:
        return any(block.rod is None for block in self.blocks)

    @property
    def tells_branch(self) -> bool:
        """Whether signs tell every limb's branch: all are rods or have closed forms."""
        return _tells_branch(self.blocks)

    @cached_property
    def conditions(self) -> System:
        """Rows that no joint enters: the pose alone must satisfy them."""
        return (
            constant_rows(self.geometry.system(self.inverse))
            if self.core is None
            else self.core.conditions
        )

    @cached_property
    def blocks(self) -> tuple[LimbBlock, ...]:
        """Limbs, each a system of its own once the pose is given."""
        if self.core is None:
            return self._closure_blocks
        return tuple(
            self._block(number, system) for number, system in enumerate(self.core.limbs, start=1)
        )

    @cached_property
    def _closure_blocks(self) -> tuple[LimbBlock, ...]:
        """Limbs with their passive joints."""
        systems = split_blocks(self.geometry.system(self.inverse))
        return tuple(self._block(number, system) for number, system in enumerate(systems, start=1))

    def _block(self, number: int, system: System) -> LimbBlock:
        pose, symbols = self.closure.role("pose"), self.geometry.symbols
        rod, kernel, formulas = None, None, None
        if (
            len(system.unknowns) == 1
            and system.unknowns[0].least is not None
            and system.errors.numel() == 1
        ):
            # the error of a rod is its length by the pose less its coordinate
            rod = ca.substitute(system.errors, system.unknown, 0)
        else:
            formulas = self._formulas(system)
        left_over = formulas is not None and not _solves_any_pose(
            formulas, self.samples[0], self.inverse
        )
        free = [] if formulas is None else free_divisors(formulas)
        if rod is None and (formulas is None or left_over):
            # of a limb that not every pose lets close, rates are least squares over its rows
            kernel = system_kernel(f"limb{number}", system, pose, symbols)
        sides = self.by_twist(system, system.rows if rod is None else rod)
        return LimbBlock(
            f"limb{number}",
            system,
            kernel,
            rod,
            formulas,
            sides if rod is not None else -sides,
            tuple(free),
            left_over or bool(free),
        )

    def by_twist(self, system: System, expression: ca.SX) -> ca.SX:
        """Derivatives (entries, freedom of the pose) of an expression of a limb's system by the
        platform's twist.
        """
        pose, size = self.closure.role("pose"), self.size
        of_pose = replace(system.exchanged(pose), rows=expression)
        scale = ca.diag(ca.SX([size if angular else 1.0 for angular in _angular(pose)]))
        return ca.mtimes(of_pose.jacobian, scale)

    def _formulas(self, system: System) -> ClosedForm | None:
        """The closed form of a limb, where its numbers are constants and all samples are on the
        reference's branch.
        """
        if self.geometry.at_run_time or len(self.samples) < _COMPARED:
            return None
        poses = self.sampled_poses
        limbs = np.array(
            [self.inverse.select_values(sample.values, system.unknowns) for sample in self.samples]
        )
        found = closed_form(system, poses[:_COMPARED])
        if found is None:
            return None
        home = self.home_signs(found)
        alike = all(
            np.array_equal(found.signs_at(limb, pose), home)
            for limb, pose in zip(limbs, poses, strict=True)
        )
        known = self.inverse.known_coordinates
        if not alike or not is_firm(
            found, self.inverse.select_values(self.home_values, known), poses, home
        ):
            return None
        return (
            found
            if not found.has_conditions
            or keeps_digits(found, poses, home, known, self.real.epsilon)
            else None
        )

    def home_signs(self, formulas: ClosedForm) -> np.ndarray:
        """The signs of the reference in a limb's closed form."""
        parts = (formulas.system.unknowns, self.inverse.known_coordinates)
        return formulas.signs_at(*(self.inverse.select_values(self.home_values, c) for c in parts))

    @property
    def home_values(self) -> np.ndarray:
        """All variables of the closure at home, which is the reference."""
        return self.closure.reference

    def stated(self, pose: Pose) -> np.ndarray:
        """The seven numbers by which generated code tells a pose of the mechanism."""
        told = pose if self.frames is None else self.frames.told(pose)
        return np.array([*told.position, *told.quaternion])

    def told_rates(self, rates: np.ndarray) -> np.ndarray:
        """Joint rates by the twist (n, 6) of the mechanism as generated code tells them."""
        rotation = self.geometry.rotation
        if rotation is None:
            return rates
        return np.hstack([rates[:, :3] @ rotation, rates[:, 3:] @ rotation])

    def inverse_at(self, numbers: np.ndarray, near: np.ndarray) -> np.ndarray:
        """Joint values at a pose as stated, from a configuration near it."""
        inverse, unit = (
            self.inverse,
            np.array([*numbers[:3], *(numbers[3:] / np.linalg.norm(numbers[3:]))]),
        )
        known = np.asarray(self._coordinates_of(unit, self.geometry.values)).ravel()
        unknown = inverse.system.polish(
            inverse.select_values(near, inverse.system.unknowns), known, 6
        )
        return inverse.select_values(inverse.join_values(unknown, known), self.actuated)

    @cached_property
    def _coordinates_of(self) -> ca.Function:
        """Pose coordinates of the seven numbers of a pose, as C takes them."""
        x = ca.SX.sym("x", 7)
        return ca.Function(
            "coordinates", [x, self.geometry.symbols], [restricted(self.geometry, x).coordinates]
        )

    @property
    def singular_starts(self) -> np.ndarray:
        """Poses (n, 7) at which the matrix is singular, as stated: none is known."""
        return np.zeros((0, 7))

    def check(self) -> None:
        """Raises InputError where a generated solver could not work."""
        if not self.actuated:
            raise InputError(f"{self.name} has no actuated joint; nothing to generate")
        self._check_reference()
        self._check_independent_joints()
        if not self.samples:
            raise InputError(
                f"{self.name}: no closed configurations were found near the reference; nothing to "
                f"generate"
            )
        for sample in self.samples[:_CHECKED]:
            if self.direct_kernel.is_wide or self._is_singular(sample.values):
                raise InputError(
                    f"{self.name}: locking the actuated joints does not fix the platform near the "
                    f"reference "
                    "(`symkin show` prints mobility and rank); nothing to generate"
                )
        for block in self.blocks:
            self._check_block(block)

    def _check_reference(self) -> None:
        """Raises InputError where the direct problem is singular at the reference, from which
        vectors and home begin.
        """
        values, problem = self.closure.reference, self.direct
        gap = problem.system.residual(
            *(values[places] for places in (problem.unknown_places, problem.known_places))
        )
        if gap <= CLOSURE_TOLERANCE * self.size and self._is_singular(values):
            if (free := what_is_free(problem)) is not None:
                raise InputError(f"{free} wherever it is; nothing to generate")
            raise InputError(
                f"{self.name}: the reference configuration is singular for the joints "
                f"{', '.join(c.name for c in self.actuated)}: "
                "locked there, they do not hold the platform; give the file another reference"
            )

    def _is_singular(self, values: np.ndarray) -> bool:
        """Whether locked actuated joints leave the platform free at a configuration: rows and
        columns are of one length, whatever the unit of their numbers is.
        """
        matrix = self.direct_kernel.matrix(*self.direct_state(values), self.geometry.values)
        for axis in (1, 0):
            matrix = matrix / np.maximum(np.linalg.norm(matrix, axis=axis, keepdims=True), _TINY)
        singular = np.linalg.svd(matrix, compute_uv=False)
        return bool(singular[-1] < _SINGULAR * singular[0])

    def _check_independent_joints(self) -> None:
        """Raises InputError where actuated joints are more than the freedoms that they move."""
        found = mobility(self.mechanism)
        if found.closed and found.direct_rank.value < found.rank.value:
            more = found.rank.value - found.direct_rank.value
            raise InputError(
                f"{self.name}: {found.actuated} actuated joints move {found.mobility} freedoms, so "
                f"that their values must agree "
                "with each other; between two sets of values that do, they do not, and generated "
                "code follows the straight line "
                f"between them. Leave {more} of the limbs out of the file, or let {more} of the "
                f"joints be passive: the pose is the same"
            )

    def _check_block(self, block: LimbBlock) -> None:
        """Raises InputError where a pose leaves joints of a limb free."""
        if block.kernel is None:
            return
        known = self.inverse.known_coordinates
        for sample in self.samples[:_CHECKED]:
            state, pose = (
                self.inverse.select_values(sample.values, c) for c in (block.system.unknowns, known)
            )
            matrix = block.kernel.matrix(state, pose, self.geometry.values)
            if Rank.of(matrix).value < matrix.shape[1]:
                names = ", ".join(c.name for c in block.system.unknowns)
                raise InputError(
                    f"{self.name}: the platform's pose does not fix joints of one limb ({names}), "
                    f"so that there is no inverse; "
                    "nothing to generate"
                )


def _tells_branch(blocks: Sequence[LimbBlock]) -> bool:
    return all(block.rod is not None or block.formulas is not None for block in blocks)


def _solves_any_pose(formulas: ClosedForm, sample: Configuration, inverse: Problem) -> bool:
    """Whether a limb's formulas satisfy its rows at poses beside a configuration's, not only at
    those that the platform can take.
    """
    if not formulas.has_conditions:
        return True
    if any(c.is_rotation for c in inverse.known_coordinates):
        return False
    pose = inverse.known_coordinates
    return formulas.closes(
        samples_about(formulas.system, inverse.select_values(sample.values, pose), pose)
    )


def _angular(pose: Sequence[Coordinate]) -> list[bool]:
    flags: list[bool] = []
    for c in pose:
        flags += [not c.is_length] * c.freedom
    return flags
