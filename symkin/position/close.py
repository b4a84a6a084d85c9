"""The verb `close`: the closed configuration nearest to a file's own, and what its constraints
leave free there.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.closure.link_poses import link_poses
from symkin.formats.assembled import assembled, open_sentence
from symkin.formats.load import is_robot, load, read_robot
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.robot import Robot
from symkin.formats.tree import Closed, nearest_closed
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.tolerances import (
    CLEAR_GAP,
    CLOSURE_TOLERANCE,
    FILE_DIGITS,
    LIMIT_SLACK,
    RANK_TOLERANCE,
    SINGULAR_VALUE,
)
from symkin.position.close_result import ClosedConfiguration, LoopGap
from symkin.position.closed_configurations import (
    Assembly,
    assembly_of,
    begun_closed,
    whole_system,
)
from symkin.position.generic_rank import GenericRank, first_order_sentences, generic_rank
from symkin.position.gruebler import counts
from symkin.position.mobility import mobility
from symkin.position.moved_reference import with_reference_at
from symkin.position.readings import readings_at
from symkin.text import first_of
from symkin.verb import read_as, verb


@verb()
def close(
    name_or_path: str | Path | Mechanism, read: ReadOptions = AS_IT_IS, *, seed: int = 0
) -> ClosedConfiguration:
    """Find the closed configuration nearest to the one that a file describes, and count its
    freedoms. Nearest is meant along the branch to which a search from there comes: of loops that
    stand open by half a radian and more another branch may be nearer.

    Takes what `load` takes, with what is told of a robot beside its file (`read`), or a Mechanism.
    Rank, mobility and redundant constraints of robots in other formats (MJCF, URDF, SDF) are those
    of their closures and couplings on the freedoms of their tree, idle spins of rods included, as
    other tools count them. `seed` is that of the steps to configurations at which the generic rank
    is taken. Raises as `load` does; where nothing closes the loops, the result says so (`closed`),
    with what comes nearest.

    >>> import symkin
    >>> found = symkin.close("four_bar")
    >>> found.closed, found.mobility
    (True, 1)
    """
    if isinstance(name_or_path, Mechanism):
        return _of_mechanism(name_or_path, seed)
    path = Path(read_as("str | Path", "name_or_path", name_or_path))
    if is_robot(path):
        return close_robot(read_robot(path, read), seed=seed)
    return _of_mechanism(load(name_or_path, read), seed)


def close_robot(robot: Robot, *, seed: int = 0) -> ClosedConfiguration:
    """As `close`, of a robot that is read."""
    found = nearest_closed(robot)
    tree = found.tree
    rows = tree.system.rows.shape[0]
    _, jacobian = tree.constraints.linearise_one(found.state)
    rank = Rank.of(jacobian, RANK_TOLERANCE if found.closed else FILE_DIGITS).value
    generic = (
        generic_rank(Assembly(tree.constraints, found.state), seed) if found.to_digits else None
    )
    displaced = found.displacements
    # links first, then bodies that are part of them
    frames = sorted(robot.frames.items(), key=lambda entry: entry[0] != entry[1][0])
    poses = {name: displaced[link] @ frame for name, (link, frame) in frames}
    return ClosedConfiguration(
        mechanism=robot.name,
        units=("m", "rad"),
        links=len(robot.links),
        joint_count=len(robot.joints),
        freedoms=tree.freedom,
        rows=rows,
        rank=rank,
        redundant=rows - rank,
        generic_rank=None if generic is None else _clear_value(generic),
        actuated=tuple(c.name for e in robot.tree if e.joint.actuated for c in e.joint.coordinates),
        loops=tuple(LoopGap(name, found.gaps[name], found.residuals[name]) for name in found.gaps),
        open_by=found.open_by,
        residual=found.residual,
        closed=found.to_digits,
        joints=_tree_values(robot, found),
        link_poses=poses,
        notes=(*_closing_notes(found, rank, generic), *_limit_notes(robot, found), *robot.notes),
        reference=assembled(robot, found) if found.to_digits and _moves(robot) else None,
        infinitesimal=0 if generic is None else generic.infinitesimal,
    )


def _clear_value(generic: GenericRank) -> int | None:
    """The generic rank, to digits where loops close to these alone; None where it is not clear."""
    if generic.digits is not None:
        return generic.digits.rank
    rank = generic.rank
    return rank.value if rank.least >= SINGULAR_VALUE and rank.gap >= CLEAR_GAP else None


def _moves(robot: Robot) -> bool:
    """Whether a joint or a closure leaves any freedom."""
    return bool(robot.tree) or any(c.joint.type != "weld" for c in robot.closures)


def _tree_values(robot: Robot, found: Closed) -> dict[str, float | list[float]]:
    """The values of the tree's joints, in the file's order."""
    names = [c.name for entry in robot.tree for c in entry.joint.coordinates]
    values = {name: list(found.values[name]) for name in names}
    return {name: value[0] if len(value) == 1 else value for name, value in values.items()}


def _closing_notes(found: Closed, rank: int, generic: GenericRank | None) -> list[str]:
    if not found.to_digits:
        return [open_sentence(found)]
    notes, freedom = [], found.tree.freedom
    if not found.closed:
        notes.append(
            f"the loops close only to the digits of the file: the nearest configuration leaves "
            f"{found.residual:.1e} m"
        )
    value = None if generic is None else _clear_value(generic)
    if generic is None or value is None:
        notes.append(
            "the rank at closed configurations beside this one is not clear: freedoms here may be "
            "lost away from it, or not"
        )
    elif rank > value:
        notes.append(
            f"the digits of the file make constraints of what is redundant: the rank is {rank} "
            f"here, and {value} at configurations "
            "beside this one, which close to those digits"
        )
    elif rank != value:
        digits = ", which close to the digits of the file" if generic.digits is not None else ""
        notes.append(
            f"this configuration is singular: the rank is {rank} here, and {value} at "
            f"closed configurations beside it{digits}: "
            f"the mobility is {freedom - rank} here, and {freedom - value} there"
        )
    if generic is not None:
        notes += first_order_sentences(freedom - generic.rank.value, generic.infinitesimal)
    return notes


def _limit_notes(robot: Robot, found: Closed) -> list[str]:
    """Which joints lie beyond their limits."""
    beyond = []
    for entry in robot.tree:
        limits = entry.joint.limits
        if limits is not None:
            value = found.values[entry.joint.name][0]
            slack = LIMIT_SLACK * (found.tree.size if entry.joint.type == "P" else 1.0)
            if not limits[0] - slack <= value <= limits[1] + slack:
                beyond.append(
                    f"{entry.joint.name} = {value:.6g} (limits {limits[0]:g} to {limits[1]:g})"
                )
    return [f"beyond the limits of the file: {first_of(beyond)}"] if beyond else []


# --- mechanism files ------------------------------------------------------------------------------


def _of_mechanism(mechanism: Mechanism, seed: int) -> ClosedConfiguration:
    """The same of a mechanism, from its reference."""
    closure, account = build_closure(mechanism), mobility(mechanism, seed=seed)
    system, size = whole_system(closure), closure.characteristic_length
    open_by, values = system.residual(closure.reference), begun_closed(assembly_of(closure))
    if system.residual(values) > CLOSURE_TOLERANCE * size:
        values = min((values, account.values), key=system.residual)
    residual = system.residual(values)
    closed = residual <= (FILE_DIGITS if account.digits is not None else CLOSURE_TOLERANCE) * size
    moved = mechanism if open_by <= CLOSURE_TOLERANCE * size else with_reference_at(closure, values)
    links, joints, _ = counts(mechanism)
    rank = account.rank.value if account.reference_rank is None else account.reference_rank.value
    redundant = account.redundant_at_reference
    return ClosedConfiguration(
        mechanism=mechanism.name,
        units=(mechanism.length_unit, mechanism.angle_unit),
        links=links,
        joint_count=joints,
        freedoms=account.freedoms,
        rows=account.rows,
        rank=rank,
        redundant=account.redundant if redundant is None else redundant,
        generic_rank=account.rank.value,
        actuated=tuple(c.name for c in mechanism.actuated),
        loops=(),
        open_by=open_by,
        residual=residual,
        closed=closed,
        joints=_joint_values(closure, values),
        link_poses=dict(link_poses(closure, values[None]).at(0)),
        notes=account.warnings,
        reference=moved if closed else None,
        infinitesimal=account.infinitesimal,
    )


def _joint_values(closure: Closure, values: np.ndarray) -> dict[str, float | list[float]]:
    """Every joint coordinate in the mechanism's units."""
    mechanism = closure.mechanism
    read = readings_at(closure, values[None])
    found: dict[str, float | list[float]] = {}
    for c in mechanism.coordinates:
        numbers = read[c.name][0] if c.name in read else values[closure.slices[c.name]]
        if c.is_rotation:
            found[c.name] = [float(v) for v in numbers]
        else:
            found[c.name] = mechanism.value_out(c, float(numbers[0]))
    return found
