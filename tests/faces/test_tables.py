"""Tables of results: within 80 columns, units as `x [mm]`, passive joints where they are asked for
or tell solutions apart.
"""

import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

import symkin
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.inside import TERMINAL_WIDTH, folded
from helpers.shipped import TWELVE, UNDRIVEN

NAMES = [name for name in symkin.shipped_names() if name not in UNDRIVEN]
_CELLS = st.text("0123456789.-", min_size=1, max_size=30)


@given(
    st.integers(2, 12).flatmap(
        lambda n: st.lists(st.lists(_CELLS, min_size=n, max_size=n), min_size=1, max_size=4)
    )
)
def test_folded_tables_hold_every_cell(rows: list[list[str]]) -> None:
    """No line is wider than a terminal, and every cell of a row stands in the blocks in its order,
    after the first one.
    """
    lines = folded(rows)
    assert all(len(line) <= TERMINAL_WIDTH for line in lines)
    blocks = [block.splitlines() for block in "\n".join(lines).split("\n\n")]
    for k, row in enumerate(rows):
        cells = [block[k].split() for block in blocks]
        assert all(first[0] == row[0] for first in cells)
        assert [cell for part in cells for cell in part[1:]] == row[1:]


@pytest.mark.parametrize("name", in_gate(NAMES, TWELVE))
def test_solutions_fit_a_terminal(name: str) -> None:
    """The table of a solution, short and whole; every coordinate of the whole one has its unit."""
    found = symkin.solve(symkin.load(name))
    for everything in (False, True):
        summary = found.summary(everything=everything)
        assert all(len(line) <= TERMINAL_WIDTH for line in folded([summary.header, *summary.rows]))
    coordinates = [
        t for t in summary.header if t not in ("#", "qw", "qx", "qy", "qz", "limits", "condition")
    ]
    assert all(re.fullmatch(r".+ \[(mm|m|deg|rad)\]", title) for title in coordinates)


def test_all_shows_what_json_has(capsys: pytest.CaptureFixture[str]) -> None:
    """`--all` has the passive joints and named points that the short table counts and leaves out;
    JSON is the same.
    """
    short, whole = (run(capsys, "modes", "ankle", *more)[1] for more in ([], ["--all"]))
    assert "2 passive joints and 2 named points not shown" in short
    assert "ankle.1" not in short
    assert "not shown" not in whole
    assert all(
        title in whole for title in ("ankle.1 [deg]", "ankle.2 [deg]", "toe.x [mm]", "heel.z [mm]")
    )
    answers = [run_json(capsys, "modes", "ankle", *more)[1]["modes"] for more in ([], ["--all"])]
    assert answers[0] == answers[1]


@pytest.mark.parametrize("name", ["sarrus", "bennett", "four_bar", "delta", "zhao2000", "ankle"])
def test_no_two_rows_look_the_same(name: str) -> None:
    """Passive joints stand in the table where two modes would look the same without them, or
    nothing would stand there.
    """
    found = symkin.modes(symkin.load(name))
    summary = found.summary()
    rows = [tuple(row[1:]) for row in summary.rows]
    assert len(set(rows)) == len(rows)
    assert len(summary.header) > 2


def test_given_poses_are_told_without_rounding() -> None:
    """A pose that `modes` found, given again: the zeros of a platform above the middle are zeros,
    what was given is kept in the data.
    """
    delta = symkin.load("delta")
    pose = symkin.modes(delta, joints=[10.0, 10.0, 10.0])[0].pose
    first = str(symkin.modes(delta, pose=pose)).splitlines()[0]
    assert "e-" not in first
    assert "pose 0, 0, -" in first


@pytest.mark.parametrize(
    "command",
    [
        ("modes", "klann_leg"),
        ("track", "four_bar", "--from", "20", "--to", "200"),
        ("singularities", "zhao2000"),
    ],
)
def test_sentences_are_folded_on_a_terminal(
    command: tuple[str, ...], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Words and tables are those of a file; no line is longer than the terminal."""
    monkeypatch.setenv("COLUMNS", "80")
    plain = run(capsys, *command)[1]
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    folded = run(capsys, *command)[1]
    assert folded.split() == plain.split()
    assert max(map(len, plain.splitlines())) > 80
    assert max(map(len, folded.splitlines())) <= 80
    table = [line for line in plain.splitlines() if len(line) <= 80]
    assert set(table) <= set(folded.splitlines())
