"""Machines of many equal loops: parts that share nothing are solved apart, and what loops of one
shape have in common is derived once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.inside import (
    Search,
    diagonal_parts,
    extreme_singular_values,
    least_squares_steps,
    modes_by_groups,
    null_space,
    problem_of,
    read_given,
    singular_values,
)
from symkin import Pose


def _scattered(rng: np.random.Generator, shapes: list[tuple[int, int]]) -> np.ndarray:
    """A block diagonal matrix of random parts, its rows and columns in random order."""
    rows, columns = (sum(shape[k] for shape in shapes) for k in (0, 1))
    whole, i, j = np.zeros((rows, columns)), 0, 0
    for r, c in shapes:
        whole[i : i + r, j : j + c] = rng.normal(size=(r, c))
        i, j = i + r, j + c
    return whole[rng.permutation(rows)][:, rng.permutation(columns)]


@pytest.mark.parametrize("shapes", [[(3, 2)] * 40, [(2, 3)] * 20 + [(5, 5)] * 3])
def test_parts_of_a_matrix_are_the_matrix(shapes: list[tuple[int, int]]) -> None:
    """Singular values, null space and least steps of a block diagonal matrix are those of the
    whole one.
    """
    rng = np.random.default_rng(0)
    whole = _scattered(rng, shapes)
    parts = diagonal_parts(whole[None])
    assert sum(rows.size for rows, _ in parts) == len(whole)
    assert sum(columns.size for _, columns in parts) == whole.shape[1]
    wanted = np.linalg.svd(whole, compute_uv=False)
    np.testing.assert_allclose(singular_values(whole), wanted, atol=1e-12)
    left = null_space(whole, 1e-9, relative=True)
    assert len(left) == whole.shape[1] - np.sum(wanted > 1e-9)
    np.testing.assert_allclose(left @ left.T, np.eye(len(left)), atol=1e-12)
    np.testing.assert_allclose(whole @ left.T, 0.0, atol=1e-12)
    values = rng.normal(size=(1, len(whole)))
    step = least_squares_steps(whole[None], values)[0]
    np.testing.assert_allclose(step, -np.linalg.pinv(whole) @ values[0], atol=1e-9)
    extremes = extreme_singular_values(whole[None])[0]
    np.testing.assert_allclose(extremes, wanted[[0, -1]], atol=1e-12)


def _four_bars(count: int, coupler: str = "link", length: float = 1.0) -> symkin.Mechanism:
    """Four-bars of different sizes beside each other, the links of each with its number, of cranks
    of some `length`; couplers are links, or rods, or links of loops that stand turned, each in a
    plane of its own.
    """
    rng, joints, rods = np.random.default_rng(0), [], []
    for k in range(count):
        base, crank, rocker = (size + rng.uniform(-0.2, 0.2) for size in (4.0, length, 2.5))
        a, angle = np.array([10.0 * k, rng.uniform(-1, 1)]), rng.uniform(0.5, 1.5)
        b = a + crank * np.array([np.cos(angle), np.sin(angle)])
        d = a + [base, 0.0]
        c = d + rocker * np.array([-np.sin(0.1 * angle), np.cos(0.1 * angle)])
        for name, point, links in (
            ("a", a, ("base", f"crank{k}")),
            ("b", b, (f"crank{k}", f"coupler{k}")),
            ("c", c, (f"coupler{k}", f"rocker{k}")),
            ("d", d, ("base", f"rocker{k}")),
        ):
            if coupler == "rod" and name in "bc":
                continue
            turn = Pose.from_euler(
                [0, 0, 0], [20.0 * k, 35.0, 10.0] if coupler == "turned" else [0] * 3
            )
            place, axis = turn.apply(np.array([*point, 0.0])), turn.turn(np.array([0, 0, 1.0]))
            joint = symkin.Joint(f"{name}{k}", "R", place, axis, actuated=name == "a")
            joints.append(symkin.LinkJoint(joint, links))
        if coupler == "rod":
            ends = [(*point.tolist(), 0.0) for point in (b, c)]
            rods.append(symkin.LinkRod(f"coupler{k}", (f"crank{k}", f"rocker{k}"), *ends))
    return symkin.Mechanism("four_bars", link_joints=joints, link_rods=rods)


@pytest.fixture
def counted(monkeypatch):
    """How often formulas, and starts of paths, are derived."""
    counts = {"closed_form": 0, "start_of_structure": 0}
    for module, name in (
        (inside.closed_roots, "closed_form"),
        (inside.group_solvers, "start_of_structure"),
    ):
        own = getattr(module, name)

        def counting(*arguments, name=name, own=own, **options):
            counts[name] += 1
            return own(*arguments, **options)

        monkeypatch.setattr(module, name, counting)
    return counts


@pytest.mark.parametrize("coupler", ["link", "rod", "turned"])
def test_equal_loops_are_derived_once(coupler, counted):
    """However many loops of one kind a machine has, formulas, paths and their roots are those of
    one.
    """
    found = symkin.modes(_four_bars(40, coupler), given={f"a{k}": 0.1 * k for k in range(40)})
    assert found.count == 2**40
    # the loop at the origin has shorter rows
    assert counted["closed_form"] <= 2
    assert counted["start_of_structure"] <= 2


def test_turned_loops_that_do_not_reach_are_proved_once(counted):
    """That loops have no configuration is proved by complex branches of formulas, which all loops
    share.
    """
    given = {f"a{k}": 180.0 for k in range(9)}
    machine = _four_bars(9, "turned", 4.0)
    read = read_given(machine, None, None, given)
    search = Search("continuation", 10, 0, "batched")
    found = modes_by_groups(problem_of(machine, read), read.values[None], search, certify=True)
    assert found.account.seen.all()
    assert not found.account.statement.any()
    assert not found.total.any()
    assert counted["closed_form"] <= 2


def _legs(count: int, *, turned: bool) -> symkin.Mechanism:
    """A platform on legs U P S, their U joints along the base's axes, or turned about the base."""
    rng, limbs = np.random.default_rng(0), []
    for k, angle in enumerate(2.0 * np.pi * np.arange(count) / count + 0.2):
        foot, ball = (
            np.array([r * np.cos(angle), r * np.sin(angle), z]) + rng.uniform(-0.1, 0.1, 3)
            for r, z in ((2.0, 0.0), (1.0, 1.0))
        )
        out = np.array([np.cos(angle), np.sin(angle), 0.0]) if turned else np.array([1.0, 0, 0])
        joints = [
            symkin.Joint(f"u{k}", "U", foot, out, np.cross((0, 0, 1), out)),
            symkin.Joint(f"p{k}", "P", foot, ball - foot, actuated=True),
            symkin.Joint(f"s{k}", "S", ball),
        ]
        limbs.append(symkin.Limb(f"leg{k}", joints))
    return symkin.Mechanism("legs", limbs)


