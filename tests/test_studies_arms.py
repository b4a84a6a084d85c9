"""The studies of the arms and of XJ-HEXAS run, and their tables say what the sources and computation say."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symkin

STUDIES = Path(__file__).parent.parent / "studies"


def study(name: str, folder: Path, *options: str) -> dict:
    """Run a study as a user does; its JSON, once the picture is there."""
    command = [sys.executable, str(STUDIES / f"{name}.py"), "-o", str(folder), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    return json.loads((folder / f"{name}.json").read_text())


def row(content: dict, start: str) -> dict:
    """The one row whose quantity begins with `start`."""
    found = [r for r in content["rows"] if r["quantity"].startswith(start)]
    assert len(found) == 1, [r["quantity"] for r in content["rows"]]
    return found[0]


def computed(content: dict, start: str) -> np.ndarray:
    return np.asarray(row(content, start)["computed"], dtype=float)


def assert_errata(content: dict, *words: str) -> None:
    """Each erratum is named once, and there is no other."""
    assert len(content["errata"]) == len(words)
    for word in words:
        assert sum(word in text for text in content["errata"]) == 1, (word, content["errata"])


def assert_close(values: np.ndarray, expected: object, tolerance: float) -> None:
    np.testing.assert_allclose(values, expected, rtol=0, atol=tolerance)


# --- Gluon-6L3 ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def gluon(tmp_path_factory: pytest.TempPathFactory) -> dict:
    return study("gluon_6l3", tmp_path_factory.mktemp("gluon"), "--poses", "40")


def test_gluon_example(gluon: dict) -> None:
    """The page's example, 15 degrees each: the pose by the DH product, and two solutions of its inverse problem (the page
    gives the first), by the closed form, Newton, IPOPT and multistart."""
    assert_close(computed(gluon, "tool position"), [-144.03182, -161.2822, 489.30956], 1e-5)
    assert computed(gluon, "symkin's forward less") < 1e-9
    assert_close(computed(gluon, "inverse, closed form, solution 1"), [15] * 6, 1e-9)
    assert_close(computed(gluon, "inverse, closed form, solution 2"), [15, 30, -15, 30, 15, 15], 1e-9)
    assert not [r for r in gluon["rows"] if r["quantity"].startswith("inverse, closed form, solution 3")]
    assert_close(computed(gluon, "inverse, newton"), [15] * 6, 1e-8)
    assert_close(computed(gluon, "inverse, ipopt"), [15, 30, -15, 30, 15, 15], 1e-8)
    assert computed(gluon, "inverse by multistart") == 2


def test_gluon_closed_form_is_multistart(gluon: dict) -> None:
    """Law: on every random pose both routes give the same set."""
    assert computed(gluon, "random poses where closed form = multistart") == 40


def test_gluon_jacobian(gluon: dict) -> None:
    """Law: the symbolic Jacobian is the derivative, and its determinant the product of the three singularities' factors."""
    assert computed(gluon, "symbolic Jacobian less") < 1e-6
    assert_close(computed(gluon, "det J"), [1, 1], 1e-6)
    assert computed(gluon, "rank of J") == 5


def test_gluon_errata(gluon: dict) -> None:
    assert_errata(gluon, "[3,1] and [3,2]")


def test_gluon_inverse_is_that_of_eaik() -> None:
    """Oracle: EAIK (subproblem decomposition) finds the same solutions on 25 random poses."""
    eaik = pytest.importorskip("eaik.IK_DH")
    arm = symkin.load("gluon_6l3")
    table = arm.dh.rows
    offset = np.array([r.theta for r in table])
    robot = eaik.DhRobot(*(np.array([getattr(r, key) for r in table]) for key in ("alpha", "a", "d")))
    rng = np.random.default_rng(25)
    for q in rng.uniform(-180, 180, (25, 6)):
        pose = symkin.solve(arm, joints=q).solution.pose
        answer = robot.IK(np.asarray(pose.matrix))
        exact = [np.asarray(v) - offset for v, least in zip(answer.Q, answer.is_LS, strict=True) if not least]
        found = [np.radians(s.actuated) for s in symkin.modes(arm, pose=pose)]
        assert len(found) == len(exact)
        assert all(min(turned(a, b) for b in exact) < 1e-6 for a in found)
        assert all(min(turned(a, b) for b in found) < 1e-6 for a in exact)


def turned(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference of angles modulo turns, in rad."""
    return float(np.abs((a - b + np.pi) % (2 * np.pi) - np.pi).max())




# --- solvers -----------------------------------------------------------------------------------------------------


def test_solvers(tmp_path: Path) -> None:
    """200 batched starts find every mode known of the four mechanisms; every solver finds some."""
    content = study("solvers", tmp_path)
    known = {"zhang2009": 4, "zhao2000": 4, "gluon_6l3": 2, "yao2020": 4}
    for name, count in known.items():
        batched = row(content, f"{name}, batched, 200 starts: modes found")
        assert batched["computed"] == count
        assert batched["quantity"].endswith(f"of {count} known")
        for solver in ("newton", "ipopt"):
            assert (
                0
                < row(content, f"{name}, {solver}, {100 if solver == 'ipopt' else 200} starts: modes found")["computed"]
                <= count
            )
    assert_errata(content)
