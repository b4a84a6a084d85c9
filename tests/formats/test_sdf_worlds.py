"""Worlds of SDF: one of several models by name, models that joints of the world join, static
models, includes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inside import read_sdf
from symkin import InputError, ReadOptions, SymkinError

ARM = """<model name='{name}'><pose>{at} 0 0 0</pose><link name='low'/><link name='high'>
<pose>0 0 1 0 0 0</pose></link>
<joint name='knee' type='revolute'><parent>low</parent><child>high</child><axis><xyz>0 1 0</xyz>
</axis></joint></model>"""
TWO = ARM.format(name="left", at="0 0 0") + ARM.format(name="right", at="2 0 0")
FLOOR = "<model name='floor'><static>true</static><link name='slab'/></model>"
HINGE = """<joint name='{name}' type='revolute'><parent>{parent}</parent><child>{child}</child>
<pose relative_to='{child}'>{at} 0 0 0</pose>
<axis><xyz>0 1 0</xyz></axis></joint>"""


def world(folder: Path, inside: str, version: str = "1.9") -> Path:
    path = folder / "w.sdf"
    path.write_text(
        f"<sdf version='{version}'><world name='w'>\n{inside}</world></sdf>", encoding="utf-8"
    )
    return path


def test_one_of_several_models_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each by its name; without one, and for one that is unknown, the sentence names them."""
    path = world(tmp_path, TWO)
    assert read_sdf(path, ReadOptions(model="right")).name == "right"
    status, _, err = run(capsys, "show", path)
    assert status == 2
    assert "2 models are found: left, right; name one of them by model (--model left)" in err
    status, out, _ = run(capsys, "show", path, "--model", "left")
    assert status == 0
    assert out.startswith("left")
    status, _, err = run(capsys, "show", path, "--model", "rigth")
    assert status == 2
    assert "has no model 'rigth' (do you mean 'right'?); its models: left, right" in err


def test_models_that_joints_of_the_world_join_are_one_robot(tmp_path: Path) -> None:
    """Two arms on a floor that stands still, whose hands a joint joins: a four-bar, whose mobility
    is one.
    """
    feet = "".join(
        HINGE.format(name=f"foot_{m}", parent="floor::slab", child=f"{m}::low", at="0 0 0")
        for m in ("left", "right")
    )
    bar = "<model name='bar'><pose>0 0 2 0 0 0</pose><link name='rod'/></model>"
    knees = HINGE.format(name="a", parent="left::high", child="bar::rod", at="0 0 0")
    knees += HINGE.format(name="b", parent="right::high", child="bar::rod", at="2 0 0")
    stiff = TWO.replace("revolute", "fixed").replace("<axis><xyz>0 1 0</xyz></axis>", "")
    path = world(tmp_path, FLOOR + stiff + bar + feet + knees)
    robot = read_sdf(path)
    assert robot.frames["floor/slab"][0] == "base"
    assert robot.frames["left/high"][0] == "left/low"
    np.testing.assert_allclose(robot.links["right/low"].position, [2, 0, 0])
    found = symkin.close(path)
    assert found.mobility == 1
    assert found.open_by <= 1e-14
    # all of its bars are as long as those opposite: turned, the rod stays level
    for mode in symkin.modes(symkin.load(path), given={"foot_left": 0.4}):
        if abs(mode.joints["foot_right"] - 0.4) < 1e-9:
            np.testing.assert_allclose(mode.link_poses["bar/rod"].rotation, np.eye(3), atol=1e-9)
            break
    else:
        raise AssertionError("no mode is the parallelogram")


def test_a_model_that_a_world_includes_is_the_robot(tmp_path: Path) -> None:
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "model.sdf").write_text(
        f"<sdf version='1.9'>{ARM.format(name='arm', at='0 0 0')}</sdf>", encoding="utf-8"
    )
    include = "<include><uri>model://arm</uri><name>mine</name><pose>1 0 0 0 0 0</pose></include>"
    robot = read_sdf(world(tmp_path, include))
    assert "mine/high" in robot.links
    both = world(tmp_path, include + ARM.format(name="other", at="0 0 0"))
    assert read_sdf(both).name == "other"
    assert "mine/high" in read_sdf(both, ReadOptions(model="mine")).links


