"""The verb `close`: closed configurations of files in every format, how far they were open, and
counts against those of other tools.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import main
from helpers.mjcf_models import MODELS, REAL, SMALL, body, file_text, joint
from symkin import Pose

pytest.importorskip("mujoco")


CRANKS = """
format = 1
name = "cranks"
length_unit = "m"
angle_unit = "rad"
joint = [
    {name = "a", type = "R", links = ["base", "p"], point = [0, 0, 0], axis = [0, 0, 1]},
    {name = "b", type = "R", links = ["base", "q"], point = [3, 0, 0], axis = [0, 0, 1]},
]
rod = [{name = "r", links = ["p", "q"], from = [0, 1, 0], to = [3, 2, 0], length = 2.5}]
"""


def open_four_bar(folder: Path, reach: float, name: str = "open.xml") -> Path:
    """Crank 0.2 at `reach` from the hip of a leg of 0.3 and 0.4; closed where the ends meet."""
    leg = body(
        "thigh",
        "0 0 0",
        joint("hip", 'axis="0 0 1" range="-1 1"')
        + body("shin", "0.3 0 0", joint("knee") + '<site name="toe" pos="0.4 0 0"/>'),
    )
    crank = body("crank", f"{reach} 0 0", joint("motor") + '<site name="pin" pos="0 0.2 0"/>')
    text = file_text(
        leg + crank,
        '<equality><connect name="loop" site1="toe" site2="pin"/></equality><actuator><motor '
        'joint="motor"/></actuator>',
    )
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    out, err = capsys.readouterr()
    return int(stop.value.code or 0), out, err


@pytest.mark.parametrize("name", REAL)
def test_counts_of_real_robots(name: str) -> None:
    """Rank, mobility, also beside, actuated joints and poses of bodies as the JSON beside each file
    says, of the held root.
    """
    told = json.loads((MODELS / f"{name}.json").read_text(encoding="utf-8"))
    found = symkin.close(MODELS / f"{name}.xml").to_dict()
    free = 6 * told["joints"].get("free", 0)
    assert (found["rank"], found["mobility"]) == (
        told["rank_at_configuration"],
        told["mobility_at_configuration"] - free,
    )
    assert found["generic"]["mobility"] == told["mobility_generic"] - free
    assert found["rows"] == told["constraint_rows"]
    assert found["residual"] <= 1e-12
    assert found["loops"] == told["independent_loops"]
    if name in ("g1_parallel_ankle", "robotiq_2f85"):
        for link, position in told["bodies_xpos"].items():
            if link != "world":
                np.testing.assert_allclose(
                    found["link_poses"][link]["position"], position, atol=1e-12
                )


def test_an_open_file(tmp_path: Path) -> None:
    """How far it is open is the distance of its two sites; closed, the frames meet, and the two
    bars have their lengths.
    """
    found = symkin.close(open_four_bar(tmp_path, 0.6))
    assert found.open_by == pytest.approx(np.hypot(0.1, 0.2))
    assert found.residual <= 1e-10
    assert (found.rank, found.mobility, found.rows, found.redundant) == (2, 1, 3, 1)
    assert found.actuated == ("motor",)
    toe = found.link_poses["shin"].apply(np.array([0.4, 0.0, 0.0]))
    pin = found.link_poses["crank"].apply(np.array([0.0, 0.2, 0.0]))
    np.testing.assert_allclose(toe, pin, atol=1e-10)


def test_the_mechanism_that_is_loaded_stands_there(tmp_path: Path) -> None:
    """Its joints have the closed values at the reference, and given one of them `solve` finds the
    others.
    """
    path = open_four_bar(tmp_path, 0.6)
    found, mechanism = symkin.close(path), symkin.load(path)
    solution = symkin.solve(mechanism, joints=[found.joints["motor"]]).solution
    for name in ("hip", "knee", "motor"):
        assert solution.joints[name] == pytest.approx(found.joints[name], abs=1e-9)
    assert len(symkin.modes(mechanism, joints=[found.joints["motor"]])) == 2


def test_a_singular_configuration(tmp_path: Path) -> None:
    """A parallelogram lying in one line: rank 1 there, 2 beside it, as its two branches cross."""
    bars = body(
        "a", "0 0 0", joint("a") + body("c", "1 0 0", joint("c") + '<site name="s" pos="1 0 0"/>')
    )
    path = tmp_path / "flat.xml"
    last = body("b", "1 0 0", joint("b") + '<site name="t" pos="1 0 0"/>')
    path.write_text(
        file_text(bars + last, '<equality><connect site1="s" site2="t"/></equality>'),
        encoding="utf-8",
    )
    found = symkin.close(path)
    assert (found.rank, found.generic_rank, found.mobility) == (1, 2, 2)
    assert any("singular" in note for note in found.notes)
    found.plot(tmp_path / "flat.png")


def test_a_robot_that_no_motion_leads_away_from_is_told_so(tmp_path: Path) -> None:
    """Two bars that a connect holds stretched: a freedom of first order, and no mobility."""
    bar = '<site name="{}" pos="{} 0 0"/>'
    bars = body("a", "0 0 0", joint("a") + bar.format("s", 1)) + body(
        "b", "2 0 0", joint("b") + bar.format("t", -1)
    )
    path = tmp_path / "stretched.xml"
    rest = '<equality><connect site1="s" site2="t"/></equality>'
    path.write_text(file_text(bars, rest), encoding="utf-8")
    found = symkin.close(path)
    assert (found.mobility, found.to_dict()["generic"]["mobility"]) == (1, 0)
    assert any(note.startswith("no motion leads away") for note in found.notes)


def test_limits_that_the_closed_configuration_breaks(tmp_path: Path) -> None:
    path = open_four_bar(tmp_path, 0.6)
    path.write_text(
        path.read_text(encoding="utf-8").replace('range="-1 1"', 'range="2 3"'), encoding="utf-8"
    )
    assert any("beyond the limits of the file: hip" in note for note in symkin.close(path).notes)


def test_what_no_configuration_closes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The bars are 0.9 long together and 1 is asked of them: the JSON is written, no picture, and
    the exit status is 3.
    """
    path, picture = open_four_bar(tmp_path, 1.0), tmp_path / "nothing.png"
    status, out, _ = run(capsys, "close", str(path), "--json", "--plot", str(picture))
    assert not picture.exists()
    found = json.loads(out)
    assert status == 3
    assert found["closed"] is False
    assert found["residual"] == pytest.approx(0.1, abs=1e-3)
    assert "most of it in the loop of loop" in found["notes"][0]
    status, _, err = run(capsys, "show", str(path))
    assert status == 2
    assert "no configuration was found that closes the loops" in err


