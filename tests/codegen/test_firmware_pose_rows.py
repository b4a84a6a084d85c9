"""The direct problem over the pose alone: the rows that are left when limbs' passive joints are
taken out.
"""

from __future__ import annotations

import numpy as np
import pytest

import symkin
from helpers import moved_points as machines
from helpers.gate import in_gate, in_gate_but
from helpers.inside import (
    LimbPlatform,
    Options,
    Real,
    _reduced_null_space,
    all_followed,
    build_vectors,
    configurations,
    pose_of,
)
from helpers.many_answers import answers_of
from helpers.samples import delta, readme_five_bar, three_rps, three_rrr

MACHINES = {
    "3-RRR": lambda: three_rrr("planar"),
    "3-RPR": machines.three_rpr,
    "3-RPS": three_rps,
    "6-RSS": machines.six_rss,
    "6-RUS": lambda: machines.six_rss(rods=False),
    "hexaglide": machines.hexaglide,
    "6-PUS": lambda: machines.hexaglide(rods=False),
}
KNOWN = {"3-RRR": 6, "3-RPR": 3, "3-RPS": 3, "6-RSS": 18, "6-RUS": 18, "hexaglide": 6, "6-PUS": 6}
"""Numbers that the joints give to the rows: coordinates of centers and squared radii that they
move.
"""


def _platform(name: str) -> LimbPlatform:
    return LimbPlatform(MACHINES[name](), Options("double"), Real("double"))


@pytest.fixture(
    scope="module", params=in_gate_but(MACHINES, ["3-RPR", "6-RUS", "6-PUS", "hexaglide"])
)
def platform(request):
    return request.param, _platform(request.param)


def _far(made):
    """Configurations farther away than those over which code is tuned."""
    return configurations(made.direct, made.closure.reference, 12, 7, spread=0.3, turn=0.7)


def test_passive_joints_are_gone(platform):
    name, made = platform
    assert made.core is not None
    kernel = made.core.direct.kernel
    assert (kernel.m, kernel.n) == (
        made.closure.role("pose")[-1].freedom
        + sum(c.freedom for c in made.closure.role("pose")[:-1]),
    ) * 2
    assert int(kernel.known.shape[0]) == KNOWN[name]
    assert all(c.role == "actuated" for block in made.blocks for c in block.system.unknowns)


def test_rows_vanish_at_closed_configurations(platform):
    _, made = platform
    kernel = made.core.direct.kernel
    for found in _far(made):
        rows, _ = kernel.row_function()(*made.direct_state(found.values), [])
        assert (
            np.max(np.abs(np.asarray(rows))) * kernel.row_length
            < 1e-10 * made.closure.characteristic_length
        )


def test_the_matrix_is_the_rows_derivative(platform):
    _, made = platform
    kernel = made.core.direct.kernel
    state, known = made.direct_state(made.samples[0].values)
    matrix, move, rows = (
        kernel.matrix(state, known, np.zeros(0)),
        kernel.move_function(),
        kernel.row_function(),
    )
    for j in range(kernel.n):
        step = np.zeros(kernel.n)
        step[j] = 1e-5 / max(
            1.0, float(np.max(np.abs(matrix[:, j])) / np.max(np.abs(matrix[:, 0])))
        )
        ends = [
            np.asarray(rows(move(state, sign * step, [])[0], known, [])[0]).ravel()
            for sign in (1.0, -1.0)
        ]
        slope = (ends[1] - ends[0]) / (2 * step[j])
        assert np.max(np.abs(slope - matrix[:, j])) < 1e-6 * np.max(np.abs(matrix[:, j]))


def test_a_rows_failure_is_the_limbs(platform):
    """Off the closed configurations rows do not vanish: they say more than the closure's own
    residual allows.
    """
    _, made = platform
    kernel, size = made.core.direct.kernel, made.closure.characteristic_length
    state, known = made.direct_state(made.samples[0].values)
    rng = np.random.default_rng(3)
    for _ in range(5):
        step = rng.normal(size=kernel.n)
        unit = np.sqrt(float(kernel.move_function()(state, step, [])[1]))
        moved = np.asarray(kernel.move_function()(state, 0.01 * size / unit * step, [])[0]).ravel()
        assert (
            np.max(np.abs(np.asarray(kernel.row_function()(moved, known, [])[0])))
            * kernel.row_length
            > 1e-5 * size
        )


