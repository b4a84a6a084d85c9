"""Read values of coordinates that are given by name: joints, passive ones too, and coordinates of
the platform's pose.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symkin.closure.partition import POSE_COORDINATES
from symkin.errors import InputError
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import Given, given_from, given_many, number_of, refuse_negative_rod
from symkin.position.problem import Kind, Problem, build_problem
from symkin.spatial.pose import Pose
from symkin.text import meant, shown

Values = Mapping[str, float | Sequence[float]]
Columns = Mapping[str, float | Sequence[float] | Sequence[Sequence[float]] | np.ndarray]
"""Values by name of many inputs: columns, and one value where all inputs have the same."""


def given_by_name(mechanism: Mechanism, values: Values) -> Given:
    """The known values of a problem from values by name, in the mechanism's units; "pose" is x, y,
    z, qw, qx, qy, qz as a whole. Raises InputError for a name that nothing has and a value that is
    none.
    """
    if not isinstance(values, Mapping):
        raise InputError(
            f"given = {shown(str(values))} has no names; values by name are needed, as in "
            f"given={{'crank': 60.0}}"
        )
    whole = (
        given_from(mechanism, None, values["pose"]) if is_whole_pose(mechanism, values) else None  # type: ignore[arg-type]
    )
    names = [] if whole is None else list(pose_names(mechanism))
    numbers = [] if whole is None else whole.values.tolist()
    coordinates = given_coordinates(mechanism)
    for name, value in values.items():
        if name == "pose" and whole is not None:
            continue
        if name not in coordinates:
            raise InputError(unknown_name(mechanism, name, list(coordinates)))
        names.append(name)
        numbers.append(_number(mechanism, coordinates[name], value))
    clash = sorted(set(names) & set(POSE_CONDITIONS)) if whole is not None else []
    if clash:
        raise InputError(
            f"given: the whole pose and {', '.join(clash)} beside it; give one or the other"
        )
    single = {name: v for name, v in values.items() if name != "pose" or whole is None}
    echo: dict[str, Any] = {name: float(v) for name, v in single.items()}  # type: ignore[arg-type]
    if whole is not None:
        return replace(
            whole,
            kind="given",
            values=np.array(numbers),
            names=tuple(names),
            echo=whole.echo | echo,
        )
    return Given("given", np.array(numbers), echo, tuple(names))


def is_whole_pose(mechanism: Mechanism, values: Values) -> bool:
    """Whether values by name hold the platform's pose as a whole."""
    return (
        "pose" in values
        and "pose" not in given_coordinates(mechanism)
        and mechanism.platform_link is not None
    )


def pose_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the coordinates of the platform's pose."""
    return tuple(f"pose.{name}" for name, _ in POSE_COORDINATES[mechanism.motion])


def named_given(mechanism: Mechanism, joints: Any, pose: Any, given: Values | None) -> Given:
    """What is given of a mechanism whose coordinates are told by name: `given`, or all actuated
    joints, or the whole pose.
    """
    require_mechanism(mechanism)
    given = _of_example(mechanism, joints, pose, given)
    if given is not None:
        if joints is not None or pose is not None:
            raise InputError(
                "given: values by name and joints or a pose beside them; give one of them"
            )
        return given_by_name(mechanism, given)
    if joints is None and pose is None and mechanism.example is None and not mechanism.actuated:
        return Given("given", np.zeros(0), {})
    if pose is not None and mechanism.platform_link is None:
        raise InputError(
            f"pose: {mechanism.name} has no platform link; name it by [platform] link in its "
            f"mechanism file, of a robot's file by --platform LINK, or give joints"
        )
    return told_by_name(mechanism, given_from(mechanism, joints, pose))


def told_by_name(mechanism: Mechanism, given: Given) -> Given:
    """The same values of all actuated joints, or of the whole pose, with the names of their
    coordinates.
    """
    names = tuple(c.name for c in mechanism.actuated) if given.of_joints else pose_names(mechanism)
    return replace(given, kind="given", names=names)


def given_coordinates(mechanism: Mechanism) -> dict[str, Coordinate]:
    """What can be given: coordinates of joints, actuated rods, and those of the pose that no joint
    has the name of.
    """
    found = {c.name: c for c in mechanism.coordinates if not c.is_rotation}
    if mechanism.platform_link is not None:
        pose = {
            n: Coordinate(n, "length" if n in ("x", "y", "z") else "angle", "given")
            for n in POSE_CONDITIONS
        }
        found = pose | found
    return found


def unknown_name(mechanism: Mechanism, name: str, known: list[str], what: str = "given") -> str:
    """A sentence about a name that no coordinate has, with the nearest ones."""
    return (
        f"{what}: {mechanism.name} has no coordinate {shown(name)}{meant(name, known)}; allowed: "
        f"{', '.join(known)}"
    )


