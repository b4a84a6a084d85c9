"""The study of zhang2009 as a reader runs it: rows against paper and computation, errata named,
rows quote what was run.

Published figures: Zhang Zhaoyin 2009, section 2.1 and table 1. The computed figures were found
independently, before the study was written.
"""

from __future__ import annotations

import shutil
from itertools import pairwise

import numpy as np
import pytest

from helpers.study_outcome import Outcome, assert_complete

pytestmark = [pytest.mark.slow, pytest.mark.long]

TABLE_1 = [144.6, 347.0, 110.3, 178.6, 277.6, 269.4]
POSE = (119.030, 88.011, 71.936, 10.001, 20.990, 14.992)
MODES = [np.array(POSE), np.array([91.608, 100.062, 42.934, 7.371, 35.260, 15.558])]
MIRROR = np.array([1, 1, -1, -1, -1, 1])


@pytest.fixture(scope="module")
def zhang(tmp_path_factory) -> Outcome:
    return Outcome("zhang2009", tmp_path_factory.mktemp("zhang2009"), "--points", "5")


def test_zhang_errata_and_pictures(zhang):
    parts = [
        "called quadratic",
        "not the fewest unknowns",
        "B_1 = (0, -125, 0)",
        "row 3, column 1 of T",
        "X - C D",
    ]
    assert_complete(zhang, parts)
    for name in ("figure1", "guesses", "unknowns"):
        assert (zhang.folder / f"zhang2009_{name}.png").stat().st_size > 20_000


def test_zhang_inverse_gives_table_1(zhang):
    """Paper's table 1; reference lengths computed: all six 138.009 mm with the frames
    coincident.
    """
    assert zhang.number("limb lengths, frames coincident") == pytest.approx([138.009] * 6, abs=5e-4)
    expected = [144.61, 347.00, 110.25, 178.68, 277.61, 269.45]
    for row in ("limb lengths at (119, 88, 72", "the same by symkin"):
        assert zhang.number(row) == pytest.approx(expected, abs=6e-3)
        assert zhang.rows(row)[0]["paper"] == TABLE_1
    assert zhang.number("of these truncate or round") == 6


def test_zhang_geometry(zhang):
    """Section 2.1: arcs of 30 and 90 degrees; only B_1 of the printed matrices is off its
    circle.
    """
    for letter in "AB":
        assert zhang.number(f"central angles of the {letter}_i") == pytest.approx(
            [30] * 3 + [90] * 3
        )
    assert zhang.number("printed matrix A") == pytest.approx([250] * 6)
    assert zhang.number("printed matrix B") == pytest.approx([125] + [275] * 5)
    assert zhang.number("B of equations (2)") == pytest.approx([275] * 6)


def test_zhang_printed_lines(zhang):
    """One entry of T is misprinted; A_4 lies on the y axis, so that z_4 alone does not take it from
    the first column.
    """
    assert zhang.rows("entries of the printed rotation")[0]["computed"] == "3, 1"
    assert zhang.rows("lines of x_1 to z_6")[0]["computed"] == "z_1, z_2, z_3, z_5, z_6"
    assert zhang.number("D by CasADi less D by the axes") < 1e-12


def test_zhang_newton_converges_quadratically(zhang):
    """8 or 9 steps to the evident pose; each late residual is far below the one before."""
    steps = zhang.rows("Newton, step")
    assert int(zhang.number("Newton steps from")) == len(steps) - 1 in (8, 9)
    residuals = [row["computed"][6] for row in steps]
    assert residuals[-1] < 1e-9
    assert all(b < 0.05 * a for a, b in pairwise(residuals[4:]))
    assert steps[-1]["computed"][:6] == pytest.approx(POSE, abs=6e-4)
    for row in zhang.rows("CasADi rootfinder"):
        assert row["computed"] == pytest.approx(POSE, abs=6e-4)
    missing = [row["quantity"] for row in zhang.content["rows"] if row["verdict"] == "outside"]
    assert any("table 2" in text for text in missing)
    assert any("table 3" in text for text in missing)


