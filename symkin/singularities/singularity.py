"""Singular configurations: which kind, how near, and the motion or wrench that shows it.

With the limbs' velocity equations A t + B q' = 0 (passive joints eliminated, rows orthonormal limb by limb, see
`limb_equations`) the feasible motions are the pairs (t, q') of their null space. Compared with a generic configuration
of the same mechanism nearby, a configuration is singular when (Zlatanov, Fenton and Benhabib 1995)

    RI   redundant input: q' != 0 with t = 0                      type 1 (Gosselin and Angeles 1990; B loses rank)
    RO   redundant output: t != 0 with q' = 0                     type 2 (A loses rank)
    II   impossible input: some q' belong to no motion
    IO   impossible output: some t belong to no motion
    RPM  redundant passive motion: passive joints move alone      P loses rank
    IIM  increased instantaneous mobility: more motions in all

and where the limbs' constraint wrenches lose rank it is a constraint singularity (Zlatanov, Bonev and Gosselin 2002).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import RANK_TOLERANCE
from symkin.position.solution import Solution
from symkin.quiet import without_float_warnings
from symkin.singularities.configuration import configuration
from symkin.singularities.limb_equations import LimbwiseEquations, limbwise_equations, small_null_space
from symkin.singularities.motion_ranks import Ranks, distances, feasible_motions, generic_ranks
from symkin.singularities.named_screw import NamedScrew, joint_rates, named_twist, named_wrench
from symkin.singularities.output import Output, OutputEquations, make_output, output_equations, output_twists
from symkin.singularities.standing import everywhere, notes_on
from symkin.spatial.pose import Pose
from symkin.spatial.screw import tidy_rows
from symkin.velocity.velocity import variables_of

TOLERANCE = 1e-6
"""A configuration counts as singular when its distance is below this: a double root is known to 1e-8 only."""
OUTPUT_KINDS = {
    "type 1": "the inverse problem loses rank: joints move, the output stands",
    "type 2": "the direct problem loses rank: the output moves, the actuated joints stand",
    "constraint": "the limbs' constraint wrenches lose rank: the platform gains a freedom",
    "passive": "platform or passive joints move, output and actuated joints stand",
}
"""What the kinds mean where an output is named."""
KINDS = {
    "type 1": "the inverse problem loses rank: joints move, the platform stands",
    "type 2": "the direct problem loses rank: the platform moves, the actuated joints stand",
    "constraint": "the limbs' constraint wrenches lose rank: the platform gains a freedom",
    "passive": "passive joints move alone, platform and actuated joints stand",
}
"""Kinds of singularity and what they mean."""
CONDITIONS = {
    "RI": "redundant input",
    "RO": "redundant output",
    "II": "impossible input",
    "IO": "impossible output",
    "RPM": "redundant passive motion",
    "IIM": "increased instantaneous mobility",
}
"""Zlatanov's conditions in words."""


