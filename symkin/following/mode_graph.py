"""Find which assembly modes connect without a singularity, over a slice of one or two inputs: a
graph of modes at grid points.

At each point of a grid all modes are enumerated; each mode is followed along the grid's lines (see
`track`), whose pieces between neighbouring points are the graph's edges.
Modes that a path without singularity joins are of one sheet. Two modes of one input on
one sheet are joined by a path that leaves the input and comes back to it on the other mode: it goes
round a cusp of the singularity locus (Innocenti and Parenti-Castelli 1998). The graph says only
what the grid's edges show: a finer grid can join more, and never parts what is joined.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import Any, Literal, Unpack

import numpy as np

from symkin.assembly.modes import modes, modes_on_grid
from symkin.assembly.modes_result import Modes
from symkin.errors import InputError
from symkin.following.follow import carried
from symkin.following.machine_path import MachinePath, machine_path
from symkin.following.meeting_modes import listed_unknowns, nearest_mode
from symkin.following.options import GraphOptions
from symkin.following.track import branch_from
from symkin.following.trajectory import Trajectory, make_trajectory
from symkin.model.joined import Joined, back, tree_from
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import Joints, Values, given_by_name, read_given
from symkin.position.problem import are_of_limbs
from symkin.result import Result, Summary, json_fields
from symkin.text import meant
from symkin.verb import verb

_MOST_POINTS = 10_000
"""Grid points at most."""
_BATCH = 256
"""Inputs whose modes are found together."""

_MOST_TOGETHER = 2048
"""Modes that are followed together."""

Node = tuple[int, int]
"""A grid point's number (row-major, the first axis slowest; the chosen input is the last one) and a
mode's number there.
"""
Carried = tuple[Node, Node | Literal["stopped", "unmatched"], bool]
"""A node, the one that it is carried to, or why there is none, and whether that is proved."""


@dataclass(frozen=True)
class Axis:
    """A known coordinate and its range, in its unit."""

    name: str
    low: float
    high: float


@dataclass(frozen=True, eq=False, repr=False)
class ModeGraph(Result):
    """Which modes connect without a singularity; made by `mode_graph`.

    `found` holds the modes at each grid point and, last, at the chosen input; `names` are the known
    coordinates, the actuated joints unless others are told by name, `inputs` (n * n + 1, names; n +
    1 over one axis) their values in the mechanism's units; `edges` pairs of nodes that were joined;
    `sheets` the connected sets of nodes, largest first; `certified` whether every joined edge is
    proved; `stopped` counts the modes that an edge did not carry on, `unmatched` those that it
    carried to a configuration which the enumeration at its other end lacks (0 where the lists are
    complete). `path` gives the joint values that lead from one mode to another, `plot()` draws the
    sheets.

    >>> import symkin
    >>> platform = symkin.load("zhao2000")
    >>> graph = symkin.mode_graph(platform, [("theta1", 80.0, 82.0), ("op", 105.0, 106.0)], 2)
    >>> len(graph.chosen), graph.groups
    (4, [[0], [1], [2], [3]])
    """

    mechanism: Mechanism
    axes: tuple[Axis, ...]
    n: int
    names: tuple[str, ...]
    inputs: np.ndarray
    found: tuple[Modes, ...]
    edges: tuple[tuple[Node, Node], ...]
    sheets: tuple[frozenset[Node], ...]
    certified: bool
    stopped: int
    unmatched: int

    @property
    def chosen(self) -> Modes:
        """The modes at the chosen input."""
        return self.found[-1]

    @property
    def groups(self) -> list[list[int]]:
        """The numbers (from 0) of the chosen input's modes, those that connect without a
        singularity together.
        """
        last = len(self.found) - 1
        here = (sorted(k for point, k in sheet if point == last) for sheet in self.sheets)
        return sorted(filter(None, here))

    def path(self, begin: int, end: int) -> np.ndarray | None:
        """Known values (m, names) along edges from mode `begin` of the chosen input back to it on
        mode `end`; None where the graph does not join them.
        """
        last = len(self.found) - 1
        for k in (begin, end):
            if not 0 <= k < len(self.chosen):
                raise InputError(
                    f"mode {k} is unknown; the chosen input has modes 0 to {len(self.chosen) - 1}"
                )
        tree = tree_from(self.edges, (last, begin))
        if (last, end) not in tree:
            return None
        points = [last, *(point for _, (point, _) in back(tree, (last, end)))]
        rows = self.inputs[points[::-1]]
        moved = np.any(np.diff(rows, axis=0) != 0.0, axis=1)
        return rows[np.append(True, moved)]

    def to_dict(self) -> dict[str, Any]:
        last = self.inputs[-1].tolist()
        plain = are_of_limbs(self.mechanism, self.names)
        return {
            "mechanism": self.mechanism.name,
            "axes": [[a.name, a.low, a.high] for a in self.axes],
            "n": self.n,
            **({"joints": last} if plain else {"given": dict(zip(self.names, last, strict=True))}),
            "counts": [len(found) for found in self.found[:-1]],
            "sheets": [[list(node) for node in sorted(sheet)] for sheet in self.sheets],
            **json_fields(self, "groups", "certified", "stopped", "unmatched"),
        }

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - there is no table
        """Counts of points, modes, sheets and edges, and the chosen input's modes that connect."""
        named = ", ".join(f"{a.name} {a.low:g} to {a.high:g}" for a in self.axes)
        groups = "; ".join(" and ".join(str(k + 1) for k in group) for group in self.groups)
        proved = "each proved in ball arithmetic" if self.certified else "not proved"
        text = (
            f"{self.mechanism.name}: {' x '.join(str(self.n) for _ in self.axes)} points over "
            f"{named}: {sum(map(len, self.found[:-1]))} modes on "
            f"{len(self.sheets)} sheets, {len(self.edges)} edges without a singularity ({proved}); "
            f"modes of the chosen input that "
            f"connect without a singularity: {groups or 'none'}"
        )
        missing = (
            f"; {self.unmatched} followed modes are missing in the enumeration"
            if self.unmatched
            else ""
        )
        return Summary([text + missing])


