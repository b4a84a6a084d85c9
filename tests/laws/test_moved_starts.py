"""A start where the closure's Jacobian loses rank is moved off it, and the result says so.

Laws: from a singular start every solver reaches a configuration that closes the loops, the note
names the rank that finite differences of the mechanism's own geometry have there and a start that
is not singular; regular starts and starts that solve the problem stay as they are.
"""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import begun, main, moved_starts, read_given
from helpers.laws import closes, same_pose
from helpers.samples import pieper
from symkin import Joint, Limb, Mechanism

SOLVERS = ["newton", "fast_newton", "ipopt"]
EXAMPLE = [15.0] * 6
"""Joint values of the Gluon page's example, degrees."""


def dh_product(q: np.ndarray) -> np.ndarray:
    """Tool pose of the Gluon-6L3 from its DH table, q in degrees."""
    T = np.eye(4)
    rows = zip(
        (0.0, -90.0, 0.0, -90.0, 0.0, 0.0),
        (105.03, 0, 0, 75.66, 80.09, 44.36),
        (0, -174.42, -174.42, 0, 0, 0),
        (90, 0, 0, 90, -90, 0),
        q,
        strict=True,
    )
    for offset, d, a, alpha, value in rows:
        t, u = np.radians(offset + value), np.radians(alpha)
        c, s, x, y = np.cos(t), np.sin(t), np.cos(u), np.sin(u)
        T = T @ [[c, -s * x, s * y, a * c], [s, c * x, -c * y, a * s], [0, y, x, d], [0, 0, 0, 1]]
    return T


def difference_singular_values(q: np.ndarray) -> np.ndarray:
    """Singular values of the arm's Jacobian (rotation; position over 400 mm) by central
    differences, largest 1.
    """
    columns, R, step = [], dh_product(q)[:3, :3], 1e-3
    for e in step * np.eye(6):
        dT = (dh_product(q + e) - dh_product(q - e)) / np.radians(2 * step)
        W = dT[:3, :3] @ R.T
        columns.append([W[2, 1], W[0, 2], W[1, 0], *(dT[:3, 3] / 400)])
    values = np.linalg.svd(np.array(columns), compute_uv=False)
    return values / values[0]


def moved(notes: tuple[str, ...]) -> tuple[str, np.ndarray]:
    """What the only note about a moved start calls it, and where the iteration began."""
    (note,) = [n for n in notes if "the iteration began at" in n]
    return note, np.array([float(v) for v in note.split()[-2].split(",")])


@pytest.mark.slow
@pytest.mark.parametrize("solver", in_gate(SOLVERS, ["fast_newton", "newton"]))
def test_the_example_of_the_gluon_page_from_zero_joints(solver):
    """The page's numeric inverse begins from zeros, where elbow, wrist and shoulder are singular at
    once.
    """
    arm = symkin.load("gluon_6l3")
    pose = symkin.solve(arm, joints=EXAMPLE).solution.pose
    for start in ([0.0] * 6, None, [1e-3] * 6):
        found = symkin.solve(arm, pose=pose, start=start, solver=solver)
        assert (
            np.abs(
                dh_product(np.array(found.solution.actuated_values)) - dh_product(np.array(EXAMPLE))
            ).max()
            < 1e-6
        )


@pytest.mark.parametrize(
    ("start", "rank"),
    [
        ([0] * 6, 3),
        ([0, 0, 0, 0, 10, 0], 4),
        ([0, 0, 10, 0, 0, 0], 5),
        ([40, 20, 0, 30, 40, 10], 5),
    ],
)
def test_the_note_names_the_rank_and_a_regular_start(start, rank):
    """The rank is that of finite differences of the DH product; the Jacobian at the start that is
    named has full rank.
    """
    arm = symkin.load("gluon_6l3")
    pose = symkin.solve(arm, joints=EXAMPLE).solution.pose
    assert np.sum(difference_singular_values(np.array(start, dtype=float)) > 1e-6) == rank
    note, named = moved(symkin.solve(arm, pose=pose, start=start).notes)
    assert f"the start is singular (the closure's Jacobian has rank {rank} of 6)" in note
    assert difference_singular_values(named)[-1] > 1e-3
    assert np.abs(named - start).max() < 100
    again = symkin.solve(arm, pose=pose, start=named)
    assert not any("singular" in n for n in again.notes)


