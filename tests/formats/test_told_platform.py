"""The platform of a robot is the link that is told: its frame is the file's, and a chain to it is a
serial arm.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inside import arm_of, joints_left_out
from symkin import InputError, Joint, LinkJoint, Mechanism, ReadOptions

LINKS = "".join(f"<link name='{name}'/>" for name in ("foot", "one", "two", "three", "tool0"))
ORIGINS = {
    "a": ((0.1, -0.2, 0.3), (0.2, 0.0, 0.5), (0.0, 0.0, 1.0)),
    "b": ((0.0, 0.1, 0.4), (0.0, -0.7, 0.1), (0.0, 1.0, 0.0)),
    "c": ((0.3, 0.0, 0.1), (0.4, 0.3, 0.0), (1.0, 0.0, 0.0)),
    "flange": ((0.0, 0.05, 0.2), (0.3, 0.2, -1.0), (0.0, 0.0, 0.0)),
}
KINDS = {"a": "revolute", "b": "revolute", "c": "prismatic", "flange": "fixed"}


def arm_text() -> str:
    """Two turns, a slide and a flange; the slide moves along its own x axis."""
    names = ["foot", "one", "two", "three", "tool0"]
    joints = "".join(
        f"<joint name='{name}' type='{KINDS[name]}'><parent link='{names[k]}'/><child "
        f"link='{names[k + 1]}'/>"
        f"<origin xyz='{' '.join(map(str, xyz))}' rpy='{' '.join(map(str, rpy))}'/><axis "
        f"xyz='{' '.join(map(str, axis))}'/>"
        "<limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
        for k, (name, (xyz, rpy, axis)) in enumerate(ORIGINS.items())
    )
    return f"<robot name='arm'>{LINKS}{joints}</robot>"


def turn(axis: int, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    m = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def account(values: dict[str, float]) -> np.ndarray:
    """The flange's frame by the product of the file's transforms, yaw after pitch after roll."""
    total = np.eye(4)
    for name, (xyz, rpy, axis) in ORIGINS.items():
        step = turn(2, rpy[2]) @ turn(1, rpy[1]) @ turn(0, rpy[0])
        step[:3, 3] = xyz
        moved = np.eye(4)
        if KINDS[name] == "revolute":
            moved = turn(int(np.argmax(axis)), values[name])
        elif KINDS[name] == "prismatic":
            moved[:3, 3] = np.array(axis) * values[name]
        total = total @ step @ moved
    return total


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    path = tmp_path / "arm.urdf"
    path.write_text(arm_text(), encoding="utf-8")
    return path


def test_the_platform_frame_is_the_frame_of_the_file(arm: Path) -> None:
    """Position and rotation of a body behind a fixed joint, at random joint values."""
    mechanism = symkin.load(arm, ReadOptions(platform="tool0"))
    assert mechanism.platform_link == "three"
    rng = np.random.default_rng(5)
    for _ in range(10):
        values = dict(zip("abc", rng.uniform(-1.5, 1.5, 3), strict=True))
        found = symkin.solve(mechanism, joints=list(values.values())).solution
        wanted = account(values)
        np.testing.assert_allclose(found.position, wanted[:3, 3], atol=1e-12)
        np.testing.assert_allclose(found.pose.rotation, wanted[:3, :3], atol=1e-12)


def test_without_it_poses_are_refused_by_its_name(
    arm: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pose = "--pose=0.3,0.2,0.5,1,0,0,0"
    status, _, err = run(capsys, "modes", arm, pose)
    assert status == 2
    assert "--platform LINK" in err
    status, out, err = run(
        capsys, "modes", arm, "--joints", "0.1,0.2,0.3", "--platform", "tool0", "--json"
    )
    assert (status, err) == (0, "")
    assert json.loads(out)["modes"][0]["pose"] is not None


def test_degrees_where_radians_are_read_get_a_note(
    arm: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Robots' files are in radians: roll, pitch, yaw of more than a turn are asked about, pi is
    taken silently.
    """
    words = ["modes", arm, "--platform", "tool0", "--pose", "0.3,0.2,0.5"]
    assert "note: 180 rad: more than a turn" in run(capsys, *words, "--rpy", "180,0,0")[2]
    assert "note" not in run(capsys, *words, "--rpy", "pi,0,0")[2]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "tool",
            "no link is named 'tool' (do you mean 'tool0'?); links that move: one, two, three, "
            "tool0",
        ),
        (
            "base",
            "'base' is part of the base, which is held; links that move: one, two, three, tool0",
        ),
        (" ", "--platform is empty; the name of a link is needed"),
    ],
)
def test_wrong_names_are_told(
    name: str, expected: str, arm: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = run(capsys, "modes", arm, "--platform", name)
    assert (status, out) == (2, "")
    assert expected in err
    assert len(err.splitlines()) == 1


def test_a_mechanism_file_says_it_itself(capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = run(capsys, "modes", "zhang2009", "--platform", "tool0")
    assert status == 2
    assert "platform (--platform) has no meaning for zhang2009" in err


@pytest.mark.parametrize(
    "name",
    [
        "mjcf/g1_parallel_ankle.xml",
        "sdf/pr2_gripper.sdf",
        pytest.param("urdf_plus/six_bar.urdf", marks=pytest.mark.long),
    ],
)
def test_links_of_closed_loops_are_where_close_has_them(name: str) -> None:
    """In all three formats: the platform's pose at the reference is the link's."""
    path = Path(__file__).parents[1] / "data" / "models" / name
    closed, found = symkin.close(path), 0
    for link, wanted in closed.link_poses.items():
        try:
            mechanism = symkin.load(path, ReadOptions(platform=link))
        except InputError as error:
            assert "is part of the base" in str(error)  # noqa: PT017
            continue
        np.testing.assert_allclose(mechanism.platform_position, wanted.position, atol=1e-12)
        np.testing.assert_allclose(mechanism.reference_pose.rotation, wanted.rotation, atol=1e-12)
        found += 1
    assert found >= 3


def test_the_chain_to_it_is_a_serial_arm(arm: Path, tmp_path: Path) -> None:
    """Firmware and the Jacobian of an arm: the same matrix as that of rates by names, and code of
    an arm.
    """
    mechanism = symkin.load(arm, ReadOptions(platform="tool0"))
    serial = arm_of(mechanism)
    assert serial is not None
    values = [0.3, -0.4, 0.2]
    one, two = (symkin.solve(m, joints=values).solution for m in (mechanism, serial))
    np.testing.assert_allclose(one.position, two.position, atol=1e-13)
    np.testing.assert_allclose(one.pose.rotation, two.pose.rotation, atol=1e-13)
    matrix = symkin.jacobian(mechanism).at(one)
    np.testing.assert_allclose(
        matrix[:3],
        symkin.jacobian(mechanism, of=["x", "y", "z"], by=["a", "b", "c"]).at(one),
        atol=1e-10,
    )
    step = 1e-6
    for k in range(3):
        ends = [
            account(dict(zip("abc", np.add(values, s * step * np.eye(3)[k]), strict=True)))[:3, 3]
            for s in (1, -1)
        ]
        np.testing.assert_allclose(matrix[:3, k], (ends[0] - ends[1]) / (2 * step), atol=1e-8)
    written = symkin.write_firmware(mechanism, tmp_path / "c")
    assert "arm_inverse" in (tmp_path / "c" / "arm.h").read_text(encoding="utf-8")
    assert {path.name for path in written} >= {"arm.h", "arm.c", "manifest.json"}


def chain(*more: LinkJoint, reverse: bool = False) -> Mechanism:
    pan = Joint("pan", "R", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), actuated=True)
    tilt = Joint("tilt", "R", (0.0, 0.0, 200.0), (1.0, 0.0, 0.0), actuated=True)
    links = ["camera", "head"] if reverse else ["head", "camera"]
    return Mechanism(
        "neck",
        link_joints=[LinkJoint(tilt, links), LinkJoint(pan, ["base", "head"]), *more],
        platform_link="camera",
    )


@pytest.mark.parametrize("reverse", [False, True])
def test_joints_in_any_order_and_direction(reverse: bool) -> None:
    """The arm's joints stand from the base to the tool, and move it as those of the graph do."""
    graph = chain(reverse=reverse)
    serial = arm_of(graph)
    assert serial is not None
    assert [joint.name for _, joint in serial.joints] == ["pan", "tilt"]
    one = symkin.solve(graph, given={"pan": 0.4, "tilt": -0.3}).solution
    two = symkin.solve(serial, given={"pan": 0.4, "tilt": -0.3}).solution
    np.testing.assert_allclose(one.pose.rotation, two.pose.rotation, atol=1e-13)
    np.testing.assert_allclose(one.position, two.position, atol=1e-10)


def test_graphs_that_are_no_arms() -> None:
    """A loop, a passive joint, a coupling, no tool: none of them is an arm, and what is taken is
    said.
    """
    lens = Joint("lens", "P", (0.0, 0.0, 250.0), (0.0, 1.0, 0.0), actuated=True)
    arm = chain()
    passive = [
        replace(e, joint=replace(e.joint, actuated=e.joint.name == "pan")) for e in arm.link_joints
    ]
    assert arm_of(chain(LinkJoint(lens, ["base", "camera"]))) is None
    assert arm_of(replace(arm, couplings=[symkin.Coupling("tilt", {"pan": 2.0})])) is None
    assert arm_of(replace(arm, link_joints=passive)) is None
    assert arm_of(symkin.load("four_bar")) is None
    untold = replace(arm, platform_link=None)
    assert arm_of(untold) is None
    with pytest.raises(InputError, match=r"no platform link, .*; name it by"):
        symkin.jacobian(untold)


def test_what_does_not_move_the_tool_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A lens on the head, and a closed loop beside the arm: the arm is that without them, and a
    note names what drives them.
    """
    lens = Joint("lens", "P", (0.0, 0.0, 250.0), (0.0, 1.0, 0.0), actuated=True)
    branched = chain(LinkJoint(lens, ["head", "lens"]))
    both = chain(*symkin.load("four_bar").link_joints)
    wanted = arm_of(chain())
    assert wanted is not None
    for found in (arm_of(branched), arm_of(both)):
        assert found is not None
        assert (found.name, [joint for _, joint in found.joints]) == (
            "neck_camera",
            [joint for _, joint in wanted.joints],
        )
    assert joints_left_out(branched) == ("lens",)
    file = tmp_path / "neck.toml"
    symkin.convert(branched, file)
    status, out, err = run(capsys, "firmware", file, "-o", tmp_path / "c")
    assert status == 0
    assert "neck_camera.c" in out
    assert err == "symkin: note: left out, as they do not move the platform link 'camera': lens\n"
