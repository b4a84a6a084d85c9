"""Theorems: a list is proved complete where its certificates reach a bound, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from flint import arb

import symkin
from helpers.certificates import certify
from helpers.gate import in_gate
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    algebraic_point,
    bound_of,
    build_problem,
    exact_known,
    known_values,
    knowns_of,
    proves,
    root_counts,
    structure_groups,
    system_of,
)
from helpers.known_roots import DIETMAIER, case, complex_roots, dietmaier
from helpers.samples import five_bar, unit
from helpers.spellings import MACHINES, spellings
from symkin import Joint, Limb, LinkJoint, LinkRod, Mechanism, Pose


def is_complete(certificates, bound) -> bool:
    """Whether certified roots of one instance are all that there are."""
    return bool(proves(certificates.batch, bound)[0])


def arm(seed: int) -> Mechanism:
    """Six revolute joints about random lines."""
    rng = np.random.default_rng(seed)
    joints = [
        Joint(f"q{i}", "R", tuple(rng.uniform(-1, 1, 3)), unit(rng), actuated=True)
        for i in range(1, 7)
    ]
    return Mechanism(
        "arm", [Limb("arm", joints)], serial=True, platform_position=tuple(rng.uniform(-1, 1, 3))
    )


@pytest.mark.slow
def test_forty_modes_are_proved():
    """Dietmaier's 40 certified poses are all that six distances allow."""
    problem, system, _, z = case("dietmaier")
    bound = bound_of(problem, system)
    assert bound is not None
    assert bound.theorem.count == 40
    certificates = certify(
        bound.system,
        z,
        knowns_of(problem, np.array([DIETMAIER["legs"]])),
        problem.closure.characteristic_length,
    )
    assert is_complete(certificates, bound)
    assert set(certificates.real) == {"real"}


@pytest.mark.slow
def test_what_is_short_of_the_bound_is_not_proved():
    """39 of 40 roots, 40 with one of them twice, a root left undecided or uncertified, or another
    system: no proof.
    """
    problem, system, k, z = case("dietmaier")
    bound = bound_of(problem, system)
    assert bound is not None
    whole = certify(system, z, k)
    assert is_complete(whole, bound)
    assert not is_complete(certify(system, z[:, 1:], k), bound)
    assert not is_complete(
        certify(system, np.concatenate([z[:, 1:], -1j * z[:, 5:6]], axis=1), k), bound
    )
    assert not is_complete(certify(system, z + np.where(np.arange(40) == 7, 1e-3, 0), k), bound)
    decided = np.arange(len(whole.real)) != 3
    undecided = {
        "proved_real": whole.batch.proved_real & decided,
        "proved_unreal": whole.batch.proved_unreal & decided,
    }
    assert replace(whole.batch, **undecided).real[3] == "unknown"
    assert not proves(replace(whole.batch, **undecided), bound)[0]
    other = AlgebraicSystem(1.0, (), system.z, system.k, system.rows, system.projective)
    assert not is_complete(certify(other, z, k), bound)


def test_a_special_platform_stays_below_the_bound():
    """28 certified roots of a symmetric platform are no proof: the theorem allows 40."""
    problem, system, _, z = case("zhang2009")
    bound = bound_of(problem, system)
    assert bound is not None
    certificates = certify(
        bound.system, z, knowns_of(problem, np.array([problem.mechanism.example.joints]))
    )
    assert certificates.certified.all()
    assert not is_complete(certificates, bound)


@pytest.mark.slow
@pytest.mark.parametrize("seed", in_gate(range(6), [3, 4]))
def test_forty_poses_of_a_nearly_special_hexapod_are_proved(seed):
    """Some of Ren's hexapod have rotations with entries of 1e6, beside which boxes of double
    precision are wide.
    """
    hexapod, rng = symkin.load("ren2008_true"), np.random.default_rng(seed)
    about, turn = hexapod.reference_pose, rng.normal(size=4) + 3 * np.eye(4)[0]
    place = about.position + hexapod.characteristic_length * rng.uniform(-0.2, 0.2, 3)
    pose = Pose(place, turn / np.linalg.norm(turn))
    legs = symkin.solve(hexapod, pose=pose).solution.actuated_values
    found = symkin.modes(hexapod, joints=legs)
    assert (found.complex_count, found.completeness) == (40, "proved")
    assert all(mode.certified for mode in found)


