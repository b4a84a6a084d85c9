"""The studies of enumeration as a reader runs them: exit 0, picture, and what they compute against
theorems and sources.

Known counts: 40 for six distances (Ronga and Vust 1992), all of them real for Dietmaier's platform
(Dietmaier 1998); 16 for the general 6R (Primrose 1986), all real for the arm of Manseur and Doty
(1989), 8 with three parallel or concurrent axes (Pieper 1968). Counts of platforms with shared
joint centres: see the study.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.study_outcome import command
from studies.others import dietmaier1998
from studies.others import hexapod_classes as hexapods
from studies.others.hexapod_classes import IncidenceClass, all_classes, canonical, from_list
from studies.others.solvers import never

pytestmark = [pytest.mark.slow, pytest.mark.long]

DATA = json.loads((Path(__file__).parents[1] / "data" / "dietmaier1998.json").read_text())


class Study:
    """A study run once as a command: its JSON, by the beginnings of its rows' names."""

    def __init__(self, name: str, folder: Path, *options: str) -> None:
        done = subprocess.run(
            command(name, folder, *options),
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        content = json.loads((folder / f"{name}.json").read_text())
        assert content["seed"] is None or f"seed {content['seed']}" in done.stdout
        self.rows = content["rows"]

    def all(self, beginning: str) -> list[dict]:
        found = [row for row in self.rows if row["quantity"].startswith(beginning)]
        assert found, beginning
        return found

    def __getitem__(self, beginning: str) -> object:
        (row,) = self.all(beginning)
        return row["computed"]


def assert_complete(statement: str) -> None:
    """A result that claims to be complete and has no unresolved path."""
    assert statement.startswith(("proved", "probability one"))
    assert "0 paths unresolved" in statement


# --- 40 real modes --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def dietmaier(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study("dietmaier1998", tmp_path_factory.mktemp("dietmaier1998"))


def test_the_study_has_the_published_numbers():
    """Base, platform and legs are those of the published example."""
    for ours, published in (
        (dietmaier1998.BASE, "base"),
        (dietmaier1998.PLATFORM, "platform"),
        (dietmaier1998.LEGS, "legs"),
    ):
        np.testing.assert_array_equal(ours, DATA[published])


@pytest.mark.slow
def test_all_forty_modes_are_real(dietmaier):
    """As many real modes as the bound for six distances has complex ones, each at the legs'
    lengths, no two alike.
    """
    assert dietmaier["complex solutions"] == dietmaier["real modes"] == 40
    assert_complete(dietmaier["completeness"])
    assert dietmaier["largest leg error, plain arithmetic"] < 1e-12
    assert dietmaier["two nearest modes"] > 1e-3


def test_certificates_are_reported_as_they_are(dietmaier):
    """Proved means that every one of the 40 is certified, each in a radius far below the modes'
    distance.
    """
    certified, radius = dietmaier["certified modes"], dietmaier["largest radius"]
    assert (radius is None) == (certified == 0)
    if dietmaier["completeness"].startswith("proved"):
        assert certified == 40
    assert radius is None or radius < 1e-6


def test_rounded_legs_keep_an_even_number(dietmaier):
    """Real modes come and go in pairs, never more than 40."""
    counts = [row["computed"] for row in dietmaier.all("legs rounded")]
    assert all(count % 2 == 0 and count <= 40 for count in counts)


# --- shared joint centres -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def classes(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study("hexapod_classes", tmp_path_factory.mktemp("hexapod_classes"), "--named")


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(hexapods.NAMED))
def test_named_classes_have_their_known_counts(classes, kind):
    """40 for 6-6, 6-5 and 5-5, 32 for 6-4, 24 for 4-4, 16 for 6-3 and 3-3, with the lists that the
    study writes out.
    """
    text, count = hexapods.NAMED[kind]
    assert classes[f"{kind}: {from_list(text)}"] == count


def test_plane_hexagons(classes):
    """General hexagons in planes keep 40; a common symmetry of order three leaves 28."""
    assert classes["6-6 with plane hexagons"] == 40
    assert classes["6-6 with semi-regular hexagons"] == 28


def test_no_search_of_classes_was_only_sampled(classes):
    assert "sampled" not in classes["completeness of these searches"]
    assert "incomplete" not in classes["completeness of these searches"]


def test_classes_are_distinct_graphs_of_six_legs():
    """Each graph once, also after exchanging base and platform; six legs, one to three a point."""
    classes = all_classes()
    both = {
        max(g.matrix, canonical(tuple(zip(*g.matrix, strict=True))))
        if len(g.matrix) == len(g.matrix[0])
        else g.matrix
        for g in classes
    }
    assert len(both) == len(classes)
    for graph in classes:
        matrix = np.array(graph.matrix)
        assert matrix.sum() == 6
        for degrees in (matrix.sum(axis=0), matrix.sum(axis=1)):
            assert degrees.min() >= 1
            assert degrees.max() <= 3


def test_only_two_stars_do_not_hold_the_platform():
    """Three legs fix a platform point in the base and three others a base point in the platform:
    their distance is fixed twice. Every other class is rigid.
    """
    (loose,) = [graph for graph in all_classes() if not graph.is_rigid]
    assert (
        sorted(map(sum, loose.matrix))
        == sorted(map(sum, zip(*loose.matrix, strict=True)))
        == [1, 1, 1, 3]
    )
    assert len(loose.legs) == 6