@verb(GraphOptions)
def mode_graph(
    mechanism: Mechanism,
    axes: Sequence[Axis | tuple[str, float, float]],
    n: int,
    **options: Unpack[GraphOptions],
) -> ModeGraph:
    """Find which modes connect without a singularity over one or two known coordinates: their graph
    on n or n x n points.

    Nodes are the modes at each point, found by complete enumeration; edges join those that `track`
    carries from one point to its neighbour without a singularity. Modes of the chosen input that
    are on one connected set of nodes can be exchanged without a singularity (Innocenti and
    Parenti-Castelli 1998); a finer grid can join more, and never parts what is joined.

    `axes` are one or two actuated joints, each with a range in its unit, `n` (2 to 100) the points
    along each. `joints` is the chosen input, in file order or by name, and holds the other joints
    (default: the example's, else the reference's); or `given`, values of any coordinates by name,
    as many as the mobility, of which the axes are then one or two. Joint limits are left out of
    account. `progress` is called with the points and lines done and their number. Raises
    InputError.

        >>> from symkin import Joint, Limb, Mechanism, mode_graph
        >>> z = (0, 0, 1)
        >>> left = [Joint("q1", "R", (0, 0, 0), z, actuated=True), Joint("a", "R", (0, 60, 0), z)]
        >>> right = [Joint("q2", "R", (90, 0, 0), z, actuated=True)]
        >>> right += [Joint("b", "R", (90, 60, 0), z), Joint("c", "R", (45, 120, 0), z)]
        >>> limbs, tip = [Limb("left", left), Limb("right", right)], (45, 120, 0)
        >>> five_bar = Mechanism("five_bar", limbs, tip, motion="planar", angle_unit="deg")
        >>> graph = mode_graph(five_bar, [("q1", -10, 10), ("q2", -10, 10)], 2)
        >>> graph.groups, graph.certified   # tip above or below the elbows, parted by a singularity
        ([[0], [1]], True)
    """
    joints, given, progress = options["joints"], options["given"], options["progress"]
    require_mechanism(mechanism)
    if mechanism.serial and (given is None or are_of_limbs(mechanism, tuple(given))):
        raise InputError(
            f"{mechanism.name} is a serial arm: its joint values have one assembly mode, and there "
            f"is nothing to join"
        )
    names, chosen = _chosen_input(mechanism, joints, given)
    pair = _checked(mechanism, axes, n, names)
    inputs = _grid(names, pair, n, chosen)
    lines = _lines(n, inputs, pair, names)
    total, found = len(inputs) + len(lines), list[Modes]()
    for first in range(0, len(inputs) - 1, _BATCH):
        columns = inputs[first : min(first + _BATCH, len(inputs) - 1)].T.tolist()
        found += modes_on_grid(mechanism, dict(zip(names, columns, strict=True)))
        if progress is not None:
            progress(len(found), total)
    # of the chosen input least errors are told too
    found.append(modes(mechanism, given=dict(zip(names, inputs[-1].tolist(), strict=True))))
    edges: list[tuple[Node, Node]] = []
    certified, stopped, unmatched = True, 0, 0
    for done, ends in _carried(mechanism, names, inputs, found, lines):
        for node, end, proved in ends:
            stopped += end == "stopped"
            unmatched += end == "unmatched"
            if not isinstance(end, str):
                edges.append((node, end))
                certified = certified and proved
        if progress is not None:
            progress(len(inputs) + done, total)
    nodes = [(p, k) for p, modes_there in enumerate(found) for k in range(len(modes_there))]
    return ModeGraph(
        mechanism=mechanism,
        axes=pair,
        n=n,
        names=names,
        inputs=inputs,
        found=tuple(found),
        edges=tuple(edges),
        sheets=_sheets(nodes, edges),
        certified=certified,
        stopped=stopped,
        unmatched=unmatched,
    )


