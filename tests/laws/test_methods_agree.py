"""The modes of the five systems from varied initial guesses are those that continuation lists: a
part of them, and all where the starts suffice.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import structure_groups
from helpers.laws import configuration
from symkin import Modes, Solution

SEED = 5
CASES = [
    ("zhao2000", "direct", 100),
    ("zhao2000", "inverse", 50),
    ("zhao2000_links", "direct", 1500),
    ("zhang2009", "direct", 200),
    ("zhang2009", "inverse", 20),
    ("ren2008", "direct", 500),
    ("ren2008", "inverse", 20),
    ("ren2008_true", "direct", 500),
    ("gluon_6l3", "inverse", 200),
    ("yao2020", "inverse", 200),
]
"""Problems that are no formula, and a number of starts that reaches every mode several times."""


@cache
def given(name: str, kind: str) -> dict[str, Any]:
    """The worked example, or a pose and lengths of which no two are equal; for an inverse problem
    the first pose of these.
    """
    mechanism = symkin.load(name)
    example = mechanism.example
    if name.startswith("ren2008"):
        lengths = np.array(
            symkin.solve(mechanism, pose=mechanism.reference_pose).solution.actuated_values
        )
        joints = {"joints": tuple(lengths + [0.03, -0.02, 0.05, 0.01, -0.04, 0.02])}
    else:
        joints = (
            {"joints": example.joints} if example.joints is not None else {"pose": example.pose}
        )
    return (
        joints
        if kind == "direct" or "pose" in joints
        else {"pose": symkin.solve(mechanism, **joints).solution.pose}
    )


@cache
def listed(name: str, kind: str) -> Modes:
    """All modes, by continuation."""
    found = symkin.modes(symkin.load(name), **given(name, kind), method="continuation")
    assert found.method == "continuation"
    assert found.completeness in ("proved", "probability one")
    return found


def places(sampled: Modes, complete: Modes) -> list[int]:
    """Of each sampled mode its place in the complete list, which has it exactly once."""
    size = complete.problem.closure.characteristic_length
    rows = np.array([configuration(mode, size) for mode in complete])

    def place(mode: Solution) -> int:
        near = np.flatnonzero(np.max(np.abs(rows - configuration(mode, size)), axis=1) < 1e-6)
        assert len(near) == 1, (
            f"a mode at {mode.position} is {len(near)} times in the list of continuation"
        )
        return int(near[0])

    return [place(mode) for mode in sampled]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "starts"),
    in_gate(CASES, [case for case in CASES if case[0] in ("gluon_6l3", "zhang2009", "zhao2000")]),
)
def test_varied_guesses_reach_every_mode_that_continuation_lists(name, kind, starts) -> None:
    """Enough starts: each listed mode once, no other, each reached by some start; that these are
    all of them is known only where a theorem says so of the complete list too.
    """
    complete = listed(name, kind)
    sampled = symkin.modes(
        symkin.load(name), **given(name, kind), method="multistart", starts=starts, seed=SEED
    )
    assert (sampled.method, sampled.starts) == ("multistart", starts)
    assert sampled.completeness == "sampled" or complete.completeness == "proved"
    found = places(sampled, complete)
    assert len(set(found)) == len(found)
    missed = len(complete) - len(found)
    assert missed == 0, f"{missed} of {len(complete)} modes are missed by {starts} starts"
    assert all(mode.hits >= 1 for mode in sampled)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), [case[:2] for case in CASES])
def test_few_guesses_reach_a_part_of_the_list(name, kind) -> None:
    """Three starts for the mechanism: what they reach is in the list of continuation; where modes
    are missed, `missed` counts them.
    """
    complete = listed(name, kind)
    sampled = symkin.modes(
        symkin.load(name), **given(name, kind), method="multistart", starts=3, seed=SEED
    )
    found = places(sampled, complete)
    missed = set(range(len(complete))) - set(found)
    assert len(missed) == len(complete) - len(sampled)
    assert len(sampled) <= 3 or len(structure_groups(sampled.problem)) > 1


def test_each_solver_reaches_modes_of_the_list_only() -> None:
    """CasADi's rootfinder and IPOPT from the same guesses as well."""
    complete = listed("zhao2000", "direct")
    for solver, starts in (("newton", 40), ("fast_newton", 40), ("ipopt", 25)):
        sampled = symkin.modes(
            symkin.load("zhao2000"),
            **given("zhao2000", "direct"),
            solver=solver,
            starts=starts,
            seed=SEED,
        )
        assert sampled.method == f"multistart {solver}"
        assert set(places(sampled, complete)) == {0, 1, 2, 3}


def test_working_modes_of_the_real_limbs_are_the_product_of_their_branches() -> None:
    """Continuation has no start system there. A limb's plane of motion may be turned by half a
    turn, and its elbow may be up or down: four branches in each of three limbs, 64 working modes of
    a pose within reach.
    """
    platform = symkin.load("zhao2000_links")
    sampled = symkin.modes(
        platform, **given("zhao2000_links", "inverse"), method="multistart", starts=100, seed=SEED
    )
    assert len(sampled) == 4**3


def test_the_formula_answers_both_methods() -> None:
    """The direct problem of an arm has one solution, whichever method is named."""
    for name in ("gluon_6l3", "yao2020"):
        arm = symkin.load(name)
        joints = [10.0] * len(arm.actuated)
        one, other = (
            symkin.modes(arm, joints=joints, method=method)
            for method in ("continuation", "multistart")
        )
        assert one.method == other.method == "forward"
        assert np.array_equal(one[0].position, other[0].position)
