"""The verb `transmission`: find a linkage by its motors and joints, or all of a robot;
refuse what is none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Unpack, overload

import numpy as np

from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import Values, checked_names
from symkin.position.moved_reference import with_reference_at
from symkin.position.solution import Solution
from symkin.position.solve import solve
from symkin.text import counted, first_of
from symkin.transmissions.found import Group, group_with, groups_of, with_ranges
from symkin.transmissions.linkage import Linkage
from symkin.transmissions.motors import motors_of_file, read_motors
from symkin.transmissions.options import MotorOptions, TransmissionOptions
from symkin.transmissions.states import States
from symkin.transmissions.transmission_result import Transmission, Transmissions
from symkin.verb import verb

_OPEN = 1e-6
"""Closure error at the reference, over the size, above which loops are open there."""
_MOST_TRIED = 24
"""Sets of joints that are tried for a linkage whose joints nobody names."""
_MORE = 3
"""Coordinates of a serial way beyond the motors' number, some of which then follow from others."""
_DECIDED = 1e-6
"""Singular value of coordinates by unit motions of their linkage that is not zero."""


@overload
def transmission(
    mechanism: Mechanism,
    motors: None = None,
    joints: None = None,
    **options: Unpack[TransmissionOptions],
) -> Transmissions: ...
@overload
def transmission(
    mechanism: Mechanism,
    motors: Sequence[str],
    joints: Sequence[str] | None = None,
    **options: Unpack[TransmissionOptions],
) -> Transmission: ...
@verb(TransmissionOptions)
def transmission(
    mechanism: Mechanism,
    motors: Sequence[str] | None = None,
    joints: Sequence[str] | None = None,
    **options: Unpack[TransmissionOptions],
) -> Transmission | Transmissions:
    """The exact map between motors and the joints that they drive by a closed linkage.

    `motors` and `joints` are names of coordinates; as many joints as the linkage has freedoms, and
    at least as many motors. Without joints they are found: a serial way through the linkage,
    without both every linkage of a robot is found, and a `Transmissions` returned. `inertia` (of a
    motor), `torque_limits`, `speed_limits` and `resolution` are numbers, one for each motor or one
    for all; limits may be pairs (low, high). `ranges` are limits of coordinates, (low, high) by
    name, in place of the file's. `start`, a solution of `modes` or `solve` or values by name near
    the reference, is taken in the reference's place: its mode is that which is followed. Raises
    InputError where motors do not decide the joints, or joints the motors.

        >>> import symkin
        >>> linkage = symkin.load("four_bar")
        >>> knee = symkin.transmission(linkage, ["crank"], ["follower"], torque_limits=10.0)
        >>> knee.jacobian([60.0]).shape, knee.second([60.0]).shape
        ((1, 1), (1, 1, 1))
    """
    require_mechanism(mechanism)
    mechanism = with_ranges(_begun(mechanism, options["start"]), options["ranges"] or {})
    if motors is None and joints is None:
        return _all(mechanism, options)
    single = [c.name for c in mechanism.coordinates if not c.is_rotation]
    for what, names in (("motors", motors), ("joints", joints)):
        if names is not None:
            checked_names(mechanism, names, what, single)
    group = group_with(mechanism, [*(motors or ()), *(joints or ())])
    for name in (*(motors or ()), *(joints or ())):
        if name not in {c.name for c in group.coordinates} and not mechanism.limbs:
            raise InputError(
                f"{mechanism.name}: {name} is in no loop: nothing but itself moves it, so that no "
                f"other coordinate is a function of it"
            )
    if motors is None or joints is None:
        return _named(mechanism, group, motors, joints, options)
    linkage = Linkage(group.alone, tuple(motors), tuple(joints))
    return _checked(mechanism.name, linkage, options)


# --- what is found, and what cannot be ------------------------------------------------------------


