"""Closed forms of blocks of rows: every value closes on all rows, they are all solutions, and a
configuration tells its own.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    ClosedForm,
    Problem,
    System,
    angle_sums,
    build_problem,
    closed_form,
    misses_none,
    samples_about,
    start_of,
    structure_groups,
    system_of,
)
from helpers.samples import delta, readme_five_bar, three_rps, three_rrr

GROUPS = {
    "four_bar": 1,
    "slider_crank": 1,
    "jansen_leg": 3,
    "klann_leg": 2,
    "watt_six_bar": 2,
    "excavator_bucket": 4,
    "pantograph_leg": 2,
    "ankle's motors": 2,
}
"""Structure groups of linkages whose actuated joints are given; of the ankle its motors."""
PLATFORMS = [
    "five-bar direct",
    "delta direct",
    "delta limb",
    "3-RRR limb",
    "3-RPS limb",
    "zhao2000 direct",
    "zhao2000 limb",
]
NAMES = [
    *PLATFORMS,
    *(f"{name} {number}" for name, count in GROUPS.items() for number in range(count)),
]


@cache
def parts() -> dict[str, Problem]:
    """Blocks that have closed forms: of platforms, of their limbs, and structure groups of
    linkages.
    """
    asked = {
        "five-bar direct": (build_problem(readme_five_bar("planar"), "direct"), 0),
        "delta direct": (build_problem(delta(), "direct"), 0),
        "delta limb": (build_problem(delta(), "inverse"), 0),
        "3-RRR limb": (build_problem(three_rrr("planar"), "inverse"), 1),
        "3-RPS limb": (build_problem(three_rps(), "inverse"), 2),
        "zhao2000 direct": (build_problem(symkin.load("zhao2000"), "direct"), 0),
        "zhao2000 limb": (build_problem(symkin.load("zhao2000"), "inverse"), 1),
    }
    found = {name: structure_groups(problem)[number] for name, (problem, number) in asked.items()}
    for name, count in GROUPS.items():
        mechanism = symkin.load("ankle" if name == "ankle's motors" else name)
        given = (
            ("ankle.1", "ankle.2")
            if name == "ankle's motors"
            else tuple(c.name for c in mechanism.actuated)
        )
        groups = structure_groups(build_problem(mechanism, "given", given))
        assert len(groups) == count
        found |= {f"{name} {number}": group for number, group in enumerate(groups)}
    return found


def about(problem: Problem, system: System, seed: int = 0) -> np.ndarray:
    return samples_about(system, problem.reference_known, problem.known_coordinates, seed)


def formulas(name: str) -> ClosedForm:
    group = parts()[name]
    found = closed_form(group.system, about(group, group.system))
    assert found is not None
    return found


def inputs(problem: Problem, count: int, seed: int = 7) -> np.ndarray:
    """Known values about the reference, with other random numbers than those that the formulas were
    found by.
    """
    return np.concatenate([about(problem, problem.system, seed + k) for k in range(count // 3)])


@pytest.mark.parametrize("name", [name for name in NAMES if name != "3-RPS limb"])
def test_real_values_close_on_all_rows_and_tell_their_signs(name: str) -> None:
    found, problem = formulas(name), parts()[name]
    known = inputs(problem, 30)
    solutions, size = found.solutions(known), found.system.characteristic_length
    assert solutions.real.any()
    for row, which in zip(*np.nonzero(solutions.real), strict=True):
        point = solutions.values[row, which]
        assert found.system.residual(point, known[row]) < 1e-10 * size
        assert np.array_equal(found.signs_at(point, known[row]), found.choices[which])


def test_a_limb_that_not_every_pose_lets_close() -> None:
    """A limb R-P-S keeps its ball in a plane: of poses that do, both values close."""
    found, problem = formulas("3-RPS limb"), parts()["3-RPS limb"]
    known = problem.reference_known + np.array(
        [[0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0] for z in (-20.0, 0.0, 30.0)]
    )
    solutions, size = found.solutions(known), found.system.characteristic_length
    assert solutions.real.all()
    assert solutions.clear.all()
    for row, values in enumerate(known):
        assert np.all(found.system.residuals(solutions.values[row], values) < 1e-10 * size)


@pytest.mark.parametrize("name", NAMES)
def test_formulas_that_lack_a_branch_are_told_from_those_that_have_all(name: str) -> None:
    """By random complex starts, at one instance."""
    found, problem = formulas(name), parts()[name]
    known = problem.reference_known if name == "3-RPS limb" else inputs(problem, 3)[0]
    known = problem.system.exchanged(problem.known_coordinates).unit(known)
    assert misses_none(problem, found, known)
    if not found.signs.numel():
        return
    halved = {
        part: ca.substitute(getattr(found, part), found.signs[0], 1.0)
        for part in ("first", "second", "discriminants", "divisors")
    }
    assert not misses_none(problem, replace(found, signs=found.signs[1:], **halved), known)


def test_rows_of_rounding_are_none() -> None:
    """Nothing is solved by what rounding has left of a row that is zero."""
    problem = parts()["four_bar 0"]
    system, noise = problem.system, ca.cos(problem.system.unknown[0])
    rows = ca.vertcat(system.rows, 1e-15 * system.characteristic_length * noise)
    found = closed_form(replace(system, rows=rows), about(problem, system))
    assert found is not None
    assert found.steps == formulas("four_bar 0").steps


def test_sums_of_angles_are_tried_where_axes_are_parallel() -> None:
    """Of the two angles of a planar limb; none of a loop whose axes cross."""
    limb = parts()["3-RRR limb"]
    loop = build_problem(symkin.load("bricard"), "given", ("joint2",))
    for problem, block, count in (
        (limb, limb.system, 2),
        (loop, structure_groups(loop)[0].system, 1),
    ):
        assert sum(c.is_angular for c in block.unknowns) >= 2
        ways = list(angle_sums(block, block.rows, about(problem, block)[0]))
        assert ways[0] == {}
        assert len({tuple(way.items()) for way in ways}) == len(ways) == count


COUNTED = [name for name in NAMES if name != "3-RPS limb"]


@pytest.mark.parametrize("name", in_gate(COUNTED, COUNTED[::3]))
def test_there_are_as_many_as_paths_find(name: str) -> None:
    part = parts()[name]
    start, _ = start_of(part, system_of(part))
    assert start is not None
    assert formulas(name).count == start.z.shape[1]


@pytest.mark.parametrize(
    "name",
    [
        "five-bar direct",
        "delta direct",
        "zhao2000 direct",
        "3-RRR limb",
        "slider_crank 0",
        "jansen_leg 2",
    ],
)
def test_newton_from_random_starts_finds_no_other(name: str) -> None:
    found, problem = formulas(name), parts()[name]
    block, rng = found.system, np.random.default_rng(3)
    known = inputs(problem, 6)
    solutions = found.solutions(known)
    starts = np.stack(
        [
            rng.uniform(-np.pi, np.pi, 300)
            if c.is_angular
            else rng.uniform(-2, 2, 300) * block.characteristic_length
            for c in block.unknowns
        ],
        axis=1,
    )
    angular = np.array([c.is_angular for c in block.unknowns])
    for row, values in enumerate(known):
        ends = block.polish_many(starts, values, 40).points
        ends = ends[block.residuals(ends, values) < 1e-11 * block.characteristic_length]
        assert len(ends)
        own = solutions.values[row][solutions.real[row]]
        apart = np.abs(ends[:, None] - own[None])
        apart[..., angular] = np.abs(np.angle(np.exp(1j * apart[..., angular])))
        assert (
            np.max(
                np.min(
                    np.max(apart / np.where(angular, 1.0, block.characteristic_length), axis=2),
                    axis=1,
                )
            )
            < 1e-6
        )


def test_circles_that_are_too_far_apart_do_not_meet() -> None:
    """The bases are 150 apart, the cranks 100 and the couplers 150 long: both cranks outward leave
    350 between circles of 150.
    """
    solutions = formulas("five-bar direct").solutions(
        np.array([[np.pi / 2, -np.pi / 2], [0.0, 0.0]])
    )
    assert solutions.real.tolist() == [[False, False], [True, True]]


def test_a_double_solution_is_not_clear() -> None:
    """A stretched five-bar: both circles touch."""
    found = formulas("five-bar direct")
    mechanism = parts()["five-bar direct"].mechanism
    # the tips of the cranks, 100 above bases 150 apart, are 300 apart where both cranks lean
    # outward by asin(75 / 100)
    stretched = np.arcsin(0.75)
    reach = np.array(
        [
            [mechanism.angle_in(0.0) + s * stretched for s in signs]
            for signs in itertools.product((1, -1), repeat=2)
        ]
    )
    assert not found.solutions(reach).clear.all()
    assert found.solutions(np.zeros((1, 2))).clear.all()


def test_formulas_hold_for_relations_that_hold_at_all_samples() -> None:
    """The platform of the real limbs stays level: what holds of tilted poses needs no formula."""
    problem = build_problem(symkin.load("zhao2000_links"), "inverse")
    block, rng = structure_groups(problem)[0].system, np.random.default_rng(0)
    quarter = rng.uniform(-0.2, 0.2, size=(3, 1))
    level = problem.reference_known + np.hstack(
        [rng.uniform(-20, 20, size=(3, 3)), np.zeros((3, 4))]
    )
    level[:, 3:] = np.hstack([np.cos(quarter), 0 * quarter, 0 * quarter, np.sin(quarter)])
    found = closed_form(block, level)
    assert found is not None
    assert found.count == 4
    solutions = found.solutions(level)
    assert solutions.real.sum() >= 4
    for row, which in zip(*np.nonzero(solutions.real), strict=True):
        assert (
            block.residual(solutions.values[row, which], level[row])
            < 1e-10 * block.characteristic_length
        )


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000_links"])
def test_what_has_no_closed_form_is_said(name: str) -> None:
    problem = build_problem(symkin.load(name), "direct")
    assert closed_form(problem.system, about(problem, problem.system)) is None


def test_the_same_formulas_every_time() -> None:
    first, second = formulas("zhao2000 direct"), formulas("zhao2000 direct")
    assert first.steps == second.steps
    assert str(first.values) == str(second.values)
