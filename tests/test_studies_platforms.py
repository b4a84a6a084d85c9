"""The two platform studies as a reader runs them: exit 0, picture, numbers against paper and computation, errata named.

Published figures: Zhang Zhaoyin 2009, table 1; Zhao Tieshi et al. 2000, table 1 and section 4. The computed
figures were found independently, before these studies were written.
"""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).resolve().parent.parent / "studies"


class Outcome:
    """What a study printed and wrote."""

    def __init__(self, name: str, folder: Path) -> None:
        command = [sys.executable, "-W", "error", str(STUDIES / f"{name}.py"), "-o", str(folder)]
        self.run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        self.picture = folder / f"{name}.png"
        self.content = json.loads((folder / f"{name}.json").read_text()) if self.run.returncode == 0 else {}

    def rows(self, beginning: str) -> list[dict]:
        found = [row for row in self.content["rows"] if row["quantity"].startswith(beginning)]
        assert found, f"no row begins with {beginning!r}"
        return found

    def number(self, beginning: str) -> np.ndarray:
        """`computed` of the only row that begins so."""
        (row,) = self.rows(beginning)
        return np.array(row["computed"])


@pytest.fixture(scope="module")
def zhang(tmp_path_factory) -> Outcome:
    return Outcome("zhang2009", tmp_path_factory.mktemp("zhang2009"))


@pytest.fixture(scope="module")
def zhao(tmp_path_factory) -> Outcome:
    return Outcome("zhao2000", tmp_path_factory.mktemp("zhao2000"))


def assert_complete(outcome: Outcome, errata: list[str]) -> None:
    """Exit 0, a PNG, finite differences, every erratum in the JSON and in print, in order."""
    assert outcome.run.returncode == 0, outcome.run.stderr
    assert outcome.picture.read_bytes()[:4] == b"\x89PNG"
    assert len(outcome.content["errata"]) == len(errata)
    assert outcome.run.stdout.count("Erratum, shown by computation") == len(errata)
    for text, part in zip(outcome.content["errata"], errata, strict=True):
        assert part in text


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


def test_zhao_errata(zhao):
    parts = ["120 and 240 mm", "(-3.85, 23.60, +-102.45, 14.99) are wrong", "two platform poses", "cos(theta_1)"]
    assert_complete(zhao, parts)
    assert "misses the line of limb 2 by 32 mm" in zhao.content["errata"][1]
    assert "245.4, 213.5, 234.6 mm" in zhao.content["errata"][2]


def test_zhao_inverse_gives_table_1(zhao):
    expected = {"inverse at (0.0": (90.0, 210.0, 330.0, 100.0), "inverse at (5.0": (81.577, 202.849, 330.636, 105.238)}
    for beginning, values in expected.items():
        assert zhao.number(beginning) == pytest.approx(values, abs=6e-4)
    for row, values in zip(zhao.rows("the same by symkin"), expected.values(), strict=True):
        assert row["computed"] == pytest.approx(values, abs=6e-4)
        assert np.abs(row["difference"]).max() < 0.06


def test_zhao_mobility(zhao):
    """Section 2 of the paper: 4 freedoms, one couple a limb, rank 2, no common constraint."""
    assert zhao.number("6 (n - g - 1)") == 4
    couples = [np.array(row["computed"]).ravel() for k in (1, 2, 3) for row in zhao.rows(f"limb {k}: reciprocal couple")]
    assert len(couples) == 6
    for couple in couples:
        assert couple[[0, 1, 2, 5]] == pytest.approx([0.0] * 4, abs=1e-12)
    for row in ("rank of the three couples", "screws reciprocal to all", "platform freedoms"):
        assert all(r["computed"] == r["paper"] for r in zhao.rows(row))
    assert zhao.number("zhao2000, closure Jacobian")[[2, 4]].tolist() == [10, 4]
    assert zhao.number("zhao2000_links, closure Jacobian").tolist() == [19, 16, 15, 1, 4]


def test_zhao_three_routes_agree(zhao):
    for k, z in enumerate((104.964, -104.964), start=1):
        assert zhao.number(f"direct, closed form, pose {k}") == pytest.approx((4.946, 5.009, z, 5.021), abs=6e-4)
    for k, z in enumerate((103.124, -103.124), start=3):
        assert zhao.number(f"direct, closed form, pose {k}") == pytest.approx((14.613, 14.799, z, 165.013), abs=6e-4)
    for name in ("rootfinder", "IPOPT"):
        assert zhao.number(f"{name}, ")[0] == 4
    for name in ("rootfinder", "IPOPT", "symkin.modes"):
        assert zhao.number(f"{name}: largest difference") < 1e-9


def test_zhao_real_limbs(zhao):
    assert zhao.number("real limbs").tolist() == [16, 2]
    counts = [row["computed"] for row in zhao.rows("configurations at")]
    assert counts == [[8, 2, 2, 2], [8, 2, 2, 2], [0, 0, 0, 0], [0, 0, 0, 0]]
    assert zhao.number("limb lengths at gamma = 165.013") == pytest.approx([245.4, 213.5, 234.6], abs=0.05)


def test_zhao_verdict_on_the_four_poses(zhao):
    """The first pair is right, the second misses limb 2 by 32 mm, from arcsin's 14.99 and lines 1 and 3."""
    verdicts = [row["quantity"].split(": ")[1].split(";")[0] for row in zhao.rows("(")]
    assert verdicts == ["right", "right", "wrong", "wrong"]
    assert zhao.number("inverse of the paper's")[1] == pytest.approx(177.5, abs=0.05)
    assert zhao.number("arcsin of the two roots") == pytest.approx([5.02, 14.99], abs=5e-3)
    assert zhao.number("Xp, Yp there from lines 1 and 3") == pytest.approx([-3.85, 23.60], abs=5e-3)


def test_zhao_upside_down(zhao):
    assert zhao.number("upside down, table 1 row 2") > 1.0
    assert zhao.number("upside down, row 1") == pytest.approx([0.0] * 3, abs=1e-10)
    assert zhao.number("longest limb on that self-motion") > 140.0