def _number(mechanism: Mechanism, c: Coordinate, value: Any) -> float:
    number = number_of(value, f"given: {c.name}")
    refuse_negative_rod(mechanism, c, number, "given")
    return mechanism.value_in(c, number)


def plain_kind(mechanism: Mechanism, names: Collection[str]) -> Kind | None:
    """ "direct" or "inverse" where known coordinates are all actuated joints or the whole pose of
    limbs; None for any others, and for a graph.
    """
    if mechanism.is_graph:
        return None
    actuated = {c.name for c in mechanism.actuated}
    whole = list(names) == ["pose"] and "pose" not in given_coordinates(mechanism)
    if whole or (names and set(names) == set(pose_names(mechanism))):
        return "inverse"
    return "direct" if actuated and set(names) == actuated else None


def plain_case(
    mechanism: Mechanism, joints: Any, pose: Any, given: Values | None
) -> tuple[Any, Any] | None:
    """Joints and pose as they are given, or where the values by name are all actuated joints or the
    whole pose: the direct and the inverse problem of limbs. None for any other values, and for a
    graph.
    """
    if mechanism.is_graph:
        return None
    given = _of_example(mechanism, joints, pose, given)
    if given is None:
        return joints, pose
    if joints is not None or pose is not None or not isinstance(given, Mapping):
        return None
    kind = plain_kind(mechanism, list(given))
    if kind == "inverse":
        return (None, given["pose"]) if "pose" in given else None
    return (given, None) if kind == "direct" else None


def _of_example(
    mechanism: Mechanism, joints: Any, pose: Any, given: Values | None
) -> Values | None:
    """The values by name; where nothing is given those of the example, if it tells names."""
    example = mechanism.example
    if (
        given is not None
        or joints is not None
        or pose is not None
        or example is None
        or example.given is None
    ):
        return given
    return dict(example.given)


def problem_of_names(
    mechanism: Mechanism, names: tuple[str, ...], held: tuple[str, ...] = ()
) -> Problem:
    """The problem whose known coordinates have these names; `held` are others that a closure of
    names must hold.
    """
    kind = plain_kind(mechanism, names)
    return (
        build_problem(mechanism, "given", names, held)
        if kind is None
        else build_problem(mechanism, kind)
    )


def any_given(
    mechanism: Mechanism, joints: Any = None, pose: Any = None, given: Values | None = None
) -> Given:
    """What is given in any form: joints or a pose, which of limbs make the direct and the inverse
    problem, or values by name.
    """
    plain = plain_case(mechanism, joints, pose, given)
    return (
        named_given(mechanism, joints, pose, given)
        if plain is None
        else given_from(mechanism, *plain)
    )


def many_given(mechanism: Mechanism, joints: Any, pose: Any, given: Columns | None) -> list[Given]:
    """What is given of many inputs, as `any_given` has one: rows of joints or of poses, or by name
    a column or one value each.
    """
    if given is not None:
        return [any_given(mechanism, joints, pose, row) for row in rows_by_name(given)]
    if pose is not None and mechanism.platform_link is None:
        return [named_given(mechanism, joints, pose, None)]
    many = given_many(mechanism, joints, pose)
    plain = plain_case(mechanism, joints, pose, None) is not None
    return many if plain else [told_by_name(mechanism, one) for one in many]


def has_columns(given: Any) -> bool:
    """Whether values by name are those of several inputs: some are a column, of whole poses several
    rows.
    """
    return isinstance(given, Mapping) and any(map(_is_column, given, given.values()))


def _is_column(name: str, value: Any) -> bool:
    """Whether a value is one of each input: of whole poses several rows or poses."""
    several = not isinstance(value, Pose | str) and np.ndim(value) > 0
    if name != "pose" or not several:
        return several
    return np.ndim(value) > 1 or any(isinstance(one, Pose) or np.ndim(one) > 0 for one in value)


def rows_by_name(given: Mapping[str, Any], each: str = "an input") -> list[dict[str, Any]]:
    """Values by name of `each` input or sample; one value is that of all. Raises InputError for
    columns of different lengths.
    """
    lengths = {name: len(value) for name, value in given.items() if _is_column(name, value)}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputError(
            f"given: the columns have different counts of values ({told}); each needs one {each}"
        )
    columns = {
        name: list(value) if name in lengths else [value] * max(lengths.values())
        for name, value in given.items()
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def problem_of(mechanism: Mechanism, given: Given) -> Problem:
    """The problem for which values are given."""
    return build_problem(mechanism, given.kind, given.names)
