"""Lists of many modes are told by what was found, and what meets at a singular point in sentences
that make sense.
"""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import Meeting, _labels, shown_numbers
from helpers.samples import rus


@pytest.mark.parametrize("limbs", in_gate([2, 4], [2]))
def test_modes_are_listed_by_sets_of_motors(limbs):
    """4^n modes of 2^n sets of motors: each set is printed before another mode of it, by its number
    in the list, and the U joints in which others differ are named.
    """
    found = symkin.modes(rus(limbs), pose=[5.0, 0.0, 250.0, 1.0, 0.0, 0.0, 0.0])
    motors = np.array([[mode.joints[f"m{k}"] for k in range(limbs)] for mode in found])
    sets = {tuple(np.round(row, 6)) for row in motors.tolist()}
    assert (len(found), found.poses, len(sets), len(found.representatives)) == (
        4**limbs,
        1,
        2**limbs,
        2**limbs,
    )
    assert f"{2**limbs} sets of actuated joints" in str(found)
    assert all(f"u{k}" in str(found) for k in range(limbs))
    shown = shown_numbers(found, most=2**limbs)
    assert {tuple(np.round(motors[k - 1], 6)) for k in shown} == sets
    if len(found) > 64:
        assert [int(row[0]) for row in found.summary().rows] == shown
    told = found.to_dict()
    assert (told["count"], told["listed"], len(told["modes"]), told["poses"]) == (
        4**limbs,
        4**limbs,
        4**limbs,
        1,
    )


def test_arms_and_elbows_are_no_universal_joints():
    """Modes of an arm are sets of motors each, and those of a five-bar's loops differ in more than
    U joints.
    """
    for found in (symkin.modes(symkin.load("ur5e")), symkin.modes(symkin.load("jansen_leg"))):
        assert len(found.representatives) == len(found)
        assert "U joint" not in str(found)


def test_a_picture_of_many_modes_shows_different_machines(tmp_path: Path):
    found = symkin.modes(rus(3), pose=[5.0, 0.0, 250.0, 1.0, 0.0, 0.0, 0.0])
    figure = found.plot(tmp_path / "modes.png")
    words = " ".join(text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text")))
    assert "8 sets of actuated joints" in words


def test_no_modes_are_no_poses():
    for machine, pose in (
        (rus(2), [0, 0, 2000.0, 1, 0, 0, 0]),
        (symkin.load("delta"), [0, 0, -900.0, 1, 0, 0, 0]),
    ):
        found = symkin.modes(machine, pose=pose)
        assert (len(found), found.poses, found.representatives, found.to_dict()["poses"]) == (
            0,
            0,
            [],
            0,
        )
        assert "no real solution" in str(found)


def test_equal_rows_have_one_label():
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(50, 9))
    which = rng.integers(50, size=4000)
    labels = _labels(rows[which] + 1e-9 * rng.normal(size=(4000, 9)))
    first = {}
    assert labels.tolist() == [first.setdefault(k, len(first)) for k in which.tolist()]


@pytest.mark.parametrize(
    ("own", "others", "count", "said", "not_said"),
    [
        (None, (), 0, "lists no mode at 0.25", "the 0"),
        (None, (), 4, "the mode followed is none of the 4", "near"),
        (None, (2,), 4, "mode 2 is near it", "meets"),
        (
            1,
            (),
            4,
            "mode 1 of the 4 that `modes` lists at 0.25 of the path (sampled) was followed",
            "meets",
        ),
        (1, (2, 3), 4, "meets modes 2 and 3", "followed"),
    ],
)
def test_what_meets_is_told_in_sentences(own, others, count, said, not_said):
    text = str(Meeting(0.25, {}, own, others, count, "sampled"))
    assert said in text
    assert not_said not in text
    alone = dataclasses.replace(Meeting(0.25, {}, 1, (2,), 4, "sampled"), opposite_signs=True)
    assert str(alone).endswith("meets mode 2, with determinants of opposite sign")
