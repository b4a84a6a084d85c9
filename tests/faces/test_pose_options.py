"""Poses of the command line with angles: the same pose, however it is written."""

import json
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run, run_json
from helpers.inside import euler_from_quaternion, quaternion_from_euler

ANGLES = np.array([4.0, -7.0, 11.0])
WHOLE = [10.0, -5.0, 90.0, *quaternion_from_euler(np.radians(ANGLES), "xyz")]
"""A pose of zhang2009 and its roll, pitch and yaw in degrees."""


def _text(values: object) -> str:
    return ",".join(map(repr, np.asarray(values, dtype=float).tolist()))


def _writings(option: str) -> list[list[str]]:
    """The pose in all its forms: quaternion, roll, pitch and yaw, and two Euler sequences."""
    turned = np.degrees(euler_from_quaternion(np.array(WHOLE[3:]), "ZYZ"))
    return [
        [option, _text(WHOLE)],
        [option, "10,-5,90", "--rpy", _text(ANGLES)],
        [option, f"10,-5,90,{_text(ANGLES[::-1])}", "--euler", "ZYX"],
        [option, f"10,-5,90,{_text(ANGLES)}", "--euler", "rpy"],
        [option, f"10,-5,90,{_text(turned)}", "--euler", "ZYZ"],
    ]


@pytest.mark.parametrize("command", ["modes", "solve"])
def test_one_pose_in_many_forms(capsys: pytest.CaptureFixture[str], command: str) -> None:
    """JSON has the same quaternion and the same joints for each form."""
    answers = [run_json(capsys, command, "zhang2009", *words)[1] for words in _writings("--pose")]
    for answer in answers:
        assert np.allclose(answer["given"]["pose"], WHOLE, atol=1e-12)
        solution = answer["modes"][0] if command == "modes" else answer["solution"]
        first = answers[0]["modes"][0] if command == "modes" else answers[0]["solution"]
        assert np.allclose(
            list(solution["joints"].values())[:6], list(first["joints"].values())[:6], atol=1e-9
        )


def test_forms_are_one_in_every_command(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """`singularities`, `sweep --at`, `firmware --home`, `--start` and `--given pose` take them too,
    with equal results.
    """
    kinds = [
        run_json(capsys, "singularities", "zhang2009", *words)[1]["distances"]
        for words in _writings("--pose")
    ]
    assert all(np.allclose(list(k.values()), list(kinds[0].values()), rtol=1e-9) for k in kinds)
    sources = set()
    for k, words in enumerate(_writings("--home")[:2]):
        assert run(capsys, "firmware", "zhang2009", "-o", tmp_path / str(k), *words)[0] == 0
        sources.add((tmp_path / str(k) / "zhang2009.h").read_bytes())
    assert len(sources) == 1
    for k, words in enumerate(_writings("--at")[:2]):
        grid = [
            "--poses",
            "--grid",
            "x=0:10:2",
            "--workers",
            "0",
            "-o",
            str(tmp_path / f"sweep{k}"),
            "--csv",
            str(tmp_path / f"{k}.csv"),
        ]
        assert run(capsys, "sweep", "zhang2009", *grid, *words)[0] == 0
    tables = [np.genfromtxt(tmp_path / f"{k}.csv", delimiter=",", skip_header=1) for k in (0, 1)]
    assert np.allclose(tables[0], tables[1], atol=1e-9, equal_nan=True)
    starts = [["--start", _text(WHOLE)], ["--start", f"10,-5,90,{_text(ANGLES)}", "--euler", "xyz"]]
    found = [
        run_json(capsys, "solve", "zhang2009", *words)[1]["solution"]["pose"] for words in starts
    ]
    assert np.allclose(found[0]["position"], found[1]["position"], atol=1e-9)
    named = ["--given", f"pose=10,-5,90,{_text(ANGLES)}", "--euler", "xyz"]
    assert np.allclose(
        run_json(capsys, "modes", "zhang2009", *named)[1]["given"]["pose"], WHOLE, atol=1e-12
    )


def test_tracks_of_poses_with_angles(capsys: pytest.CaptureFixture[str]) -> None:
    """`track --poses --euler` goes from and to the poses of the angles."""
    ends = [
        "--from",
        "0,0,95,0,0,0",
        "--to",
        f"10,-5,90,{_text(ANGLES)}",
        "--euler",
        "xyz",
        "--samples",
        "3",
    ]
    status, data = run_json(capsys, "track", "zhang2009", "--poses", *ends)
    assert status == 0
    last = data["samples"][-1]["pose"]
    assert np.allclose([*last["position"], *last["quaternion"]], WHOLE, atol=1e-9)


def test_a_translation_needs_no_orientation(capsys: pytest.CaptureFixture[str]) -> None:
    """A delta's pose is X,Y,Z; its orientation is the reference's."""
    quaternion = symkin.load("delta").reference_pose.quaternion
    status, data = run_json(capsys, "modes", "delta", "--pose", "0,0,-150")
    assert (status, data["given"]["pose"]) == (0, [0.0, 0.0, -150.0, *map(float, quaternion)])


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--pose 1,2,3", "for angles write X,Y,Z --rpy R,P,Y"),
        ("--rpy 1,2,3", "--rpy is given without a position"),
        ("--pose 1,2,3 --rpy 1,2", "--rpy: 2 values given, 3 are needed"),
        (
            "--pose 1,2,3,1,0,0,0 --rpy 1,2,3",
            "--pose: 7 values given, 3 are needed: X,Y,Z beside --rpy",
        ),
        ("--pose 1,2,3 --rpy 1,2,3 --euler ZYX", "both --rpy and --euler"),
        ("--pose 1,2,3,4,5,6 --euler ZZX", "Euler sequence 'ZZX' is unknown"),
        ("--pose 1,2,3,1,0,0,0 --euler ZYX", "7 values given, 6 are needed"),
        ("--joints 1,2,3,4,5,6 --euler ZYX", "no pose is given"),
    ],
)
def test_what_is_no_pose_is_one_sentence(
    capsys: pytest.CaptureFixture[str], words: str, expected: str
) -> None:
    """Counts of numbers, options without a pose, sequences that are none."""
    status, out, err = run(capsys, "modes", "zhang2009", *words.split())
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert expected in err


def test_json_writes_what_was_given(capsys: pytest.CaptureFixture[str]) -> None:
    """`given` in JSON is the pose with its quaternion, and is read back as such."""
    _, out, _ = run(capsys, "modes", "zhang2009", *_writings("--pose")[1], "--json")
    given = json.loads(out)["given"]["pose"]
    assert run_json(capsys, "modes", "zhang2009", "--pose", _text(given))[1]["given"][
        "pose"
    ] == pytest.approx(given)


def test_solve_draws_its_solution(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """`solve --plot` writes a picture and names it; without a solution it writes none, and the exit
    status says so.
    """
    picture = tmp_path / "solution.png"
    status, out, _ = run(
        capsys, "solve", "zhang2009", "--plot", picture, "--names", "all", "--views", "main,top"
    )
    assert status == 0
    assert out.splitlines()[-1] == f"picture: {picture}"
    assert picture.read_bytes().startswith(b"\x89PNG")
    picture.unlink()
    status, out, _ = run(
        capsys, "solve", "zhang2009", "--joints", "100,2000,100,100,100,100", "--plot", picture
    )
    assert (status, "picture" in out, picture.exists()) == (3, False, False)
    status, _, err = run(capsys, "solve", "zhang2009", "--views", "top")
    assert (status, "--plot" in err) == (2, True)