@pytest.mark.parametrize("seed", in_gate([2, 5], [2]))
def test_sixteen_solutions_of_a_general_arm_are_proved(seed):
    """16 certified solutions of a general 6R arm are all that there are; 15 prove nothing."""
    mechanism = arm(seed)
    pose = symkin.solve(mechanism, joints=[0.3, -0.2, 0.5, 0.7, -0.4, 0.1]).solution
    values = np.concatenate([pose.position, pose.quaternion])
    problem = build_problem(mechanism, "inverse")
    system = system_of(problem)
    z = complex_roots(system, known_values(problem, values))
    bound = bound_of(problem, system)
    assert bound is not None
    knowns = bound.knowns(knowns_of(problem, values[None]))
    certificates = certify(bound.system, z, knowns, problem.closure.characteristic_length)
    assert is_complete(certificates, bound)
    assert not is_complete(certify(bound.system, z[:, 1:], knowns), bound)
    reached = certificates.find(
        algebraic_point(
            problem,
            system,
            {f"q{i + 1}": np.array([q]) for i, q in enumerate([0.3, -0.2, 0.5, 0.7, -0.4, 0.1])},
        )
    )
    assert reached is not None


def test_rod_lengths_are_proved_alone():
    """The inverse problem of a platform on rods: each length is one root of a quadratic, sign
    apart.
    """
    platform = symkin.load("zhang2009")
    problem = build_problem(platform, "inverse")
    values = np.array([10.0, 20, 300, 0.9, 0.1, -0.2, 0.05])
    for part in structure_groups(problem):
        system = system_of(part)
        bound = bound_of(part, system)
        assert bound is not None
        assert bound.theorem.count == 1
        k = known_values(problem, values)
        row, slope = (
            system.linearise(np.zeros((1, 1)), k[:, None])[0],
            system.linearise(np.ones((1, 1)), k[:, None])[1],
        )
        z = np.sqrt(-2 * row[0] / slope[0, 0]) if system.unknowns[0].least == 0.0 else None
        assert z is not None
        certificates = certify(
            bound.system,
            z[:, None],
            knowns_of(problem, values[None]),
            problem.closure.characteristic_length,
        )
        assert is_complete(certificates, bound)


def test_rows_with_one_unknown_more_each_are_bounded_together():
    """y^2 = x, cos(a) = y, x^2 = k: 4 roots (x, y) and 8 with the angle. All of them are complete,
    one less is not; x put into x y = k leaves 3 and 6; where x too stands squared there is no such
    bound.
    """
    z, k = ca.SX.sym("z", 3), ca.SX.sym("k")
    unknowns = tuple(
        Coordinate(name, kind, "passive")
        for name, kind in (("y", "length"), ("a", "angle"), ("x", "length"))
    )
    rows = ca.vertcat(z[0] ** 2 - z[2], ca.cos(z[1]) - z[0], z[2] ** 2 - k)
    system = AlgebraicSystem(1.0, unknowns, z, k, rows, ())
    bound = bound_of(build_problem(five_bar(), "direct"), system)
    assert bound is not None
    assert bound.theorem.count == 8
    points = [
        (y, sign * np.arccos(complex(y)), x)
        for x in (0.3, -0.3)
        for y in (np.sqrt(complex(x)), -np.sqrt(complex(x)))
        for sign in (1, -1)
    ]
    roots = np.array(points).T
    assert is_complete(certify(system, roots, np.array([0.09])), bound)
    assert not is_complete(certify(system, roots[:, 1:], np.array([0.09])), bound)
    problem = build_problem(five_bar(), "direct")
    for square, count in ((z[2], 6), (z[2] ** 2, None)):
        both = ca.vertcat(z[0] ** 2 - square, ca.cos(z[1]) - z[0], z[2] * z[0] - k)
        found = bound_of(problem, replace(system, rows=both))
        assert (None if found is None else found.theorem.count) == count


def test_a_chain_of_such_rows_is_proved_in_every_spelling(tmp_path):
    """The piston of a crank: two solutions, proved to be all, however the machine is written."""
    machine = MACHINES["slider-crank"]()
    for spelled in spellings(machine, tmp_path):
        found = spelled.modes(machine, inverse=False)
        assert (spelled.name, len(found), found.completeness) == (spelled.name, 2, "proved")


def test_no_theorem_no_bound():
    """A five-bar's direct problem has two solutions, but no theorem here says so: it has no
    bound.
    """
    problem = build_problem(five_bar(), "direct")
    assert bound_of(problem, system_of(problem)) is None