def _carried(
    mechanism: Mechanism,
    names: Sequence[str],
    inputs: np.ndarray,
    found: Sequence[Modes],
    lines: Sequence[Sequence[int]],
) -> Iterator[tuple[int, list[Carried]]]:
    """What each mode of each point of the lines becomes at the next one, for many lines together,
    and how many lines are done.
    """
    paths = [_path(mechanism, names, inputs[list(line)]) for line in lines]
    unknowns = [listed_unknowns(paths[0], there) for there in found]
    ways_out: list[_WayOut] = []
    for done, (line, path) in enumerate(zip(lines, paths, strict=True), start=1):
        ways_out += [
            _WayOut(path.trajectory, row, (a, k), b)
            for row, (a, b) in enumerate(pairwise(line))
            for k in range(len(found[a]))
        ]
        if len(ways_out) >= _MOST_TOGETHER or done == len(lines):
            yield done, _ends(unknowns, ways_out)
            ways_out = []


@dataclass(frozen=True, eq=False)
class _WayOut:
    """From a node to a neighbouring point, over an interval of a path."""

    path: Trajectory
    row: int
    node: Node
    to: int

    def alone(self) -> Trajectory:
        """The interval as a path of its own."""
        return replace(self.path, samples=self.path.samples[self.row : self.row + 2])


def _ends(unknowns: Sequence[np.ndarray], ways_out: Sequence[_WayOut]) -> list[Carried]:
    """What the modes become, those that are easy to follow all at once, the others one by one."""
    if not ways_out:
        return []
    problem = ways_out[0].path.problem
    begin = np.array([unknowns[w.node[0]][w.node[1]] for w in ways_out])
    begin = begin.reshape(len(ways_out), problem.system.width)
    samples = [(w.path.samples[w.row], w.path.samples[w.row + 1]) for w in ways_out]
    there = carried(problem, begin, samples)
    end = there.end
    ends: list[Carried] = []
    for k, w in enumerate(ways_out):
        proved = bool(there.suffices[k])
        if not there.reached[k]:
            branch = branch_from(begin[k], w.alone(), limits=False, known=there.steps_of(k))
            if branch.ending != "reached":
                ends.append((w.node, "stopped", False))
                continue
            end[k], proved = branch.last.unknown, branch.proves_pieces
        number = nearest_mode(problem, unknowns[w.to], end[k])
        ends.append((w.node, "unmatched" if number is None else (w.to, number), proved))
    return ends


