"""Twins find what differs between two checkouts, and the third method says who is right; a child
that hangs or crashes ends alone.
"""

import copy

import pytest

from campaigns.children import run_each
from campaigns.twin_answers import answers
from campaigns.twin_cases import make_case, text_of
from campaigns.twin_compare import differences
from campaigns.twin_judge import judged
from campaigns.twin_oracle import numbers_only


def work(task, send):
    send("begun")
    if task == "hangs":
        while True:
            pass
    if task == "crashes":
        raise ValueError("no")
    send(task)


def test_a_hang_and_a_crash_are_entries_and_no_end():
    found = {e.task: e for e in run_each(["hangs", "crashes", "works"], work, 2, 1.0)}
    assert found["works"].sent == ["begun", "works"]
    assert found["works"].fault is None
    assert found["hangs"].sent == ["begun"]
    assert "processor time" in found["hangs"].fault
    assert "ended with 1" in found["crashes"].fault


def test_arithmetic_of_files_is_worked_out_and_names_are_left():
    data = {
        "angle_unit": "deg",
        "joint": [{"name": "pi", "type": "R", "point": ["3*cos(60)", 0, 1]}],
        "of": "pi",
    }
    read = numbers_only(data)
    assert read["joint"][0]["point"] == [pytest.approx(1.5), 0, 1]
    assert read["joint"][0]["name"] == read["of"] == "pi"


@pytest.fixture(scope="module")
def entry():
    """A four-bar and an arm, as `write` keeps them."""
    found = {}
    for name in ("shipped four_bar", "shipped gluon_6l3"):
        case, sent = make_case(name, text_of(name), 0), []
        answers(case, sent.append)
        found[name] = {"case": case, "answers": dict(sent), "fault": None}
    return found


def faulty(entry, name, key, change):
    """What is told of an entry and of one with a change in the answer to a question."""
    spoilt = copy.deepcopy(entry[name])
    change(spoilt["answers"][key])
    return {d.kind: (judged(d).who, d) for d in differences(name, entry[name], spoilt)}


def drop_mode(answer):
    answer["modes"].pop()
    answer["count"] -= 1


def test_equal_answers_have_no_difference(entry):
    for name, one in entry.items():
        assert list(differences(name, one, copy.deepcopy(one))) == []


@pytest.mark.parametrize(
    ("name", "key"), [("shipped four_bar", "direct 0"), ("shipped gluon_6l3", "inverse 0")]
)
def test_a_lost_mode_is_found_and_old_is_right(entry, name, key):
    found = faulty(entry, name, key, drop_mode)
    assert {kind: who for kind, (who, _) in found.items()} == {
        "count": "old is right",
        "modes": "old is right",
    }


def test_a_mode_that_does_not_close_is_found_and_old_is_right(entry):
    def bend(answer):
        answer["modes"][0]["joints"]["follower"] += 1.0

    found = faulty(entry, "shipped four_bar", "direct 0", bend)
    assert found["modes"][0] == "old is right"


def test_a_whole_turn_and_the_sign_of_a_quaternion_are_no_difference(entry):
    def turn(answer):
        mode = answer["modes"][0]
        mode["joints"]["q1"] += 360.0
        mode["pose"][3:] = [-v for v in mode["pose"][3:]]

    assert faulty(entry, "shipped gluon_6l3", "inverse 0", turn) == {}


def test_a_wrong_jacobian_is_found_and_old_is_right(entry):
    def turn(answer):
        row = answer["modes"][0]["jacobians"]["direct"]["wx"]
        row["q1"] += 0.5

    found = faulty(entry, "shipped gluon_6l3", "direct 0", turn)
    assert {kind: who for kind, (who, _) in found.items()} == {"jacobian direct": "old is right"}


def test_claims_and_counts_are_judged_by_the_independent_closure(entry):
    def weaken(answer):
        answer["modes"][0]["certified"] = False
        answer["completeness"] = "sampled"

    found = faulty(entry, "shipped four_bar", "direct 0", weaken)
    assert {kind: who for kind, (who, _) in found.items()} == {
        "certified": "old is right",
        "completeness": "old is right",
    }
    assert (
        faulty(entry, "shipped four_bar", "mobility", lambda a: a.update(mobility=2))["mobility"][0]
        == "old is right"
    )


def test_the_identified_rank_is_judged_by_differences(entry):
    found = faulty(
        entry, "shipped gluon_6l3", "calibration", lambda a: a.update(rank=a["rank"] - 1)
    )
    assert found["rank"][0] == "old is right"


def test_a_refusal_of_what_was_answered_is_found(entry):
    def refuse(answer):
        answer.clear()
        answer["refused"] = "no"

    found = faulty(entry, "shipped four_bar", "direct 1", refuse)
    assert found["state"][0] == "old is right"
