"""Sliders of a page where the actuated joints do not decide a configuration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import build_problem, completed_sliders, determination, page_html, page_model
from helpers.samples import with_actuated
from symkin import Mechanism

GRAPHS = [
    "jansen_leg",
    "klann_leg",
    "watt_six_bar",
    "stephenson_six_bar",
    "slider_crank",
    "double_wishbone",
    "planetary_gear",
]
GRIPPER = """<robot name='r'><link name='a'/>{links}<link name='left'/><link name='right'/>{chain}
<joint name='j_left' type='prismatic'><parent link='b6'/><child link='left'/><axis xyz='0 1 0'/>
<limit lower='0' upper='.1' effort='1' velocity='1'/></joint>
<joint name='j_right' type='prismatic'><parent link='b6'/><child link='right'/><axis xyz='0 1 0'/>
<limit lower='-.1' upper='0' effort='1' velocity='1'/>
<mimic joint='j_left' multiplier='-1'/></joint>{motors}</robot>"""
MOTOR = (
    "<transmission name='t_{0}'><type>SimpleTransmission</type><joint name='{0}'/><actuator "
    "name='m_{0}'/></transmission>"
)


@pytest.mark.parametrize("name", GRAPHS)
@pytest.mark.parametrize("seed", range(3))
def test_any_motors_are_completed_to_what_decides(name: str, seed: int) -> None:
    """Motors on no, some or all joints: the sliders are as many as the mobility, none is decided by
    others, and the motors that stay keep their order.
    """
    mechanism, rng = symkin.load(name), np.random.default_rng([seed, GRAPHS.index(name)])
    simple = [c.name for c in mechanism.coordinates if c.kind != "quaternion"]
    share = seed / 2
    chosen = [n for n in simple if rng.uniform() < share]
    changed = with_actuated(mechanism, chosen)
    names = [c.name for c in changed.actuated]
    found = completed_sliders(changed)
    sliders = names if found is None else list(found[0])
    told = determination(build_problem(changed, "given", tuple(sliders)))
    assert not told.free
    assert not told.decided
    assert len(sliders) == told.mobility
    assert [n for n in sliders if n in names] == [n for n in names if n in sliders]


def robot(tmp_path: Path, motors: list[str]) -> Mechanism:
    """An arm of six hinges with a gripper of two coupled fingers."""
    links = "".join(f"<link name='b{k}'/>" for k in range(1, 7))
    parents = ["a", *(f"b{k}" for k in range(1, 6))]
    axes = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"]
    chain = "".join(
        f"<joint name='j{k}' type='continuous'><parent link='{parent}'/><child "
        f"link='b{k}'/><origin xyz='.1 .02 .2'/><axis xyz='{axis}'/></joint>"
        for k, (parent, axis) in enumerate(zip(parents, axes, strict=True), start=1)
    )
    text = GRIPPER.format(
        links=links, chain=chain, motors="".join(MOTOR.format(name) for name in motors)
    )
    (tmp_path / "r.urdf").write_text(text, encoding="utf-8")
    return symkin.load(tmp_path / "r.urdf")


def test_joints_at_which_loops_are_cut_have_sliders_too(tmp_path: Path) -> None:
    """Motors at the gripper alone, both fingers, of which one follows the other."""
    machine = robot(tmp_path, ["j_left", "j_right"])
    assert [c.name for c in machine.actuated] == ["j_left"], "one follows the other"
    found = completed_sliders(with_actuated(machine, ["j_left", "j_right"]))
    assert found is not None
    assert set(found[0]) == {"j_left", "j1", "j2", "j3", "j4", "j5", "j6"}
    assert found[1].count("j_right has no slider: other actuated joints decide it.") == 1
    assert found[1].startswith("j1, j2, j3, j4 and 2 more have sliders: the actuated joints leave")


def test_a_page_says_which_sliders_are_not_those_of_motors() -> None:
    html = page_html(with_actuated(symkin.load("four_bar"), []))
    assert (
        "has a slider: no joint of the mechanism is actuated. --given gives sliders to others."
        in html
    )


def test_motors_that_decide_are_left_as_they_are() -> None:
    for name in ("four_bar", "zhao2000", "ur5e", "jansen_leg"):
        assert completed_sliders(symkin.load(name)) is None


@pytest.mark.parametrize(
    ("name", "follows"),
    in_gate(
        [
            ("hexapod_stack", True),
            ("urdf_loop_joint/strandbeest.urdf", True),
            ("urdf_gepetto_yaml/digit_like_2legs.urdf", False),
        ],
        [("hexapod_stack", True)],
    ),
)
def test_pages_of_large_machines_stay_small(name: str, *, follows: bool) -> None:
    """Below 1.5 MB without meshes, with the formulas of all steps below 2.5 MB; where a step has
    more solutions than are followed they are not.
    """
    models = Path(__file__).parents[1] / "data" / "models"
    html = page_html(symkin.load(models / name if "/" in name else name))
    assert f'"follows":{str(follows).lower()}' in html
    assert len(html.encode()) < (2.5e6 if follows else 1.5e6)


def test_sliders_are_the_motors_where_the_loops_close_only_to_digits() -> None:
    """The Minitaur's reference is singular, and beside it its loops close to the file's digits
    alone: the mobility is that of `show`.
    """
    mechanism = symkin.load(Path(__file__).parents[1] / "data" / "models" / "sdf" / "minitaur.sdf")
    assert completed_sliders(mechanism) is None
    told = determination(
        build_problem(mechanism, "given", tuple(c.name for c in mechanism.actuated))
    )
    assert (told.free, told.decided, told.mobility) == (0, (), 8)
    assert "mobility is 8" in str(symkin.mobility(mechanism))


def test_a_page_begins_within_limits_where_a_mode_is() -> None:
    """Limits of the rocker that leave out the branch of the reference: the page begins on the other
    one.
    """
    mechanism = symkin.load("four_bar")
    crank = mechanism.actuated[0].name
    first, second = symkin.modes(mechanism, given={crank: 60.0})
    near = symkin.solve(mechanism, given={crank: 60.0}).solution
    other = max(
        (first, second), key=lambda mode: float(np.abs(mode.variables - near.variables).max())
    )
    name = next(
        n for n in near.joints if n != crank and abs(near.joints[n] - other.joints[n]) > 30.0
    )
    half = np.deg2rad(10.0)
    limits = (np.deg2rad(other.joints[name]) - half, np.deg2rad(other.joints[name]) + half)
    joints = [
        replace(e, joint=replace(e.joint, limits=limits)) if e.joint.name == name else e
        for e in mechanism.link_joints
    ]
    limited = replace(mechanism, link_joints=tuple(joints))
    assert symkin.solve(limited, given={crank: 60.0}).solution.within_limits is False
    start = page_model(limited, {crank: 60.0}).model["start"]
    np.testing.assert_allclose(start, other.variables, atol=1e-9)


def test_a_limb_whose_motor_is_left_out_has_a_slider_all_the_same() -> None:
    """A platform on limbs that its motors leave free to move has a page, as a graph has."""
    whole = symkin.load("zhao2000")
    first, *others = whole.limbs
    joints = [replace(joint, actuated=False) for joint in first.joints]
    free = replace(whole, limbs=[replace(first, joints=joints), *others], example=None)
    sliders, note = completed_sliders(free) or ({}, "")
    assert [*sliders] == ["theta2", "theta3", "op", "theta1"]
    assert note.startswith("theta1 has a slider: the actuated joints leave")
    assert page_model(free, sliders).model["names"]
