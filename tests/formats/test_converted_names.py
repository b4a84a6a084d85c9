"""Names mean the same after a round trip through another format: joints of every type, told from
either of their links, in a tree and in a loop, actuated and passive, with and without zero and
range.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.gate import each_once
from helpers.inside import as_graph, main
from helpers.same_mechanism import assert_same
from oracle.product_of_exponentials import displacement, random_values

pytest.importorskip("mujoco")
FORMATS = (".xml", ".urdf", ".sdf", ".yaml")
"""The last is a URDF with its loops in a file beside it."""
AT, AXIS, SQUARE, SKEW = (0.1, -0.2, 0.3), (2.0, 1.0, 2.0), (1.0, -2.0, 0.0), (1.0, 0.3, 0.2)
KINDS = ("R", "P", "H", "C", "U", "skew U", "S")


def round_trip(mechanism: symkin.Mechanism, suffix: str, folder: Path) -> symkin.Mechanism:
    path = folder / f"m{'.urdf' if suffix == '.yaml' else suffix}"
    return symkin.load(
        symkin.convert(mechanism, path, loops="yaml" if suffix == ".yaml" else "loop")
    )


def joints_of(kind: str) -> Iterator[symkin.Joint]:
    """The joint `j` of a kind, passive and actuated, bare and with zero and range."""
    if kind == "S":
        yield symkin.Joint("j", "S", AT)
        return
    axis2 = {"U": SQUARE, "skew U": SKEW}.get(kind)
    pitch = 0.05 if kind == "H" else 0.0
    for driven in (False, True):
        yield symkin.Joint("j", kind[-1], AT, AXIS, axis2, pitch=pitch, actuated=driven)
        if kind in "RPH":
            yield symkin.Joint(
                "j", kind, AT, AXIS, pitch=pitch, actuated=driven, zero=0.4, limits=(-0.5, 0.9)
            )


def machines(kind: str) -> Iterator[symkin.Mechanism]:
    """The joint between the base and a hand, told from either; a second one of its kind behind it;
    a loop over an arm closes it, or not.
    """
    for joint, backward, looped in product(joints_of(kind), (False, True), (False, True)):
        ends = ("hand", "base") if backward else ("base", "hand")
        second = symkin.Joint(
            "k", joint.type, (0.4, 0.1, -0.2), joint.axis, joint.axis2, pitch=joint.pitch
        )
        entries = [
            symkin.LinkJoint(joint, ends),
            symkin.LinkJoint(second, ("tool", "hand") if backward else ("hand", "tool")),
        ]
        if looped:
            entries.append(
                symkin.LinkJoint(
                    symkin.Joint("shoulder", "R", (0.5, 0, 0), (0, 0, 1), zero=-0.3),
                    ("arm", "base"),
                )
            )
            entries.append(
                symkin.LinkJoint(
                    symkin.Joint(
                        "wrist", joint.type, (0.5, 0.5, 0.1), joint.axis, joint.axis2, joint.pitch
                    ),
                    ("tool", "arm") if backward else ("arm", "tool"),
                )
            )
        yield symkin.Mechanism(
            "m", link_joints=entries, platform_link="hand", platform_position=(0.1, 0.2, 1.0)
        )


@pytest.mark.parametrize(
    ("kind", "suffix"), each_once(KINDS, FORMATS, kept=[("R", ".xml"), ("U", ".urdf")])
)
def test_the_same_names_and_values_mean_the_same_poses(
    kind: str, suffix: str, tmp_path: Path
) -> None:
    """By a product of exponentials of what is written and of what is read; written again, it is the
    same file.
    """
    for mechanism in machines(kind):
        found = round_trip(mechanism, suffix, tmp_path)
        assert_same(as_graph(mechanism), found)
    assert_same(found, round_trip(found, suffix, tmp_path))


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_loop_of_one_point_closes_to_rounding(suffix: str, tmp_path: Path) -> None:
    """Two slides and a ball: the two frames of the ball, which are all the points there are, differ
    by rounding, and that is no size.
    """
    entries = [
        symkin.LinkJoint(symkin.Joint("p", "P", AT, AXIS, zero=0.0385), ("base", "a")),
        symkin.LinkJoint(symkin.Joint("q", "P", AT, SKEW, zero=0.0731), ("b", "a")),
        symkin.LinkJoint(symkin.Joint("s", "S", (0.08506903, -0.01000043, 0.07229414)), ("a", "b")),
    ]
    mechanism = symkin.Mechanism("m", link_joints=entries, length_unit="m")
    assert_same(as_graph(mechanism), round_trip(mechanism, suffix, tmp_path))


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("backward", [False, True])
def test_couplings_follow_their_axis(suffix: str, backward: bool, tmp_path: Path) -> None:
    """Of a universal joint told from the link that the tree carries, a joint that follows .2
    follows it after the round trip.
    """
    links = ("hand", "base") if backward else ("base", "hand")
    entries = [
        symkin.LinkJoint(symkin.Joint("u", "U", AT, AXIS, SQUARE), links),
        symkin.LinkJoint(symkin.Joint("r", "R", (1, 0, 0), (0, 1, 0)), ("hand", "tool")),
    ]
    mechanism = symkin.Mechanism(
        "m", link_joints=entries, couplings=[symkin.Coupling("r", {"u.2": 2.0})]
    )
    assert_same(as_graph(mechanism), round_trip(mechanism, suffix, tmp_path))


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_hand_is_where_its_universal_joint_puts_it(suffix: str, tmp_path: Path) -> None:
    """Values by name give the pose of the hand: u moves the base in the hand, so that the hand
    stands at the inverse.
    """
    u = symkin.Joint("u", "U", (0, 0, 0.5), (1, 0, 0), (0, 1, 0), actuated=True)
    mechanism = symkin.Mechanism(
        "wrist",
        link_joints=[symkin.LinkJoint(u, ("hand", "base"))],
        platform_link="hand",
        platform_position=(0, 0, 1),
        length_unit="m",
    )
    values = {"u.1": 0.3, "u.2": 0.7}
    at = np.linalg.inv(displacement(u, values))
    for made in (mechanism, round_trip(mechanism, suffix, tmp_path)):
        (solution,) = symkin.modes(made, given=values)
        np.testing.assert_allclose(solution.pose.position, (at @ [0, 0, 1, 1])[:3], atol=1e-12)
        np.testing.assert_allclose(solution.pose.rotation, at[:3, :3], atol=1e-12)


@pytest.mark.parametrize("backward", [False, True])
def test_mujoco_turns_the_ball_the_way_that_the_text_tells(backward: bool, tmp_path: Path) -> None:
    """The file's ball turns the hand in the base; of one told from the hand, its value is the
    inverse.
    """
    import mujoco

    ball = symkin.Joint("s", "S", AT)
    links = ("hand", "base") if backward else ("base", "hand")
    mechanism = symkin.Mechanism("m", link_joints=[symkin.LinkJoint(ball, links)])
    path = symkin.convert(mechanism, tmp_path / "m.xml")
    values = random_values(mechanism, 3)
    quaternion = np.asarray(values["s"]) * ([1, -1, -1, -1] if backward else 1)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[:] = quaternion
    mujoco.mj_kinematics(model, data)
    moved = displacement(symkin.load(path).link_joints[0].joint, values)
    hand = np.linalg.inv(moved) if backward else moved
    np.testing.assert_allclose(data.xmat[1].reshape(3, 3), hand[:3, :3], atol=1e-12)


@pytest.mark.parametrize("backward", [False, True])
def test_close_tells_a_ball_as_the_mechanism_has_it(backward: bool, tmp_path: Path) -> None:
    """An MJCF file whose loop is open: the ball of the tree turns by its value from the file's
    configuration to the closed one, and the file that `close` writes has MuJoCo's links there.
    """
    import mujoco

    links = ("bar", "crank") if backward else ("crank", "bar")
    entries = [
        symkin.LinkJoint(
            symkin.Joint("q", "R", (0, 0, 0), (0, 0, 1), actuated=True), ("base", "crank")
        ),
        symkin.LinkJoint(symkin.Joint("near", "S", (1, 0, 0)), links),
        symkin.LinkJoint(symkin.Joint("far", "S", (1, 2, 0)), ("bar", "base")),
    ]
    path = symkin.convert(
        symkin.Mechanism("m", link_joints=entries, length_unit="m"), tmp_path / "m.xml"
    )
    text = path.read_text().replace(
        'body1="bar" body2="world" anchor="0 2 0"', 'site1="end" site2="post"'
    )
    text = text.replace("<worldbody>", '<worldbody><site name="post" pos="0.8 1.9 0.5"/>')
    path.write_text(text.replace('type="ball" />', 'type="ball" /><site name="end" pos="0 2 0"/>'))
    found, output = symkin.close(path), tmp_path / "closed.xml"
    assert found.open_by > 0.5 > 1e-9 > found.residual
    crank, bar = (found.link_poses[name].rotation for name in ("crank", "bar"))
    turn = displacement(entries[1].joint, found.joints)[:3, :3]
    np.testing.assert_allclose(turn, bar.T @ crank if backward else crank.T @ bar, atol=1e-12)
    with pytest.raises(SystemExit):
        main(["close", str(path), "-o", str(output)])
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_path(str(output)))
    mujoco.mj_resetDataKeyframe(model, data, model.key("closed").id)
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(data.body("bar").xmat.reshape(3, 3), bar, atol=1e-12)


@pytest.mark.parametrize("suffix", FORMATS[:3])
def test_a_text_that_turns_an_unknown_joint_is_refused(
    suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ball = symkin.LinkJoint(symkin.Joint("s", "R", AT, AXIS), ("hand", "base"))
    path = symkin.convert(symkin.Mechanism("m", link_joints=[ball]), tmp_path / f"m{suffix}")
    assert "turned: s" in path.read_text()
    path.write_text(path.read_text().replace("turned: s", "turned: x"))
    with pytest.raises(SystemExit) as stop:
        main(["show", str(path), "--json"])
    assert stop.value.code == 2
    assert "names the joint 'x', which the file has not" in capsys.readouterr().err