def test_known_balls_hold_the_quotients():
    """Lengths over the size, in thin balls that hold the exact quotient: times the size they hold
    the length again.
    """
    problem = build_problem(dietmaier(), "direct")
    values = np.array(DIETMAIER["legs"])
    balls = exact_known(problem, values)
    for ball, value in zip(balls[::7], values, strict=True):
        assert (ball * arb(problem.closure.characteristic_length)).contains(arb(float(value)))
        assert ball.rad() < 1e-60
    assert np.allclose([float(b) for b in balls], known_values(problem, values).real)


@pytest.mark.parametrize(
    ("kind", "row", "degree"),
    [
        ("length", lambda z, k: (z - 0.3) ** 2 * k + z, 2),
        ("length", lambda z, k: (z * z + k) ** 2 / (1 + k * k), 4),
        ("length", lambda z, k: ca.sqrt(1 + z * z) - k, None),
        ("length", lambda z, k: 1 / z - k, None),
        ("length", lambda z, k: ca.sin(z) - k, None),
        ("angle", lambda z, k: ca.cos(z) * k + ca.sin(z - 0.2), 2),
        ("angle", lambda z, k: ca.cos(z) ** 2 - k * ca.sin(2 * z + k), 4),
        ("angle", lambda z, k: ca.sin(0.5 * z) - k, None),
        ("angle", lambda z, k: ca.sin(0.5 * z) * ca.cos(0.5 * z) - k, 2),
        ("angle", lambda z, k: ca.cos(0.5 * z) ** 2 + k * ca.sin(z), 2),
        ("angle", lambda z, k: ca.cos(0.5 * z) * k, 1),
        ("angle", lambda z, k: ca.sin(z - k) * ca.cos(k) + ca.cos(z - k) * ca.sin(k) - 0.5, 2),
        ("angle", lambda z, k: ca.sin(z) - k * z, None),
        ("angle", lambda z, k: ca.sin(k * z) - 0.5, None),
        ("angle", lambda z, k: ca.sin(k) - 0.5 + 0 * z, None),
    ],
)
def test_degrees_bound_the_roots_of_one_row(kind, row, degree):
    """Polynomials in z, and in exp(i z) for angles, have their degree, half angles too where a
    whole turn changes the row's sign alone; anything else has no bound.
    """
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    system = AlgebraicSystem(1.0, (Coordinate("x", kind, "passive"),), z, k, row(z, k), ())
    assert root_counts(system) == (None if degree is None else {"x": degree})


def test_a_point_that_turns_about_any_axis_meets_a_distance_twice():
    """The squares of cosine and sine cancel but for the rounding of the axis, which is that of the
    largest of them: the last one of seed 126 is small.
    """
    for seed in (0, 1, 2, 3, 126):
        rng = np.random.default_rng(seed)
        axis, point, far = rng.normal(size=(3, 3))
        axis = axis / np.linalg.norm(axis)
        z, k = ca.SX.sym("z"), ca.SX.sym("k")
        along = axis * (axis @ point)
        across = ca.DM(point - along) * ca.cos(z) + ca.DM(np.cross(axis, point)) * ca.sin(z)
        row = ca.sumsqr(along + across - far) - k**2
        system = AlgebraicSystem(1.0, (Coordinate("x", "angle", "passive"),), z, k, row, ())
        assert root_counts(system) == {"x": 2}


def two_links(z, k):
    """Where a point that two links carry is to be."""
    turned = z[0] + z[1]
    return [
        2 * ca.cos(z[0]) + ca.cos(turned) - 0.3 * ca.sin(turned) - k,
        2 * ca.sin(z[0]) + ca.sin(turned) + 0.3 * ca.cos(turned) - 0.4,
    ]