def _begun(mechanism: Mechanism, start: Solution | Values | None) -> Mechanism:
    """The mechanism with another reference; values are held, or where others than they decide one
    of them, as beside a reference where joints are locked, a search begins at them.
    """
    if start is None:
        return mechanism
    if isinstance(start, Solution):
        begun: Solution | None = start
    else:
        try:
            begun = solve(mechanism, given=start).solution
        except InputError:
            begun = solve(mechanism, start=start).solution
    if begun is None or begun.mechanism != mechanism:
        raise InputError(f"start: the solution is none of {mechanism.name}")
    closure = build_closure(mechanism, begun.partition)
    return with_reference_at(closure, begun.variables)


def _all(mechanism: Mechanism, options: MotorOptions) -> Transmissions:
    found, notes = [], []
    for group in groups_of(mechanism):
        try:
            found.append(_named(mechanism, group, None, None, options))
        except InputError as error:
            notes.append(str(error))
    if not found:
        told = notes or [f"{mechanism.name}: there are no loops; every joint is its own motor's"]
        raise InputError("; ".join(told))
    return Transmissions(mechanism, tuple(found), tuple(notes))


def _named(
    mechanism: Mechanism,
    group: Group,
    motors: Sequence[str] | None,
    joints: Sequence[str] | None,
    options: MotorOptions,
) -> Transmission:
    """The transmission of a linkage whose motors, or joints, nobody names."""
    names, robot = tuple(c.name for c in group.coordinates), mechanism.name
    motors = tuple(motors or (c.name for c in group.actuated))
    whole, notes = Linkage(group.alone, motors, names), []
    _refuse_still(robot, whole)
    free = whole.mobility
    if not motors:
        raise InputError(
            f"{robot}: the linkage of {first_of(names)} has no motors; name them (--motors)"
        )
    if joints is not None:
        return _checked(robot, Linkage(group.alone, motors, tuple(joints)), options)
    if len(motors) > free:
        deciding = _deciding(whole, motors)
        notes.append(
            f"{len(motors)} coordinates are marked as actuated, and the linkage has "
            f"{counted(free, 'freedom')}: taken as motors are {', '.join(deciding)}; "
            f"--motors names others"
        )
        motors = deciding
    _refuse_too_few(robot, whole, motors)
    for chosen in _serial_sets(group, motors, free):
        if _decide(whole, chosen):
            made = _checked(robot, Linkage(group.alone, motors, chosen), options)
            return Transmission(made.name, made.linkage, made.data, (*made.notes, *notes))
    raise InputError(
        f"{robot}: no serial way through the linkage of {', '.join(motors)} has joints "
        f"that decide the motors; name them (--joints)"
    )


def _deciding(whole: Linkage, names: tuple[str, ...]) -> tuple[str, ...]:
    """As many of the names as decide the motion together, the first ones that do so at the
    reference too.
    """
    chosen: list[str] = []
    for at in (True, False):
        for name in names:
            if _rank(whole, [*chosen, name], at_reference=at) > len(chosen):
                chosen.append(name)
    return tuple(name for name in names if name in chosen)


def _serial_sets(group: Group, motors: tuple[str, ...], free: int) -> Iterator[tuple[str, ...]]:
    """Names of joints that may stand for a serial limb, the likeliest first."""
    tried = 0
    for more in range(_MORE):
        for way in group.serial_ways(free + more):
            sets = sorted(
                combinations(way, free), key=lambda names: sum(n in motors for n in names)
            )
            for names in sets:
                if set(names) != set(motors) and tried < _MOST_TRIED:
                    tried += 1
                    yield names


def _rank(whole: Linkage, names: Sequence[str], *, at_reference: bool = False) -> int:
    """How many freedoms coordinates decide: at generic configurations, or at the reference."""
    values = whole.reference[None] if at_reference else whole.generic
    tangents = whole.tangents(values)[0][:, whole.places_of(names)]
    singular = np.linalg.svd(tangents, compute_uv=False)
    return int(np.sum(singular > _DECIDED, axis=1).max(initial=0))


def _decide(whole: Linkage, names: Sequence[str]) -> bool:
    """Whether coordinates decide the motion, at the reference too."""
    return all(_rank(whole, names, at_reference=at) == whole.mobility for at in (True, False))


