"""The two platform studies as a reader runs them: exit 0, picture, numbers against paper and computation, errata named.

Published figures: Zhang Zhaoyin 2009, table 1; Zhao Tieshi et al. 2000, table 1 and section 4. The computed
figures were found independently, before these studies were written.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from study_outcome import Outcome, assert_complete


@pytest.fixture(scope="module")
def zhang(tmp_path_factory) -> Outcome:
    return Outcome("zhang2009", tmp_path_factory.mktemp("zhang2009"))


def test_zhang_errata(zhang):
    assert_complete(zhang, ["B_1 = (0, -125, 0)", "row 3, column 1 of T", "X - C D"])


def test_zhang_inverse_gives_table_1(zhang):
    """Paper's table 1; reference lengths computed: all six 138.009 mm with the frames coincident."""
    assert zhang.number("limb lengths, frames coincident") == pytest.approx([138.009] * 6, abs=5e-4)
    expected = [144.61, 347.00, 110.25, 178.68, 277.61, 269.45]
    for row in ("limb lengths at (119, 88, 72", "the same by symkin"):
        assert zhang.number(row) == pytest.approx(expected, abs=6e-3)
        assert zhang.rows(row)[0]["paper"] == [144.6, 347.0, 110.3, 178.6, 277.6, 269.4]
    assert zhang.number("of these truncate or round") == 6


def test_zhang_newton_converges_quadratically(zhang):
    """8 or 9 steps to the evident pose; each late residual is far below the one before."""
    steps = zhang.rows("Newton, step")
    assert int(zhang.number("Newton steps from")) == len(steps) - 1 in (8, 9)
    residuals = [row["computed"][6] for row in steps]
    assert residuals[-1] < 1e-9
    assert all(b < 0.05 * a for a, b in pairwise(residuals[4:]))
    pose = (119.030, 88.011, 71.936, 10.001, 20.990, 14.992)
    assert steps[-1]["computed"][:6] == pytest.approx(pose, abs=6e-4)
    for row in zhang.rows("CasADi rootfinder"):
        assert row["computed"] == pytest.approx(pose, abs=6e-4)
    assert "not comparable" in zhang.rows("Newton steps from")[0]["paper"]


def test_zhang_four_modes_in_two_mirror_pairs(zhang):
    first = np.array([119.030, 88.011, 71.936, 10.001, 20.990, 14.992])
    second = np.array([91.608, 100.062, 42.934, 7.371, 35.260, 15.558])
    mirror = np.array([1, 1, -1, -1, -1, 1])
    assert zhang.number("real modes") == 4
    assert zhang.number("mirror pairs") == 2
    modes = [np.array(row["computed"]) for row in zhang.rows("mode ")]
    for expected in (first, mirror * first, second, mirror * second):
        assert sum(np.abs(mode - expected).max() < 1e-3 for mode in modes) == 1
    assert [row["computed"] for row in zhang.rows("modes reached by symkin.solve")] == [4, 4, 4]


def test_zhang_misprints_lead_astray(zhang):
    assert zhang.number("rank of D").tolist() == [5, 6]
    false_pose = (123.134, 94.730, 68.333, 8.483, 30.722, 15.164)
    assert zhang.number("Newton, T as printed") == pytest.approx(false_pose, abs=6e-4)
    assert np.abs(zhang.number("limb lengths there under the right")).max() > 20.0
    assert zhang.number("printed update X - C D") == pytest.approx([-1.0, -1.0], abs=1e-9)
