"""Many inputs of mechanisms solved by structure groups, all at once: the same as one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest

import symkin
from helpers.inside import Search, modes_by_groups, problem_of, read_given

SEARCH = Search.of(None)
PLATFORM = symkin.load("zhang2009")


def known_of(name, given):
    """The problem of a mechanism for values (n,) by name, and its known values."""
    mechanism = symkin.load(name)
    rows = [dict(zip(given, row, strict=True)) for row in zip(*given.values(), strict=True)]
    givens = [read_given(mechanism, None, None, row) for row in rows]
    return problem_of(mechanism, givens[0]), np.array([one.values for one in givens]), rows


@pytest.mark.parametrize(
    ("name", "ranges"),
    [
        ("four_bar", {"crank": (0.0, 360.0)}),
        pytest.param("four_bar", {"follower": (-180.0, 180.0)}, marks=pytest.mark.long),
        pytest.param("watt_six_bar", {"output": (-60.0, 60.0)}, marks=pytest.mark.long),
        ("ankle", {"ankle.1": (-15.0, 15.0), "ankle.2": (-15.0, 15.0)}),
        pytest.param(
            "pantograph_leg", {"x": (60.0, 120.0), "y": (200.0, 280.0)}, marks=pytest.mark.long
        ),
        ("differential", {"shaft": (-90.0, 90.0), "left": (-90.0, 90.0)}),
    ],
)
def test_many_inputs_have_the_modes_of_each(name, ranges):
    """Counts, values, residuals and statements of each input are those that it has alone, solvable
    or not.
    """
    rng = np.random.default_rng(1)
    given = {n: rng.uniform(low, high, 12) for n, (low, high) in ranges.items()}
    problem, known, rows = known_of(name, given)
    found = modes_by_groups(problem, known, SEARCH)
    for i, row in enumerate(rows):
        alone = symkin.modes(problem.mechanism, given=row)
        mine = found.owner == i
        assert found.total[i] == mine.sum() == len(alone)
        for values, mode in zip(found.listed.values[mine], alone, strict=True):
            assert np.allclose(values, mode.variables, rtol=0, atol=1e-8)
        assert (found.listed.residual[mine] < 1e-9 * problem.mechanism.characteristic_length).all()


def test_counts_are_those_of_a_triangle():
    """A four-bar's follower can stand where crank pin and follower pin are a coupler's length
    apart: two modes within the crank's and the coupler's reach of the follower's end, none beyond.
    """
    mechanism = symkin.load("four_bar")
    at = {one.joint.name: np.array(one.joint.point[:2]) for one in mechanism.link_joints}
    crank, coupler = (
        float(np.linalg.norm(at[a] - at[b]))
        for a, b in (("crank", "crank_pin"), ("crank_pin", "follower_pin"))
    )
    angles = np.linspace(-180.0, 180.0, 73)
    problem, known, _ = known_of("four_bar", {"follower": angles})
    found = modes_by_groups(problem, known, SEARCH)
    joint = next(one.joint for one in mechanism.link_joints if one.joint.name == "follower")
    for i, angle in enumerate(angles):
        turn = math.radians(angle) - joint.zero
        rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        end = at["follower"] + rotation @ (at["follower_pin"] - at["follower"])
        away = float(np.linalg.norm(end - at["crank"]))
        assert found.total[i] == (2 if abs(crank - coupler) < away < crank + coupler else 0)


def test_rows_of_joints_are_the_modes_of_each():
    """`modes` of a graph takes an array of inputs; each input without a solution has its least
    closure error.
    """
    mechanism = symkin.load("stephenson_six_bar")
    rows = np.array([[3.0], [40.0], [140.0], [200.0]])
    many = symkin.modes(mechanism, joints=rows)
    for row, found in zip(rows, many, strict=True):
        alone = symkin.modes(mechanism, joints=row)
        assert [mode.joints for mode in found] == [
            pytest.approx(mode.joints, abs=1e-6) for mode in alone
        ]
        assert (found.count, found.complex_count, found.completeness) == (
            alone.count,
            alone.complex_count,
            alone.completeness,
        )
        assert (found.smallest_residual is None) == (len(found) > 0)
        if not len(found):
            assert found.smallest_residual == pytest.approx(alone.smallest_residual, rel=1e-6)
    assert {len(found) for found in many} > {0}


def test_columns_by_name_are_many_inputs():
    """A column for each name, or one value for all; joints of limbs by name too. Columns of
    different lengths are refused, and names that nothing has, where a column is empty too.
    """
    ankle = symkin.load("ankle")
    many = symkin.modes(ankle, given={"ankle.1": [3.0, 5.0, -2.0], "ankle.2": 4.0})
    for angle, found in zip([3.0, 5.0, -2.0], many, strict=True):
        alone = symkin.modes(ankle, given={"ankle.1": angle, "ankle.2": 4.0})
        assert [mode.joints for mode in found] == [
            pytest.approx(mode.joints, abs=1e-8) for mode in alone
        ]
    legs = dict(zip((c.name for c in PLATFORM.actuated), PLATFORM.example.joints, strict=True))
    assert [
        len(found)
        for found in symkin.modes(
            PLATFORM, given=legs | {"leg1": [legs["leg1"], legs["leg1"] + 1.0]}
        )
    ] == [4, 4]
    with pytest.raises(symkin.InputError, match=r"ankle\.1 2, ankle\.2 3"):
        symkin.modes(ankle, given={"ankle.1": [3.0, 5.0], "ankle.2": [1.0, 2.0, 3.0]})
    assert symkin.modes(ankle, given={"ankle.1": [], "ankle.2": []}) == ()
    with pytest.raises(symkin.InputError, match=r"no coordinate 'ankle\.3'"):
        symkin.modes(ankle, given={"ankle.1": [], "ankle.3": []})


def test_random_starts_of_an_input_do_not_depend_on_others():
    """Searched from random starts, an input has the same modes alone and among others, bit for
    bit.
    """
    problem, known, _ = known_of(
        "ankle",
        {"upper_motor": np.array([8.0, -3.0, 5.0]), "lower_motor": np.array([12.0, 4.0, 1.0])},
    )
    search = Search.of("multistart", starts=60)
    together = modes_by_groups(problem, known, search)
    for i in range(3):
        alone = modes_by_groups(problem, known[i : i + 1], search)
        assert np.array_equal(together.listed.values[together.owner == i], alone.listed.values)
        assert len(alone.listed)