@pytest.mark.parametrize(
    ("text", "count"), [("B1P1 B1P2 B2P1 B2P3 B3P4 B4P4", 16), ("B1P1 B1P2 B1P3 B2P1 B3P4 B4P4", 8)]
)
def test_the_count_depends_on_the_incidence_list(text, count):
    """Other 4-4 platforms than the one of 24: a third or more of the modes is gone. Exchanging base
    and platform changes no count.
    """
    graph, rng = from_list(text), np.random.default_rng(8)
    turned = IncidenceClass(tuple(zip(*graph.matrix, strict=True)))
    for g in (graph, turned):
        found = hexapods.modes_at_random_pose(
            hexapods.machine(g, *hexapods.random_points(g, rng)), rng
        )
        assert (g.type, found.complex_count, found.unresolved_paths) == ("4-4", count, 0)


# --- arms -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def arms(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study("general_6r", tmp_path_factory.mktemp("general_6r"), "--poses", "4")


@pytest.mark.slow
def test_sixteen_real_solutions(arms):
    """The arm of Manseur and Doty: 16 of 16 real, each brought back to the pose by forward
    kinematics.
    """
    assert arms["Manseur and Doty's arm: complex"] == arms["Manseur and Doty's arm: real"] == 16
    assert_complete(arms["its completeness"])
    assert arms["its forward kinematics"] < 1e-10
    assert arms["printed hand less the nearest rotation"] < 1e-6


def test_eight_with_special_axes(arms):
    """Three parallel axes, and a 5R1P with three concurrent ones: 8, of which an even number is
    real.
    """
    for name in ("gluon_6l3", "yao2020"):
        (count,) = [
            row["computed"]
            for row in arms.all(name)
            if row["quantity"].endswith("complex solutions")
        ]
        (real,) = [
            row["computed"]
            for row in arms.all(name)
            if "poses that have so many" in row["quantity"]
        ]
        assert count == 8
        assert all(int(part.split(":")[0]) % 2 == 0 for part in real.split(", "))


# --- multistart against the complete set ----------------------------------------------------------


@pytest.fixture(scope="module")
def coverage(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study("coverage", tmp_path_factory.mktemp("coverage"), "--scale", "0.1")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "total"), [("zhang2009", 4), ("dietmaier1998", 40), ("yao2020", 4)]
)
def test_multistart_finds_nothing_more(coverage, name, total):
    """Every mode that any solver reaches from random starts is one of the complete set."""
    assert f"{total} real" in coverage[f"{name}: complete set"]
    assert coverage[f"{name}: modes that only multistart found"] == 0
    for row in coverage.all(f"{name}, "):
        if "modes met of" in row["quantity"]:
            met, share, rarest, _ = row["computed"]
            assert 0 <= met <= total
            assert 0 <= share <= 100
            assert (rarest >= 1) == (met >= 1)
    assert all(0 <= unseen <= total for unseen in coverage[f"{name}: unseen modes, in truth"])


def test_few_starts_miss_modes(coverage):
    """Of 40 modes, three starts can meet three at most."""
    assert coverage["dietmaier1998, batched starts"][0] == 3
    assert coverage["dietmaier1998: unseen modes, in truth"][0] >= 37


def test_coverage_formula_is_the_mean_over_samples():
    """C(N - h, n) / C(N, n) is the share of samples of n of N starts that miss all h hits."""
    rng, (N, h, n) = np.random.default_rng(0), (30, 4, 7)
    missed = np.mean([np.all(rng.permutation(N)[:n] >= h) for _ in range(20_000)])
    assert never(N, h, n) == pytest.approx(missed, abs=0.015)
    assert never(N, h, 0) == pytest.approx(1.0)
    assert never(N, h, N) == 0.0


# --- near a singularity ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def singular(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study("near_singular", tmp_path_factory.mktemp("near_singular"))


@pytest.mark.slow
def test_the_walk_ends_at_a_type_2_singularity(singular):
    """det J = 0 with one vanishing singular value."""
    largest, fifth, sixth = singular["singular values of J"]
    assert sixth < 1e-14 * largest
    assert fifth > 1e-3 * largest


def test_merging_modes_are_two_d_apart(singular):
    """Law: a fold. Down to d = 1e-5 both modes are there, 2 d apart, their condition grows as 1 /
    d.
    """
    assert singular["smallest d at which both"] <= 1e-5
    rows = [row["computed"] for row in singular.all("d = ") if "apart" in row["quantity"]]
    apart, condition = np.array([[row[0], row[1]] for row in rows[:5]], dtype=float).T
    np.testing.assert_allclose(apart[1:], [2e-2, 2e-3, 2e-4, 2e-5], rtol=1e-3)
    np.testing.assert_allclose(condition[2:] / condition[1:-1], 10.0, rtol=0.05)


def test_nothing_is_lost_or_invented_in_silence(singular):
    """At every d both merging modes are found, or one is flagged, or a path is unresolved; beyond,
    no complex pair is called real without a flag; modes elsewhere do not change.
    """
    assert singular["d at which one or both are lost"] == "none"
    assert singular["d at which a complex pair"] == "none"
    assert len(set(singular["modes elsewhere"])) == 1
    assert singular["largest residual over the size"] < 1e-9


# --- the papers -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "real", "complex_count"), [("zhang2009", 4, 28), ("zhao2000", 4, 4)]
)
def test_the_papers_sets_are_complete(name, real, complex_count):
    """28 complex and 4 real modes of the platform; the four poses of the line model: no path
    unresolved.
    """
    found = symkin.modes(symkin.load(name), joints=symkin.load(name).example.joints)
    assert (len(found), found.complex_count, found.unresolved_paths) == (real, complex_count, 0)
    assert found.completeness in ("proved", "probability one")