def test_what_of_a_world_is_left_out_is_named(tmp_path: Path) -> None:
    notes = read_sdf(
        world(
            tmp_path,
            TWO + HINGE.format(name="j", parent="left::low", child="right::low", at="0 0 0"),
        ),
        ReadOptions(model="left"),
    ).notes
    assert any(
        "line 8: <joint> of the world is left out; the model is read alone" in note
        for note in notes
    )


@pytest.mark.parametrize(
    ("inside", "told", "sentence"),
    [
        ("", None, r"line 1: <sdf>: 0 models are found; one is needed"),
        (FLOOR, None, r"<static>: the model is static"),
        (
            TWO + HINGE.format(name="j", parent="left::low", child="right::lo", at="0 0 0"),
            None,
            r"line 8: .*the frame 'right::lo' is unknown \(do you mean 'right::low'",
        ),
        (
            "<include><uri>model://none</uri></include>",
            None,
            r"line 2: <include>: the included model 'model://none' is not found",
        ),
        ("", "m", r"has no model 'm'; its models: none"),
    ],
)
def test_what_is_wrong_is_one_sentence(
    inside: str, told: str | None, sentence: str, tmp_path: Path
) -> None:
    path = world(tmp_path, inside)
    with pytest.raises((SymkinError, InputError), match=sentence) as error:
        read_sdf(path, ReadOptions(model=told))
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("told", ["by the include", "by its file", "by the model around it"])
def test_what_stands_still_is_held_wherever_it_is_told(told: str, tmp_path: Path) -> None:
    """Two posts of an older file carry a four-bar, whose mobility is one; the second is placed in
    the first one's frame, which the rules of the world's file allow.
    """
    still = "<static>true</static>"
    inside, own = (still if told == f"by {place}" else "" for place in ("the include", "its file"))
    (tmp_path / "post.sdf").write_text(
        f"<sdf version='1.4'><model name='post'>{own}<link name='top'/></model></sdf>",
        encoding="utf-8",
    )
    posts = "".join(
        f"<include><uri>post.sdf</uri><name>{name}</name>{inside}<pose {pose}</pose></include>"
        for name, pose in (("p", ">0 0 0 0 0 0"), ("q", "relative_to='p'>2 0 0 0 0 0"))
    )
    prefix = ""
    if told == "by the model around it":
        posts, prefix = f"<model name='yard'>{still}{posts}</model>", "yard::"
    feet = "".join(
        HINGE.format(name=f"foot_{m}", parent=f"{prefix}{post}::top", child=f"{m}::low", at="0 0 0")
        for m, post in (("left", "p"), ("right", "q"))
    )
    bar = "<model name='bar'><pose>0 0 2 0 0 0</pose><link name='rod'/></model>"
    knees = HINGE.format(name="a", parent="left::high", child="bar::rod", at="0 0 0")
    knees += HINGE.format(name="b", parent="right::high", child="bar::rod", at="2 0 0")
    stiff = TWO.replace("revolute", "fixed").replace("<axis><xyz>0 1 0</xyz></axis>", "")
    path = world(tmp_path, stiff + bar + posts + feet + knees)
    plain = prefix.replace("::", "/")
    assert read_sdf(path).frames[f"{plain}q/top"][0] == "base"
    found = symkin.close(path)
    assert found.mobility == 1
    assert found.open_by <= 1e-14
    np.testing.assert_allclose(found.link_poses[f"{plain}q/top"].position, [2, 0, 0])


def test_frames_of_a_world_are_the_worlds_own(tmp_path: Path) -> None:
    """A frame of a world that names no other is attached to the world, not to a link: an arm that
    hangs on it by its outer link has two freedoms.
    """
    post = "<frame name='post'><pose>0 0 1 0 0 0</pose></frame>"
    hinge = HINGE.format(name="hip", parent="post", child="arm::high", at="0 0 0")
    path = world(tmp_path, post + ARM.format(name="arm", at="0 0 0") + hinge)
    assert read_sdf(path).joints[0].links == ("base", "arm/high")
    assert symkin.close(path).mobility == 2
