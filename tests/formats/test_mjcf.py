"""MJCF as MuJoCo means it: link poses, closedness, rank and mobility at random closed
configurations equal MuJoCo's, for models of the tests and for real robots; what is wrong with a
file is one sentence.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.inside import (
    Closed,
    Robot,
    assembled,
    nearest_closed,
    read_mjcf,
)
from helpers.mjcf_models import MODELS, REAL, SMALL, Account, body, file_text, joint, random_robot
from helpers.robot_files import closed_neighbours, rank_at
from symkin import Pose

pytest.importorskip("mujoco")
POSE = 1e-10
"""Metres, and quaternions: what MuJoCo's poses may differ by."""


def in_file(folder: Path, text: str, name: str = "made.xml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def body_poses(robot: Robot, closed: Closed, state: np.ndarray) -> dict[str, Pose]:
    """Bodies by name, those of fixed joints included."""
    placed = closed.tree.displacements(state)
    return {name: placed[link] @ frame for name, (link, frame) in robot.frames.items()}


def check_against_mujoco(path: Path, neighbours: int) -> tuple[Robot, Closed]:
    """Poses, closedness and rank at the closed configuration and at random ones."""
    robot = read_mjcf(path)
    closed = nearest_closed(robot)
    assert closed.closed
    account = Account(path, robot)
    states = [closed.state, *closed_neighbours(closed, neighbours, 3)]
    assert len(states) == 1 + neighbours
    for state in states:
        data = account.at(closed, state)
        for name, pose in body_poses(robot, closed, state).items():
            if name == "base" or name not in [
                account.model.body(b).name for b in range(account.model.nbody)
            ]:
                continue
            np.testing.assert_allclose(pose.position, data.body(name).xpos, atol=POSE)
            off = min(
                np.abs(pose.quaternion - sign * data.body(name).xquat).max() for sign in (1, -1)
            )
            assert off <= POSE
        errors, jacobian = account.equality_rows(data)
        assert np.abs(errors).max(initial=0.0) <= 1e-9 * closed.tree.size
        s = np.linalg.svd(jacobian, compute_uv=False)
        rank = int(np.sum(s > 1e-8 * s[0])) if s.size else 0
        held = account.model.nv - account.free_roots() - closed.tree.freedom
        assert rank_at(closed.tree, state) == rank - held
    return robot, closed


def test_a_suffix_in_capitals_is_read_like_another(tmp_path: Path) -> None:
    """With what it includes from its own folder; sizes of old files, which are those of contacts,
    want no memory.
    """
    in_file(tmp_path, f"<mujoco>{body('b', '0 0 0', joint('k'))}</mujoco>", "part.xml")
    sizes = '<size njmax="8000" nconmax="4000"/>'
    text = file_text('<include file="part.xml"/>' + body("a", "0 0 0", joint("j")), sizes)
    robots = [read_mjcf(in_file(tmp_path, text, name)) for name in ("m.xml", "M.XML")]
    names = [[entry.joint.name for entry in robot.tree] for robot in robots]
    assert names == [["k", "j"]] * 2


@pytest.mark.parametrize("name", SMALL)
def test_models_of_the_tests(name: str, tmp_path: Path) -> None:
    text, rank, mobility = SMALL[name]
    robot, closed = check_against_mujoco(
        in_file(tmp_path, text.replace('<joint joint1="q5" polycoef="0.3 0 0 0 0"/>', "")), 3
    )
    held = name == "couplings"
    (neighbour,) = closed_neighbours(closed, 1, 5)
    assert rank_at(closed.tree, neighbour) == rank
    assert closed.tree.freedom - rank == mobility + held
    # the rod between a ball and a connect may spin, which the closure of the graph leaves out
    spins = name == "hinge_pair_ref_and_turned_frames"
    assert symkin.mobility(assembled(robot, closed)).mobility == mobility + held - spins


@pytest.mark.parametrize("name", REAL)
def test_real_robots(name: str) -> None:
    """Rank and mobility of the JSON beside each (of the held root), its actuated joints, and its
    closed configuration.
    """
    told = json.loads((MODELS / f"{name}.json").read_text(encoding="utf-8"))
    robot, closed = check_against_mujoco(MODELS / f"{name}.xml", 1)
    free = 6 * told["joints"].get("free", 0)
    assert rank_at(closed.tree, closed.state) == told["rank_at_configuration"]
    assert (
        closed.tree.freedom - rank_at(closed.tree, closed.state)
        == told["mobility_at_configuration"] - free
    )
    assert closed.open_by <= 1e-12
    directly = [entry.joint.name for entry in robot.tree if entry.joint.actuated]
    assert directly == told["actuated"] or name == "robotiq_2f85"
    counted = symkin.mobility(assembled(robot, closed))
    # rods between two balls may spin, which the closure of the graph leaves out
    assert counted.mobility <= told["mobility_generic"] - free <= counted.mobility + 2
    assert counted.reference_rank is not None


def test_a_joint_that_is_held(tmp_path: Path) -> None:
    """Its link is part of the one that carries it, at the value; the note says so; what a tendon or
    a motor drives is actuated.
    """
    robot = read_mjcf(in_file(tmp_path, SMALL["couplings"][0]))
    assert robot.frames["f5"][0] != "f5"
    assert any("'q5' is held at 0.8" in note for note in robot.notes)
    turned = robot.frames["f5"][1]
    assert 2.0 * np.arccos(turned.quaternion[0]) == pytest.approx(0.3)
    assert {entry.joint.name for entry in robot.tree if entry.joint.actuated} <= {
        "q1",
        "q2",
        "q3",
    }


def test_bodies_named_base_and_names_that_are_not_allowed(tmp_path: Path) -> None:
    still = body("base", "0 0 1", body("left:foot", "0 0 1", joint("a@b")))
    robot = read_mjcf(in_file(tmp_path, file_text(still)))
    assert robot.links["base"].position.tolist() == [0.0, 0.0, 1.0]
    assert "left_foot" in robot.links
    assert [entry.joint.name for entry in robot.tree] == ["a_b"]
    assert any("left_foot" in note for note in robot.notes)
    moving = read_mjcf(in_file(tmp_path, file_text(body("base", "0 0 1", joint("q")))))
    assert set(moving.links) == {"base", "base_2"}


def test_what_is_left_out_is_told(tmp_path: Path) -> None:
    """Constraints that are not active or hang on mocap bodies, motors of balls, sensors: each one
    note.
    """
    world = '<body name="hand" mocap="true"/>' + body(
        "arm", "0 0 1", joint("a") + body("tip", "1 0 0", joint("b", 'type="ball"'))
    )
    rest = (
        '<equality><weld body1="hand" body2="tip"/>\n'
        '<connect body1="arm" body2="tip" anchor="0 0 0" active="false"/></equality>'
        '<actuator><motor name="m" joint="b"/></actuator>'
        '<sensor><jointpos joint="a"/><jointvel joint="a"/></sensor>'
    )
    robot = read_mjcf(in_file(tmp_path, file_text(world, rest)))
    assert not robot.closures
    for sentence in (
        "line 8: <weld>: it joins a mocap body",
        "line 9: <connect>: it is not active",
        "are left out: m",
        "moves no link by itself: 2 sensors",
    ):
        assert sum(sentence in note for note in robot.notes) == 1, robot.notes


def test_files_that_kinematics_does_not_need(tmp_path: Path) -> None:
    """Meshes, textures and inertias may be missing; what meshes there are is kept by name."""
    text = """<mujoco><asset><mesh name="m" file="m.stl"/><texture name="t" type="2d" file="a.png"/>
<material name="w" texture="t"/></asset>
<worldbody><body name="a"><joint name="j"/><geom type="mesh" mesh="m" material="w"/><body name="b">
<joint name="k" type="slide"/></body>
</body></worldbody><keyframe><key qpos="0 0"/></keyframe></mujoco>"""
    robot = read_mjcf(in_file(tmp_path, text))
    assert {name: [mesh.file for mesh in meshes] for name, meshes in robot.meshes.items()} == {
        "a": ["m.stl"]
    }
    assert [entry.joint.type for entry in robot.tree] == ["R", "P"]


def test_meshes_that_an_included_file_names_lie_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the meshes' folder has them they are those; else they lie beside the included file,
    found or not, from wherever the model is read.
    """
    folder, mesh = (
        tmp_path / "a" / "inc",
        '<mujoco><asset><mesh name="m" file="m.stl"/></asset></mujoco>',
    )
    folder.mkdir(parents=True)
    (folder / "part.xml").write_text(mesh)
    text = """<mujoco><compiler meshdir="inc"/><include file="inc/part.xml"/><worldbody>
<body name="l"><joint name="j"/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
    monkeypatch.chdir(tmp_path)

    def files(meshdir: str) -> list[str]:
        Path("a", "main.xml").write_text(text.replace('"inc"', f'"{meshdir}"'))
        return [mesh.file for mesh in read_mjcf(Path("a", "main.xml")).meshes["l"]]

    assert files("inc") == files("nowhere") == [str(Path("inc", "m.stl"))]
    (folder / "m.stl").touch()
    assert files("inc") == files("nowhere") == [str(Path("a", "inc", "m.stl"))]


BAD = {
    "no joint type": ('<body><joint type="hing"/></body>', "", "invalid keyword: 'hing'.*line 4"),
    "no axis": (
        '<body name="a"><joint axis="0 0 0"/></body>',
        "",
        "axis too small in joint.*line 4",
    ),
    "not a number": (
        '<body pos="nan 0 0"><joint/></body>',
        "",
        "line 4: <body>: a number is not finite",
    ),
    "two of one name": (
        '<body name="a"><joint/></body><body name="a"><joint/></body>',
        "",
        "repeated name 'a' in body.*line 4",
    ),
    "unknown body": (
        '<body name="a"><joint/></body>',
        '<equality><connect body1="a" body2="zz" anchor="0 0 0"/></equality>',
        "unknown element 'zz'.*line 6",
    ),
    "missing include": (
        "<body><joint/></body>",
        '<include file="nothing.xml"/>',
        "Error opening file.*nothing.xml",
    ),
    "itself": ("<body><joint/></body>", '<include file="made.xml"/>', "made.xml.*already included"),
    "nothing moves": ('<body name="a"/>', "", "no joint moves"),
    "two polynomials": (
        body("a", "0 0 0", joint("a")) + body("b", "0 0 0", joint("b")),
        '<equality><joint joint1="a" joint2="b" polycoef="0 1 1 0 0"/><joint joint1="a" '
        'joint2="b" polycoef="0 1 2 0 0"/></equality>',
        "line 8: <joint>: the joint 'a' follows others already",
    ),
    "contradiction": (
        body("a", "0 0 0", joint("a")) + body("b", "0 0 0", joint("b")),
        '<equality><joint joint1="a" joint2="b"/>\n'
        '<joint joint1="b" joint2="a" polycoef="0.5 1 0 0 0"/></equality>',
        "line 9: <joint>: it contradicts other couplings",
    ),
    "a closure within a link": (
        body(
            "a",
            "0 0 0",
            joint("a") + body("b", "0 0 0", '<site name="s" pos="1 0 0"/>') + '<site name="t"/>',
        ),
        '<equality><connect site1="s" site2="t"/></equality>',
        "line 8: <connect>: it closes a loop within the one link 'a', whose two frames are 1 apart",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_files_that_are_not_right(name: str, tmp_path: Path) -> None:
    world, rest, sentence = BAD[name]
    with pytest.raises(symkin.SymkinError, match=rf"made\.xml.*{sentence}") as caught:
        symkin.load(in_file(tmp_path, file_text(world, rest)))
    assert "\n" not in str(caught.value)


def test_what_is_no_mjcf(tmp_path: Path) -> None:
    for text, sentence in (
        (
            '<!DOCTYPE m [<!ENTITY a "b">]><mujoco model="&a;"/>',
            "document types and entities are not read",
        ),
        ("<mujoco><worldbody></mujoco>", "line 1: not XML"),
        ("<html/>", "<mujoco>"),
    ):
        with pytest.raises(symkin.SymkinError, match=sentence):
            symkin.load(in_file(tmp_path, text))


def test_without_mujoco(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(symkin.InputError, match=r"pip install 'symkin\[mjcf\]'"):
        read_mjcf(in_file(tmp_path, SMALL["weld"][0]))


def test_nothing_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiler's log is not written into the user's folder."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(symkin.MechanismError):
        read_mjcf(in_file(tmp_path, file_text('<body pos="nan 0 0"><joint/></body>')))
    assert [path.name for path in tmp_path.iterdir()] == ["made.xml"]


@pytest.mark.parametrize(
    ("file", "given"),
    [
        ("g1_parallel_ankle", {"left_motor_joint": 0.1, "right_motor_joint": -0.05}),
        (
            "robotiq_2f85",
            {"left_driver_joint": 0.2, "left_coupler_joint": -0.1, "right_coupler_joint": -0.15},
        ),
        ("four_bar_by_sites", {"motor": 0.4}),
        ("couplings", {"q1": 0.2}),
    ],
)
def test_solutions_and_rates_are_mujocos(
    file: str, given: dict[str, float], tmp_path: Path
) -> None:
    """MuJoCo finds its constraints closed at every mode, link poses as symkin's, and rates of
    joints that keep them closed.
    """
    import mujoco

    path = MODELS / f"{file}.xml" if file in REAL else in_file(tmp_path, SMALL[file][0])
    mechanism, robot = symkin.load(path), read_mjcf(path)
    closed = symkin.close(path)
    account = Account(path, robot)
    scalars = [
        c.name
        for c in mechanism.coordinates
        if c.kind != "quaternion" and not c.name.startswith("connect")
    ]
    others = [name for name in scalars if name not in given]
    for mode in symkin.modes(mechanism, given=given):
        data = mujoco.MjData(account.model)
        rates = symkin.jacobian(mechanism, of=others, by=list(given)).at(mode)
        velocity = np.zeros((account.model.nv, len(given)))
        for j in range(account.model.njnt):
            name, place, row = (
                account.model.joint(j).name,
                int(account.model.jnt_qposadr[j]),
                int(account.model.jnt_dofadr[j]),
            )
            if name in scalars:
                data.qpos[place] = mode.joints[name]
                velocity[row] = (
                    rates[others.index(name)]
                    if name in others
                    else np.eye(len(given))[list(given).index(name)]
                )
            else:
                data.qpos[place] = account.model.qpos0[place] + 0.3 * (name == "q5")
        mujoco.mj_forward(account.model, data)
        errors, jacobian = account.equality_rows(data)
        assert np.abs(errors).max() <= 1e-9
        assert np.abs(jacobian @ velocity).max() <= 1e-8 * max(1.0, np.abs(velocity).max())
        for link in robot.links:
            if (
                link in [account.model.body(b).name for b in range(account.model.nbody)]
                and link != "base"
            ):
                pose = mode.link_poses[link] @ closed.link_poses[link]
                np.testing.assert_allclose(pose.position, data.body(link).xpos, atol=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_random_robots(seed: int, tmp_path: Path) -> None:
    """Poses, closedness and rank as MuJoCo has them, where anything closes the random loop."""
    path = in_file(tmp_path, random_robot(seed))
    try:
        closed = nearest_closed(read_mjcf(path)).closed
    except symkin.MechanismError as error:
        assert "nothing closes it" in str(error)  # noqa: PT017 - any other error is a fault
        return
    if closed:
        check_against_mujoco(path, 0)


def test_a_process_of_its_own_says_the_same(request: pytest.FixtureRequest) -> None:
    """The tests compile by forks of one process, users by a process for each file."""
    path = sorted(MODELS.glob("*.xml"))[0]
    by_fork = repr(read_mjcf(path))
    request.getfixturevalue("own_mujoco")
    assert repr(read_mjcf(path)) == by_fork
