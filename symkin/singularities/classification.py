"""Classify a configuration: which kind of singularity, how near, and the motion or wrench that
shows it.

With the limbs' velocity equations A t + B q' = 0 (passive joints eliminated, rows orthonormal limb
by limb, see `limb_equations`) the feasible motions are the pairs (t, q') of their null space.
Compared with a generic configuration of the same mechanism nearby, a configuration is singular when
(Zlatanov, Fenton and Benhabib 1995; types 1 and 2 by Gosselin and Angeles 1990)

    RI   redundant input: q' != 0 with t = 0                      type 1 (B loses rank)
    RO   redundant output: t != 0 with q' = 0                     type 2 (A loses rank)
    II   impossible input: some q' belong to no motion
    IO   impossible output: some t belong to no motion
    RPM  redundant passive motion: passive joints move alone      P loses rank
    IIM  increased instantaneous mobility: more motions in all    F loses rank ("increased")

where q' may be the rates of any coordinates that drive and t those of any that are wanted, told by
name (see `roles`), and where the limbs' constraint wrenches lose rank it is a constraint
singularity (Zlatanov, Bonev and Gosselin 2002).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Unpack

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.errors import InputError
from symkin.machine.lower import arm_or_limbs
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import null_space, row_space
from symkin.numeric.tolerances import RANK_TOLERANCE, SINGULAR_VALUE
from symkin.position.problem import actuated_names, build_problem
from symkin.position.solution import Solution
from symkin.position.transfer import many_of_machine, own_closure, variables_elsewhere
from symkin.quiet import without_float_warnings
from symkin.singularities.configuration import configuration
from symkin.singularities.motion_ranks import (
    distances,
    generic_ranks,
    held_motions,
    singular_value,
)
from symkin.singularities.named_screw import NamedScrew, joint_rates, named_twist, named_wrench
from symkin.singularities.options import SingularityOptions
from symkin.singularities.output import (
    Output,
    OutputEquations,
    coordinate_names,
    make_output,
    output_equations,
    output_twists,
)
from symkin.singularities.singular_groups import SingularGroup, singular_groups
from symkin.singularities.singularity_result import KINDS, Singularity
from symkin.spatial.screw import tidy_rows
from symkin.velocity.limb_equations import (
    LimbwiseEquations,
    Ranks,
    feasible_motions,
    limbwise_equations,
)
from symkin.velocity.roles import Roles, roles_of
from symkin.verb import verb


@verb(SingularityOptions)
def singularity(
    mechanism: Mechanism | Solution, **options: Unpack[SingularityOptions]
) -> Singularity:
    """Classify a configuration: which kinds of singularity, how near each is, and the screws that
    show it.

    With the velocity equations A t + B q' = 0, t the platform's twist and q' the actuated joints'
    rates, passive joints eliminated: type 1 where B loses rank, type 2 where A does (Gosselin and
    Angeles 1990), and Zlatanov's conditions (Zlatanov, Fenton and Benhabib 1995). A distance is a
    singular value of rows of unit length; below `tolerance` it is zero.

    `mechanism` is a Mechanism, whose configuration is the one that `symkin.solve` reaches from
    `joints`, `pose` or `given` and `start` (in the mechanism's units); or a Solution that is there
    already, from `solve` or `modes`. At a singular configuration Newton's steps may fail;
    Levenberg-Marquardt from the same start then takes over. `output` names what type 1 and type 2
    are about, in place of the platform's position and orientation together: some of x, y, z
    (velocity of `point`, given in the platform's frame, its origin without) and rx, ry, rz (angular
    velocity), base frame; or coordinates by name. Raises SolveError where no configuration is
    reached, InputError for values that do not fit.

    The coordinates that `given` names drive, q' are their rates; with a Solution their names are
    enough. Without `output` t is the platform's twist, or all other joints' rates where no link is
    the platform or its own coordinates drive; "increased" is what the mechanism as a whole gains.
    `Singularity.motions` are the joints that may move while the given coordinates stand, `groups`
    the structure groups that are singular, with their loops.

        >>> import symkin
        >>> arm = symkin.load("gluon_6l3")
        >>> found = symkin.singularity(arm, joints=[10, 20, 30, 40, 0, 50])   # straight wrist
        >>> found.kinds, sorted(found.inputs[0])
        (('type 1',), ['q2', 'q3', 'q4', 'q6'])
        >>> symkin.singularity(arm, joints=[10, 20, 30, 40, 50, 60]).is_singular
        False
        >>> slider = symkin.load("slider_crank")
        >>> stretched = symkin.solve(slider, given={"crank": 0.0}).solution
        >>> [symkin.singularity(stretched, given=[by]).kinds for by in ("crank", "piston")]
        [(), ('type 2',)]
    """
    joints, pose, start = options["joints"], options["pose"], options["start"]
    given, output, tolerance = options["given"], options["output"], options["tolerance"]
    described = mechanism.mechanism if isinstance(mechanism, Solution) else mechanism
    names = coordinate_names(described, output) if isinstance(described, Mechanism) else None
    wanted = make_output(output if names is None else None, options["point"])
    if isinstance(mechanism, Solution):
        if not (joints is None and pose is None and start is None):
            raise InputError(
                "a Solution is classified as it is: give joints, pose and start with a mechanism "
                "only"
            )
        return classify(mechanism, tolerance, wanted, roles_of(described, given, names))
    if not isinstance(mechanism, Mechanism):
        raise InputError(
            f"a {type(mechanism).__name__} is given; allowed: a Mechanism, or a Solution, such as "
            f"`symkin.solve(...).solution` "
            "or one of `symkin.modes(...)`"
        )
    if given is not None and not isinstance(given, Mapping):
        raise InputError(
            "given: values by name are needed, as in given={'crank': 60.0}; names alone go with a "
            "Solution"
        )
    roles = roles_of(mechanism, given, names)
    return classify(
        configuration(mechanism, joints=joints, pose=pose, given=given, start=start),
        tolerance,
        wanted,
        roles,
    )


@without_float_warnings
def classify(
    solution: Solution,
    tolerance: float = SINGULAR_VALUE,
    output: Output | None = None,
    roles: Roles | None = None,
) -> Singularity:
    """Kind, distances and singular screws at a closed configuration; distances below `tolerance`
    count as zero.
    """
    if not 0.0 < tolerance < 1e-2:
        raise InputError(f"tolerance = {tolerance!r}; allowed: above 0 and below 0.01")
    roles = roles_of(solution.mechanism) if roles is None else roles
    if output is not None and not roles.has_twist:
        raise InputError(_no_twist(roles, output))
    closure = roles.closure
    values = variables_elsewhere(closure, solution)
    whole = limbwise_equations(closure, values, tolerance, roles)
    reduced = (
        None if output is None else output_equations(closure, values, whole, output, tolerance)
    )
    equations = whole if reduced is None else reduced.equations
    ranks = Ranks.of(equations, tolerance)
    generic = generic_ranks(roles, output).at_other_assembly(ranks)
    conditions = _conditions(ranks, generic)
    wrenches, least, most = equations.constraints, ranks.constraints, generic.constraints
    if roles.by_name:
        wrenches, least, most = _of_limbs(solution, roles, tolerance)
    spatial = closure.mechanism.motion == "spatial"
    kinds = _kinds(conditions, roles, lost=spatial and least < most)
    away = distances(closure, equations, generic, roles)
    if spatial and most:
        away["constraint"] = singular_value(wrenches, most)
    feasible = feasible_motions(whole, tolerance)[:, : whole.twist.shape[1]]
    borne = (
        _borne_wrenches(feasible, reduced, tolerance)
        if "IO" in conditions and roles.has_twist
        else feasible[:0]
    )
    inputs = null_space(equations.rates, tolerance) if "type 1" in kinds else equations.rates[:0]
    return Singularity(
        solution=solution,
        equations=equations,
        ranks=ranks,
        generic=generic,
        conditions=conditions,
        kinds=kinds,
        distances={kind: away[kind] for kind in KINDS if kind in away},
        singular_values=_direct_map(equations, ranks, generic, tolerance),
        twists=_twists(
            solution, whole, _free_twists(whole, reduced, ranks, kinds, wrenches, tolerance)
        )
        if roles.has_twist
        else (),
        wrenches=tuple(named_wrench(solution, row) for row in tidy_rows(borne @ whole.motion.T)),
        inputs=tuple(
            joint_rates(solution.mechanism, roles.driven(closure), row) for row in tidy_rows(inputs)
        ),
        feasible_twists=_twists(solution, whole, row_space(feasible, tolerance))
        if roles.has_twist
        else (),
        notes=_notes(closure, ranks, generic, output, roles),
        output=output,
        roles=roles,
        motions=held_motions(closure, values, roles, tolerance) if roles.by_name else (),
        groups=_groups(solution, roles, tolerance)
        if roles.by_name and {"type 2", "passive"} & set(kinds)
        else (),
    )


def _groups(solution: Solution, roles: Roles, tolerance: float) -> tuple[SingularGroup, ...]:
    """The structure groups of the problem whose known coordinates drive that are singular at a
    solution.
    """
    problem = build_problem(solution.mechanism, roles.inputs, ())
    return singular_groups(problem, variables_elsewhere(problem.closure, solution), tolerance)


def _of_limbs(solution: Solution, roles: Roles, tolerance: float) -> tuple[np.ndarray, int, int]:
    """The constraint wrenches of a graph that is a platform on limbs, driven by all actuated
    joints, their rank and its generic one; no wrenches of another.
    """
    is_whole = roles.has_twist and roles.inputs == actuated_names(roles.mechanism)
    low = arm_or_limbs(roles.mechanism) if is_whole else None
    if low is None:
        return np.zeros((0, 6)), 0, 0
    closure = build_closure(low.machine)
    values = many_of_machine(closure, own_closure(solution), solution.variables[None], low)[0]
    equations = limbwise_equations(closure, values, tolerance)
    ranks = Ranks.of(equations, tolerance)
    generic = generic_ranks(Roles.of_limbs(low.machine)).at_other_assembly(ranks)
    return equations.constraints, ranks.constraints, generic.constraints


def _no_twist(roles: Roles, output: Output) -> str:
    name, names = roles.mechanism.name, ", ".join(output.names)
    if roles.mechanism.platform_link is None:
        return (
            f"output = {names}: {name} has no platform link; name coordinates of joints, or the "
            f"link by [platform] link"
        )
    return f"output = {names}: coordinates of the platform drive {name}; name coordinates of joints"


# --- kinds ----------------------------------------------------------------------------------------


def _conditions(ranks: Ranks, generic: Ranks) -> tuple[str, ...]:
    """Zlatanov's names, each a count beside the generic one. RI and RO are the ranks of B and A,
    whose singular values are the distances of type 1 and type 2, so that one tolerance decides
    both.
    """
    tests = {
        "RI": ranks.rates < generic.rates,
        "RO": ranks.twist < generic.twist,
        "II": ranks.inputs < generic.inputs,
        "IO": ranks.outputs < generic.outputs,
        "RPM": ranks.idle > generic.idle,
        "IIM": ranks.freedoms > generic.freedoms,
    }
    return tuple(name for name, holds in tests.items() if holds)


def _kinds(conditions: tuple[str, ...], roles: Roles, *, lost: bool) -> tuple[str, ...]:
    """The kinds of singularity; `lost`: the limbs' constraint wrenches have lost rank."""
    tests = {
        "type 1": "RI" in conditions and roles.names_output,
        "type 2": "RO" in conditions,
        "increased": "IIM" in conditions,
        "constraint": lost,
        "passive": "RPM" in conditions,
    }
    return tuple(name for name, holds in tests.items() if holds)


def _direct_map(
    equations: LimbwiseEquations, ranks: Ranks, generic: Ranks, tolerance: float
) -> np.ndarray:
    """Singular values of q' -> t on the feasible motions; infinite where a platform motion needs no
    joint rate.
    """
    motions = feasible_motions(equations, tolerance)
    outputs, inputs = np.split(motions, [equations.twist.shape[1]], axis=1)
    count = min(generic.outputs, generic.inputs)
    if ranks.motions > ranks.inputs or ranks.twist < generic.twist or ranks.inputs < generic.inputs:
        return np.full(count, np.inf)
    jacobian = np.linalg.pinv(inputs, rcond=RANK_TOLERANCE) @ outputs
    values = np.linalg.svd(jacobian, compute_uv=False)[:count]
    return np.where(values > tolerance, values, 0.0)


# --- the screws that show it ----------------------------------------------------------------------


def _free_twists(
    whole: LimbwiseEquations,
    reduced: OutputEquations | None,
    ranks: Ranks,
    kinds: tuple[str, ...],
    wrenches: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Twists (n, r) with the actuated joints held, or with all joints free where a constraint is
    lost, one of the limbs' `wrenches`; none where no such motion is told.
    """
    if "type 2" in kinds or ("constraint" not in kinds and ranks.motions > ranks.inputs):
        return (
            null_space(whole.twist, tolerance)
            if reduced is None
            else output_twists(whole, reduced, tolerance)
        )
    return null_space(wrenches, tolerance) if "constraint" in kinds else whole.twist[:0]


def _borne_wrenches(
    feasible: np.ndarray, reduced: OutputEquations | None, tolerance: float
) -> np.ndarray:
    """Wrenches (n, r), as work on twists, that do no work on any feasible twist (or on the output's
    part of it): the platform bears them without the actuated joints.
    """
    if reduced is None:
        return null_space(feasible, tolerance)
    return null_space(feasible @ reduced.rows.T, tolerance) @ reduced.rows


def _twists(
    solution: Solution, equations: LimbwiseEquations, rows: np.ndarray
) -> tuple[NamedScrew, ...]:
    return tuple(named_twist(solution, row) for row in tidy_rows(rows @ equations.motion.T))


# --- notes ----------------------------------------------------------------------------------------

_PERMANENT = {
    "type 1": "freedoms of the actuated joints with the platform at rest",
    "type 2": "freedoms that are not actuated",
    "passive": "freedoms of passive joints alone",
}
"""What a mechanism has of each kind at every configuration."""


_PERMANENT_BY_NAME = {
    "type 1": "freedoms of the given coordinates with {output} at rest",
    "type 2": "freedoms that the given coordinates do not decide",
    "passive": "freedoms of further joints alone",
}
"""The same where what drives and what is wanted are told by name."""


def _notes(
    closure: Closure, ranks: Ranks, generic: Ranks, output: Output | None, roles: Roles
) -> tuple[str, ...]:
    """Sentences on what is not looked for or counted, and where the freedoms differ from those
    elsewhere.
    """
    notes = [] if roles.by_name else _notes_on_platform(closure, generic, output)
    driven = len(roles.inputs)
    if generic.inputs < driven:
        what = "given coordinates" if roles.by_name else "actuated joints"
        notes.append(f"only {generic.inputs} of {driven} {what} are independent")
    counts = generic.permanent_freedoms
    if not roles.names_output:
        counts = {"type 2": generic.motions - generic.inputs}
    texts = _PERMANENT_BY_NAME if roles.by_name else _PERMANENT
    notes += [
        f"{texts[kind].format(output=roles.output_text)}, everywhere: {count}"
        for kind, count in counts.items()
        if count
    ]
    if ranks.freedoms != generic.freedoms:
        notes.append(f"freedoms of motion here {ranks.freedoms}, elsewhere {generic.freedoms}")
    return tuple(notes)


def _notes_on_platform(closure: Closure, generic: Ranks, output: Output | None) -> list[str]:
    """What is not looked for of a platform on limbs, and what the kinds do not name."""
    mechanism, notes = closure.mechanism, list[str]()
    full = sum(c.freedom for c in closure.role("pose"))
    if mechanism.motion != "spatial":
        notes.append(
            f"the platform's motion is declared {mechanism.motion}: constraint singularities are "
            f"not looked for"
        )
    if output is None and generic.outputs < full:
        notes.append(
            _of_short_arm(len(mechanism.actuated), generic.outputs, full)
            if mechanism.serial
            else _of_few_freedoms(generic.outputs, full)
        )
    return notes


def _of_short_arm(joints: int, freedoms: int, full: int) -> str:
    return (
        f"with {joints} joint{'' if joints == 1 else 's'} the tool has {freedoms} of {full} "
        f"freedoms: type 1 means that joints move "
        "while position and orientation of the tool both stand; where only its position loses a "
        "direction, as a stretched arm's "
        "may, is not named without an output, such as --output x,y,z"
    )


def _of_few_freedoms(freedoms: int, full: int) -> str:
    return (
        f"the platform has {freedoms} of {full} freedoms; type 1 and type 2 are about its position "
        f"and orientation together: joints that "
        "turn it about a point at rest are no type 1; for a point or some coordinates name the "
        "output, such as --output x,y"
    )
