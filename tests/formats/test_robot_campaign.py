"""The campaign over a folder of robots: a line for every file, other tools that would notice a
misreading, and the exit status.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from helpers.inside import Robot, read_robot
from helpers.mjcf_models import SMALL

pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")
CAMPAIGN = Path(__file__).resolve().parents[1] / "campaigns" / "robots.py"
ARM = """<robot name="arm"><link name="ground"/><link name="upper"/><link name="lower"/>
<joint name="a" type="continuous"><parent link="ground"/><child link="upper"/>
<origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><axis xyz="0 1 0"/></joint>
<joint name="b" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/>
<axis xyz="0 0.6 0.8"/></joint></robot>"""
LEG = """<sdf version="1.6"><model name="leg"><pose>1 2 3 0.1 0.2 0.3</pose><link name="hip"/>
<link name="thigh"><pose>0 0 -0.1 0 0 0.4</pose></link>
<joint name="j" type="revolute"><parent>hip</parent><child>thigh</child><axis><xyz>1 0 0</xyz>
</axis></joint>
<joint name="k" type="revolute"><parent>hip</parent><child>thigh</child><axis><xyz>1 0 0</xyz>
</axis></joint></model></sdf>"""


def folder_of(tmp_path: Path) -> Path:
    folder = tmp_path / "models"
    (folder / "deep").mkdir(parents=True)
    (folder / "deep" / "bar.xml").write_text(SMALL["four_bar_by_sites"][0], encoding="utf-8")
    (folder / "arm.urdf").write_text(ARM, encoding="utf-8")
    (folder / "leg.sdf").write_text(LEG, encoding="utf-8")
    (folder / "wrong.urdf").write_text(
        ARM.replace('axis xyz="0 1 0"', 'axis xyz="0 0 0"'), encoding="utf-8"
    )
    (folder / "part.xml").write_text("<mujoco><asset/></mujoco>", encoding="utf-8")
    (folder / "other.xml").write_text("<package/>", encoding="utf-8")
    return folder


@pytest.mark.long
@pytest.mark.slow
def test_each_file_has_a_line_and_the_last_one_counts_them(tmp_path: Path) -> None:
    folder, out = folder_of(tmp_path), tmp_path / "found.json"
    command = [sys.executable, str(CAMPAIGN), str(folder), "--modes", "--json", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    *lines, summary = done.stdout.splitlines()
    found = {entry["file"]: entry for entry in json.loads(out.read_text(encoding="utf-8"))}
    assert (
        [line.split(":")[0] for line in lines]
        == sorted(found)
        == ["arm.urdf", "deep/bar.xml", "leg.sdf", "wrong.urdf"]
    )
    assert found["deep/bar.xml"]["rank"] == SMALL["four_bar_by_sites"][1]
    assert found["deep/bar.xml"]["modes"].startswith("2 = 2")
    assert found["leg.sdf"]["mobility"] == 1
    assert found["wrong.urdf"]["status"] == "refused"
    assert "zero vector" in found["wrong.urdf"]["sentence"]
    assert summary.startswith(
        "4 files: 3 read, 0 open, 1 refused, 0 timed out, 0 crashed, 0 read otherwise; 2 with loops"
    )


@pytest.mark.parametrize("file", ["deep/bar.xml", "arm.urdf", "leg.sdf"])
def test_a_robot_that_is_read_otherwise_is_noticed(file: str, tmp_path: Path) -> None:
    """Right as it is; wrong with one axis or one link's frame turned."""
    from oracle.robot_twins import DisagreementError, mujoco_agreement, pinocchio_agreement
    from oracle.sdf_twin import sdf_agreement

    path = folder_of(tmp_path) / file
    agreement = {".xml": mujoco_agreement, ".urdf": pinocchio_agreement, ".sdf": sdf_agreement}[
        path.suffix
    ]
    robot = read_robot(path)
    assert agreement(path, robot).startswith("as ")
    with pytest.raises(DisagreementError):
        agreement(path, _with_a_turned_axis(robot))


def test_gears_count_in_the_plain_account(tmp_path: Path) -> None:
    """Two shafts that a gear couples; without it the robot has one freedom more."""
    from oracle.sdf_twin import sdf_agreement

    shafts = "".join(
        f"<link name='{x}'><pose>{k} 0 0 0 0 0.3</pose></link><joint name='{x}_j' "
        f"type='revolute'><parent>box</parent><child>{x}</child>"
        "<axis><xyz>0 0 1</xyz></axis></joint>"
        for k, x in enumerate("ab", start=1)
    )
    gear = (
        "<joint name='g' "
        "type='gearbox'><parent>a</parent><child>b</child><gearbox_ratio>3</gearbox_ratio>"
        "<gearbox_reference_body>box</gearbox_reference_body><axis><xyz>0 0 "
        "1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2></joint>"
    )
    path = tmp_path / "gears.sdf"
    path.write_text(
        f"<sdf version='1.6'><model name='m'><link name='box'/>{shafts}{gear}</model></sdf>",
        encoding="utf-8",
    )
    robot = read_robot(path)
    assert sdf_agreement(path, robot) == "as the plain account: 2 poses, mobility 1"
    ungeared = path.with_name("ungeared.sdf")
    ungeared.write_text(path.read_text(encoding="utf-8").replace(gear, ""), encoding="utf-8")
    assert (
        sdf_agreement(ungeared, read_robot(ungeared)) == "as the plain account: 2 poses, mobility 2"
    )


def _with_a_turned_axis(robot: Robot) -> Robot:
    first = next(joint for joint in robot.told if joint.axis is not None)
    turned = replace(first, axis=tuple(np.roll(np.array(first.axis), 1)))
    return replace(robot, told=[turned if joint is first else joint for joint in robot.told])
