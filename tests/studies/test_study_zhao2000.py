"""The study of zhao2000 as a reader runs it: rows against paper and computation, errata named, rows
quote what was run.

Published figures: Zhao Tieshi et al. 2000, table 1 and section 4. The computed figures were found
independently, before the study was written.
"""

from __future__ import annotations

import numpy as np
import pytest

from helpers.study_outcome import Outcome, assert_complete

pytestmark = [pytest.mark.slow, pytest.mark.long]


@pytest.fixture(scope="module")
def zhao(tmp_path_factory) -> Outcome:
    return Outcome("zhao2000", tmp_path_factory.mktemp("zhao2000"), "--points", "5")


def test_zhao_errata(zhao):
    parts = [
        "120 and 240 mm",
        "(-3.85, 23.60, +-102.45, 14.99) are wrong",
        "two platform poses",
        "cos(theta_1)",
    ]
    assert_complete(zhao, parts)
    assert "misses the line of limb 2 by 32 mm" in zhao.content["errata"][1]
    assert "245.4, 213.5, 234.6 mm" in zhao.content["errata"][2]


def test_zhao_inverse_gives_table_1(zhao):
    expected = {
        "(3), (4): inverse at (0.0": (90.0, 210.0, 330.0, 100.0),
        "(3), (4): inverse at (5.0": (81.577, 202.849, 330.636, 105.238),
    }
    for beginning, values in expected.items():
        assert zhao.number(beginning) == pytest.approx(values, abs=6e-4)
    for row, values in zip(zhao.rows("the same by symkin"), expected.values(), strict=True):
        assert row["computed"] == pytest.approx(values, abs=6e-4)
        assert np.abs(row["difference"]).max() < 0.06


def test_zhao_figure_1_is_drawn(zhao):
    """Three limbs T R T: five hinges, the two of a T at a right angle (paper, section 1)."""
    assert zhao.number("figure 1 drawn") == pytest.approx([3, 5, 90])
    assert (zhao.folder / "zhao2000_figure1.png").read_bytes()[:4] == b"\x89PNG"


def test_zhao_mobility(zhao):
    """Section 2 of the paper: 4 freedoms, one couple a limb, rank 2, no common constraint."""
    assert zhao.number("M = 6 (n - g - 1)") == 4
    couples = [
        np.array(row["computed"])
        for row in zhao.content["rows"]
        if "reciprocal couple" in row["quantity"]
    ]
    assert len(couples) == 6
    for couple in couples:
        assert couple[[0, 1, 2, 5]] == pytest.approx([0.0] * 4, abs=1e-12)
    for part in (
        "rank of the three couples",
        "screws reciprocal to all",
        "platform freedoms",
        "freedoms with nothing",
    ):
        found = [row for row in zhao.content["rows"] if part in row["quantity"]]
        assert len(found) == 2
        assert all(row["computed"] == row["paper"] for row in found)
    assert zhao.number("zhao2000, closure Jacobian")[[2, 4]].tolist() == [10, 4]
    assert zhao.number("zhao2000_links, closure Jacobian").tolist() == [19, 16, 15, 1, 4]


def test_zhao_three_routes_agree(zhao):
    for k, z in enumerate((104.964, -104.964), start=1):
        assert zhao.number(f"direct, closed form, pose {k}") == pytest.approx(
            (4.946, 5.009, z, 5.021), abs=6e-4
        )
    for k, z in enumerate((103.124, -103.124), start=3):
        assert zhao.number(f"direct, closed form, pose {k}") == pytest.approx(
            (14.613, 14.799, z, 165.013), abs=6e-4
        )
    assert zhao.number("largest difference from the closed form") < 1e-9


def test_zhao_four_modes_from_varied_guesses(zhao):
    """Every solver meets all four modes; its hits and failures are all its guesses."""
    for name in ("direct, rootfinder", "direct, IPOPT"):
        assert zhao.number(f"{name}: modes met").tolist() == [4, 0]
        hits, failures = (
            zhao.number(f"{name}: hits per mode"),
            zhao.number(f"{name}: guesses that led to no solution"),
        )
        assert hits.min() > 0
        assert hits.sum() + failures == 300
        assert 4 <= zhao.number(f"{name}: guesses needed") <= 300
    for solver in ("batched", "newton", "ipopt"):
        name = f"direct, symkin.modes by multistart, {solver}"
        assert zhao.number(f"{name}: modes met") == 4
        assert min(zhao.rows(f"{name}: hits")[0]["computed"]) > 0
        assert zhao.number(f"{name}: largest difference") < 1e-7


def test_zhao_inputs_and_rounding(zhao):
    """Only the paper's four inputs stand on the base; the printed pose lies within what the inputs'
    rounding explains.
    """
    for row in (
        row for row in zhao.content["rows"] if "every motor on the base" in row["quantity"]
    ):
        assert row["computed"] == row["paper"] == [[0, 5, 10, 15]]
    assert zhao.rows("'the difference comes from")[0]["verdict"] == "reproduced"
    bound, gap = (
        zhao.number("most that the inputs' rounding"),
        zhao.number("printed direct less table 1's pose"),
    )
    assert np.all(np.abs(gap) <= bound + 0.005)


def test_zhao_real_limbs(zhao):
    assert zhao.number("real limbs: configurations, poses").tolist() == [16, 2]
    counts = [row["computed"] for row in zhao.rows("configurations at")]
    assert counts == [[8, 2, 2, 2], [8, 2, 2, 2], [0, 0, 0, 0], [0, 0, 0, 0]]
    assert zhao.number("limb lengths at gamma = 165.013") == pytest.approx(
        [245.4, 213.5, 234.6], abs=0.05
    )


def test_zhao_verdict_on_the_four_poses(zhao):
    """The first pair is right, the second misses limb 2 by 32 mm, from arcsin's 14.99 and lines 1
    and 3.
    """
    judged = [
        row for row in zhao.content["rows"] if "distances from the three lines" in row["quantity"]
    ]
    assert [row["verdict"] for row in judged] == ["reproduced", "reproduced", "refuted", "refuted"]
    assert zhao.number("inverse of the paper's")[1] == pytest.approx(177.5, abs=0.05)
    assert zhao.number("arcsin of the two roots") == pytest.approx([5.02, 14.99], abs=5e-3)
    assert zhao.number("Xp, Yp there from lines 1 and 3") == pytest.approx([-3.85, 23.60], abs=5e-3)


def test_zhao_upside_down(zhao):
    assert zhao.number("upside down, table 1 row 2") > 1.0
    assert zhao.number("upside down, row 1") == pytest.approx([0.0] * 3, abs=1e-10)
    assert zhao.number("longest limb on that self-motion") > 140.0