@pytest.mark.slow
@pytest.mark.parametrize("solver", in_gate(SOLVERS, ["fast_newton", "newton"]))
def test_random_poses_from_zero_joints(solver):
    arm, rng = symkin.load("gluon_6l3"), np.random.default_rng(5)
    for q in rng.uniform(-180, 180, (12, 6)):
        pose = symkin.solve(arm, joints=q).solution.pose
        assert closes(arm, symkin.solve(arm, pose=pose, start=[0.0] * 6, solver=solver).solution)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_wrist_that_is_stretched(solver):
    """An arm by joints, its wrist's first and third axes in line."""
    arm, rng = pieper(), np.random.default_rng(1)
    for q in rng.uniform(-2, 2, (5, 6)):
        pose = symkin.solve(arm, joints=q).solution.pose
        assert closes(
            arm,
            symkin.solve(
                arm, pose=pose, start=[0.3, 0.4, 0.5, 0.2, 0.0, 0.1], solver=solver
            ).solution,
        )


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", ["zhang2009", "ren2008"])
def test_platforms_from_the_plane_of_their_base(name, solver):
    """Rods in one plane have rank 3 or less of 6 where all their joints lie in it; the solution is
    the direct problem's.
    """
    platform = symkin.load(name)
    pose = symkin.solve(platform).solution.pose if name == "zhang2009" else platform.reference_pose
    joints = symkin.solve(platform, pose=pose).solution.actuated_values
    flat = [*map(float, platform.platform_position[:2]), 0.0, 1.0, 0.0, 0.0, 0.0]
    found = symkin.solve(platform, joints=joints, start=flat, solver=solver)
    again = symkin.solve(platform, pose=found.solution.pose).solution
    assert np.allclose(again.actuated_values, joints, atol=1e-8 * platform.characteristic_length)


def test_a_moved_pose_is_named_as_a_pose():
    """A hexapod flat in its base: three rows of z, alpha, beta vanish, and the pose that is named
    has a height.
    """
    found = symkin.solve(symkin.load("zhang2009"), start=[0, 0, 0, 1, 0, 0, 0])
    note, pose = moved(found.notes)
    assert "rank 3 of 6" in note
    assert abs(pose[2]) > 1
    assert np.linalg.norm(pose[3:]) == pytest.approx(1.0, abs=1e-3)


def test_the_same_start_moves_to_the_same_place():
    arm = symkin.load("gluon_6l3")
    pose = symkin.solve(arm, joints=EXAMPLE).solution.pose
    one, two = (symkin.solve(arm, pose=pose, start=[0.0] * 6) for _ in range(2))
    assert one.notes == two.notes
    assert one.solution.values == two.solution.values


def test_a_start_that_solves_the_problem_stays():
    """The stretched arm's own pose: singular, no step, no note of a move; so by default too."""
    arm = symkin.load("gluon_6l3")
    pose = symkin.solve(arm, joints=[0.0] * 6).solution.pose
    for start in ([0.0] * 6, None):
        found = symkin.solve(arm, pose=pose, start=start)
        assert found.iterations == 0
        assert np.abs(found.solution.actuated_values).max() < 1e-6
        assert not any("began at" in n for n in found.notes)


def test_a_regular_start_stays():
    arm = symkin.load("gluon_6l3")
    pose = symkin.solve(arm, joints=EXAMPLE).solution.pose
    found = symkin.solve(arm, pose=pose, start=[10.0, 10.0, 20.0, 10.0, 20.0, 10.0])
    assert found.notes == ()
    assert found.history[0].values[:6] == pytest.approx(np.radians([10, 10, 20, 10, 20, 10]))


