"""Couplings of whole ratios leave whole turns alone, however they are written; others advance, and
the reason names them.
"""

from itertools import pairwise
from math import gcd

import numpy as np
import pytest
from scipy.optimize import brentq

import symkin
from helpers.gate import in_gate_but
from helpers.inside import (
    MOST_TEETH,
    build_problem,
    groups,
    parse,
    problem_of,
    random_starts,
    read_given,
)

HEAD = 'format = 1\nname = "coupled"\nlength_unit = "m"\nangle_unit = "deg"\n'
POINTS = np.array([[3.0, 1.0], [1.0, 2.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0]])
"""Joints j0 to j4 of a five-bar, whose j0 and j4 stand on the base."""
RATIOS = [(1, 2), (2, 1), (-3, 2)]


def revolute(name, ends, point, more=""):
    x, y = point
    return (
        f'[[joint]]\nname = "{name}"\ntype = "R"\nlinks = ["{ends[0]}", "{ends[1]}"]\n'
        f"point = [{x!r}, {y!r}, 0.0]\naxis = [0.0, 0.0, 1.0]\n{more}"
    )


def five_bar(coupling):
    ends = [("base", "k1"), ("k1", "k2"), ("k2", "k3"), ("k3", "k4"), ("base", "k4")]
    joints = "".join(revolute(f"j{i}", ends[i], POINTS[i].tolist()) for i in range(5))
    return parse(HEAD + joints + "[[coupling]]\n" + coupling)


def pair(coupling):
    joints = revolute("x", ("base", "a"), (0.0, 0.0), "actuated = true\n") + revolute(
        "y", ("base", "b"), (1.0, 0.0)
    )
    return parse(HEAD + joints + "[[coupling]]\n" + coupling)


def spellings(driven, driver, p, q, offset=0.0):
    """The coupling driven = p/q driver + offset: as it stands, with the names exchanged, as a
    polynomial.
    """
    return [
        f'joint = "{driven}"\nof = {{ {driver} = "{p}/{q}" }}\noffset = {offset}\n',
        f'joint = "{driver}"\nof = {{ {driven} = "{q}/{p}" }}\noffset = {-offset * q / p}\n',
        f'joint = "{driven}"\nof = "{driver}"\npolynomial = [{offset}, "{p}/{q}"]\n',
    ]


def turn(degrees):
    angle = np.radians(degrees)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def places_of_five_bar(p, q, j0):
    """Angles j1 and j2 of all configurations: those at which the fourth joint is as far from the
    fifth as at the reference, found by a scan of j2 over as many turns as the ratio has places.
    """

    def gap(j2):
        rows = [turn(j0), turn(j0 + p / q * j2), turn(j0 + (p / q + 1) * j2)]
        end = POINTS[0] + sum(
            rot @ step for rot, step in zip(rows, np.diff(POINTS[:4], axis=0), strict=True)
        )
        return float(np.linalg.norm(end - POINTS[4]) - np.linalg.norm(POINTS[3] - POINTS[4]))

    scan = np.linspace(-180.0, q * 360.0 - 180.0, 4000 * q)
    values = np.array([gap(j2) for j2 in scan])
    roots = [
        brentq(gap, a, b, xtol=1e-12)
        for (a, b), (u, v) in zip(pairwise(scan), pairwise(values), strict=True)
        if u * v < 0
    ]
    return [(p / q * j2, j2) for j2 in roots]


def without_turns(degrees):
    return (np.asarray(degrees) + 180.0) % 360.0 - 180.0


@pytest.mark.parametrize(("p", "q"), in_gate_but(RATIOS, [(2, 1), (1, 2)]))
def test_a_ratio_has_the_same_modes_however_it_is_written(p, q):
    """As many configurations as a scan of one angle finds, each with angles within a turn, told by
    paths or theorems and not by samples.
    """
    wanted = np.array(places_of_five_bar(p, q, -40.0))
    for coupling in spellings("j1", "j2", p, q):
        found = symkin.modes(five_bar(coupling), given={"j0": -40.0})
        assert found.completeness in ("probability one", "proved"), coupling
        angles = np.array([[mode.joints[name] for name in ("j1", "j2")] for mode in found])
        assert len(angles) == len(wanted)
        assert np.all((angles > -180.0) & (angles <= 180.0))
        assert np.abs(without_turns(q * angles[:, 0] - p * angles[:, 1])).max() < 1e-7
        apart = np.abs(without_turns(wanted[:, None] - angles[None])).max(axis=2)
        assert np.all((apart < 1e-6).sum(axis=1) == 1)