def test_the_picture_of_the_closed_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Written where the loops close; a wrong name is refused before the work."""
    picture = tmp_path / "closed.png"
    status, out, _ = run(capsys, "close", str(open_four_bar(tmp_path, 0.6)), "--plot", str(picture))
    assert status == 0
    assert f"picture: {picture}" in out
    assert picture.read_bytes().startswith(b"\x89PNG")
    status, _, err = run(
        capsys, "close", str(open_four_bar(tmp_path, 0.6)), "--plot", str(tmp_path / "a.txt")
    )
    assert status == 2
    assert "has no picture format" in err


def test_a_robot_of_welds_alone_moves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A free body that a weld joins to the world: it is closed, and no mechanism."""
    path = tmp_path / "welded.xml"
    path.write_text(
        file_text(
            body("beam", "0 1 0", "<freejoint/>"), '<equality><weld body1="beam"/></equality>'
        ),
        encoding="utf-8",
    )
    found = symkin.close(path)
    assert found.closed
    assert found.reference is None
    assert (found.rank, found.mobility) == (6, 0)
    for command in ("show", "modes", "solve"):
        status, _, err = run(capsys, command, str(path))
        assert status == 2
        assert "no joint moves" in err


def test_balls_alone_leave_no_joint_to_be_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "ball.xml"
    path.write_text(
        file_text(body("beam", "0 1 0", joint("ball", 'type="ball"'))), encoding="utf-8"
    )
    status, _, err = run(capsys, "modes", str(path))
    assert status == 2
    assert "3 freedoms" in err
    assert "no joint is left to be given" in err


