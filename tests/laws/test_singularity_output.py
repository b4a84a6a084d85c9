"""Type 1 and type 2 for an output that the user names: both limbs' dead centres of a five-bar are
told alike for its tip.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import symkin
from helpers.inside import main
from helpers.samples import Z, hexapod, readme_five_bar
from symkin import InputError, Joint, Limb, Mechanism, Solution

TIP = ("x", "y")


def stretched(mechanism: Mechanism, side: int, lean: float = 62.0) -> Solution:
    """The five-bar with the limb on one side in one line: tip 250 from its base, the other elbow
    outwards.
    """
    a = math.radians(lean)
    base, other = np.array([75.0 * side, 0.0]), np.array([-75.0 * side, 0.0])
    tip = base + 250.0 * np.array([-side * math.cos(a), math.sin(a)])
    away = tip - other
    r = float(np.linalg.norm(away))
    h, u = (r * r + 100.0**2 - 150.0**2) / (2 * r), away / r
    elbow = other + h * u + side * math.sqrt(100.0**2 - h * h) * np.array([-u[1], u[0]])
    cranks = {side: tip - base, -side: elbow - other}
    joints = [math.degrees(math.atan2(cranks[k][1], cranks[k][0])) - 90.0 for k in (-1, 1)]
    modes = symkin.modes(mechanism, joints=joints, method="multistart", starts=100)
    return min(modes, key=lambda mode: float(np.linalg.norm(mode.position[:2] - tip)))


@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_dead_centres_of_mirror_images_are_told_alike(motion) -> None:
    """The platform is a link of the left limb; for the tip both limbs' dead centres are type 1,
    with equal distances.
    """
    mechanism = readme_five_bar(motion)
    found = {side: symkin.singularity(stretched(mechanism, side), output=TIP) for side in (-1, 1)}
    for side, crank in ((-1, "crank1"), (1, "crank2")):
        assert found[side].kinds == ("type 1",)
        assert found[side].inputs == ({crank: 1.0},)
        assert found[side].distances["type 1"] < 1e-9
        force = found[side].wrenches[0]
        assert force.name == "force"
        assert np.allclose(
            force.direction[:2],
            [math.cos(math.radians(62)), -side * math.sin(math.radians(62))],
            atol=1e-6,
        )
    assert found[-1].distances["type 2"] == pytest.approx(found[1].distances["type 2"], rel=1e-6)
    assert np.allclose(found[-1].singular_values, found[1].singular_values, atol=1e-9)


def test_the_verdict_without_an_output_says_what_it_is_about() -> None:
    """The left limb's dead centre turns the platform about the tip: no type 1 of the whole pose,
    and a note says so.
    """
    found = symkin.singularity(stretched(readme_five_bar(), -1))
    assert found.kinds == ()
    assert any(
        "about its position and orientation together" in note and "--output" in note
        for note in found.notes
    )


def test_couplers_in_line_are_type_2_of_the_tip() -> None:
    """Elbows 300 apart: the tip moves across the couplers with the cranks held, as the twist
    shows.
    """
    mechanism = readme_five_bar("planar")
    turn = math.degrees(math.asin(0.75))
    found = symkin.singularity(
        mechanism, joints=[turn, -turn], output=TIP, start=[0, 66, 0, 1, 0, 0, 0]
    )
    assert "type 2" in found.kinds
    assert len(found.twists) == 1


def test_all_six_components_are_the_platform() -> None:
    """With the whole twist as the output, kinds, singular values and feasible twists are those
    without an output.
    """
    mechanism = symkin.load("zhang2009")
    solution = symkin.solve(
        mechanism, pose=[10, 20, 200, 0.98, 0.1, -0.1, math.sqrt(1 - 0.98**2 - 0.02)]
    ).solution
    whole = symkin.singularity(solution)
    named = symkin.singularity(solution, output=["x", "y", "z", "rx", "ry", "rz"])
    assert named.kinds == whole.kinds
    assert set(named.distances) >= set(whole.distances)
    assert np.allclose(named.singular_values, whole.singular_values, rtol=1e-9)


def test_a_stretched_arm_loses_a_direction_of_its_position() -> None:
    """Two links of 100 and 80: det of the position Jacobian is 100 80 sin q2, so that a stretched
    elbow is type 1 of the tip.
    """
    joints = [
        Joint("q1", "R", (0.0, 0, 0), Z, actuated=True),
        Joint("q2", "R", (100.0, 0, 0), Z, actuated=True),
    ]
    arm = Mechanism(
        "two_links", [Limb("two_links", joints)], serial=True, platform_position=(180.0, 0.0, 0.0)
    )
    for q2 in (0.0, 0.3, 1.2):
        found = symkin.singularity(symkin.solve(arm, joints=[0.4, q2]).solution, output=TIP)
        assert found.kinds == (("type 1",) if q2 == 0.0 else ())
        per_size = 100.0 * 80.0 * math.sin(q2) / arm.characteristic_length**2
        assert found.manipulability == pytest.approx(per_size, abs=1e-9)


@pytest.mark.slow
def test_the_point_decides() -> None:
    """The same point of the platform, named from two platform origins, has one verdict; another
    point has another.
    """
    ring = [(100 * math.cos(a), 100 * math.sin(a)) for a in (0.1, 2.0, 2.2, 4.1, 4.3, 6.2)]
    base, platform = (
        [(x, y, 0.0) for x, y in ring],
        [(0.6 * y, -0.6 * x, 5.0 * k) for k, (x, y) in enumerate(ring)],
    )
    moved = [(x - 20.0, y + 5.0, z - 7.0) for x, y, z in platform]
    one, two = hexapod(base, platform), hexapod(base, moved)
    first = symkin.singularity(
        symkin.solve(one, pose=[5, 3, 110, 1, 0, 0, 0]).solution, point=[20.0, -5.0, 7.0]
    )
    second = symkin.singularity(
        symkin.solve(two, pose=[25, -2, 117, 1, 0, 0, 0]).solution, output=["x", "y", "z"]
    )
    other = symkin.singularity(first.solution, output=["x", "y", "z"])
    assert first.distances["type 2"] == pytest.approx(second.distances["type 2"], rel=1e-6)
    assert abs(first.distances["type 2"] - other.distances["type 2"]) > 1e-6
    assert first.permanent_freedoms == {"type 1": 3}


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        main(["singularities", *arguments])
    said = capsys.readouterr()
    return stop.value.code or 0, said.out, said.err


def test_the_command_takes_output_and_point(tmp_path, capsys) -> None:
    """`--output x,y --point X,Y,Z`: said in the text and in the JSON; what does not fit is one
    sentence, status 2.
    """
    path = tmp_path / "five_bar.toml"
    path.write_text(readme_five_bar("planar").to_toml(), encoding="utf-8")
    status, text, _ = run(
        capsys, str(path), "--joints", "10,-10", "--output", "x,y", "--point", "0,20,0"
    )
    assert status == 0
    assert "output: velocity x, y of the platform's point (0, 20, 0)" in text
    status, text, _ = run(capsys, str(path), "--joints", "10,-10", "--point", "0,20,0", "--json")
    assert json.loads(text)["output"] == {"coordinates": ["x", "y", "z"], "point": [0.0, 20.0, 0.0]}
    assert json.loads(run(capsys, str(path), "--joints", "10,-10", "--json")[1])["output"] is None
    for options, said in (
        (["--output", "x,q"], "allowed: one or more of x, y, z, rx, ry, rz"),
        (["--output", "x,x"], "each once"),
        (["--output", "z"], "never moves it"),
        (["--point", "1,2"], "three finite numbers"),
        (["--plane", "x,y", "--output", "x"], "not to --plane"),
    ):
        status, _, error = run(capsys, str(path), "--joints", "10,-10", *options)
        assert status == 2
        assert said in error
        assert error.count("\n") == 1


def test_an_output_is_checked() -> None:
    with pytest.raises(InputError, match="each once"):
        symkin.singularity(readme_five_bar(), joints=[10, -10], output=[])
