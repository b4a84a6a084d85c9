"""Words of a command line that are wrong: one sentence that says what is meant."""

import pytest

from helpers.command_line import run


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("modes zhao2000 --joints 1 2 3 4", ["separate values by commas", "--joints 1,2,3,4"]),
        ("modes zhao2000 --joints 1, 2, 3, 4", ["--joints 1,2,3,4"]),
        ("modes zhao2000 --joints -1 -2 3 4", ["--joints -1,-2,3,4"]),
        ("track zhao2000 --from 1 2 3 4 --to 2 3 4 5", ["--from 1,2,3,4"]),
        ("modes zhao2000 --given theta1=80 op=200", ["--given theta1=80,op=200"]),
        ("singularities zhang2009 --plane x y", ["--plane x,y"]),
        ("modes zhao2000 1,2,3,4", ["'1,2,3,4' stands alone", "--joints 1,2,3,4"]),
        ("modes zhao2000 --joints", ["--joints has no value", "--joints V1,V2,..."]),
        ("modes zhao2000 --jonts 1", ["'--jonts'", "do you mean '--joints'?", "`symkin modes -h`"]),
        ("modes zhao2000 --json=yes", ["--json takes no value"]),
        ("modes", ["MECH is missing", "`symkin modes -h`"]),
        ("firmware zhao2000", ["-o DIR is missing"]),
        ("mode zhao2000", ["'mode' is unknown", "do you mean 'modes'?", "allowed: list, show"]),
        ("zhao2000", ["'zhao2000' is a mechanism", "symkin modes zhao2000"]),
        ("calibrate zhang2009 data.csv", ["symkin calibrate fit zhang2009"]),
        ("help", ["symkin --help"]),
        ("modes zhao2000 --method multstart", ["--method 'multstart' is unknown", "'multistart'", "continuation"]),
        ("list zhao2000", ["options only"]),
    ],
)
def test_words_are_told_what_they_lack(capsys: pytest.CaptureFixture[str], words: str, expected: list[str]) -> None:
    """Status 2, nothing on stdout, one line with the offender and how it is written."""
    status, out, err = run(capsys, *words.split())
    assert (status, out) == (2, "")
    assert err.startswith("symkin: ")
    assert len(err.splitlines()) == 1
    assert all(text in err for text in expected), err
