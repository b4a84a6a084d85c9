"""Bodies and branches of a graph, its structure groups, and the tree of their choices."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.inside import (
    BASE,
    COMPLETENESS,
    Rank,
    build_problem,
    closed_configurations,
    given_by_name,
    independent_parts,
    layout_of,
    make_finder,
    parse,
    problem_of,
    structure_groups,
)
from helpers.moved_mechanisms import reordered
from helpers.shipped import TWELVE
from symkin import InputError

ROOT = Path(__file__).resolve().parents[2]
GALLERY = json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text())
CASES = [(name, k) for name, entry in GALLERY.items() for k in range(len(entry["cases"]))]
FEW = [(name, 0) for name in GALLERY if name in TWELVE]
FOUR_BAR = ROOT / "symkin" / "mechanisms" / "four_bar.toml"


def groups_of(name: str, k: int) -> tuple[symkin.Mechanism, list]:
    mechanism = symkin.load(name)
    problem = problem_of(mechanism, given_by_name(mechanism, GALLERY[name]["cases"][k]["given"]))
    return mechanism, list(structure_groups(problem))


def legs(count: int) -> symkin.Mechanism:
    """Four-bars side by side on one crank, each with a coupler and a follower of its own."""
    tables = [
        'format = 1\nname = "legs"\nlength_unit = "mm"\nangle_unit = "deg"\n',
        joint("crank", "base", "arm", 0, 0, actuated=True),
    ]
    for k in range(count):
        tables.append(joint(f"a{k}", "arm", f"coupler{k}", 40, 0))
        tables.append(joint(f"b{k}", f"coupler{k}", f"follower{k}", 120 + k, 100))
        tables.append(joint(f"c{k}", "base", f"follower{k}", 150, -10 * k))
    return parse("\n".join(tables))


def joint(name: str, a: str, b: str, x: float, y: float, *, actuated: bool = False) -> str:
    text = (
        f'[[joint]]\nname = "{name}"\ntype = "R"\nlinks = ["{a}", "{b}"]\npoint = [{x}, {y}, 0]\n'
        f"axis = [0, 0, 1]\n"
    )
    return text + ("actuated = true\n" if actuated else "")


# --- bodies and branches --------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(GALLERY))
def test_every_joint_stands_in_one_branch_and_every_body_is_placed(name):
    """The elements of all branches are the joints and rods, each once; a branch begins at a body
    that is placed before it.
    """
    mechanism = symkin.load(name)
    for pose in (False, True):
        layout = layout_of(mechanism, frozenset(), pose=pose)
        elements = [element.name for branch in layout.branches for element in branch.elements]
        expected = [j.name for j in mechanism.all_joints] + [
            rod.name for rod in mechanism.link_rods
        ]
        assert sorted(elements) == sorted(expected)
        placed = {BASE, *layout.floating}
        for branch in layout.branches:
            assert branch.ends[0] in placed
            assert branch.carries == (branch.ends[1] not in placed)
            placed.add(branch.ends[1])


def test_a_welded_link_is_one_with_its_partner():
    """A coupler cut in two and welded: the same modes."""
    text = FOUR_BAR.read_text()
    plain = symkin.modes(parse(text), given={"crank": 60})
    coupler = next(
        j
        for j in symkin.load("four_bar").link_joints
        if "coupler" in j.links[0] or "coupler" in j.links[1]
    )
    other = "half"
    halves = text.replace(
        f'"{coupler.links[0]}", "{coupler.links[1]}"', f'"{coupler.links[0]}", "{other}"', 1
    )
    halves += (
        f'\n[[joint]]\nname = "seam"\ntype = "weld"\nlinks = ["{other}", "{coupler.links[1]}"]\n'
    )
    welded = symkin.modes(parse(halves), given={"crank": 60})
    assert len(welded) == len(plain)
    for mine, theirs in zip(welded, plain, strict=True):
        assert mine.joints["follower"] == pytest.approx(theirs.joints["follower"], abs=1e-9)


# --- groups ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "k"), in_gate(CASES, [case for case in CASES if case[1] == 0]))
def test_groups_are_solved_in_order_and_determined(name, k):
    """Each reads what is given and what is found before; at a closed configuration its rows have
    the rank of its unknowns.
    """
    mechanism, groups = groups_of(name, k)
    problem = problem_of(mechanism, given_by_name(mechanism, GALLERY[name]["cases"][k]["given"]))
    known = {c.name for c in problem.known_coordinates}
    values = np.array(closed_configurations(problem.closure, 0))
    for group in groups:
        assert {c.name for c in group.known_coordinates} <= known
        known |= {c.name for c in group.system.unknowns}
        jacobians = group.system.linearise(
            values[:, group.unknown_places], values[:, group.known_places]
        )[1]
        assert max(Rank.of(j).value for j in jacobians) == group.system.freedom
    assert known == {c.name for c in problem.closure.coordinates}


@pytest.mark.parametrize(
    ("name", "k", "sizes"),
    [
        ("watt_six_bar", 0, [2, 2]),
        ("stephenson_six_bar", 0, [2, 2]),
        ("stephenson_six_bar", 2, [4]),
        ("jansen_leg", 0, [2, 2, 2]),
        ("excavator_bucket", 0, [2, 2, 2, 2]),
    ],
)
def test_groups_are_the_assur_groups_of_textbooks(name, k, sizes):
    """Dyads of two unknown angles; a Stephenson linkage driven from its five-bar is a triad of
    four.
    """
    _, groups = groups_of(name, k)
    assert sorted(group.system.freedom for group in groups) == sizes


# --- the tree of choices --------------------------------------------------------------------------


def test_independent_parts_do_not_multiply_the_work():
    """Sixteen legs on one crank: 2^16 modes are counted, each leg's two are listed, any one is
    reached by its choices.
    """
    walker = legs(16)
    found = symkin.modes(walker, joints=[20.0])
    assert found.total == 2**16
    assert len(found) == 1 + 16
    assert found.to_dict()["count"] == 2**16
    assert found.to_dict()["listed"] == 17
    assert len(found.groups) == 16
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(5):
        choice = rng.integers(0, 2, 16).tolist()
        (mode,) = symkin.modes(walker, joints=[20.0], choose=choice)
        assert mode.residual < 1e-9 * walker.characteristic_length
        seen.add(tuple(round(mode.joints[f"b{k}"], 6) for k in range(16)))
    assert len(seen) == 5


def test_inputs_with_more_modes_than_are_listed_stand_beside_others():
    """Of sixteen legs on one crank some modes of each input are listed, the first of all legs with
    both of one.
    """
    walker = legs(16)
    for found in symkin.modes(walker, joints=[[20.0], [35.0]]):
        assert found.total == 2**16
        assert len(found) == 1 + 16
        assert max(mode.residual for mode in found) < 1e-9 * walker.characteristic_length


def test_points_with_more_modes_than_are_listed_are_counted_as_such():
    """A sweep's point of sixteen legs is "too many to list", one of three legs has its eight
    modes.
    """
    for count, expected, said in ((16, -1, "too many to list"), (3, 8, "probability one")):
        problem = build_problem(legs(count), "given", ("crank",))
        finder = make_finder(problem, starts=100, seed=0, certify=False)
        found = finder.find_values(np.radians([[20.0], [35.0]]))
        assert found.count.tolist() == [expected, expected]
        assert [COMPLETENESS[code] for code in found.completeness] == [said, said]
        assert len(found.listed) == 2 * max(expected, 0)


def test_a_sweep_says_that_there_are_too_many_modes(tmp_path):
    pytest.importorskip("xarray")
    swept = symkin.sweep(legs(16), {"crank": [20.0, 35.0]}, tmp_path / "s", workers=0)
    assert "too many to list: 2" in str(swept)
    assert "no point" not in str(swept)
    assert swept.plot().axes[0].texts[0].get_text() == "too many modes to list at every point"


def test_choices_and_the_whole_list_agree():
    """Three legs: the eight modes are those of all choices."""
    walker = legs(3)
    listed = symkin.modes(walker, joints=[20.0])
    parts = independent_parts(structure_groups(listed.problem))
    assert len(parts) == 3
    chosen = [
        symkin.modes(walker, joints=[20.0], choose=[i, j, k])[0]
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    ]
    names = [f"b{k}" for k in range(3)]
    assert len(listed) == 8
    assert {tuple(round(m.joints[n], 6) for n in names) for m in listed} == {
        tuple(round(m.joints[n], 6) for n in names) for m in chosen
    }


@pytest.mark.parametrize(
    ("choose", "words"),
    [
        ([2], "has 2 solutions here"),
        ([0, 0, 0, 0], "4 numbers for 3 blocks"),
        ([-1], "whole numbers"),
        ([0.5], "whole"),
    ],
)
def test_choices_that_nothing_has_are_refused(choose, words):
    with pytest.raises(InputError, match=words):
        symkin.modes(legs(3), joints=[20.0], choose=choose)


def test_choices_on_the_command_line(capsys, tmp_path):
    path = tmp_path / "legs.toml"
    path.write_text(legs(3).to_toml())
    status, told = run_json(capsys, "modes", str(path), "--joints", "20", "--choose", "1,0,1")
    assert status == 0
    assert told["count"] == 1
    assert [block["count"] for block in told["blocks"]] == [2, 2, 2]
    status, _, err = run(capsys, "modes", path, "--joints", 20, "--choose", "1,x")
    assert status == 2
    assert "--choose" in err


def test_a_part_with_too_many_modes_names_the_remedy(monkeypatch):
    """A ladder of four-bars, each driven by the one before: the modes double with every rung."""
    for module in (inside.tree, inside.by_groups):
        monkeypatch.setattr(module, "MOST_MODES", 3)
    mechanism = symkin.load("jansen_leg")
    with pytest.raises(symkin.SymkinError, match="--choose"):
        symkin.modes(mechanism, given={"crank": 40})
    assert len(symkin.modes(mechanism, given={"crank": 40}, choose=[0, 1])) == 2


# --- against a solver of its own ------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.slow
def test_random_graphs_lose_nothing():
    """No configuration that random starts of an independent solver find is missing."""
    script = ROOT / "tests" / "campaigns" / "random_graphs.py"
    command = [
        sys.executable,
        str(script),
        "--starts",
        "150",
        "--only",
        "0",
        "2",
        "5",
        "7",
        "9",
        "17",
        "19",
        "22",
        "53",
    ]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout + told.stderr


# --- couplings ------------------------------------------------------------------------------------


@pytest.mark.parametrize("shaft", [10.0, 170.0, 400.0, -1000.0])
def test_gears_advance_by_more_than_a_turn(shaft):
    """Law of a bevel differential: the carrier turns by the mean of both wheels, whole turns
    included.
    """
    (mode,) = symkin.modes(symkin.load("differential"), given={"shaft": shaft, "left": -170.0})
    assert mode.residual < 1e-9
    assert mode.joints["shaft"] == pytest.approx(shaft)
    assert 2 * mode.joints["carrier"] == pytest.approx(mode.joints["left"] + mode.joints["right"])


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_whole_turns_of_equal_gears_make_no_modes(turns):
    """Two fingers on one pair of equal gears: a whole turn of the driver is the same
    configuration.
    """
    gripper = symkin.load("parallel_gripper")
    plain = symkin.modes(gripper, given={"left": 40.0})
    turned = symkin.modes(gripper, given={"left": 40.0 + 360.0 * turns})
    assert len(plain) == len(turned) == 4
    assert max(mode.residual for mode in turned) < 1e-9 * gripper.characteristic_length
    assert len(symkin.modes(gripper, given={"left_crank_pin": 40.0})) == 4


def test_a_strut_whose_point_is_told_may_turn(tmp_path):
    """A link between two balls spins about them: that is a freedom where a point off its axis is
    told, and none where none is.
    """
    balls = [
        '[[joint]]\nname = "s"\ntype = "S"\nlinks = ["arm", "strut"]\npoint = [40, 0, 0]\n',
        '[[joint]]\nname = "t"\ntype = "S"\nlinks = ["strut", "base"]\npoint = [40, 90, 30]\n',
    ]
    head = 'format = 1\nname = "strut"\nlength_unit = "mm"\nangle_unit = "deg"\n' + joint(
        "crank", "base", "arm", 0, 0, actuated=True
    )
    plain = parse(head + "".join(balls))
    told = parse(
        head + "".join(balls) + '[[link]]\nname = "strut"\npoints = { pin = [45, 50, 30] }\n'
    )
    assert symkin.mobility(told).mobility == symkin.mobility(plain).mobility + 1


@pytest.mark.parametrize(
    ("name", "k"),
    in_gate(CASES, [case for case in FEW if case[0] not in ("sarrus", "spherical_wrist")]),
)
def test_something_is_proved_of_every_mode_of_the_gallery(name, k):
    """A certificate; where rows are redundant, an exact point of independent rows, and a bound of
    the others that is rounding.
    """
    case = GALLERY[name]["cases"][k]
    mechanism = symkin.load(name)
    found = symkin.modes(mechanism, given=case["given"])
    for mode in found:
        if mode.certified:
            assert mode.radius < 1e-6 * mechanism.characteristic_length
            continue
        assert mode.ground is not None
        assert mode.ground.independent < mode.ground.rows
        assert mode.ground.remaining < 1e-10 * mechanism.characteristic_length


@pytest.mark.parametrize("order", range(4))
def test_dyads_that_meet_at_a_pin_are_solved_before_what_turns_about_it(order: int) -> None:
    """Two forearms of a five-bar hold a tool at one pin: in whatever order they are written, the
    forearms are a group without the linkage that turns the tool.
    """
    mechanism = reordered(symkin.load("pantograph_five_bar"), order)
    groups = structure_groups(build_problem(mechanism, "given", ("arm1", "arm2")))
    assert [len(group.system.unknowns) for group in groups] == [2, 2, 2]
