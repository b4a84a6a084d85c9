"""The tables of the five papers in docs/papers come from the studies, and each row quotes what was
run.
"""

from pathlib import Path

import pytest

from helpers.study_outcome import Outcome, assert_docs_show, assert_rows_quote_runs

FEWER = {
    "gluon_6l3": ("--poses", "20", "--points", "5"),
    "ren2008": ("--trials", "2", "--points", "3"),
    "yao2020": ("--points", "3"),
    "zhang2009": ("--points", "5"),
    "zhao2000": ("--points", "5"),
}
"""Options with which a study takes seconds and has the rows of a whole run."""


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", FEWER)
def test_a_papers_table_is_its_studys(name: str, tmp_path: Path) -> None:
    outcome = Outcome(name, tmp_path, *FEWER[name])
    assert outcome.run.returncode == 0, outcome.run.stderr
    assert_rows_quote_runs(outcome)
    assert_docs_show(outcome)