@pytest.mark.parametrize("turned", [False, True])
def test_equal_legs_are_derived_once(turned, counted):
    """At a pose a leg of many is derived no oftener than one of two, and answers as by itself: one
    of three is asked.
    """
    pose, machine = (0.05, 0.02, 0.1, 0.99, 0.0, 0.1, 0.05), _legs(8, turned=turned)
    found = symkin.modes(machine, pose=pose)
    assert sum(counted.values()) <= 2
    assert found.count == 4**8
    assert all(mode.certified for mode in found)
    for k in range(0, len(machine.limbs), 3):
        alone = symkin.modes(symkin.Mechanism("one", [machine.limbs[k]]), pose=pose)
        names = (f"p{k}", f"u{k}.1", f"u{k}.2")
        held = [
            {tuple(np.round([m.joints[n] for n in names], 8)) for m in f} for f in (found, alone)
        ]
        assert held[0] == held[1]


@pytest.mark.parametrize("coupler", ["link", "rod", "turned"])
def test_loops_of_a_family_answer_as_alone(coupler):
    """Each loop's configurations, what is said of them and their proofs are those of the loop by
    itself.
    """
    count = 9
    angles = np.random.default_rng(1).uniform(-180.0, 180.0, count).tolist()
    whole = _four_bars(count, coupler)
    given = {f"a{k}": angle for k, angle in enumerate(angles)}
    found = symkin.modes(whole, given=given)
    assert found.count == len(found) == 2**count
    # two circles meet: a polynomial of degree 2 counts the solutions of a loop's two rows, turned
    # in space too
    assert found.completeness == "proved"
    assert all(mode.certified for mode in found)
    for k, angle in enumerate(angles):
        joints = [j for j in whole.link_joints if j.joint.name[1:] == str(k)]
        rods = [rod for rod in whole.link_rods if rod.name == f"coupler{k}"]
        one = symkin.Mechanism("one", link_joints=joints, link_rods=rods)
        alone = symkin.modes(one, given={f"a{k}": angle})
        names = [name for name in (f"b{k}", f"d{k}") if name in alone[0].joints]
        held = [
            {tuple(np.round([m.joints[n] for n in names], 8)) for m in f} for f in (found, alone)
        ]
        assert held[0] == held[1]


def test_a_loop_of_a_family_that_does_not_close_is_told():
    """A crank that is too long for its loop at what is given: no modes, and by how much."""
    machine, joints = _four_bars(9), []
    for link_joint in machine.link_joints:
        joint = link_joint.joint
        shift = -2.5 if joint.name == "a3" else 0.0
        moved = replace(joint, point=(joint.point[0] + shift, *joint.point[1:]))
        joints.append(replace(link_joint, joint=moved))
    longer = symkin.Mechanism("longer", link_joints=joints)
    found = symkin.modes(longer, given={f"a{k}": 180.0 * (k == 3) for k in range(9)})
    assert len(found) == 0
    assert found.smallest_residual > 0.1
