"""The studies of motion run as a reader runs them, in reduced size; their tables hold what the
closed forms demand.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from helpers.study_outcome import command

pytestmark = [pytest.mark.slow, pytest.mark.long]


def study(name: str, folder: Path, *options: str) -> list[dict]:
    """Rows of a study's JSON, once it has run without a warning and its picture is there."""
    done = subprocess.run(
        command(name, folder, *options), capture_output=True, text=True, check=False, timeout=600
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    return json.loads((folder / f"{name}.json").read_text())["rows"]


def rows_of(rows: list[dict], part: str) -> list[dict]:
    found = [row for row in rows if part in row["quantity"]]
    assert found, f"no row holds {part!r}"
    return found


def values(rows: list[dict], part: str) -> np.ndarray:
    return np.array([row["computed"] for row in rows_of(rows, part)], dtype=float)


def assert_equal_to_paper(rows: list[dict], part: str, tolerance: float = 0.0) -> None:
    """Rows whose closed form and computed value agree, and whose verdict says so."""
    for row in rows_of(rows, part):
        assert row["verdict"] == "reproduced", row
        if isinstance(row["paper"], str | bool):
            assert row["computed"] == row["paper"]
        else:
            assert np.abs(np.array(row["difference"], dtype=float)).max() <= tolerance, row


@pytest.fixture(scope="module")
def zhao(tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    return study("zhao2000_singular", tmp_path_factory.mktemp("zhao"), "--grid", "3")


@pytest.fixture(scope="module")
def zhang(tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    return study(
        "zhang2009_modes_map",
        tmp_path_factory.mktemp("zhang"),
        "--grid",
        "5",
        "--starts",
        "30",
        "--bisected",
        "2",
    )


@pytest.fixture(scope="module")
def gluon(tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    return study("gluon_singular", tmp_path_factory.mktemp("gluon"), "--random", "50")


@pytest.fixture(scope="module")
def cusp(tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    return study("cusp_3rrr", tmp_path_factory.mktemp("cusp"))


@pytest.mark.slow
def test_zhao_determinant_and_its_factors(zhao: list[dict]) -> None:
    """det A = its three factors; the circle and gamma = 60 are type 2 with the pole that statics
    gives.
    """
    assert_equal_to_paper(zhao, "det A over its factors", 1e-9)
    assert_equal_to_paper(zhao, "every position is singular", 1e-12)
    assert_equal_to_paper(zhao, "largest distance from the circle", 1e-9)
    assert_equal_to_paper(zhao, "kind and conditions")
    assert_equal_to_paper(zhao, "distance to type 2", 1e-9)
    assert_equal_to_paper(zhao, "pole of the motion", 1e-9)
    assert_equal_to_paper(zhao, "Zp = 0: motion with the inputs held")
    assert_equal_to_paper(zhao, "C_1 over a_1")


def test_zhao_coefficients_vanish_on_the_circle(zhao: list[dict]) -> None:
    """A = B = C = 0 on the circle, C^2 = A^2 + B^2 at gamma = 60, and the platform turns with its
    inputs held.
    """
    assert_equal_to_paper(zhao, "largest of |A|, |B|, |C|", 1e-12)
    assert_equal_to_paper(zhao, "plus 120, modulo 180", 1e-9)
    assert_equal_to_paper(zhao, "at 200 random positions", 1e-12)
    assert_equal_to_paper(zhao, "largest miss of the three lines", 1e-9)
    assert_equal_to_paper(zhao, "says that solutions are not isolated")


def test_zhao_mode_map(zhao: list[dict]) -> None:
    """Enumeration = closed form at every input of the grid; loci lie on a factor of det A, and
    wherever the number changes.
    """
    assert_equal_to_paper(zhao, "where enumeration = closed form")
    assert_equal_to_paper(zhao, "smallest factor of det A", 1e-9)
    assert_equal_to_paper(zhao, "where the closed-form number changes")


@pytest.mark.slow
def test_zhang_boundaries_are_the_loci(zhang: list[dict]) -> None:
    """The number of modes changes where the independent locus is, to the bisection's 1e-5 mm; the
    polyline of the picture to the height of its chords.
    """
    assert_equal_to_paper(zhang, "grid edges along leg 1")
    assert_equal_to_paper(zhang, "bisected on", 0.2)
    assert_equal_to_paper(zhang, "the same less Newton", 1e-5)
    assert set(rows_of(zhang, "numbers of real modes")[0]["computed"]) <= {0, 4, 8, 12}


def test_zhang_right_angle(zhang: list[dict]) -> None:
    """gamma = +-90: type 2, and the screw's pitch."""
    assert_equal_to_paper(zhang, "distance to type 2", 1e-9)
    assert_equal_to_paper(zhang, "pitch of the screw", 1e-6)


@pytest.mark.slow
def test_gluon_determinant_factorises(gluon: list[dict]) -> None:
    """det J = its factors to 1e-12, the conditions are numeric singularities, and only they."""
    assert_equal_to_paper(gluon, "det J less the product", 1e-12)
    assert_equal_to_paper(gluon, "distance to type 1", 1e-9)
    assert_equal_to_paper(gluon, "classified as type 1")
    assert_equal_to_paper(gluon, "work of the wrench", 1e-9)
    assert_equal_to_paper(gluon, "random configurations that are regular")
    assert_equal_to_paper(gluon, "smallest closed-form factor", 1e-9)
    assert_equal_to_paper(gluon, "farther than 0.2 deg")


@pytest.mark.slow
def test_cusp_to_1e_9_and_a_path_around_it(cusp: list[dict]) -> None:
    """Cusps by two routes to 1e-9; the path closes in the inputs, keeps the sign of det A, and ends
    on another mode.
    """
    assert_equal_to_paper(cusp, "on the traced locus less by Newton", 1e-9)
    assert_equal_to_paper(cusp, "largest of the eight equations", 1e-12)
    assert_equal_to_paper(cusp, "inputs at the start and at the end", 1e-12)
    assert_equal_to_paper(cusp, "sign of det A along the path")
    assert_equal_to_paper(cusp, "both are among the enumerated modes", 1e-6)
    assert_equal_to_paper(cusp, "followed back", 1e-9)
    assert_equal_to_paper(cusp, "steps of a third", 1e-6)
    first, last = values(cusp, "number of the mode")[0]
    assert first != last
