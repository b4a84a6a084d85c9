"""The study that compares solvers runs, and its table says what is known of four mechanisms."""

from __future__ import annotations

import pytest

from helpers.study_outcome import Outcome, assert_complete

pytestmark = [pytest.mark.slow, pytest.mark.long]

KNOWN = {"zhang2009": 4, "zhao2000": 4, "gluon_6l3": 2, "yao2020": 4}


@pytest.fixture(scope="module")
def solvers(tmp_path_factory) -> Outcome:
    return Outcome("solvers", tmp_path_factory.mktemp("solvers"))


@pytest.mark.slow
def test_no_error_of_a_paper_is_claimed(solvers):
    assert_complete(solvers, [])


@pytest.mark.parametrize("name", KNOWN)
def test_batched_starts_find_every_known_mode_and_each_solver_some(solvers, name):
    (batched,) = solvers.rows(f"{name}, batched, 200 starts: modes found")
    assert batched["computed"] == KNOWN[name]
    assert batched["quantity"].endswith(f"of {KNOWN[name]} known")
    for solver, starts in (("newton", 200), ("ipopt", 100)):
        assert 0 < solvers.number(f"{name}, {solver}, {starts} starts: modes found") <= KNOWN[name]