def test_what_is_written_reads_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The mechanism file has the closed configuration as its reference: it is closed, with the same
    joint values and mobility.
    """
    path, output = open_four_bar(tmp_path, 0.6), tmp_path / "closed.toml"
    status, out, _ = run(capsys, "close", str(path), "-o", str(output))
    assert status == 0
    assert f"written: {output}" in out
    before, after = symkin.close(path), symkin.close(output)
    assert after.open_by <= 1e-12
    assert after.mobility == before.mobility
    for name, value in before.joints.items():
        assert after.joints[name] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    "name",
    in_gate(
        ["open", "hinge_pair_ref_and_turned_frames", "platform_on_six_legs", "couplings"],
        ["open", "hinge_pair_ref_and_turned_frames", "couplings"],
    ),
)
def test_the_keyframe_that_is_written(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """MuJoCo's bodies stand there where `close` has the links, and its constraints are closed."""
    import mujoco

    path, output = open_four_bar(tmp_path, 0.6), tmp_path / "closed.xml"
    if name != "open":
        path.write_text(SMALL[name][0], encoding="utf-8")
    status, _, _ = run(capsys, "close", str(path), "-o", str(output))
    assert status == 0
    model = mujoco.MjModel.from_xml_path(str(output))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("closed").id)
    mujoco.mj_forward(model, data)
    equality = np.asarray(data.efc_type[: data.nefc]) == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    assert np.abs(np.asarray(data.efc_pos[: data.nefc])[equality]).max() <= 1e-9
    for link, pose in symkin.close(path).link_poses.items():
        if link in [model.body(b).name for b in range(model.nbody)]:
            np.testing.assert_allclose(pose.position, data.body(link).xpos, atol=1e-10)


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_the_keyframe_stands_in_the_model_whatever_follows_it(
    encoding: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A comment that speaks of the end is left as it is, and the file keeps its bytes."""
    import mujoco

    path, output = open_four_bar(tmp_path, 0.6), tmp_path / "closed.XML"
    text = f'<?xml version="1.0" encoding="{encoding}"?>\n{path.read_text(encoding="utf-8")}'
    content = f"{text}\n<!-- \xe9: the end of </mujoco> -->\n".encode(encoding)
    path.write_bytes(content)
    assert run(capsys, "close", str(path), "-o", str(output))[0] == 0
    written = output.read_bytes()
    assert written.endswith(content[content.index(b"</mujoco>") :])
    assert written.startswith(content[: content.index(b"</mujoco>")])
    assert mujoco.MjModel.from_xml_path(str(output)).nkey == 1


def test_names_that_the_compiler_cannot_tell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = open_four_bar(tmp_path, 0.6)
    text = path.read_text(encoding="utf-8").replace('"thigh"', '"\xe9paule"')
    declared = f'<?xml version="1.0" encoding="latin-1"?>\n{text}'
    path.write_bytes(declared.encode("latin-1"))
    status, _, err = run(capsys, "close", str(path), "-o", str(tmp_path / "closed.xml"))
    assert status == 2
    assert "is not UTF-8; write the file in UTF-8" in err


def test_a_file_without_joints_takes_no_keyframe(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, output = tmp_path / "empty.xml", tmp_path / "closed.xml"
    path.write_text('<mujoco model="m"/>', encoding="utf-8")
    status, _, err = run(capsys, "close", str(path), "-o", str(output))
    assert status == 2
    assert "no joint whose value a keyframe could hold" in err
    assert not output.exists()


@pytest.mark.parametrize(
    "name", ["four_bar", "ankle", "zhang2009", "zhao2000", "gluon_6l3", "delta_parallelograms"]
)
def test_mechanism_files(name: str) -> None:
    """Their reference is closed, and the counts are those of `mobility`."""
    found, account = symkin.close(name).to_dict(), symkin.mobility(symkin.load(name))
    assert found["closed"]
    assert found["generic"]["mobility"] == account.mobility
    assert set(found["joints"]) == {c.name for c in symkin.load(name).coordinates}


def test_an_open_mechanism_file_closes_at_the_nearest(tmp_path: Path) -> None:
    """Two cranks and a rod of another length than their ends have: no closed configuration beside
    the one told turns the cranks by less.
    """
    path = tmp_path / "cranks.toml"
    path.write_text(CRANKS, encoding="utf-8")
    found, machine = symkin.close(path), symkin.load(path)
    assert found.closed
    assert found.open_by > 0.1
    first, second = (float(found.joints[name]) for name in ("a", "b"))
    for step in (-1e-3, 1e-3):
        near = symkin.solve(machine, given={"a": first + step}, start={"b": second}).solution
        assert np.hypot(near.joints["a"], near.joints["b"]) > np.hypot(first, second)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["close", "none.xml"], "none.xml: there is no such file"),
        (["close", "none.stl"], "or a path to a file (.toml"),
        (
            ["close", "four_bar", "-o", "out.xml"],
            "a keyframe is written into a copy of an MJCF file",
        ),
        (["close", "four_bar", "-o", "out.png"], "another suffix than .toml, .json, .xml"),
    ],
)
def test_wrong_input(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = run(capsys, *arguments)
    assert (status, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("seed", [0, 3, 11, 12, 25])
def test_close_and_mobility_stand_on_one_configuration(seed: int) -> None:
    """Of a truss thrown wide open, which closes at several configurations: two hinged links, whose
    points two rods keep at their distances at (0.5, 2).
    """
    rng, ground = np.random.default_rng(seed), np.array([4.0, 0.0, 0.0])
    thrown, points = rng.uniform(-np.pi, np.pi, 2), [(2.0, 0.0), (1.0, 1.5)]
    ends = [(2.5, 0.0), (1.2, -1.0)]

    def at(angle: float, point: Sequence[float]) -> np.ndarray:
        turn = Pose.from_rotation_vector(np.zeros(3), np.array([0.0, 0.0, angle]))
        return np.asarray(turn.apply(np.array([*point, 0.0])))

    rods = []
    for k, (p, q) in enumerate(zip(points, ends, strict=True)):
        length = float(np.linalg.norm(at(0.5, p) - at(2.0, q) - ground))
        first, last = at(thrown[0], p), at(thrown[1], q) + ground
        rods.append(symkin.LinkRod(f"rod{k}", ["left", "right"], first, last, length=length))
    hinges = [
        symkin.LinkJoint(symkin.Joint(name, "R", point, [0, 0, 1], zero=zero), ["base", name])
        for name, point, zero in zip(("left", "right"), (np.zeros(3), ground), thrown, strict=True)
    ]
    truss = symkin.Mechanism("truss", link_joints=hinges, link_rods=rods)
    closed, counted = symkin.close(truss), symkin.mobility(truss)
    assert closed.closed
    for c, value in zip(counted.closure.coordinates, counted.values, strict=True):
        away = float(value) - float(closed.joints[c.name])  # type: ignore[arg-type]
        assert abs(np.sin(0.5 * away)) < 1e-6