@pytest.mark.parametrize(
    ("kinds", "rows", "counts"),
    [
        # a joint that closes a planar loop: sin((a + b - k) / 2) = 0, and a circle along its frame
        (
            "aa",
            lambda z, k: [ca.sin((z[0] - z[1] + k) / 2), ca.cos(z[0]) + ca.sin(z[1]) - k],
            (1, 2),
        ),
        ("aa", lambda z, k: [ca.sin(z[0] - z[1]), ca.cos(z[0]) + ca.sin(z[1]) - k], None),
        ("aa", lambda z, k: [ca.sin((z[0] - z[1]) / 2), ca.sin((z[0] + z[1]) / 2) - k], None),
        ("aa", lambda z, k: [ca.sin(z[0] - z[1]) - 0.5, ca.cos(z[0]) + ca.sin(z[1]) - k], None),
        ("aa", lambda z, k: [k * ca.sin((z[0] - z[1]) / 2), ca.cos(z[0]) + ca.sin(z[1])], (1, 2)),
        ("al", lambda z, k: [z[1] - k * ca.cos(z[0]), z[1] + ca.sin(z[0]) - k], (2, 1)),
        ("al", lambda z, k: [k * z[1] - ca.cos(z[0]), k * z[1] + ca.sin(z[0]) - k], (1, 2)),
        # a point on two circles, level and seen askew; a conic's sum with the square of an angle
        ("aa", lambda z, k: two_links(z, k), (1, 2)),
        (
            "aa",
            lambda z, k: [3 * x - 2 * y for x, y in [two_links(z, k), two_links(z, k)[::-1]]],
            (1, 2),
        ),
        (
            "aa",
            lambda z, k: [ca.cos(z[0]) + ca.cos(z[1]) - k, 2 * ca.sin(z[0]) - ca.sin(z[1])],
            (1, 4),
        ),
        (
            "aa",
            lambda z, k: [ca.cos(2 * z[0]) + ca.cos(z[1]) - k, ca.sin(z[0]) + ca.sin(2 * z[1])],
            None,
        ),
        ("ll", lambda z, k: [z[0] - z[1] ** 2, z[0] * z[1] - k], (1, 3)),
        ("ll", lambda z, k: [z[0] * z[1] - 1, k * z[0] + k * z[1]], None),
        ("al", lambda z, k: [z[1] * ca.sin(z[0] / 2), z[1] * ca.cos(z[0] / 2) - k], None),
        # a rack and its pinion, and angles whose whole turns count, have more values
        ("tl", lambda z, k: [z[0] - 2 * z[1], z[1] - k * ca.cos(z[0])], None),
        ("ta", lambda z, k: [ca.sin((z[0] - z[1] + k) / 2), ca.cos(z[1]) - k], None),
    ],
)
def test_what_one_row_gives_is_put_into_others(kinds, rows, counts):
    """An angle that a row of two terms makes a sum of others, a length that is there once with a
    number that is not zero, an angle of a circle: the counts of what is left bound the roots.
    """
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k")
    named = {"a": "angle", "l": "length", "t": "turns"}
    unknowns = tuple(Coordinate(f"x{i}", named[kind], "passive") for i, kind in enumerate(kinds))
    found = root_counts(AlgebraicSystem(1.0, unknowns, z, k, ca.vertcat(*rows(z, k)), ()))
    assert found == (None if counts is None else {f"x{i}": n for i, n in enumerate(counts)})


def test_unknowns_are_told_in_the_order_in_which_rows_give_them():
    """Of two links the joint that is left when the other one is put in, which it tells."""
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k")
    unknowns = tuple(Coordinate(f"x{i}", "angle", "passive") for i in range(2))
    linked = ca.vertcat(*two_links(z, k))
    for system in (linked, linked[::-1]):
        counts = root_counts(AlgebraicSystem(1.0, unknowns, z, k, system, ()))
        assert [*(counts or {}).values()] == [2, 1]


def test_lengths_of_rods_are_halved_where_both_signs_are_roots():
    """(3 x - 0.7)^2 = k has one rod; with a length tied to another one, whose square is not
    mirrored, both values count.
    """
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k")
    rods = tuple(Coordinate(n, "length", "actuated", least=v) for n, v in (("a", 0.7), ("b", 0.2)))
    square = (3.0 * z[0] - 0.7) ** 2 - k
    alone = ca.vertcat(square, (3.0 * z[1] - 0.2) ** 2 - k)
    tied = ca.vertcat(square - (3.0 * z[1] - 0.2) ** 2, z[1] - 2 * z[0])
    assert root_counts(AlgebraicSystem(3.0, rods, z, k, alone, ())) == {"a": 1, "b": 1}
    assert root_counts(AlgebraicSystem(3.0, rods, z, k, tied, ())) == {"a": 1, "b": 2}


