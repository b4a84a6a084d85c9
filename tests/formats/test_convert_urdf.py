"""URDF that is written: read again it is the same mechanism, and Pinocchio has its links where
symkin has them, its loops closed there.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symkin
from helpers.gate import each_once, in_gate
from helpers.inside import as_graph
from helpers.random_graphs import random_graph
from helpers.robot_files import LARGEST, ROBOTS
from helpers.same_mechanism import assert_same
from helpers.shipped import TWELVE
from oracle.pinocchio_account import PinocchioAccount

COUPLED = ("differential", "planetary_gear")
"""Mechanisms with joints that follow two others."""
HELD = [name for name in symkin.shipped_names() if name not in COUPLED]


@pytest.mark.parametrize(
    ("name", "loops"), each_once(HELD, ["loop", "yaml"], kept=[("parallel_gripper", "loop")])
)
def test_shipped_mechanisms_come_back(name: str, loops: str, tmp_path: Path) -> None:
    mechanism = symkin.load(name)
    path = symkin.convert(mechanism, tmp_path / "written.urdf", loops=loops)
    assert path.with_suffix(".yaml").exists() == (loops == "yaml")
    assert_same(as_graph(mechanism), symkin.load(path))


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    in_gate(ROBOTS, [p for p in ROBOTS if p not in LARGEST][2::3]),
    ids=lambda path: path.stem,
)
def test_real_robots_come_back(path: Path, tmp_path: Path) -> None:
    if path.suffix == ".xml":
        pytest.importorskip("mujoco")
    mechanism = symkin.load(path)
    assert_same(
        as_graph(mechanism), symkin.load(symkin.convert(mechanism, tmp_path / "written.urdf"))
    )


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), loops=st.sampled_from(["loop", "yaml"]))
def test_random_graphs_come_back(
    seed: int, loops: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    mechanism = random_graph(seed, lines_only=True)
    path = tmp_path_factory.getbasetemp() / f"random_{loops}.urdf"
    assert_same(as_graph(mechanism), symkin.load(symkin.convert(mechanism, path, loops=loops)))


@pytest.mark.parametrize("name", in_gate(HELD, [*TWELVE, "klann_leg"]))
def test_pinocchio_moves_as_symkin(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    mechanism = symkin.load(name)
    PinocchioAccount(mechanism, symkin.convert(mechanism, tmp_path / "written.urdf")).check()


@pytest.mark.parametrize("seed", in_gate(range(20), range(5)))
def test_pinocchio_moves_as_random_graphs(seed: int, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    mechanism = random_graph(seed, lines_only=True)
    PinocchioAccount(mechanism, symkin.convert(mechanism, tmp_path / "written.urdf")).check()


@pytest.mark.parametrize("name", COUPLED)
def test_joints_that_follow_two_others(name: str, tmp_path: Path) -> None:
    with pytest.raises(
        symkin.MechanismError, match=r"is no line of one other joint, .*MJCF \(\.xml\) holds it"
    ):
        symkin.convert(name, tmp_path / "written.urdf")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".URDF", ".sdf"])
def test_a_line_is_one_however_it_is_written(suffix: str, tmp_path: Path) -> None:
    """A polynomial whose higher coefficients are 0 is a mimic of a factor and an offset; capitals
    in a suffix mean the same format.
    """
    gripper = symkin.load("parallel_gripper")
    (gears,) = (c for c in gripper.couplings if len(c.terms) == 1)
    ((of, factor),) = gears.terms
    line = symkin.Coupling(gears.joint, of, polynomial=[gears.offset, factor, 0.0, 0.0])
    written = replace(gripper, couplings=[line])
    paths = [
        symkin.convert(mechanism, tmp_path / f"{k}{suffix}")
        for k, mechanism in enumerate((gripper, written))
    ]
    first, second = (path.read_text(encoding="utf-8") for path in paths)
    assert first == second


def test_loops_beside_the_file(tmp_path: Path) -> None:
    """Loops are never told twice: neither by a file that stands beside the output, nor in a format
    without this form.
    """
    path = symkin.convert("four_bar", tmp_path / "four_bar.urdf", loops="yaml")
    before = path.read_bytes(), path.with_suffix(".yaml").read_bytes()
    for arguments, options, sentence in [
        (("ankle", path), {}, "would tell loops of a URDF of this name"),
        (("ankle", tmp_path / "ankle.xml"), {"loops": "yaml"}, "is a form of URDF"),
        (
            ("ankle", tmp_path / "ankle.urdf"),
            {"loops": "srdf"},
            "'srdf' is unknown; allowed: loop, yaml",
        ),
        (("ankle", tmp_path / "ankle.urdf"), {"loops": None}, "allowed: loop, yaml"),
    ]:
        with pytest.raises(symkin.InputError, match=sentence):
            symkin.convert(*arguments, **options)
    assert (path.read_bytes(), path.with_suffix(".yaml").read_bytes()) == before
    symkin.convert("ankle", path, loops="yaml")
    assert_same(as_graph(symkin.load("ankle")), symkin.load(path))