@pytest.mark.slow
@pytest.mark.parametrize("solver", in_gate(["newton", "ipopt"], ["newton"]))
def test_a_pose_out_of_reach_says_that_moves_led_nowhere(solver):
    """Ten arms away: infeasible whatever the start, and the note says what was tried and what to
    do.
    """
    arm = symkin.load("gluon_6l3")
    far = symkin.solve(
        arm, pose=[4000, 0, 0, 1, 0, 0, 0], start=[0.0] * 6, solver=solver, check=False
    )
    assert far.status == "infeasible"
    assert any(
        re.search(r"9 starts beside it led to no solution: give another start, or list all", n)
        for n in far.notes
    )
    with pytest.raises(symkin.SolveError, match="9 starts beside it"):
        symkin.solve(arm, pose=[4000, 0, 0, 1, 0, 0, 0], start=[0.0] * 6, solver=solver)


def test_moves_keep_limits():
    """A stretched elbow at its limit moves inwards only."""
    joints = [
        Joint(
            j.name,
            "R",
            j.point,
            j.axis,
            actuated=True,
            limits=(0.0, 1.0) if j.name == "q5" else None,
        )
        for _, j in pieper().joints
    ]
    arm = Mechanism("arm", [Limb("arm", joints)], serial=True, platform_position=(90.0, 0.0, 220.0))
    given = read_given(
        arm, None, symkin.solve(arm, joints=[0.3, 0.2, 0.4, 0.1, 0.5, 0.6]).solution.pose
    )
    problem, start = begun(arm, given, [0.0] * 6)
    starts = moved_starts(problem, start, given.values)
    (place,) = [
        s
        for c, s in zip(problem.system.unknowns, problem.system.slices, strict=True)
        if c.name == "q5"
    ]
    assert len(starts) == 9
    assert starts[:, place].min() > 0
    assert starts[:, place].max() <= 1


def test_singular_poses_are_classified_where_the_start_means_them():
    """A pose printed to three digits and the singular joints that it belongs to: `singularities`
    stays at the stretched elbow and the aligned wrist, though the start is singular; 0.1 deg is
    what the digits leave.
    """
    arm, joints = symkin.load("gluon_6l3"), [0.0, 20.0, 0.0, 30.0, 0.0, 10.0]
    pose = symkin.solve(arm, joints=joints).solution.pose
    printed = np.round([*pose.position, *pose.quaternion], 3)
    found = symkin.singularity(arm, pose=printed, start=joints)
    assert found.is_singular
    assert found.solution.actuated_values == pytest.approx(joints, abs=0.15)
    assert same_pose(found.solution.pose, pose, arm.characteristic_length, 2e-3)


@pytest.mark.parametrize("solver", ["newton", "ipopt"])
def test_the_command_solves_from_zero_joints(solver, capsys):
    pose = symkin.solve(symkin.load("gluon_6l3"), joints=EXAMPLE).solution.pose
    numbers = ",".join(repr(float(v)) for v in (*pose.position, *pose.quaternion))
    with pytest.raises(SystemExit) as stop:
        main(
            [
                "solve",
                "gluon_6l3",
                f"--pose={numbers}",
                "--start=0,0,0,0,0,0",
                f"--solver={solver}",
                "--json",
            ]
        )
    assert not stop.value.code
    content = json.loads(capsys.readouterr().out)
    joints = np.array([content["solution"]["joints"][f"q{k}"] for k in range(1, 7)])
    assert np.abs(dh_product(joints) - dh_product(np.array(EXAMPLE))).max() < 1e-6
    assert any("the start is singular" in n for n in content["notes"])


class Counted(symkin.Newton):
    """Newton's method that keeps where it began."""

    def __init__(self) -> None:
        super().__init__()
        object.__setattr__(self, "begun", list[bytes]())

    def iterate(self, problem, start, known):
        self.begun.append(np.asarray(start).tobytes())
        return super().iterate(problem, start, known)


def test_no_start_that_leads_to_a_solution_is_gone_from_twice():
    """From a singular start the moved one is iterated, and what it came to is judged as it is."""
    arm, solver = symkin.load("gluon_6l3"), Counted()
    pose = symkin.solve(arm, joints=EXAMPLE).solution.pose
    found = symkin.solve(arm, pose=pose, start=[0.0] * 6, solver=solver)
    assert found.solution is not None
    assert len(solver.begun) == len(set(solver.begun)) > 0
