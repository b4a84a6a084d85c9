"""The file of ratios knows every part, and a ratio that is worse than allowed is told in a
sentence.
"""

import pytest

import run
from run import Known, ratios_text, read_ratios, report
from timing import Figure, in_turn, median_ratio


def test_each_part_has_ratios_with_meanings_and_factors_above_one():
    quick = read_ratios()["quick"]
    assert {name.partition(":")[0] for name in quick} == set(run.PARTS)
    assert all(known.factor > 1 and known.ratio >= 0 and known.meaning for known in quick.values())


def test_the_file_is_what_is_written():
    tables = read_ratios()
    assert run.RATIOS.read_text(encoding="utf-8") == ratios_text(tables)


def test_a_worse_ratio_is_told_and_a_better_one_or_no_peer_is_not(capsys):
    known = {
        "a": Known(1.0, 1.5, "of its peer"),
        "b": Known(1.0, 1.5, ""),
        "c": Known(1.0, 1.5, ""),
        "d": Known(0.0, 2.0, ""),
    }
    figures = [
        Figure("a", 1.6, ""),
        Figure("b", 1.4, ""),
        Figure("c", None, "is not installed"),
        Figure("d", 1, ""),
    ]
    told = report(figures, known)
    assert [sentence[0] for sentence in told] == ["a", "d"]
    assert "allowed are 1.5 (1 times 1.5): of its peer" in told[0]
    assert "no peer: is not installed" in capsys.readouterr().out


def test_an_unknown_part_is_refused(capsys):
    with pytest.raises(SystemExit):
        run.main(["--parts", "sweep,dance"])
    assert "dance is unknown; allowed: enumeration" in capsys.readouterr().err


def test_runs_take_turns_after_one_that_prepares():
    order = []
    times = in_turn({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, 2)
    assert order == ["a", "b"] * 3
    assert {name: len(t) for name, t in times.items()} == {"a": 2, "b": 2}
    assert median_ratio([2.0, 9.0, 4.0], [1.0, 1.0, 1.0]) == 4.0
