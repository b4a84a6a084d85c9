"""CasADi's own C beside symkin's: the same answers where Newton's method is enough, and what its
return value does not tell.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers.gate import in_gate

README = Path(__file__).parents[2] / "codegen" / "README.md"
SYSTEMS = ("zhang2009", "ren2008", "zhao2000", "gluon_6l3", "yao2020")


def table_rows() -> list[list[str]]:
    """Cells of the rows between README's marks."""
    text = README.read_text().partition("<!-- casadi -->")[2].partition("<!-- end casadi -->")[0]
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("| ")
    ]


@pytest.fixture(
    scope="module", params=in_gate(["zhang2009", "zhao2000", "gluon_6l3"], ["zhang2009"])
)
def both(request):
    tools.compiler("gcc")
    answers, plain = tools.bench_module("plain_answers"), tools.bench_module("plain_casadi")
    return answers.Both(plain.PlainCasadi(request.param))


@pytest.mark.slow
def test_both_meet_the_vectors(both):
    """Near the start both give the answer that the vectors have."""
    cases = tools.bench_module("bench_cases").cases_of(both.plain.program.kind)
    serial = both.serial
    known, starts = (
        (cases["poses"], cases["guesses"]) if serial else (cases["joints"], cases["warm"])
    )
    for k in range(6):
        own, plain = (
            both.symkin(starts[k], known[k]),
            both.casadi(both.unknowns(starts[k]), known[k]),
        )
        assert own.code == plain.code == 0
        assert plain.closed
        assert both.same(own, plain)
        expected = cases["expected"][k][: 6 if serial else 3]
        assert plain.values[: len(expected)] == pytest.approx(expected, abs=1e-7)


@pytest.mark.slow
def test_casadi_returns_zero_without_an_answer(both):
    """Joint values out of reach, NaN, a singular start: symkin refuses each, CasADi's C returns 0
    without a solution.
    """
    for start, known in both.without_answer().values():
        own, plain = both.symkin(start, known), both.casadi(both.unknowns(start), known)
        assert own.code != 0
        assert plain.code == 0
        assert not plain.closed


def test_a_tally_accounts_for_every_goal(both):
    """symkin's OK is never another answer without being counted: each goal stands in one column."""
    answers = tools.bench_module("plain_answers")
    found = answers.tally(both, 60, 43)
    assert found.zeros == found.goals == 60
    assert found.unsolved + found.same + found.other + found.refused == 60
    assert found.same > 5


def test_the_jacobians_are_the_same(both):
    """CasADi's matrix at a configuration is the derivative of symkin's own direct or inverse
    problem, by differences.
    """
    plain, cases = both.plain, tools.bench_module("bench_cases").cases_of(both.plain.program.kind)
    place = cases["expected"][0]
    matrix = np.array(plain.matrix(plain.matrix_input(place))).T
    if not both.serial:
        step = 1e-4
        for k in range(3):
            ends = [plain.values_at(place + sign * step * np.eye(7)[k]) for sign in (1, -1)]
            joints = plain.mechanism.actuated
            slopes = [(ends[0][c.name][0] - ends[1][c.name][0]) / (2 * step) for c in joints]
            assert matrix[:, k] == pytest.approx(slopes, abs=1e-6)
        return
    step, kind = 1e-5, plain.program.kind
    for k in range(len(place)):
        ends = [kind.forward_at(place + sign * step * np.eye(len(place))[k]) for sign in (1, -1)]
        assert matrix[:3, k] == pytest.approx((ends[0] - ends[1])[:3] / (2 * step), abs=1e-4)


def test_more_rows_than_unknowns_are_refused():
    plain = tools.bench_module("plain_casadi")
    with pytest.raises(ValueError, match="17 rows, 16 unknowns"):
        _ = plain.PlainCasadi("zhao2000_links").newton


def test_readme_has_the_five_systems():
    """Every system in all three tables; CasADi's C returned 0 for each goal and each input."""
    rows = table_rows()
    counts = [row for row in rows if row[1] in ("cold", "inverse")]
    assert [row[0] for row in counts] == list(SYSTEMS)
    goals = [row for row in rows if len(row) == 8 and re.fullmatch(r"[\d,]+", row[1])]
    assert [row[0] for row in goals] == list(SYSTEMS)
    assert all(row[1] == row[3] for row in goals)
    inputs = [row for row in rows if len(row) == 5 and row[0] in SYSTEMS]
    assert {row[0] for row in inputs} == set(SYSTEMS)
    assert all(row[2] != "OK" and row[3] == "0" for row in inputs)


@pytest.mark.long
@pytest.mark.slow
def test_counts_are_those_of_the_readme():
    """Counting anew on the host gives the committed counts, but for the compiler's version."""
    for program in ("gcc", "valgrind", "make"):
        tools.compiler(program)
    harness, processors = tools.bench_module("plain_harness"), tools.bench_module("processors")
    plain = tools.bench_module("plain_casadi").PlainCasadi("ren2008")
    row = next(row for row in table_rows() if row[:2] == ["ren2008", "warm"])
    harnesses = harness.newton_harnesses(plain)
    for who, cell in (("symkin", row[4]), ("CasADi", row[5])):
        found = processors.measure(harnesses[who], "host")["warm"]
        assert found.mean == pytest.approx(float(cell.replace(",", "")), rel=0.25)
