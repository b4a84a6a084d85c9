"""Where links are and what joints read, those that the closure leaves out included, against the
rows of a solver in maximal coordinates that shares nothing with symkin.
"""

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    Closure,
    Partition,
    build_closure,
    closed_configurations,
    joint_expressions,
    joint_readings,
    link_expressions,
    link_poses,
    wrapped,
)
from helpers.shipped import GRAPHS, TWELVE
from oracle.plain_check import MECHANISMS, plain_gap

LOOP = """
format = 1
name = "m"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "r"
type = "R"
links = ["base", "a"]
point = [0, 0, 10]
axis = [0, 1, 2]
zero = 30
[[joint]]
name = "c"
type = "C"
links = ["b", "a"]
point = [20, 5, 10]
axis = [1, 1, 0]
[[joint]]
name = "u"
type = "U"
links = ["b", "c"]
point = [20, 30, 10]
axis = [1, 0, 0]
axis2 = [0.3, 1, 1]
[[joint]]
name = "h"
type = "H"
links = ["c", "d"]
point = [50, 30, 10]
axis = [0, 0, 1]
pitch = 12
zero = 20
[[joint]]
name = "p"
type = "P"
links = ["e", "d"]
axis = [1, 2, 3]
point = [55, 20, 40]
zero = 4
[[joint]]
name = "end"
links = ["e", "base"]
point = [60, 20, 40]
"""
ENDS = {
    "R": 'axis = [1, 0, 1]\ntype = "R"\nzero = 15\n',
    "C": 'axis = [1, 0, 1]\ntype = "C"\n',
    "P": 'axis = [1, 0, 1]\ntype = "P"\nzero = -3\n',
    "U": 'axis = [1, 0, 1]\naxis2 = [0, 1, 0.2]\ntype = "U"\n',
    "S": 'type = "S"\n',
}


def _assert_same(closure: Closure, values: np.ndarray, read: dict[str, np.ndarray]) -> None:
    """Readings are the closure's coordinates, but for whole turns and the signs of quaternions."""
    for c in closure.coordinates:
        if c.name not in read:
            continue
        own = values[:, closure.slices[c.name]].T
        if c.kind == "quaternion":
            assert np.abs(np.sum(own * read[c.name], axis=0)) == pytest.approx(1.0)
        else:
            gap = own[0] - read[c.name]
            gap = wrapped(gap) if c.kind == "angle" else gap
            assert gap == pytest.approx(0.0, abs=1e-9 * closure.characteristic_length)


def _assert_expressed(closure: Closure, values: np.ndarray) -> None:
    """Expressions of links and readings have the values that are found without them."""
    links = link_expressions(closure)
    read = joint_expressions(closure, links)
    poses = link_poses(closure, values)
    expected = joint_readings(closure, poses)
    parts = [ca.vertcat(pose.position, pose.quaternion) for pose in links.values()]
    whole = ca.Function(
        "all", [closure.variables], [ca.vertcat(*parts), ca.vertcat(*read.values())]
    )
    for k, row in enumerate(values):
        places, told = (np.asarray(part).ravel() for part in whole(row))
        here = np.concatenate(
            [[*poses[n].position[:, k], *poses[n].quaternion[:, k]] for n in links]
        )
        assert places == pytest.approx(here, abs=1e-9 * closure.characteristic_length)
        numbers = np.concatenate(
            [np.zeros(0), *(np.atleast_2d(expected[name])[:, k] for name in read)]
        )
        assert wrapped(told - numbers) == pytest.approx(
            0.0, abs=1e-9 * closure.characteristic_length
        )


@pytest.mark.parametrize("name", in_gate(GRAPHS, TWELVE))
def test_links_and_joints_fit_every_row_of_the_plain_graph(name: str) -> None:
    """At closed configurations near the reference, for the closure as it is and with each joint
    kept in turn.
    """
    mechanism = symkin.load(name)
    closure = build_closure(mechanism)
    values = np.array(closed_configurations(closure, 0))
    assert plain_gap(MECHANISMS / f"{name}.toml", closure, values) < 1e-9


@pytest.mark.parametrize("kind", in_gate(ENDS, ["C", "S", "U"]))
def test_a_cut_joint_of_any_type_reads_what_it_reads_when_it_is_kept(kind: str, tmp_path) -> None:
    """Each joint of a loop of all types but one is kept in turn, so that another is cut; all
    readings are the same.
    """
    path = tmp_path / "m.toml"
    path.write_text(LOOP + ENDS[kind])
    mechanism = symkin.load(path)
    names = [
        c.name
        for joint in mechanism.all_joints
        for c in joint.coordinates
        if c.kind != "quaternion"
    ]
    partitions = [
        Partition(),
        *(Partition(frozenset([name])) for name in names),
        Partition(frozenset(names)),
    ]
    for partition in partitions:
        closure = build_closure(mechanism, partition)
        values = np.array(closed_configurations(closure, 0))
        assert len(values) > 3
        assert plain_gap(path, closure, values) < 1e-9
        read = joint_readings(closure, link_poses(closure, values))
        _assert_same(closure, values, read)


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_readings_of_joints_that_the_closure_holds_are_its_coordinates(name: str) -> None:
    closure = build_closure(symkin.load(name))
    values = np.array(closed_configurations(closure, 0))
    poses = link_poses(closure, values)
    read = joint_readings(closure, poses)
    expected = [c.name for joint in closure.mechanism.all_joints for c in joint.coordinates]
    assert sorted(read) == sorted(expected)
    _assert_same(closure, values, read)
    _assert_expressed(closure, values)


def test_links_between_two_balls_meet_them_and_do_not_spin(tmp_path) -> None:
    """A leg of S, P, S joints: its two links lie on the line of the balls' centres, the slide
    apart, and turn by the shortest way.
    """
    path = tmp_path / "m.toml"
    text = 'format = 1\nname = "m"\nlength_unit = "mm"\nangle_unit = "deg"\n'
    text += (
        '[[joint]]\nname = "r"\ntype = "R"\nlinks = ["base", "arm"]\npoint = [100, 0, 0]\n'
        "axis = [0, 1, 0]\nactuated = true\n"
    )
    text += '[[joint]]\nname = "s1"\ntype = "S"\nlinks = ["base", "low"]\npoint = [0, 0, 0]\n'
    text += (
        '[[joint]]\nname = "slide"\ntype = "P"\nlinks = ["up", "low"]\npoint = [0, 0, 0]\n'
        "axis = [0, 0, -1]\n"
    )
    text += '[[joint]]\nname = "s2"\ntype = "S"\nlinks = ["up", "arm"]\npoint = [0, 0, 200]\n'
    path.write_text(text)
    mechanism = symkin.load(path)
    closure = build_closure(mechanism)
    values = np.array(closed_configurations(closure, 0))
    poses = link_poses(closure, values)
    assert plain_gap(path, closure, values) < 1e-9
    for link in ("low", "up"):
        along = poses[link].turn(np.array([0.0, 0.0, 1.0])[:, None])
        end = poses["arm"].apply(np.array([0.0, 0.0, 200.0])[:, None])
        assert along == pytest.approx(end / np.linalg.norm(end, axis=0))
        assert poses[link].quaternion[3] == pytest.approx(0.0, abs=1e-12)
    _assert_expressed(closure, values)