def test_zhang_four_modes_in_two_mirror_pairs(zhang):
    assert zhang.number("real modes") == 4
    assert zhang.number("complex solutions") == 28
    assert zhang.number("mirror pairs") == 2
    modes = [np.array(row["computed"]) for row in zhang.rows("mode ")]
    for expected in (*MODES, *(MIRROR * mode for mode in MODES)):
        assert sum(np.abs(mode - expected).max() < 1e-3 for mode in modes) == 1
    assert [row["computed"] for row in zhang.rows("modes reached by symkin.solve")] == [4, 4, 4]


def test_zhang_modes_from_varied_guesses(zhang):
    """Hits and failures are all the guesses; every search in six and in 24 unknowns meets all four
    modes.
    """
    for solver in ("Newton", "rootfinder", "IPOPT"):
        for unknowns in (6, 24):
            name = f"direct, {solver}, {unknowns} unknowns"
            hits, failures = (
                zhang.number(f"{name}: hits per mode"),
                zhang.number(f"{name}: guesses that led to no solution"),
            )
            assert hits.sum() + failures == 200
            assert zhang.number(f"{name}: modes met").tolist() == [4, 0]
    for solver in ("batched", "newton", "ipopt"):
        name = f"direct, symkin.modes by multistart, {solver}"
        assert zhang.number(f"{name}: modes met").tolist() == [4, 0]
        assert zhang.number(f"{name}: largest difference") < 1e-7


def test_zhang_six_unknowns_beside_24(zhang):
    """The same steps from the same start; a dense inverse takes 4 n^3 operations within a tenth, so
    that a step of 24 unknowns costs many times one of six.
    """
    six, many = (int(zhang.number(f"{n} unknowns: Newton steps")) for n in (6, 24))
    assert six == many == 8
    for n in (3, 6, 24):
        assert zhang.number(f"{n} unknowns: operations")[1] == pytest.approx(4 * n**3, rel=0.1)
    assert zhang.number("operations of a step, 24 over six") > 20
    assert zhang.number("third derivatives of the quadratic") < 1e-9
    assert zhang.number("third derivatives of 'quadratic") > 0.1
    assert zhang.number("rootfinder in three unknowns") == pytest.approx(POSE, abs=6e-4)


def test_zhang_real_time_by_instructions(zhang):
    """Committed counts: a step of the paper's method is dearer than its operations, cheaper than
    ten instructions for each.
    """
    counts = {
        name: zhang.number(f"instructions of the example, the paper's Newton, {name}")
        for name in ("6", "24")
    }
    for name, steps in (("6", 8), ("24", 8)):
        operations = zhang.number(f"{name} unknowns: operations").sum()
        assert np.all(counts[name] > 0.3 * steps * operations)
        assert np.all(counts[name] < 10 * steps * operations)
    assert zhang.number("'real time', taken as 1 ms")[0] < 1.0


@pytest.mark.skipif(
    not all(map(shutil.which, ("valgrind", "gcc"))), reason="needs valgrind and gcc"
)
def test_zhang_instructions_are_those_committed():
    """Counting anew on the host gives the committed count, but for the compiler's version."""
    from studies.zhang2009.instructions import committed, counts

    found = counts(("six",), ("host",))["six"]["host"]
    assert found["error"] < 1e-6
    assert found["instructions"] == pytest.approx(committed().of("six")[1], rel=0.25)


def test_zhang_misprints_lead_astray(zhang):
    assert zhang.number("rank of D at a start").tolist() == [5, 6]
    false_pose = (123.134, 94.730, 68.333, 8.483, 30.722, 15.164)
    assert zhang.number("Newton, T as printed") == pytest.approx(false_pose, abs=6e-4)
    assert np.abs(zhang.number("limb lengths there under the right")).max() > 20.0
    assert zhang.number("printed update X - C D") == pytest.approx([-1.0, -1.0], abs=1e-9)