@pytest.mark.parametrize(("p", "q"), [(1, 2), (7, 10), (-5, 12), (1, 1), (3, 1)])
def test_wheels_have_as_many_places_as_the_ratio_tells(p, q):
    """q y = p x + offset: q places of y at one of x, p of x at one of y, all of them, whatever
    whole turns are given.
    """
    for coupling in spellings("y", "x", p, q, offset=6.0):
        wheels = pair(coupling)
        for given, count in (({"x": 30.0}, q), ({"x": 390.0}, q), ({"y": 20.0}, abs(p))):
            found = symkin.modes(wheels, given=given)
            angles = np.array([[mode.joints["x"], mode.joints["y"]] for mode in found])
            assert (len(found), found.complex_count, found.completeness) == (count, count, "proved")
            assert np.abs(without_turns(q * angles[:, 1] - p * angles[:, 0] - 6.0 * q)).max() < 1e-9
            unknown = np.sort(angles[:, 1 if "x" in given else 0])
            assert count == 1 or np.diff(unknown).min() > 359.0 / count
            assert any("places" in note for note in found.notes) == (count > 1)


def test_wheels_that_are_found_together_share_their_places():
    """y = x/2 + z/2 and w = y/3 + z/3 of x and w: |det| = 3 places of y and z, as 3 y = x + 3 w and
    z = 3 w - y.
    """
    joints = "".join(revolute(n, ("base", n + "l"), (float(k), 0.0)) for k, n in enumerate("xyzw"))
    train = parse(
        HEAD + joints + '[[coupling]]\njoint = "y"\nof = { x = 0.5, z = 0.5 }\n'
        '[[coupling]]\njoint = "w"\nof = { y = "1/3", z = "1/3" }\n'
    )
    found = symkin.modes(train, given={"x": 33.0, "w": 11.0})
    places = sorted((mode.joints["z"], mode.joints["y"]) for mode in found)
    wanted = sorted((z, float(without_turns(33.0 - z))) for z in (11.0 - 120.0, 11.0, 11.0 + 120.0))
    assert found.completeness == "proved"
    np.testing.assert_allclose(places, wanted, atol=1e-9)


def test_mimics_of_a_robot_are_couplings_of_the_same_ratio(tmp_path):
    joint = (
        '<joint name="{0}" type="revolute"><parent link="base"/><child link="{0}l"/><axis xyz="0 0 '
        '1"/>{1}</joint>'
    )
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    text = (
        '<robot name="r"><link name="base"/><link name="xl"/><link name="yl"/>'
        + joint.format("x", limit)
        + joint.format("y", limit + '<mimic joint="x" multiplier="0.5"/>')
        + "</robot>"
    )
    (tmp_path / "r.urdf").write_text(text)
    found = symkin.modes(symkin.load(tmp_path / "r.urdf"), given={"x": 0.4})
    assert sorted(mode.joints["y"] for mode in found) == pytest.approx([0.2 - np.pi, 0.2])
    assert [mode.within_limits for mode in sorted(found, key=lambda mode: mode.joints["y"])] == [
        False,
        True,
    ]


@pytest.mark.parametrize(
    ("coupling", "words"),
    [
        ('joint = "j1"\nof = { j2 = 0.7071 }\n', "0.7071"),
        ('joint = "j1"\nof = "j2"\npolynomial = [0, 0.5, 0.1]\n', "polynomial"),
        (f'joint = "j1"\nof = {{ j2 = "1/{MOST_TEETH + 1}" }}\n', "whole numbers"),
    ],
)
def test_the_reason_names_a_coupling_that_advances(coupling, words):
    found = symkin.modes(five_bar(coupling), given={"j0": 20.0}, starts=50)
    (note,) = (note for note in found.notes if "not algebraic" in note)
    assert "coupling of j1" in note
    assert words in note
    assert "helical" not in note


def test_a_screw_and_a_slide_make_coupled_angles_advance():
    joints = revolute("x", ("base", "a"), (0.0, 0.0)) + revolute("y", ("base", "b"), (1.0, 0.0))
    slide = (
        '[[joint]]\nname = "s"\ntype = "P"\nlinks = ["base", "c"]\npoint = [0, 0, 0]\n'
        "axis = [0, 0, 1]\n"
    )
    couplings = (
        '[[coupling]]\njoint = "s"\nof = { x = 0.01 }\n[[coupling]]\njoint = "y"\n'
        "of = { x = 2.0 }\n"
    )
    rack = parse(HEAD + joints + slide + couplings)
    assert {c.name: c.kind for c in rack.coordinates} == {"x": "turns", "y": "turns", "s": "length"}
    assert all("the length s" in reason for reason in rack.advancing.values())


