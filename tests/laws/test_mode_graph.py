"""The graph of assembly modes over a slice of two inputs, against what is known of planar
mechanisms.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from helpers.inside import Axis, build_problem
from helpers.laws import same_pose
from helpers.samples import five_bar, pieper
from symkin import (
    InputError,
    Joint,
    Limb,
    Mechanism,
    ModeGraph,
    Solution,
    mode_graph,
    modes,
    solve,
    track,
)


@pytest.fixture
def planar() -> Mechanism:
    return five_bar_in_its_plane()


@pytest.fixture
def graph() -> ModeGraph:
    return graph_of_the_five_bar()


@cache
def graph_of_the_five_bar() -> ModeGraph:
    return mode_graph(five_bar_in_its_plane(), [("q1", 40.0, 140.0), Axis("q2", 40.0, 140.0)], 3)


def five_bar_in_its_plane() -> Mechanism:
    """The five-bar of the samples with its motion declared, so that its rows are as many as its
    unknowns.
    """
    whole = five_bar()
    return Mechanism(
        whole.name,
        whole.limbs,
        platform_position=whole.platform_position,
        motion="planar",
        angle_unit=whole.angle_unit,
    )


@pytest.mark.slow
def test_the_two_modes_of_a_five_bar_do_not_connect(planar: Mechanism, graph: ModeGraph) -> None:
    """The two points at which the couplers' circles meet lie on either side of the line of elbows;
    they are one only on the singularity, which parts them: two sheets, mirror images point by
    point.
    """
    assert graph.groups == [[0], [1]]
    assert graph.path(0, 1) is None
    assert len(graph.sheets) == 2
    assert len(graph.sheets[0]) == len(graph.sheets[1])
    for sheet in graph.sheets:
        assert len({side(graph.found[point][mode]) for point, mode in sheet}) == 1


def side(solution: Solution) -> bool:
    """Whether the end point lies to the left of the line from elbow 1 to elbow 2."""
    q1, q2 = (math.radians(v) for v in solution.actuated_values)
    first = 60 * np.array([math.cos(q1), math.sin(q1)])
    second = np.array([100.0, 0.0]) + 60 * np.array([math.cos(q2), math.sin(q2)])
    line, end = second - first, solution.position[:2] - first
    return bool(line[0] * end[1] - line[1] * end[0] > 0)


@pytest.mark.slow
def test_every_edge_joins_modes_that_a_track_joins(planar: Mechanism, graph: ModeGraph) -> None:
    """Followed backwards, an edge leads from its second mode to its first."""
    for (a, i), (b, j) in graph.edges[::5]:
        back = track(planar, joints=graph.inputs[[b, a]], start=graph.found[b][j], name_modes=False)
        assert back.reached
        assert same_pose(
            back.end.solution.pose, graph.found[a][i].pose, planar.characteristic_length, 1e-7
        )


def test_a_path_of_the_graph_stays_on_one_mode(planar: Mechanism, graph: ModeGraph) -> None:
    """A path from a mode to itself is the input alone; sheets hold each node once."""
    assert graph.path(0, 0) is not None
    assert np.allclose(graph.path(0, 0), graph.inputs[-1:])
    nodes = [node for sheet in graph.sheets for node in sheet]
    assert len(nodes) == len(set(nodes)) == sum(len(found) for found in graph.found)


def test_points_without_solution_are_not_searched(planar: Mechanism) -> None:
    """Where the cranks are too far apart there is no mode, and the least closure error there, which
    takes long to find and which nobody reads, is not told; that of the chosen input is.
    """
    apart = mode_graph(planar, [("q1", 100.0, 170.0), ("q2", 10.0, 80.0)], 4, joints=[170.0, 10.0])
    empty = [found for found in apart.found[:-1] if not len(found)]
    assert empty
    assert all(found.smallest_residual is None for found in empty)
    assert not len(apart.chosen)
    assert apart.chosen.smallest_residual > 0.0
    for row, found in zip(apart.inputs[:-1], apart.found[:-1], strict=True):
        assert len(found) == len(modes(planar, joints=row.tolist()))


def test_the_graph_is_drawn_and_printed(graph: ModeGraph, tmp_path) -> None:
    """The picture is a PNG; the text and the JSON name groups and sheets."""
    figure = graph.plot(tmp_path / "graph.png", route=graph.path(0, 0))
    drawn = [
        tuple(c) for ax in figure.axes for dots in ax.collections for c in dots.get_facecolor()
    ]
    (legend,) = figure.legends
    assert {tuple(key.get_facecolor()[0]) for key in legend.legend_handles} == {*drawn}
    assert (tmp_path / "graph.png").read_bytes().startswith(b"\x89PNG")
    assert "2 sheets" in str(graph)
    assert graph.to_dict()["groups"] == [[0], [1]]


def test_a_way_round_a_cusp_leads_to_another_mode() -> None:
    """Of a planar 3-RPR: a closed path of its inputs, without a singularity, ends at another pose,
    whose determinant has the same sign (Innocenti and Parenti-Castelli 1998).
    """
    mechanism = three_rpr()
    corners = [(17.0, 14.0), (17.0, 32.0), (15.5, 32.0), (15.5, 14.0), (17.0, 14.0)]
    joints = [[14.98, *corner] for corner in corners]
    near = [-5.5, -13.9, 0.0, 1.0, 0.0, 0.0, -0.07]
    begin = solve(mechanism, joints=joints[0], start=near).solution
    followed = track(mechanism, joints=joints, start=begin, name_modes=False)
    assert followed.reached
    assert followed.certified
    end = followed.end.solution
    assert not same_pose(begin.pose, end.pose, mechanism.characteristic_length, 1e-2)
    assert sign(begin) == sign(end)


@pytest.mark.long
@pytest.mark.slow
def test_modes_of_a_planar_3_rpr_connect_round_a_cusp() -> None:
    """Six modes at one input, three of each sign of the determinant; two of one sign are joined by
    a path without singularity that comes back to the same input (Innocenti and Parenti-Castelli
    1998), and no edge changes the sign.
    """
    mechanism = three_rpr()
    graph = mode_graph(
        mechanism, [("l2", 14.0, 17.0), ("l3", 14.0, 32.0)], 3, joints=[14.98, 17.0, 14.0]
    )
    signs = {
        (p, k): sign(mode) for p, found in enumerate(graph.found) for k, mode in enumerate(found)
    }
    assert sorted(signs[len(graph.found) - 1, k] for k in range(6)) == [-1, -1, -1, 1, 1, 1]
    assert all(signs[a] == signs[b] for a, b in graph.edges)
    assert (
        len({(a, b[0]) for a, b in graph.edges})
        == len({(a[0], b) for a, b in graph.edges})
        == len(graph.edges)
    )
    assert graph.unmatched == 0
    joined = [group for group in graph.groups if len(group) > 1]
    assert joined
    begin, end = joined[0][:2]
    path = graph.path(begin, end)
    assert path is not None
    assert np.array_equal(path[0], path[-1])
    followed = track(mechanism, joints=path, start=graph.chosen[begin], name_modes=False)
    assert followed.reached
    assert followed.certified
    assert same_pose(
        followed.end.solution.pose, graph.chosen[end].pose, mechanism.characteristic_length, 1e-7
    )
    assert not same_pose(
        graph.chosen[begin].pose, graph.chosen[end].pose, mechanism.characteristic_length, 1e-2
    )


def sign(solution: Solution) -> int:
    """Sign of det dF/dX of the direct problem."""
    system = build_problem(solution.mechanism, "direct").system
    unknown = np.array([solution.values[c.name] for c in system.unknowns])
    _, jacobian = system.linearise_one(unknown, np.array(solution.actuated_values))
    return int(np.sign(np.linalg.det(jacobian)))


def three_rpr() -> Mechanism:
    """Planar 3-RPR: base joints (0, 0), (15.91, 0), (0, 10), platform triangle of sides 17.04,
    16.54, 20.84.
    """
    base = np.array([[0.0, 0.0], [15.91, 0.0], [0.0, 10.0]])
    a, b, c = 17.04, 16.54, 20.84
    x = (a * a + c * c - b * b) / (2 * a)
    ends = np.array([[0.0, 0.0], [a, 0.0], [x, math.sqrt(c * c - x * x)]]) + [3.0, 12.0]
    limbs = []
    for k, (p, q) in enumerate(zip(base, ends, strict=True), start=1):
        along = q - p
        length = float(np.linalg.norm(along))
        turn, end = (
            Joint(f"a{k}", "R", (*p, 0.0), (0, 0, 1)),
            Joint(f"c{k}", "R", (*q, 0.0), (0, 0, 1)),
        )
        slide = Joint(f"l{k}", "P", (*p, 0.0), (*(along / length), 0.0), actuated=True, zero=length)
        limbs.append(Limb(f"limb{k}", [turn, slide, end]))
    return Mechanism("three_rpr", limbs, platform_position=(3.0, 12.0, 0.0), motion="planar")


@pytest.mark.parametrize(
    ("axes", "n", "fragment"),
    [
        ([], 3, "one or two different known coordinates"),
        ([("q1", 0, 90), ("q1", 0, 90)], 3, "one or two different known coordinates"),
        ([("q1", 0, 90), ("b1", 0, 90)], 3, "'b1' is no known coordinate"),
        ([("q1", 90, 0), ("q2", 0, 90)], 3, "low below high"),
        ([("q1", 0, math.nan), ("q2", 0, 90)], 3, "low below high"),
        ([("q1", 0), ("q2", 0, 90)], 3, "a name and a range"),
        ([("q1", 0, 90), ("q2", 0, 90)], 1, "n = 1"),
    ],
)
def test_wrong_slices_are_refused(planar: Mechanism, axes: list, n: int, fragment: str) -> None:
    """One sentence with the offender and what is allowed."""
    with pytest.raises(InputError) as error:
        mode_graph(planar, axes, n)
    assert fragment in str(error.value)


def test_a_serial_arm_is_refused() -> None:
    """Its joint values have one assembly mode."""
    with pytest.raises(InputError, match="serial arm"):
        mode_graph(pieper(), [("q1", 0.0, 1.0), ("q2", 0.0, 1.0)], 3)
