"""The home of generated code: which pose is taken, which is refused, and what stands on it."""

from __future__ import annotations

import dataclasses
import math
import re
import subprocess

import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import (
    Options,
    build_program,
    build_vectors,
    home_pose,
    main,
    mechanism_to_toml,
    write_folder,
)
from symkin import Example, InputError, Mechanism, RodLimb, load, solve

ABOVE = (0.0, 0.0, 200.0, 1.0, 0.0, 0.0, 0.0)
JOINTS = (60.0, 62.0, 58.0, 61.0, 59.0, 60.0)


def _circle(radius: float, degrees: float) -> tuple[float, float, float]:
    return radius * math.cos(math.radians(degrees)), radius * math.sin(math.radians(degrees)), 0.0


def flat(
    example: Example | None = None,
    limits: tuple[float, float] | None = (0.0, 120.0),
    base: float = 200.0,
) -> Mechanism:
    """Six rods whose reference lies in the base's plane; with base 0 all of them start at one
    point.
    """
    angles = [(-10, -50), (10, 50), (110, 70), (130, 170), (230, 190), (250, 290)]
    limbs = [
        RodLimb(f"leg{k}", _circle(base, b), _circle(120.0, a), offset=180.0, limits=limits)
        for k, (b, a) in enumerate(angles, start=1)
    ]
    return Mechanism("flat", limbs, example=example)


def _seven(pose):
    return [*pose.position, *pose.quaternion]


def test_home_is_the_first_pose_that_is_given():
    """--home, the example's start, its pose, its joints' pose, the reference: in this order."""
    other = (5.0, 0.0, 210.0, 1.0, 0.0, 0.0, 0.0)
    direct = Example(joints=JOINTS, start=ABOVE)
    assert _seven(home_pose(flat(direct), other)) == list(other)
    assert _seven(home_pose(flat(direct), None)) == list(ABOVE)
    assert _seven(home_pose(flat(Example(pose=other)), None)) == list(other)
    led = home_pose(flat(Example(joints=JOINTS)), None)
    expected = solve(flat(), joints=JOINTS).solution
    assert expected is not None
    assert np.allclose(_seven(led), _seven(expected.pose), rtol=0, atol=1e-6)
    raised = dataclasses.replace(flat(), platform_position=ABOVE[:3])
    assert _seven(home_pose(raised, None))[:3] == list(ABOVE[:3])


@pytest.mark.parametrize(
    ("example", "home", "source"),
    [
        (None, None, "the reference pose"),
        (None, (0, 0, 0, 1, 0, 0, 0), "--home"),
        (Example(pose=(0, 0, 0, 1, 0, 0, 0)), None, "[example] pose"),
        (Example(joints=JOINTS, start=(0, 0, 0, 1, 0, 0, 0)), None, "[example] start"),
    ],
)
def test_a_singular_home_is_refused_with_its_source_and_remedy(example, home, source):
    with pytest.raises(InputError, match=re.escape(f"({source}) is singular")) as refusal:
        home_pose(flat(example), home)
    for remedy in ("--home X,Y,Z,QW,QX,QY,QZ", "[platform] position", "[example] pose"):
        assert remedy in str(refusal.value)


def test_a_home_outside_limits_is_refused_with_joint_value_and_limits():
    """The value is the rod's length less its offset."""
    rod = flat().limbs[0]
    value = math.dist(np.add(rod.platform, (0, 0, 900)), rod.base) - 180.0
    with pytest.raises(
        InputError, match=re.escape(f"leg1 = {value:.6g} mm, outside its limits [0, 120]; give")
    ):
        home_pose(flat(), (0, 0, 900, 1, 0, 0, 0))
    assert home_pose(flat(limits=None), (0, 0, 900, 1, 0, 0, 0)).position[2] == 900


def test_unreached_example_joints_are_not_taken():
    """Rods that cannot meet lead to no pose; the reference is next, and is judged."""
    apart = Example(joints=(0.0, 5000.0, 0.0, 5000.0, 0.0, 5000.0))
    raised = dataclasses.replace(flat(apart), platform_position=ABOVE[:3])
    assert _seven(home_pose(raised, None))[:3] == list(ABOVE[:3])


@pytest.mark.parametrize(
    ("base", "home"),
    [(200.0, None), (200.0, "0,0,0,1,0,0,0"), (0.0, None), (0.0, "0,0,200,1,0,0,0")],
)
def test_the_command_refuses_in_one_line_and_writes_nothing(base, home, tmp_path, capsys):
    """Singular at home, or everywhere: exit 2, one sentence, no folder."""
    file = tmp_path / "flat.toml"
    file.write_text(mechanism_to_toml(flat(base=base)))
    arguments = [
        "firmware",
        str(file),
        "-o",
        str(tmp_path / "out"),
        *(["--home", home] if home else []),
    ]
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    message = capsys.readouterr().err
    assert stop.value.code == 2
    assert message.count("\n") == 1
    assert "is singular" in message
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("limits", [(0.0, 120.0), (71.4, 71.6), None])
def test_cases_are_distinct_and_within_limits(limits):
    """Every case has joint values of its own, also where limits are narrower than the reach of the
    cases.
    """
    narrow = solve(flat(limits=None), joints=[71.5] * 6, start=ABOVE).solution
    assert narrow is not None
    platform = flat(Example(pose=tuple(_seven(narrow.pose))), limits)
    joints = build_vectors(build_program(platform, Options("double")).kind).answers["joints"]
    assert len(joints) == 24
    apart = np.max(np.abs(joints[:, None] - joints), axis=2) + 1e9 * np.eye(len(joints))
    assert np.min(apart) > 1e-4
    if limits is not None:
        assert np.all((joints >= limits[0]) & (joints <= limits[1]))


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(["ren2008", "zhao2000", "gluon_6l3"], ["ren2008"]))
def test_shipped_cases_are_distinct(name):
    """With limits, without, and of an arm."""
    kind = build_program(load(name), Options("float")).kind
    assert len(np.unique(build_vectors(kind).answers["joints"], axis=0)) == 24


def _example(folder, *edit: tuple[str, str]):
    source = (folder / "example_main.c").read_text()
    for old, new in edit:
        assert old in source
        source = source.replace(old, new)
    (folder / "example_main.c").write_text(source)
    return tools.built("gcc", folder, ["flat.c", "example_main.c"], "example", "-O1")


@pytest.mark.long
@pytest.mark.slow
def test_code_about_the_example_pose_passes_and_the_example_moves(tmp_path):
    write_folder(flat(Example(pose=ABOVE)), tmp_path, Options())
    tools.passed(tools.built("gcc", tmp_path, ["flat.c", "flat_test.c"], "test", "-O1"))
    assert tools.passed(_example(tmp_path)).startswith("position ")


def test_the_example_holds_where_there_is_no_answer(tmp_path):
    """Joints out of range in every cycle: the machine is held, and the pose stays home."""
    write_folder(flat(Example(pose=ABOVE)), tmp_path, Options())
    program = _example(
        tmp_path,
        (
            "values[i] = begin[i] + part * (flat_vector_joints[0][i] - begin[i]);",
            "values[i] = 500.0 + part;",
        ),
    )
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    assert "0 tracked, 0 recovered, 70 held" in said