def test_whole_numbers_are_the_least():
    for p in range(-MOST_TEETH, MOST_TEETH + 1):
        for q in range(1, MOST_TEETH + 1):
            least = gcd(p, q)
            assert symkin.Coupling("a", {"b": p / q}).whole_numbers == (q // least, (p // least,))


# --- long trains ----------------------------------------------------------------------------------


def test_a_long_chain_is_put_in_order():
    """Five thousand unknowns of which each needs the one before, the last pair each other, numbered
    at random.
    """
    rng = np.random.default_rng(4)
    number = rng.permutation(5000)
    needs = [set() for _ in number]
    for k in range(1, 5000):
        needs[number[k]] = {number[k - 1]}
    needs[number[-2]] = {number[-3], number[-1]}
    parts = groups._components(needs)
    assert [min(part) for part in parts[:-1]] == number[:-2].tolist()
    assert parts[-1] == set(number[-2:].tolist())


def test_a_matching_is_found_where_there_is_one():
    """As many patterns as have full rank for random values have a row for each column."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        n = int(rng.integers(1, 8))
        holds = rng.random((n, n)) < rng.uniform(0.1, 0.7)
        match = groups._matching(holds)
        full = np.linalg.matrix_rank(holds * rng.normal(size=(n, n))) == n
        assert (match is not None) == full
        assert match is None or (
            sorted(match) == list(range(n)) and all(holds[row, k] for k, row in enumerate(match))
        )


def test_groups_of_a_train_are_its_wheels():
    """A hundred coupled wheels are as many groups, each of which reads the wheel before it."""
    joints = "".join(revolute(f"j{k}", ("base", f"l{k}"), (k, 0.0)) for k in range(100))
    couplings = "".join(
        f'[[coupling]]\njoint = "j{k}"\nof = {{ j{k - 1} = -1.0 }}\n' for k in range(1, 100)
    )
    train = parse(HEAD + joints + couplings)
    found = groups.structure_groups(problem_of(train, read_given(train, None, None, {"j0": 10.0})))
    assert [tuple(c.name for c in group.system.unknowns) for group in found] == [
        (f"j{k}",) for k in range(1, 100)
    ]
    assert [tuple(c.name for c in group.known_coordinates) for group in found] == [
        (f"j{k - 1}",) for k in range(1, 100)
    ]


# --- names of screws ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["screw", "a.screw", "a.b"])
def test_random_starts_reach_as_far_as_a_screw_whatever_its_name(name):
    """Every second start of a screw advances by up to the reach, which its pitch tells."""
    z = (0.0, 0.0, 1.0)
    left = symkin.Limb(
        "left",
        [
            symkin.Joint("a", "R", (0, 0, 0), z, actuated=True),
            symkin.Joint(name, "H", (1, 0, 0), z, pitch=0.01),
        ],
    )
    right = symkin.Limb(
        "right", [symkin.Joint("b", "R", (4, 0, 0), z), symkin.Joint("s", "S", (2, 1, 0))]
    )
    problem = build_problem(
        symkin.Mechanism("helix", [left, right], platform_position=(2, 1, 0)), "direct"
    )
    (place,) = (k for k, c in enumerate(problem.system.unknowns) if c.name == name)
    given = read_given(problem.mechanism, [0.0], None)
    starts = random_starts(problem, problem.system, given.values, 400, np.random.default_rng(1))
    reach = 1.5 * problem.closure.characteristic_length
    assert np.abs(starts[:, problem.system.slices[place]]).max() > 0.9 * 2 * np.pi * reach / 0.01


@pytest.mark.parametrize(("most", "count"), [(3.0, 2), (7.0, 5)])
def test_whole_turns_of_a_polynomial_are_listed_within_the_limits(most, count):
    """A four-bar turns a wheel by a polynomial of its rocker: two assemblies for each turn that the
    rocker's limits allow, the same configurations of the links. 17 were listed, up to 9 turns away.
    """
    points = {"a": (0, 0, 0), "b": (100, 0, 0), "c": (20, 40, 0), "d": (120, 60, 0)}
    ends = {"a": "base one", "b": "base two", "c": "one three", "d": "two three", "w": "base wheel"}
    joints = [
        symkin.LinkJoint(
            symkin.Joint(name, "R", points.get(name, (0, 0, 50)), (0, 0, 1), limits=(-most, most)),
            ends[name].split(),
        )
        for name in ends
    ]
    wheel = symkin.Coupling("w", "b", polynomial=[0.0, 1.0, 0.3])
    machine = symkin.Mechanism("wheel", link_joints=joints, couplings=[wheel], angle_unit="rad")
    found = symkin.modes(machine, given={"a": 0.2}, starts=300)
    angles = np.array([mode.joints["b"] for mode in found])
    assert len(found) == count
    assert np.all(np.abs(angles) < most)
    assert len(np.unique(np.round(np.cos(angles), 6))) == 2
    two = symkin.modes(machine, given={"w": 0.2}, starts=300)
    assert sorted({round(mode.joints["b"], 3) for mode in two}) == [-3.523, 0.189]