def _determinants(made, found):
    whole = made.direct.system.linearise_one(found.unknown, found.known)[1]
    reduced = made.core.direct.kernel.matrix(*made.direct_state(found.values), np.zeros(0))
    return float(np.linalg.det(whole)), float(np.linalg.det(reduced))


@pytest.mark.parametrize(
    "name", in_gate(["3-RRR", "3-RPR", "3-RPS", "6-RSS", "hexaglide"], ["3-RRR", "6-RSS"])
)
def test_singularities_are_those_of_the_closure(name):
    """A passive joint turns a vector of length l: its column is l across the vector, the sphere's
    row is l times what is left of the limb's rows along it. So the determinants differ by a factor
    alone, which is a constant here.
    """
    made = _platform(name)
    ratios = [
        whole / reduced for whole, reduced in (_determinants(made, found) for found in _far(made))
    ]
    assert np.ptp(ratios) < 1e-8 * np.max(np.abs(ratios))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
@pytest.mark.parametrize("name", ["3-RRR", "3-RPS", "6-RSS", "hexaglide"])
def test_answers_are_those_of_a_fine_walk(name, real, tmp_path):
    """Random goals from home: what is OK is where small steps along the joints' line end; most
    regular lines are.
    """
    made, rng, count = _platform(name), np.random.default_rng(11), 60
    ask = answers_of(made.mechanism, Options(real), tmp_path)
    joints, begin = made.direct.known_coordinates, made.closure.reference
    start, known = (
        made.direct.select_values(begin, c) for c in (made.direct.system.unknowns, joints)
    )
    home, size = pose_of(made.closure, begin), made.closure.characteristic_length
    reach = np.array([0.5 if c.is_angular else 0.12 * size for c in joints])
    goals = (
        (known + reach * rng.uniform(-1, 1, (count, len(joints)))).astype(np.float32).astype(float)
    )
    statuses, poses = ask(goals, np.tile([*home.position, *home.quaternion], (count, 1)))
    answered = reached = 0
    ends, whole = all_followed(made.direct, start, known, goals)
    for goal, status, found, z, is_reached in zip(goals, statuses, poses, ends, whole, strict=True):
        reached += is_reached
        answered += status == 0 and is_reached
        if status == 0 and is_reached:
            there = pose_of(made.closure, made.direct.join_values(z, goal))
            bound = (2e-7 + 32 * Real(real).epsilon * made.direct.system.condition(z, goal)) * size
            assert np.max(np.abs(found[:3] - there.position)) < bound
    assert answered > 0.9 * reached > 0


def test_a_closed_direct_problem_goes_first():
    made = LimbPlatform(delta(), Options("double"), Real("double"))
    assert made.direct_formulas is not None
    assert made.core is None


def test_geometry_at_run_time_keeps_the_closure():
    made = LimbPlatform(three_rrr("planar"), Options("double", geometry="struct"), Real("double"))
    assert made.core is None
    assert made.direct_kernel.n == made.direct.system.freedom


def test_coefficients_are_the_same_on_any_processor():
    """Null spaces are those of the row space: rows mixed by random turns, which changes all
    roundings, give the same bytes.
    """
    rng = np.random.default_rng(4)
    matrix = np.array(
        [[1.0, -1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 3.0]]
    )
    plain = _reduced_null_space(matrix)
    np.testing.assert_allclose(matrix @ plain.T, 0.0, atol=1e-15)
    for _ in range(20):
        turned = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ matrix
        assert _reduced_null_space(turned).tobytes() == plain.tobytes()


def test_bounds_of_vectors_allow_for_the_worse_of_both_problems():
    """Rounding of a pose is magnified by the inverse problem's condition, which near a stretched
    leg is worse than the direct one's: the generated test allows for it.
    """
    made = readme_five_bar("planar")
    kind = LimbPlatform(made, Options("float"), Real("float"))
    vectors, size = build_vectors(kind), made.characteristic_length
    worse = 0
    told = vectors.answers
    for joints, pose, bound in zip(told["joints"], told["poses"], vectors.bounds, strict=True):
        there = symkin.modes(made, pose=pose)
        near = min(
            there,
            key=lambda mode: np.abs(
                [mode.values[c.name] for c in made.actuated] - (kind.zero + joints)
            ).max(),
        )
        direct = min(
            symkin.modes(made, joints=[made.angle_out(v) for v in kind.zero + joints]),
            key=lambda mode: np.linalg.norm(mode.position - pose[:3]),
        )
        assert bound >= Real("float").epsilon * size * 4 * max(near.condition, direct.condition)
        worse += near.condition > 2 * direct.condition
    assert worse