@dataclass(frozen=True, eq=False)
class Singularity:
    """What the velocity equations say at one configuration.

    `kinds` are keys of KINDS, `conditions` Zlatanov's names: what differs here from a generic configuration of the same
    mechanism, both empty where nothing does. Such a configuration is regular only where `loose`, the platform's freedoms
    that the actuated joints leave everywhere when they are held, is 0. `distances`
    holds, for each kind that the mechanism can have, the smallest singular value (of those that are not zero everywhere)
    of its matrix with rows of unit length, angles times the size: the 2-norm of the smallest change of these rows that
    makes the configuration singular, between 0 and 1 for each limb. They depend on the platform origin, and on neither
    units nor the base frame. `singular_values` are those of the direct map q' -> t (lengths; angles times the size),
    `manipulability` their product (Yoshikawa 1985), infinite where the platform moves with the actuated joints held (type 2, or
    `loose`). `twists` are these motions, or those with all joints free where a constraint is lost; `wrenches` what the platform
    bears without the actuated joints' help where an output is impossible; `inputs` the joint rates with the platform at
    rest (type 1), in the mechanism's units, the largest 1; `feasible_twists` span what the platform can do. Where an `output` is
    named, it stands for the twist in all of this: `equations` and ranks are those reduced to it.
    """

    solution: Solution
    equations: LimbwiseEquations
    ranks: Ranks
    generic: Ranks
    conditions: tuple[str, ...]
    kinds: tuple[str, ...]
    distances: dict[str, float]
    singular_values: np.ndarray
    twists: tuple[NamedScrew, ...]
    wrenches: tuple[NamedScrew, ...]
    inputs: tuple[dict[str, float], ...]
    feasible_twists: tuple[NamedScrew, ...]
    notes: tuple[str, ...] = ()
    output: Output | None = None

    @property
    def everywhere(self) -> dict[str, int]:
        """Freedoms of each kind that every configuration has, where there are any; kinds and distances count further ones."""
        return everywhere(self.generic)

    @property
    def loose(self) -> int:
        """Freedoms that the platform has at every configuration with all actuated joints held."""
        return self.everywhere.get("type 2", 0)

    @property
    def is_singular(self) -> bool:
        """Whether the platform or some joints move more freely than the actuated joints say, here or everywhere."""
        return bool(self.kinds) or self.loose > 0

    @property
    def distance(self) -> float:
        """The smallest of the distances."""
        return min(self.distances.values(), default=float("inf"))

    @property
    def manipulability(self) -> float:
        """Product of the direct map's singular values; that of the inverse map is its reciprocal."""
        return float(np.prod(self.singular_values))

    @property
    def inverse_manipulability(self) -> float:
        value = self.manipulability
        return float("inf") if value == 0.0 else 1.0 / value

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of the direct map, and of the inverse one."""
        s = self.singular_values
        return float(s[0] / s[-1]) if s.size and np.isfinite(s[0]) and s[-1] > 0.0 else float("inf")

    def to_dict(self) -> dict[str, Any]:
        """One object; infinite numbers are null."""
        from symkin.singularities.singularity_text import singularity_dict

        return singularity_dict(self)

    def __str__(self) -> str:
        from symkin.singularities.singularity_text import singularity_text

        return singularity_text(self)


@without_float_warnings
def singularity(
    mechanism: Mechanism | Solution,
    *,
    joints: Sequence[float] | None = None,
    pose: Sequence[float] | Pose | None = None,
    start: Sequence[float] | Pose | None = None,
    tolerance: float = TOLERANCE,
    output: Sequence[str] | None = None,
    point: Sequence[float] | None = None,
) -> Singularity:
    """Classify the configuration that `solve` reaches from the same arguments, or a Solution that is there already:

        symkin.singularity(mechanism, joints=[...])
        symkin.singularity(mode)                       for each mode of `symkin.modes`, or `symkin.solve(...).solution`

    `output` names what type 1 and type 2 are about, in place of the platform's position and orientation together: some of x, y, z
    (velocity of `point`, given in the platform's frame, its origin without) and rx, ry, rz (angular velocity), base frame.
    At a singular configuration Newton's steps may fail; Levenberg-Marquardt from the same start then takes over. Raises
    SolveError where no configuration is reached, InputError for values that do not fit.
    """
    wanted = make_output(output, point)
    if isinstance(mechanism, Solution):
        if not (joints is None and pose is None and start is None):
            raise InputError("a Solution is classified as it is: give joints, pose and start with a mechanism only")
        return classify(mechanism, tolerance, wanted)
    if not isinstance(mechanism, Mechanism):
        raise InputError(
            f"a {type(mechanism).__name__} is given; allowed: a Mechanism, or a Solution, such as `symkin.solve(...).solution` "
            "or one of `symkin.modes(...)`"
        )
    return classify(configuration(mechanism, joints=joints, pose=pose, start=start), tolerance, wanted)


@without_float_warnings
def classify(solution: Solution, tolerance: float = TOLERANCE, output: Output | None = None) -> Singularity:
    """Kind, distances and singular screws at a closed configuration; distances below `tolerance` count as zero."""
    if not 0.0 < tolerance < 1e-2:
        raise InputError(f"tolerance = {tolerance!r}; allowed: above 0 and below 0.01")
    closure = build_closure(solution.mechanism)
    values = variables_of(closure, solution)
    whole = limbwise_equations(closure, values, tolerance)
    reduced = None if output is None else output_equations(closure, values, whole, output, tolerance)
    equations = whole if reduced is None else reduced.equations
    ranks = Ranks.of(equations, tolerance)
    generic = generic_ranks(solution.mechanism, output).at_other_assembly(ranks)
    conditions = _conditions(ranks, generic)
    kinds = _kinds(closure, ranks, generic, conditions)
    return Singularity(
        solution, equations, ranks, generic, conditions, kinds, distances(closure, equations, generic),
        _direct_map(equations, ranks, generic, tolerance), *_shown(solution, whole, reduced, ranks, kinds, conditions, tolerance),
        notes_on(closure, ranks, generic, output), output,
    )  # fmt: skip


# --- kinds ---------------------------------------------------------------------------------------------------------


def _conditions(ranks: Ranks, generic: Ranks) -> tuple[str, ...]:
    """Zlatanov's names, each a count beside the generic one. RI and RO are the ranks of B and A, whose singular values are the
    distances of type 1 and type 2, so that one tolerance decides both."""
    tests = {
        "RI": ranks.rates < generic.rates,
        "RO": ranks.twist < generic.twist,
        "II": ranks.inputs < generic.inputs,
        "IO": ranks.outputs < generic.outputs,
        "RPM": ranks.idle > generic.idle,
        "IIM": ranks.motions + ranks.idle > generic.motions + generic.idle,
    }
    return tuple(name for name, holds in tests.items() if holds)


def _kinds(closure: Closure, ranks: Ranks, generic: Ranks, conditions: tuple[str, ...]) -> tuple[str, ...]:
    tests = {
        "type 1": "RI" in conditions,
        "type 2": "RO" in conditions,
        "constraint": closure.mechanism.motion == "spatial" and ranks.constraints < generic.constraints,
        "passive": "RPM" in conditions,
    }
    return tuple(name for name, holds in tests.items() if holds)


def _direct_map(equations: LimbwiseEquations, ranks: Ranks, generic: Ranks, tolerance: float) -> np.ndarray:
    """Singular values of q' -> t on the feasible motions; infinite where a platform motion needs no joint rate."""
    motions = feasible_motions(equations, tolerance)
    outputs, inputs = np.split(motions, [equations.twist.shape[1]], axis=1)
    count = min(generic.outputs, generic.inputs)
    if ranks.motions > ranks.inputs or ranks.twist < generic.twist or ranks.inputs < generic.inputs:
        return np.full(count, np.inf)
    jacobian = np.linalg.pinv(inputs, rcond=RANK_TOLERANCE) @ outputs
    values = np.linalg.svd(jacobian, compute_uv=False)[:count]
    return np.asarray(np.where(values > tolerance, values, 0.0))


def _shown(
    solution: Solution,
    equations: LimbwiseEquations,
    reduced: OutputEquations | None,
    ranks: Ranks,
    kinds: tuple[str, ...],
    conditions: tuple[str, ...],
    tolerance: float,
) -> tuple[tuple[NamedScrew, ...], tuple[NamedScrew, ...], tuple[dict[str, float], ...], tuple[NamedScrew, ...]]:
    """The twists, wrenches and joint rates that show the singularity, and a basis of the feasible twists."""
    outputs = feasible_motions(equations, tolerance)[:, : equations.twist.shape[1]]
    named = outputs if reduced is None else outputs @ reduced.rows.T
    held = small_null_space(equations.twist, tolerance) if reduced is None else output_twists(equations, reduced, tolerance)
    twists, wrenches, inputs = np.zeros((0, 6)), np.zeros((0, 6)), np.zeros((0, equations.rates.shape[1]))
    if "type 2" in kinds or ("constraint" not in kinds and ranks.motions > ranks.inputs):
        twists = held @ equations.motion.T
    elif "constraint" in kinds:
        twists = small_null_space(equations.constraints, tolerance) @ equations.motion.T
    if "IO" in conditions:
        borne = small_null_space(named, tolerance)
        wrenches = (borne if reduced is None else borne @ reduced.rows) @ equations.motion.T
    if "type 1" in kinds:
        inputs = small_null_space(equations.rates if reduced is None else reduced.equations.rates, tolerance)
    return (
        tuple(named_twist(solution, row) for row in tidy_rows(twists)),
        tuple(named_wrench(solution, row) for row in tidy_rows(wrenches)),
        tuple(joint_rates(solution, row) for row in tidy_rows(inputs)),
        tuple(named_twist(solution, row) for row in _span(outputs, tolerance) @ equations.motion.T),
    )


def _span(matrix: np.ndarray, tolerance: float) -> np.ndarray:
    """Orthonormal rows of the same span, singular values below `tolerance` taken as zero."""
    _, singular, right = np.linalg.svd(matrix, full_matrices=False)
    return np.asarray(right[singular > tolerance])
