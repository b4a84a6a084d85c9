"""MJCF that is written: read again it is the same mechanism, and MuJoCo has its links where symkin
has them, its loops closed there and its freedoms.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

import symkin
from helpers.gate import in_gate, in_gate_but
from helpers.inside import as_graph, mjcf_text
from helpers.random_graphs import random_graph
from helpers.robot_files import LARGEST, ROBOTS
from helpers.same_mechanism import assert_same
from helpers.shipped import TWELVE
from oracle.mujoco_account import MujocoAccount

pytest.importorskip("mujoco")


def in_file(folder: Path, mechanism: symkin.Mechanism, name: str = "written.xml") -> Path:
    path = folder / name
    path.write_text(mjcf_text(mechanism), encoding="utf-8")
    return path


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_shipped_mechanisms_come_back(name: str, tmp_path: Path) -> None:
    mechanism = symkin.load(name)
    assert_same(as_graph(mechanism), symkin.load(in_file(tmp_path, mechanism)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    in_gate(ROBOTS, [p for p in ROBOTS if p not in LARGEST][0::3]),
    ids=lambda path: path.stem,
)
def test_real_robots_come_back(path: Path, tmp_path: Path) -> None:
    mechanism = symkin.load(path)
    assert_same(as_graph(mechanism), symkin.load(in_file(tmp_path, mechanism)))


@pytest.mark.parametrize("first", in_gate(range(0, 80, 20), [0]))
def test_random_graphs_come_back(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + 20):
        mechanism = random_graph(seed)
        assert_same(as_graph(mechanism), symkin.load(in_file(tmp_path, mechanism)))


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_mujoco_moves_as_symkin(name: str, tmp_path: Path) -> None:
    """Poses of all links, closed equalities, and freedoms: the mobility, and the spin of each
    rod.
    """
    mechanism = symkin.load(name)
    freedoms = MujocoAccount(mechanism, in_file(tmp_path, mechanism)).check()
    assert freedoms[-1] == symkin.mobility(mechanism).mobility + len(mechanism.bars)


MINITAUR = [path for path in ROBOTS if path.stem == "minitaur"]
"""Four legs of one loop each, which take twice as long as the two of digit_like_2legs."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    in_gate_but(
        ROBOTS,
        [
            *LARGEST,
            *MINITAUR,
            *(
                p
                for p in ROBOTS
                if p.stem in ("digit_like_2legs", "reachy_mini", "six_bar", "talos")
            ),
        ],
    ),
    ids=lambda path: path.stem,
)
def test_mujoco_moves_as_real_robots(path: Path, tmp_path: Path) -> None:
    """With the freedoms that the closures of the robot's own file leave there, and at generic
    configurations; where they close to digits only, their rank is blurred.
    """
    mechanism, account = symkin.load(path), symkin.close(path)
    freedoms = MujocoAccount(mechanism, in_file(tmp_path, mechanism)).check()
    if account.generic_rank is not None and account.residual <= 1e-12:
        assert freedoms[0] == account.mobility
        assert set(freedoms[1:]) <= {account.freedoms - account.generic_rank}


@pytest.mark.parametrize("seed", in_gate(range(20), range(5)))
def test_mujoco_moves_as_random_graphs(seed: int, tmp_path: Path) -> None:
    """Where a random graph moves at all: at the reference, and at closed configurations."""
    mechanism = random_graph(seed)
    MujocoAccount(mechanism, in_file(tmp_path, mechanism)).check()


def test_a_chain_too_deep_for_nested_bodies_is_refused(tmp_path):
    """Bodies of MJCF stand within each other, and no reader takes any depth."""
    links = ["base", *(f"link{k}" for k in range(300))]
    joints = [
        symkin.LinkJoint(symkin.Joint(f"q{k}", "R", (k, 0, 0), (0, 0, 1), actuated=True), pair)
        for k, pair in enumerate(pairwise(links))
    ]
    chain, output = symkin.Mechanism("chain", link_joints=joints), tmp_path / "chain.xml"
    with pytest.raises(symkin.MechanismError, match=r"30\d deep here; allowed: 200"):
        symkin.convert(chain, output)
    assert not output.exists()
    assert len(symkin.load(symkin.convert(chain, tmp_path / "chain.toml")).link_joints) == 300
