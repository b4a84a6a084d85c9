"""`show` of graphs: loops, rank, mobility and redundant constraints, and what is said of loops that
close to a file's digits or not.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.inside import describe, edges_of, independent_cycles
from helpers.shipped import TWELVE

GALLERY = json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text())


def rounded(mechanism: symkin.Mechanism, digits: int) -> symkin.Mechanism:
    """The mechanism as a file of so many decimals would have it."""
    joints = []
    for entry in mechanism.link_joints:
        joint = entry.joint
        point, axis = ([round(v, digits) for v in vector] for vector in (joint.point, joint.axis))
        joints.append(replace(entry, joint=replace(joint, point=point, axis=axis)))
    return replace(mechanism, link_joints=tuple(joints))


@pytest.mark.parametrize("name", in_gate(sorted(GALLERY), TWELVE))
def test_counts_are_those_of_the_gallery(name):
    """Links, loops, mobility and redundant constraints, at the reference and at generic
    configurations.
    """
    known = GALLERY[name]
    shown = symkin.mobility(symkin.load(name)).to_dict()
    assert (shown["links"], shown["joints"]) == (known["links"], known["joints"] + known["rods"])
    assert shown["loops"] == len(shown["each_loop"]) == known["loops"]
    for at in (shown, shown["generic"]):
        assert (at["mobility"], at["redundant"]) == (known["mobility"], known["redundant"])
    assert shown["rank"] == shown["rows"] - shown["redundant"]
    json.dumps(shown, allow_nan=False)


@pytest.mark.parametrize("name", in_gate(sorted(GALLERY), TWELVE))
def test_loops_are_independent_closed_walks_without_repetition(name):
    mechanism = symkin.load(name)
    edges = list(edges_of(mechanism))
    cycles = independent_cycles(mechanism)
    incidence = np.zeros((len(cycles), len(edges)), dtype=int)
    for row, cycle in zip(incidence, cycles, strict=True):
        row[list(cycle)] = 1
        assert len(set(cycle)) == len(cycle)
        ends = [link for k in cycle for link in edges[k].ends]
        assert all(ends.count(link) == 2 for link in ends)
    assert len(cycles) == 0 or rank_modulo_two(incidence) == len(cycles)


def rank_modulo_two(rows: np.ndarray) -> int:
    rows, rank = rows.copy() % 2, 0
    for column in range(rows.shape[1]):
        pivots = np.flatnonzero(rows[rank:, column]) + rank
        if not pivots.size:
            continue
        rows[[rank, pivots[0]]] = rows[[pivots[0], rank]]
        others = np.flatnonzero(rows[:, column])
        rows[others[others != rank]] ^= rows[rank]
        rank += 1
        if rank == len(rows):
            break
    return rank


@pytest.mark.parametrize(
    ("name", "redundant"),
    [("four_bar", 3), ("bennett", 3), ("goldberg", 2), ("bricard", 1), ("sarrus", 1)],
)
def test_a_single_loop_has_all_of_the_redundant_rows(name, redundant):
    """A planar loop, and Bennett's, holds three freedoms of six, Goldberg's four, Bricard's and
    Sarrus's five.
    """
    found = symkin.mobility(symkin.load(name))
    (loop,) = found.loops
    assert (loop.redundant, loop.rows, loop.rank) == (redundant, found.rows, found.rank.value)


def test_planar_loops_of_a_leg_have_three_redundant_rows_each():
    found = symkin.mobility(symkin.load("jansen_leg"))
    assert [loop.redundant for loop in found.loops] == [3, 3, 3]


@pytest.mark.parametrize(
    "name", ["ankle", "double_wishbone", "jansen_leg", "spherical_wrist", "delta_parallelograms"]
)
def test_constraints_do_no_work_on_the_twists_that_are_left(name):
    found = symkin.mobility(symkin.load(name))
    size = found.closure.characteristic_length
    for twist in found.platform_twists:
        for wrench in found.platform_constraints:
            assert abs(twist[:3] @ wrench[3:] + twist[3:] @ wrench[:3]) < 1e-9 * size
    assert len(found.platform_twists) + len(found.platform_constraints) == 6


def test_a_wrist_turns_about_its_centre_alone():
    """The joints' axes of the spherical wrist meet in the base origin: its twists have no velocity
    there.
    """
    twists = symkin.mobility(symkin.load("spherical_wrist")).platform_twists
    assert twists.shape == (3, 6)
    np.testing.assert_allclose(twists[:, 3:], 0.0, atol=1e-9)


# --- loops that close to digits, or not -----------------------------------------------------------


@pytest.mark.parametrize(("name", "digits"), [("bennett", 5), ("bennett", 6), ("goldberg", 6)])
def test_an_overconstrained_loop_in_few_digits_is_said_to_close_to_these(name, digits):
    """Rounded, such a loop is rigid; to its digits it moves as the exact one does."""
    exact, found = (
        symkin.mobility(symkin.load(name)),
        symkin.mobility(rounded(symkin.load(name), digits)),
    )
    assert found.digits is not None
    assert found.mobility == 0
    assert found.freedoms - found.digits.rank == exact.mobility == 1
    assert 0.0 < found.digits.misfit < 1e-5 * found.closure.characteristic_length
    assert "digits of the file" in found.warnings[0]
    assert f"{found.digits.misfit:.1e} mm" in found.warnings[0]
    assert found.to_dict()["to_digits"]["mobility"] == 1
    assert [loop.redundant for loop in found.loops] == [loop.redundant for loop in exact.loops]


def test_a_loop_that_cannot_close_is_named_with_its_misfit():
    """A rod of 700 between a crank of 45 and a foot that hangs 250 below: it is too long in the
    loop that holds it.
    """
    ankle = symkin.load("ankle")
    first, second = ankle.link_rods
    found = symkin.mobility(replace(ankle, link_rods=(replace(first, length=700.0), second)))
    assert not found.closed
    assert set(found.misfit.loop.split(", ")) == {"ankle", "upper_motor", "upper_rod"}
    assert found.misfit.loop in found.warnings[0]
    assert "no configuration closes" in describe(found.closure.mechanism)
    # the crank and the foot reach a distance of some 350 at most
    assert 300.0 < found.misfit.length < 400.0


def test_modes_and_solve_name_the_loop_that_cannot_close():
    """Whatever is given, a rod that is too long leaves its loop open; a reach that ends is no such
    fault.
    """
    ankle = symkin.load("ankle")
    first, second = ankle.link_rods
    long = replace(ankle, link_rods=(replace(first, length=700.0), second))
    given = {"upper_motor": 10.0, "lower_motor": 5.0}
    for notes in (
        symkin.modes(long, given=given).notes,
        symkin.solve(long, given=given, check=False).notes,
    ):
        assert any(
            "ankle, upper_motor, upper_rod" in note and "whatever is given" in note
            for note in notes
        )
    far = symkin.modes(symkin.load("slider_crank"), given={"piston": 5000.0})
    assert not any("whatever is given" in note for note in far.notes)


# --- the command ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", in_gate(sorted(GALLERY), TWELVE))
def test_the_command_shows_every_graph(name, capsys):
    status, text, _ = run(capsys, "show", name)
    assert status == 0
    mechanism = symkin.load(name)
    for joint in mechanism.all_joints:
        assert joint.name in text
    assert "mobility = " in text
    for loop in symkin.mobility(mechanism).loops:
        assert loop.name in text
    status, shown = run_json(capsys, "show", name)
    assert status == 0
    assert shown["mechanism"] == name


@pytest.mark.parametrize("name", in_gate(sorted(GALLERY), TWELVE))
def test_the_equations_of_every_graph_are_written(name, capsys):
    status, text, _ = run(capsys, "show", name, "--latex")
    assert status == 0
    rows = symkin.mobility(symkin.load(name)).closure.rows.shape[0]
    assert text.count("&&") >= rows


# --- links between balls --------------------------------------------------------------------------


def ball_chain(*, rod: bool, platform: str | None) -> symkin.Mechanism:
    """Two arms on the base; between their tips a ball, a link, and a second ball or a rod with
    balls at both ends.
    """
    z = (0.0, 0.0, 1.0)
    joints = [
        symkin.LinkJoint(
            symkin.Joint("left", "R", (0, 0, 0), z, actuated=True), ("base", "left_arm")
        ),
        symkin.LinkJoint(
            symkin.Joint("right", "R", (200, 0, 0), (0, 1, 0), actuated=True), ("base", "right_arm")
        ),
        symkin.LinkJoint(symkin.Joint("ball", "S", (0, 80, 10)), ("left_arm", "strut")),
    ]
    ends = symkin.LinkRod("bar", ("strut", "right_arm"), (90, 60, 30), (200, 20, 70))
    if not rod:
        joints.append(
            symkin.LinkJoint(symkin.Joint("ball2", "S", (200, 20, 70)), ("strut", "right_arm"))
        )
    return symkin.Mechanism(
        "balls", link_joints=joints, link_rods=[ends] if rod else [], platform_link=platform
    )


@pytest.mark.parametrize("platform", [None, "left_arm", "strut"])
def test_a_link_between_a_ball_and_a_rod_keeps_its_freedoms(platform):
    """Two arms turn, a link turns freely about a ball, a rod takes one freedom: 2 + 3 - 1."""
    found = symkin.mobility(ball_chain(rod=True, platform=platform))
    assert (found.mobility, found.redundant) == (4, 0)


@pytest.mark.parametrize(("platform", "mobility"), [(None, 1), ("left_arm", 1), ("strut", 2)])
def test_the_spin_of_a_strut_counts_where_its_pose_is_told(platform, mobility):
    """Two balls on a strut: one distance between two arms; how the strut is turned about their line
    matters to its own pose alone.
    """
    found = symkin.mobility(ball_chain(rod=False, platform=platform))
    assert (found.mobility, found.redundant) == (mobility, 0)
    if platform == "strut":
        assert len(found.platform_twists) == 2