def test_what_a_rod_about_oblique_axes_cancels_is_no_square() -> None:
    """The end of a rod on a circle: of its squared distance the second harmonic cancels, in squares
    that leave less of it each than they begin with.
    """
    first = Joint(
        "w1",
        "R",
        (0.27471940715274057, -0.1798513445773745, 0.2),
        (-0.15265190358099895, -0.9834498394983283, 0.09759000729485333),
        actuated=True,
    )
    second = Joint(
        "w2",
        "R",
        (0.5653340684946191, -0.28832524473617316, 0.2614534913368172),
        (0.3876124168518045, -0.12156557044055975, 0.9137715394921011),
    )
    ends = (
        (-0.03199883512764634, 0.1456082072142879, 0.1),
        (0.7170116543981215, -0.46318561341541575, 0.341564423174145),
    )
    mechanism = Mechanism(
        "wrist",
        link_joints=[LinkJoint(first, ["base", "w"]), LinkJoint(second, ["w", "h"])],
        link_rods=[LinkRod("push", ["base", "h"], *ends)],
        platform_link=None,
    )
    (group,) = structure_groups(build_problem(mechanism, "given", ("w1",)))
    assert root_counts(system_of(group)) == {"w2": 2}


def test_no_solution_is_proved_of_graphs_too() -> None:
    """Cranks of a five-bar that hold their forearms too far apart: both solutions are complex."""
    rows = [
        ("left", ("base", "a"), (0.0, 0.0)),
        ("right", ("base", "b"), (1.0, 0.0)),
        ("elbow", ("a", "c"), (0.0, 1.0)),
        ("knee", ("b", "d"), (1.0, 1.0)),
        ("pin", ("c", "d"), (0.5, 1.7)),
    ]
    joints = [
        LinkJoint(Joint(n, "R", (*p, 0.0), (0, 0, 1), actuated=n in ("left", "right")), links)
        for n, links, p in rows
    ]
    mechanism = Mechanism("five", link_joints=joints, platform_link=None, angle_unit="deg")
    found = symkin.modes(mechanism, given={"left": 80.0, "right": -80.0})
    assert (len(found), found.complex_count, found.completeness) == (0, 2, "proved")


@pytest.mark.parametrize("spelling", ["limbs", "graph"])
@pytest.mark.parametrize("apart", in_gate([1e-2, 1e-4, 1e-6], [1e-4]))
def test_circles_about_nearly_one_point_have_no_real_solution(apart: float, spelling: str) -> None:
    """Ends of a five-bar's cranks some 1e-6 apart, and forearms of two lengths: both solutions are
    complex and 1e4 sizes off, where paths do not lead, in either description.
    """
    joints = {
        "left": (("base", "a"), (0.0, 0.0)),
        "right": (("base", "b"), (0.6, 0.0)),
        "elbow": (("a", "c"), (0.0, 0.5)),
        "knee": (("b", "d"), (0.6, 0.5)),
        "pin": (("c", "d"), (0.2, 1.2)),
    }
    own = {
        n: Joint(n, "R", (*p, 0.0), (0, 0, 1), actuated=n in ("left", "right"))
        for n, (_, p) in joints.items()
    }
    given: dict = {"platform_position": (0.2, 1.2, 0.0), "motion": "planar", "angle_unit": "deg"}
    if spelling == "limbs":
        left, right = ([own[n] for n in names] for names in (("left", "elbow"), ("right", "knee")))
        limbs = [Limb("one", left), Limb("other", [*right, own["pin"]])]
        mechanism = Mechanism("five", limbs, **given)
    else:
        links = [LinkJoint(own[n], links) for n, (links, _) in joints.items()]
        mechanism = Mechanism("five", link_joints=links, platform_link="d", **given)
    meet = float(np.degrees(np.arcsin(0.6)))
    found = symkin.modes(mechanism, joints=[apart - meet, meet])
    assert (len(found), found.complex_count, found.completeness) == (0, 2, "proved")
    assert found.unresolved_paths == 0


def test_places_without_a_real_solution_are_proved_to_have_none() -> None:
    """A geared crank has two places beside one of the other; in one of them a five-bar's loop does
    not close, which its formulas' complex branches prove.
    """
    rows = [
        ("a", ("base", "f"), (0.0, 0.0)),
        ("b", ("base", "g"), (1.0, 0.0)),
        ("elbow", ("f", "h"), (0.0, 0.5)),
        ("knee", ("g", "i"), (1.0, 0.6)),
        ("pin", ("h", "i"), (0.5, 1.2)),
    ]
    joints = [LinkJoint(Joint(n, "R", (*p, 0.0), (0, 0, 1)), links) for n, links, p in rows]
    gear = symkin.Coupling("b", {"a": 0.5})
    mechanism = Mechanism("five", link_joints=joints, couplings=[gear], angle_unit="deg")
    found = symkin.modes(mechanism, given={"a": 20.0})
    assert (len(found), found.complex_count, found.completeness) == (2, 4, "proved")