def _path(mechanism: Mechanism, names: Sequence[str], rows: np.ndarray) -> MachinePath:
    """The path along a line of points."""
    given = dict(zip(names, rows.T.tolist(), strict=True))
    return machine_path(make_trajectory(mechanism, given=given, limits=False))


def _chosen_input(
    mechanism: Mechanism, joints: Joints | None, given: Values | None
) -> tuple[tuple[str, ...], np.ndarray]:
    """The known coordinates and their values at the chosen input, in the mechanism's units."""
    if given is None:
        chosen = np.array(read_given(mechanism, joints, None).echo.get("joints", []))
        if not len(chosen):
            raise InputError(
                f"joints: the example of {mechanism.name} gives a pose; give all actuated joints"
            )
        return tuple(c.name for c in mechanism.actuated), chosen
    if joints is not None:
        raise InputError("given: values by name and joints beside them; give one of them")
    read = given_by_name(mechanism, given)
    if "pose" in read.echo:
        raise InputError(
            "given: a whole pose is no coordinate of a graph of modes; give x, y, z, azimuth, tilt "
            "and torsion"
        )
    return tuple(read.echo), np.array(list(read.echo.values()))


def _checked(
    mechanism: Mechanism,
    axes: Sequence[Axis | tuple[str, float, float]],
    n: int,
    names: tuple[str, ...],
) -> tuple[Axis, ...]:
    for axis in axes:
        if not isinstance(axis, Axis) and len(axis) != 3:
            raise InputError(
                f"axes: {axis!r}; a name and a range are needed, as in ('q1', 0.0, 90.0)"
            )
    chosen = tuple(axis if isinstance(axis, Axis) else Axis(*axis) for axis in axes)
    if len(chosen) not in (1, 2) or len({axis.name for axis in chosen}) < len(chosen):
        raise InputError(
            f"axes: {len(chosen)} given; one or two different known coordinates are needed, each "
            f"with a range"
        )
    for axis in chosen:
        if axis.name not in names:
            raise InputError(
                f"axes: {axis.name!r} is no known coordinate of "
                f"{mechanism.name}{meant(axis.name, names)}; allowed: {', '.join(names)}"
            )
        if not (np.isfinite([axis.low, axis.high]).all() and axis.low < axis.high):
            raise InputError(
                f"axes: the range {axis.low} to {axis.high} of {axis.name} is none; low below high "
                f"is needed"
            )
    if n < 2 or n * n > _MOST_POINTS:
        raise InputError(
            f"n = {n} points along a range (--points); allowed: 2 to {int(_MOST_POINTS**0.5)}"
        )
    return chosen


def _grid(names: tuple[str, ...], axes: tuple[Axis, ...], n: int, chosen: np.ndarray) -> np.ndarray:
    """Known values at the grid points, then the chosen ones."""
    points = list(product(*(np.linspace(axis.low, axis.high, n) for axis in axes)))
    inputs = np.tile(chosen, (len(points) + 1, 1))
    inputs[:-1, [names.index(axis.name) for axis in axes]] = points
    return inputs


def _lines(
    n: int, inputs: np.ndarray, axes: tuple[Axis, ...], names: tuple[str, ...]
) -> list[tuple[int, ...]]:
    """The grid's lines along each axis, then the one from the chosen input to the nearest grid
    point.
    """
    grid = np.arange(len(inputs) - 1).reshape(-1, n)
    lines = [*grid, *grid.T] if len(axes) == 2 else [*grid]
    columns = [names.index(axis.name) for axis in axes]
    away = np.abs(inputs[:-1, columns] - inputs[-1, columns]) / [
        axis.high - axis.low for axis in axes
    ]
    nearest = int(np.argmin(away.sum(axis=1)))
    return [*(tuple(line.tolist()) for line in lines), (len(inputs) - 1, nearest)]


def _sheets(nodes: list[Node], edges: list[tuple[Node, Node]]) -> tuple[frozenset[Node], ...]:
    """Connected components, the largest first."""
    joined, sheets = Joined[Node](), dict[Node, list[Node]]()
    for pair in edges:
        joined.join(*pair)
    for node in nodes:
        sheets.setdefault(joined.head(node), []).append(node)
    return tuple(sorted(map(frozenset, sheets.values()), key=lambda s: (-len(s), min(s))))
