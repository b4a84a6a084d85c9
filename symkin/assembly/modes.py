"""All modes of a mechanism's position problem, for one input or for many."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Any, Unpack, overload

import numpy as np

from symkin.assembly.as_written import (
    Told,
    as_written,
    is_complete,
    machine_of,
    may_contradict,
)
from symkin.assembly.by_groups import modes_of_inputs
from symkin.assembly.modes_result import Modes
from symkin.assembly.options import ModesOptions
from symkin.assembly.plan import refuse_unless_isolated
from symkin.assembly.search import DEFAULT_SEED, Search
from symkin.computed_once import lru_cache
from symkin.homotopy.monodromy import told_of_searches
from symkin.machine.lower import Lowered
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import (
    Columns,
    Given,
    Joints,
    Values,
    in_order,
    is_many,
    read_given,
    read_many,
)
from symkin.position.mobility import open_loops_note
from symkin.position.multistart import DEFAULT_STARTS
from symkin.position.out_of_reach import reach_note
from symkin.position.pose_coordinates import motion_note
from symkin.position.problem import Problem, build_problem
from symkin.quiet import without_float_warnings
from symkin.spatial.pose import Pose
from symkin.verb import verb


@overload
def modes(
    mechanism: Mechanism,
    *,
    joints: Joints | None = None,
    pose: Sequence[float] | Pose | None = None,
    given: Values | None = None,
    **options: Unpack[ModesOptions],
) -> Modes: ...
@overload
def modes(
    mechanism: Mechanism,
    *,
    joints: Sequence[Joints] | Mapping[str, Sequence[float]] | None = None,
    pose: Sequence[Sequence[float] | Pose] | None = None,
    given: Columns | None = None,
    **options: Unpack[ModesOptions],
) -> tuple[Modes, ...]: ...
@overload
def modes(
    mechanism: Mechanism,
    *,
    joints: np.ndarray | None = None,
    pose: np.ndarray | None = None,
    **options: Unpack[ModesOptions],
) -> Any: ...
@verb(ModesOptions)
def modes(
    mechanism: Mechanism,
    *,
    joints: Any = None,
    pose: Any = None,
    given: Any = None,
    **options: Unpack[ModesOptions],
) -> Modes | tuple[Modes, ...]:
    """Every solution of the direct (`joints`) or inverse (`pose`) problem, values in the
    mechanism's units.

    `joints` are those of one input, in file order or by name, or of n inputs as an array (n,
    joints); `pose` is x, y, z, qw, qx, qy, qz, a `Pose`, or n of them. Of n inputs the result is a
    tuple of their `Modes`, the same as one by one, found together in a fraction of the time.
    `given` maps names of coordinates to values: joints, passive ones too, and x, y, z, azimuth,
    tilt and torsion of the platform, or its whole "pose"; as many as the mobility; of n inputs a
    column for each name, one value where all have the same. Modes for given values are found block
    by block (see `Modes.groups`); `choose` takes one solution of each of the first blocks, by
    number, where all are too many to be listed.

    By default the inverse problem of an arm whose axes allow it is solved by formulas, in each
    joint's turn, and all that these leave in doubt, and every other problem, by continuation
    (`Modes.method` says which). `method` "continuation" tracks all complex roots from the
    mechanism's own generic instance and says how complete the list is; "multistart" keeps what
    `starts` (default 2000) random starts reach. `solver`, for multistart, is "batched" (default:
    Levenberg-Marquardt on all rows, all starts at once) or a solver of `solve`, called once a
    start. With continuation a part that has no start system is sampled, and a note says why. Raises
    InputError for values that do not fit, and for options that the call would ignore: `solver` with
    continuation, `starts` and `seed` where nothing is sampled.

    >>> import numpy as np, symkin
    >>> platform = symkin.load("zhang2009")
    >>> legs = np.array(platform.example.joints)
    >>> [len(found) for found in symkin.modes(platform, joints=[legs, legs + 1.0])]
    [4, 4]
    """
    require_mechanism(mechanism)
    choose, method = options["choose"], options["method"]
    search = Search.of(
        method, options["starts"], options["seed"], options["solver"], options["progress"]
    )
    if is_many(joints, pose, given):
        return _found(mechanism, search, read_many(mechanism, joints, pose, given), choose)
    given = read_given(mechanism, joints, pose, given)
    found = _found(mechanism, search, [given], choose)[0]
    # coordinates of a pose are those of the declared motion; joints may carry it elsewhere
    listed, carries = found.modes, found.problem.carries_pose
    notes = [motion_note(mechanism, listed.position, listed.quaternion) if carries else None]
    if not (listed or found.positive_dimensional or found.smallest_residual is None):
        notes.append(reach_note(found.problem, given))
    told = [note for note in notes if note is not None]
    return replace(found, notes=(*found.notes, *told)) if told else found


def _found(
    mechanism: Mechanism,
    search: Search,
    givens: Sequence[Given],
    choose: Sequence[int] = (),
    least_errors: bool = True,
) -> tuple[Modes, ...]:
    """The modes of inputs of one kind, with the loop that cannot close where there are none;
    `choose` and `least_errors` as `modes_by_groups` has them.
    """
    if not givens:
        return ()
    if len(givens) != 1:
        search = replace(search, begun=time.perf_counter(), inputs=len(givens))
    is_searched = search.method == "continuation"
    problem, low = _problem_and_machine(mechanism, givens[0].names, bool(choose), is_searched)
    find = partial(modes_of_inputs, search=search, choose=choose, least_errors=least_errors)
    told = nullcontext() if search.progress is None else told_of_searches(search.progress)
    with told:
        found = find(problem, givens) if low is None else _of_machine(low, problem, givens, find)
    lost = [modes.problem.by_name and not modes for modes in found]
    note = open_loops_note(mechanism) if any(lost) else None
    if note is None:
        return tuple(found)
    return tuple(
        replace(modes, notes=(*modes.notes, note)) if none else modes
        for modes, none in zip(found, lost, strict=True)
    )


def _of_machine(
    low: Lowered, problem: Problem, givens: Sequence[Given], find: Callable[..., list[Modes]]
) -> list[Modes]:
    """The modes of inputs, which are those of the machine that the description means, as they are
    found there, and of the description's own problem where that does not tell all of them.
    """
    there = [given.there or in_order(low.machine, given) for given in givens]
    told = Told(low, problem, np.array([given.values for given in givens]))
    of_machine = find(build_problem(low.machine, there[0].names), there, told=told)
    own = [
        None if at.off_motion else as_written(told, given, modes)
        for at, given, modes in zip(there, givens, of_machine, strict=True)
    ]
    rest = [
        i
        for i, modes in enumerate(own)
        if modes is None or (not modes.modes and may_contradict(low, givens[i]))
    ]
    alone = find(problem, [givens[i] for i in rest]) if rest else ()
    for i, modes in zip(rest, alone, strict=True):
        own[i] = modes if own[i] is None or is_complete(modes) else own[i]
    return [modes for modes in own if modes is not None]


@lru_cache(maxsize=128)
def _problem_and_machine(
    mechanism: Mechanism, names: tuple[str, ...], chooses: bool, is_searched: bool
) -> tuple[Problem, Lowered | None]:
    """The problem of known coordinates, and the machine that the description means where another
    one's modes are to be found.
    """
    # numbers of solutions to take are those of blocks of named coordinates
    problem = build_problem(mechanism, names, () if chooses else None)
    if problem.by_name:
        refuse_unless_isolated(problem)
    return problem, machine_of(mechanism, names) if is_searched and not chooses else None


@without_float_warnings
def modes_on_grid(
    mechanism: Mechanism, columns: Mapping[str, Sequence[float]]
) -> tuple[Modes, ...]:
    """`modes` at many inputs, without the search for the least closure errors of those that have no
    solution.
    """
    return _found(mechanism, Search.of(None), read_many(mechanism, None, None, columns), (), False)


@without_float_warnings
def modes_at_need(
    mechanism: Mechanism,
    *,
    joints: Joints | None = None,
    pose: Sequence[float] | Pose | None = None,
    starts: int = DEFAULT_STARTS,
) -> Modes:
    """`modes` by continuation, with `starts` random ones at hand for the parts that need random
    starts, if any does.
    """
    search = Search("continuation", starts, DEFAULT_SEED, "batched")
    return _found(mechanism, search, [read_given(mechanism, joints, pose)])[0]
