"""Solutions as rows of a table: pose or joints, limits, condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symkin.position.solution import Solution


def solution_columns(kind: str, solutions: Sequence[Solution]) -> tuple[list[str], list[list[str]]]:
    """Header and rows for the solutions of one problem of a `kind`; both are empty where there is no solution."""
    if not solutions:
        return [], []
    columns = {"#": [str(k + 1) for k in range(len(solutions))], **_coordinate_columns(kind, solutions)}
    if any(s.within_limits is not None for s in solutions):
        columns["limits"] = ["inside" if s.within_limits else "outside" for s in solutions]
    columns["condition"] = [f"{s.condition:.3g}" for s in solutions]
    if all(s.hits is not None for s in solutions):
        columns["hits"] = [str(s.hits) for s in solutions]
    return list(columns), [list(row) for row in zip(*columns.values(), strict=True)]


def _coordinate_columns(kind: str, solutions: Sequence[Solution]) -> dict[str, list[str]]:
    """What differs between the solutions: joints of an inverse problem, pose and passive joints of a direct one."""
    serial = solutions[0].mechanism.serial
    if kind == "inverse":
        return _joint_columns(kind, solutions)
    return _pose_columns(solutions) | ({} if serial else _joint_columns(kind, solutions))


def _pose_columns(solutions: Sequence[Solution]) -> dict[str, list[str]]:
    mechanism = solutions[0].mechanism
    unit = mechanism.length_unit
    columns = {
        f"{axis}, {unit}": [_length(mechanism.characteristic_length, s.position[i]) for s in solutions]
        for i, axis in enumerate("xyz")
    }
    if mechanism.motion in ("schoenflies", "planar"):
        values = [mechanism.angle_out(s.values["pose.gamma"]) for s in solutions]
        return columns | {f"gamma, {mechanism.angle_unit}": [_fixed(v, 3) for v in values]}
    if mechanism.motion == "translation":
        return columns
    return columns | {name: [_fixed(s.quaternion[i], 5) for s in solutions] for i, name in enumerate(("qw", "qx", "qy", "qz"))}


def _joint_columns(kind: str, solutions: Sequence[Solution]) -> dict[str, list[str]]:
    """Joint coordinates that are one number; for a direct problem the passive ones."""
    mechanism = solutions[0].mechanism
    given = {c.name for c in mechanism.actuated} if kind == "direct" else set()
    digits = 3 if mechanism.characteristic_length > 10 else 5
    rows = [s.joints for s in solutions]
    names = [name for name, value in rows[0].items() if name not in given and isinstance(value, float)]
    return {name: [_fixed(row[name], digits) for row in rows] for name in names}


def _length(size: float, value: float) -> str:
    return _fixed(value, 3 if size > 10 else 6)


def _fixed(value: float, digits: int) -> str:
    """Fixed digits without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def given_text(given: Mapping[str, Sequence[float]]) -> str:
    """The given values: `joints 1, 2, 3`."""
    return "; ".join(f"{key} {', '.join(f'{v:.7g}' for v in values)}" for key, values in given.items())
