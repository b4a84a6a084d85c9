"""Results as text for terminals."""

from __future__ import annotations

import io
import shutil
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from symkin.position.solution import Modes, Solution, SolveResult

_MOST_ROWS = 64


def modes_text(modes: Modes) -> str:
    """The modes as a table, and what is known of their completeness."""
    mechanism = modes.problem.mechanism
    heading = mechanism.name + (f" ({mechanism.title})" if mechanism.title else "")
    lines = [f"{heading}: {modes.problem.kind} problem, {_given(modes.given)}"]
    if modes.modes:
        shown = list(modes.modes) if len(modes) <= _MOST_ROWS else modes.representatives[:_MOST_ROWS]
        lines.append(_render(_table(modes.problem.kind, shown)))
        if len(shown) < len(modes):
            lines.append(f"one of the modes at each of {len(shown)} poses of {modes.poses}; all {len(modes)} modes with --json")
    lines.append(_statement(modes))
    lines.extend(f"note: {note}" for note in modes.notes)
    return "\n".join(lines)


def solve_text(result: SolveResult) -> str:
    """One solution with its checks, or the status with its remedy."""
    mechanism = result.problem.mechanism
    lines = [f"{mechanism.name}: {result.problem.kind} problem, {_given(result.given)}"]
    if result.solution is not None:
        lines.append(_render(_table(result.problem.kind, [result.solution])))
        s = result.solution
        lines.append(
            f"ok after {result.iterations} iterations ({result.method}); closure error {s.residual:.1e} "
            f"{mechanism.length_unit}, condition {s.condition:.3g}"
        )
    else:
        lines.append(result.message)
    lines.extend(f"note: {note}" for note in result.notes)
    return "\n".join(lines)


def _statement(modes: Modes) -> str:
    """Count, completeness and what it rests on."""
    unit = modes.problem.mechanism.length_unit
    count, poses = len(modes), modes.poses
    head = f"{count} {_plural('mode', count)}" + (f" at {poses} {_plural('pose', poses)}" if poses != count else "")
    head = head if count else "no isolated solution" if modes.positive_dimensional else "no real solution"
    parts = [f"{head}; completeness: {modes.completeness}"]
    if modes.complex_count is not None and modes.method != "forward":
        parts.append(f"{modes.complex_count} complex solutions, {modes.unresolved_paths} unresolved paths")
    certified = [mode for mode in modes if mode.certified]
    if certified:
        radius = max(mode.radius or 0.0 for mode in certified)
        every = "each mode" if len(certified) == count else f"{len(certified)} of them"
        parts.append(f"{every} certified to {radius:.1e} {unit}")
    if modes.engine is not None:
        parts.append(f"engine: {modes.engine}")
    if modes.estimated_unseen is not None and count:
        parts.append(
            f"{modes.starts} starts, seed {modes.seed}; estimated still unseen: {modes.estimated_unseen:.3g} or more (Chao), "
            f"chance that the next hit is new: {modes.next_new:.2g} (Good-Turing)"
        )
    elif modes.starts and not count:
        parts.append(f"{modes.starts} starts, seed {modes.seed}")
    if modes.smallest_residual is not None:
        parts.append(f"smallest closure error reached: {modes.smallest_residual:.4g} {unit}")
    return "; ".join(parts)


def _table(kind: str, solutions: list[Solution]) -> Table:
    mechanism = solutions[0].mechanism
    table = Table(box=None, pad_edge=False, show_edge=False)
    table.add_column("#", justify="right")
    columns = _joint_columns(kind, solutions) if kind == "inverse" or mechanism.serial else _pose_columns(solutions)
    if kind == "direct" and mechanism.serial:
        columns = _pose_columns(solutions)
    elif kind == "direct":
        columns |= _joint_columns(kind, solutions)
    if any(s.within_limits is not None for s in solutions):
        columns["limits"] = ["inside" if s.within_limits else "outside" for s in solutions]
    columns["condition"] = [f"{s.condition:.3g}" for s in solutions]
    if all(s.hits is not None for s in solutions):
        columns["hits"] = [str(s.hits) for s in solutions]
    for name in columns:
        table.add_column(name, justify="right", no_wrap=True)
    for k in range(len(solutions)):
        table.add_row(str(k + 1), *(values[k] for values in columns.values()))
    return table


def _pose_columns(solutions: list[Solution]) -> dict[str, list[str]]:
    mechanism = solutions[0].mechanism
    unit = mechanism.length_unit
    columns = {f"{axis}, {unit}": [_length(mechanism.size, s.position[i]) for s in solutions] for i, axis in enumerate("xyz")}
    if mechanism.motion in ("schoenflies", "planar"):
        values = [mechanism.angle_out(s.values["pose.gamma"]) for s in solutions]
        return columns | {f"gamma, {mechanism.angle_unit}": [_fixed(v, 3) for v in values]}
    if mechanism.motion == "translation":
        return columns
    return columns | {name: [_fixed(s.quaternion[i], 5) for s in solutions] for i, name in enumerate(("qw", "qx", "qy", "qz"))}


def _joint_columns(kind: str, solutions: list[Solution]) -> dict[str, list[str]]:
    """Joint coordinates; for a direct problem those that differ between the solutions."""
    mechanism = solutions[0].mechanism
    actuated = {c.name for c in mechanism.actuated}
    columns = {}
    for name in solutions[0].joints:
        values = [s.joints[name] for s in solutions]
        if kind == "direct" and name in actuated:
            continue
        if not isinstance(values[0], float):
            continue
        columns[name] = [_fixed(v, 3 if mechanism.size > 10 else 5) for v in values]
    return columns


def _length(size: float, value: float) -> str:
    return _fixed(value, 3 if size > 10 else 6)


def _fixed(value: float, digits: int) -> str:
    """Fixed digits without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _given(given: dict[str, list[float]]) -> str:
    return "; ".join(f"{key} {', '.join(f'{v:.7g}' for v in values)}" for key, values in given.items())


def _plural(word: str, count: int) -> str:
    return word if count == 1 else word + "s"


def _render(table: Table) -> str:
    width = max(shutil.get_terminal_size((120, 40)).columns, _natural_width(table))
    buffer = io.StringIO()
    Console(file=buffer, width=width, highlight=False, markup=False, emoji=False).print(table)
    return "\n".join(line.rstrip() for line in buffer.getvalue().rstrip().splitlines())


def _natural_width(table: Table) -> int:
    from rich.measure import Measurement

    console = Console(width=10_000, markup=False, emoji=False)
    return Measurement.get(console, console.options, table).maximum