def _checked(robot: str, linkage: Linkage, options: MotorOptions) -> Transmission:
    """The transmission of motors and joints. Raises InputError where these make none."""
    motors, joints, free = linkage.motors, linkage.joints, linkage.mobility
    _refuse_still(robot, linkage)
    _refuse_too_few(robot, linkage, motors)
    if len(joints) != free:
        several = "are" if len(joints) > 1 else "is"
        raise InputError(
            f"{robot}: {', '.join(joints)} {several} {counted(len(joints), 'joint')}, and the "
            f"linkage of {', '.join(motors)} has {counted(free, 'freedom')}; name as many joints "
            f"as freedoms"
        )
    if _rank(linkage, joints) < free:
        raise InputError(
            f"{robot}: the joints {', '.join(joints)} do not decide the motors "
            f"{', '.join(motors)}: some joints follow from others, and motions are left free"
        )
    here = States(linkage, linkage.reference[None])
    singular = [
        f" for the {what} {', '.join(names)}"
        for what, names in (("motors", motors), ("joints", joints))
        if _rank(linkage, names, at_reference=True) < free
    ]
    if singular or not (
        np.isfinite(here.jacobian).all() and np.isfinite(here.inverse_jacobian).all()
    ):
        raise InputError(
            f"{robot}: the reference configuration of the linkage of {', '.join(motors)} is "
            f"singular{''.join(singular[:1])}: "
            f"{here.lost(0)}; give another start (--start NAME=VALUE,...)"
        )
    notes = list[str]()
    if len(motors) > free:
        notes.append(
            f"{len(motors)} motors drive {counted(free, 'joint')}: of all torques of motors that "
            f"hold a joint torque the least are told, and rates of motors must agree"
        )
    over = linkage.beyond_limits(linkage.reference[None])[0] > 0.0
    beyond = [c.name for c, out in zip(linkage.limited, over, strict=True) if out]
    if beyond:
        notes.append(f"the reference is beyond the limits of {', '.join(beyond)}")
    wide = [c.name for c in linkage.mechanism.coordinates if c.limits and c not in linkage.limited]
    if wide:
        notes.append(
            f"the limits of {first_of(wide)} are more than two turns, and count as none; ranges "
            f"(--range NAME=LOW:HIGH) tells others"
        )
    data = read_motors(motors, options, motors_of_file(linkage.mechanism, motors))
    return Transmission(", ".join(joints), linkage, data, tuple(notes))


def _refuse_still(robot: str, linkage: Linkage) -> None:
    """Refuse loops that are open, and those that hold each other still."""
    if linkage.system.residual(linkage.reference, np.zeros(0)) > _OPEN * linkage.size:
        raise InputError(
            f"{robot}: its loops are open at the reference configuration; `symkin close` closes "
            f"them"
        )
    if not linkage.mobility:
        names = list(dict.fromkeys([*linkage.motors, *linkage.joints]))
        raise InputError(
            f"{robot}: the linkage of {first_of(names)} cannot move: its loops leave no "
            f"freedom, so that no motor can drive it"
        )


def _refuse_too_few(robot: str, linkage: Linkage, motors: tuple[str, ...]) -> None:
    free = linkage.mobility
    left = free - _rank(linkage, motors)
    if left > 0:
        others = [
            c.name
            for c in linkage.problem.closure.coordinates
            if c.name not in motors and not c.is_rotation and c.role in ("actuated", "passive")
        ]
        binding: list[str] = []
        for name in others:
            if _rank(linkage, [*motors, *binding, name]) > free - left + len(binding):
                binding.append(name)
        remedy = (
            f"what would bind them: {', '.join(binding)} (springs are named among the motors)"
            if binding
            else "no other joint moves with them, whose coordinate would bind them"
        )
        raise InputError(
            f"{robot}: the motors {', '.join(motors)} do not decide the joints: their linkage has "
            f"{counted(free, 'freedom')}, and {left} {'stay' if left > 1 else 'stays'} free; "
            f"{remedy}"
        )
