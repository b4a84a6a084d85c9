"""Certificates: what is certified is true of the root at 300 bits; what is no regular root is not
certified; roots that are one are never claimed to differ.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from flint import acb, acb_mat, arb
from hypothesis import given, settings
from hypothesis import strategies as st

import symkin
from helpers import moved_points as machines
from helpers.certificates import Certificates, certify
from helpers.gate import in_gate
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    algebraic_point,
    build_problem,
    instance,
    known_values,
    precision,
    real_values,
    start_of,
    system_of,
    universal_start,
    universal_system,
)
from helpers.known_roots import Case, case
from helpers.samples import delta, five_bar, hexapod, three_rrr
from symkin import Mechanism


def sampled(mechanism: Mechanism, shift: float = 0.04) -> Case:
    """Real modes of a direct problem that random starts find."""
    joints = [c.reference[0] + shift * (i + 1) for i, c in enumerate(mechanism.actuated)]
    found = symkin.modes(
        mechanism, joints=[mechanism.angle_out(q) for q in joints], method="multistart", starts=400
    )
    problem = build_problem(mechanism, "direct")
    system = system_of(problem)
    points = [
        algebraic_point(
            problem,
            system,
            {c.name: np.atleast_1d(m.values[c.name]) for c in problem.system.unknowns},
        )
        for m in found
    ]
    return problem, system, known_values(problem, np.array(joints)), np.array(points).T


def exact_root(
    system: AlgebraicSystem, k: np.ndarray, centre: np.ndarray, patch: np.ndarray
) -> list[acb]:
    """The root near a point, in the affine patch through it, to 300 bits: Newton's method with a
    fixed inverse from double precision, and F by its own walk over the graph with numbers.
    """
    function = ca.Function("f", [system.z, system.k], [ca.densify(system.rows)])
    _, j = system.linearise(centre[:, None], np.asarray(k)[:, None])
    matrix = np.vstack([j[0], patch[None]]) if system.projective else j[0]
    inverse = acb_mat([[acb(v.real, v.imag) for v in row] for row in np.linalg.pinv(matrix)])
    with precision(400):
        x = [acb(v.real, v.imag) for v in centre]
        for _ in range(60):
            f = _values(function, x, k) + ([acb(0)] if system.projective else [])
            step = (inverse * acb_mat(len(f), 1, f)).entries()
            x = [(a - b).mid() for a, b in zip(x, step, strict=True)]
        assert max(float(abs(s)) for s in step) < 2.0**-300
    return x


def _values(function: ca.Function, z: list[acb], k: np.ndarray) -> list[acb]:
    inputs, work, out = (z, [acb(v.real, v.imag) for v in np.asarray(k, dtype=complex)]), {}, {}
    unary = {
        ca.OP_SIN: acb.sin,
        ca.OP_COS: acb.cos,
        ca.OP_SQRT: acb.sqrt,
        ca.OP_NEG: lambda x: -x,
        ca.OP_SQ: lambda x: x * x,
        ca.OP_TWICE: lambda x: x + x,
        ca.OP_INV: lambda x: 1 / x,
    }
    binary = {
        ca.OP_ADD: "__add__",
        ca.OP_SUB: "__sub__",
        ca.OP_MUL: "__mul__",
        ca.OP_DIV: "__truediv__",
    }
    for i in range(function.n_instructions()):
        op, a, o = (
            function.instruction_id(i),
            function.instruction_input(i),
            function.instruction_output(i),
        )
        if op == ca.OP_INPUT:
            work[o[0]] = inputs[a[0]][a[1]]
        elif op == ca.OP_CONST:
            work[o[0]] = acb(function.instruction_constant(i))
        elif op == ca.OP_OUTPUT:
            out[o[1]] = work[a[0]]
        elif op in unary:
            work[o[0]] = unary[op](work[a[0]])
        else:
            work[o[0]] = getattr(work[a[0]], binary[op])(work[a[1]])
    return [out[i].mid() for i in range(len(out))]


def patches(system: AlgebraicSystem, centre: np.ndarray) -> np.ndarray:
    """The row conj(x) of the ray, zero elsewhere."""
    row = np.zeros(system.width, dtype=complex)
    row[list(system.projective)] = np.conj(centre[list(system.projective)])
    return row


# --- what is certified ----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "count", "real"),
    [
        ("dietmaier", 40, 40),
        ("zhang2009", 28, 4),
        pytest.param("gluon_6l3", 8, 2, marks=pytest.mark.long),
        ("yao2020", 8, 4),
    ],
)
def test_every_root_of_known_cases_is_certified(name, count, real):
    """Every root is certified, each is real or not, none is another, all are poses; the count of
    real ones is published or the number of modes.
    """
    problem, system, k, z = case(name)
    found = certify(system, z, k, problem.closure.characteristic_length)
    assert found.certified.all()
    assert (len(found.certified), found.distinct, found.disjoint) == (count, count, True)
    assert found.pose.all()
    assert set(found.real) <= {"real", "not real"}
    assert int(np.sum(found.real == "real")) == real
    assert np.all(found.ball < 1e-10)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", in_gate(["dietmaier", "zhang2009", "yao2020"], ["zhang2009", "yao2020"])
)
def test_a_ball_holds_the_root_at_300_bits(name):
    """The box about each centre holds the same root computed by many more digits, real and
    complex.
    """
    problem, system, k, z = case(name)
    found = certify(system, z, k, problem.closure.characteristic_length)
    for i in range(0, z.shape[1], 3):
        given_ray = (
            z[:, i] / np.linalg.norm(z[list(system.projective), i])
            if system.projective
            else z[:, i]
        )
        root = exact_root(system, k, found.centre[:, i], patches(system, given_ray))
        centre, ball = found.centre[:, i], arb(0, found.ball[i])
        for x, c in zip(root, centre, strict=True):
            assert (ball + c.real).contains(x.real)
            assert (ball + c.imag).contains(x.imag)


@pytest.mark.slow
@settings(max_examples=12)
@given(
    st.sampled_from(["dietmaier", "zhang2009", "yao2020", "gluon_6l3"]),
    st.sampled_from([0.0, 1e-12, 1e-9]),
    st.integers(0, 99),
)
def test_radius_means_what_it_says(name, noise, seed):
    """From the coordinates that are printed for a point near a real root to those of the root at
    300 bits, no length, position, and no angle or unit quaternion times the size, is farther than
    the radius; also of a point that is off.
    """
    problem, system, k, z = case(name)
    rng = np.random.default_rng(seed)
    size = problem.closure.characteristic_length
    points = z + noise * rng.normal(size=z.shape)
    found = certify(system, points, k, size)
    real = np.flatnonzero(found.real == "real")
    assert real.size
    i = int(rng.choice(real))
    root = exact_root(system, k, found.centre[:, i], patches(system, found.centre[:, i]))
    rounded = np.array([complex(float(x.real), float(x.imag)) for x in root])
    printed, exact = (real_values(problem, system, p, k) for p in (points[:, i], rounded))
    for c in (*problem.system.unknowns,):
        a, b = printed[c.name], exact[c.name]
        if c.kind == "quaternion":
            b = b * np.sign(a @ b)
        unit = 1.0 if c.kind == "length" else size
        turns = 2 * np.pi * np.round((a - b) / (2 * np.pi)) if c.kind == "angle" else 0.0
        assert np.max(np.abs(a - b - turns)) * unit <= found.radius[i]
    assert found.radius[i] < (1e-9 if noise == 0.0 else 1e4 * noise) * size


@pytest.mark.parametrize(
    "mechanism",
    [three_rrr("planar"), three_rrr(), five_bar()],
    ids=["3-RRR in the plane", "3-RRR in space", "five-bar in space"],
)
def test_planar_mechanisms_are_certified_also_in_space(mechanism):
    """In space a planar mechanism has more rows than unknowns; those that a motion in the plane
    fulfils identically are left out, so that its modes are proved.
    """
    problem, system, k, z = sampled(mechanism)
    found = certify(system, z, k, problem.closure.characteristic_length)
    assert z.shape[1] >= 2
    assert found.certified.all()
    assert found.disjoint
    assert set(found.real) == {"real"}
    if mechanism.motion == "spatial":
        assert system.count > system.width


def test_complex_known_values():
    """The 40 roots of a complex platform are certified; its rows are not real, and no root of it is
    called so.
    """
    start = universal_start()
    found = certify(universal_system(), start.z, start.k)
    assert found.certified.all()
    assert (found.distinct, found.disjoint) == (40, True)
    assert "real" not in found.real


def test_known_values_may_be_balls():
    """A certificate for a ball of known values holds for each of them: its box holds the root of
    values inside.
    """
    problem, system, k, z = case("zhang2009")
    found = certify(
        system, z, [arb(float(v.real), 1e-12) for v in k], problem.closure.characteristic_length
    )
    assert found.certified.all()
    shifted = k.real + 1e-12 * np.random.default_rng(0).uniform(-1, 1, len(k))
    inside = certify(system, found.centre, shifted, problem.closure.characteristic_length)
    assert np.all(np.max(np.abs(inside.centre - found.centre), axis=0) <= found.ball + inside.ball)


# --- what is not ----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ["zhang2009", "yao2020"])
@pytest.mark.parametrize("offset", [1e-5, 1e-3, 0.1])
def test_points_beside_roots_are_not_certified(name, offset):
    """A point that is off is no root, and the reason is given."""
    problem, system, k, z = case(name)
    noise = offset * np.exp(1j * np.random.default_rng(1).uniform(0, 6, z.shape))
    found = certify(system, z + noise, k, problem.closure.characteristic_length)
    assert not found.certified.any()
    assert all(found.reasons)
    assert np.all(np.isinf(found.radius))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dietmaier", "gluon_6l3"])
def test_roots_of_other_values_are_not_certified(name):
    """Roots of slightly other known values are no roots of these."""
    problem, system, k, z = case(name)
    found = certify(
        system,
        z,
        k * (1 + 1e-5 * np.random.default_rng(0).uniform(1, 2, len(k))),
        problem.closure.characteristic_length,
    )
    assert not found.certified.any()


def test_a_double_root_is_not_certified():
    """With all legs at the flat, coincident position of a symmetric platform its root is multiple:
    nothing is proved.
    """
    platform = symkin.load("zhang2009")
    problem = build_problem(platform, "direct")
    system = system_of(problem)
    values = {
        "pose.quaternion": np.array([1.0, 0, 0, 0]),
        **{f"pose.{a}": np.zeros(1) for a in "xyz"},
    }
    z = algebraic_point(problem, system, values)[:, None]
    k = known_values(problem, np.array([c.reference[0] for c in platform.actuated]))
    assert np.max(np.abs(system.linearise(z, k[:, None])[0])) < 1e-12
    found = certify(system, z, k)
    assert not found.certified.any()


def test_redundant_rows_are_said():
    """A delta's pairs of rods close by its numbers alone, up to their rounding: no proof, and the
    reason counts rows.
    """
    problem, system, k, z = sampled(delta())
    found = certify(system, z, k, problem.closure.characteristic_length)
    assert not found.certified.any()
    assert all("6 rows for 3 unknowns" in reason for reason in found.reasons)


def test_no_roots_and_no_numbers():
    """Nothing is proved of nothing, nor of a point that is not finite beside ones that are
    certified.
    """
    _, system, k, z = case("zhang2009")
    empty = certify(system, z[:, :0], k)
    assert (empty.distinct, empty.disjoint, empty.certified.shape) == (0, True, (0,))
    spoiled = z.copy()
    spoiled[3, 5] = np.nan
    found = certify(system, spoiled, k)
    assert (int(found.certified.sum()), found.distinct, found.certified[5]) == (27, 27, False)


# --- reality and distinctness ---------------------------------------------------------------------


def single(kind: str, row, least: float | None = None) -> AlgebraicSystem:
    """One row in one unknown."""
    z = ca.SX.sym("z")
    return AlgebraicSystem(
        1.0, (Coordinate("x", kind, "passive", least=least),), z, ca.SX(0, 1), ca.SX(row(z)), ()
    )


@pytest.mark.slow
@given(st.floats(-38, -2))
def test_nearly_double_roots_are_told_apart(exponent):
    """z^2 = c has two real roots for c > 0 and none for c < 0: near zero more bits tell them apart,
    and none is called what it is not.
    """
    c = 10.0**exponent
    root = np.sqrt(c)
    two = certify(single("length", lambda z: z * z - c), np.array([[root, -root]]), ())
    assert two.certified.all()
    assert two.disjoint
    assert list(two.real) == ["real", "real"]
    none = certify(single("length", lambda z: z * z + c), np.array([[1j * root, -1j * root]]), ())
    assert list(none.real) == ["not real", "not real"]
    assert (none.distinct, none.certified.all()) == (2, True)


def test_more_bits_prove_what_doubles_cannot():
    """(z - 1)^2 = 1e-30: at 64 bits the rounding of z - 1 hides the roots; both are proved by more,
    and told apart.
    """
    found = certify(
        single("length", lambda z: (z - 1) ** 2 - 1e-30), np.array([[1 + 1e-15, 1 - 1e-15]]), ()
    )
    assert found.certified.all()
    assert found.disjoint
    assert list(found.real) == ["real", "real"]


@given(
    st.sampled_from(["dietmaier", "zhang2009"]),
    st.integers(0, 27),
    st.complex_numbers(min_magnitude=1e-3, max_magnitude=1e3),
)
def test_a_ray_and_its_multiple_are_one(name, i, factor):
    """A root given twice, the second time as another multiple of the ray, is never claimed to be
    two.
    """
    _, system, k, z = case(name)
    found = certify(system, np.concatenate([z, factor * z[:, [i]]], axis=1), k)
    assert found.certified.all()
    assert (found.disjoint, found.distinct) == (False, z.shape[1])


@given(st.sampled_from(["yao2020", "gluon_6l3"]), st.integers(0, 7), st.integers(-3, 3))
def test_whole_turns_make_no_other_root(name, i, turns):
    """A root given twice, the second time with one angle turned by whole turns, is never claimed to
    be two.
    """
    _, system, k, z = case(name)
    again = z[:, [i]].copy()
    angles = [j for j, c in enumerate(system.unknowns) if c.kind == "angle"]
    again[angles[i % len(angles)]] += 2 * np.pi * turns
    found = certify(system, np.concatenate([z, again], axis=1), k)
    assert found.certified.all()
    assert (found.disjoint, found.distinct) == (False, z.shape[1])


@given(st.floats(0.1, 9), st.floats(-3, 3))
def test_the_sign_of_a_length_makes_no_other_root(length, least):
    """A rod's coordinate has two roots of one configuration, least + l and least - l."""
    system = single("length", lambda z: (z - least) ** 2 - length**2, least)
    found = certify(system, np.array([[least + length, least - length]]), ())
    assert found.certified.all()
    assert (found.disjoint, found.distinct) == (False, 1)


def test_a_ray_with_a_null_quaternion_is_no_pose():
    """x0^2 + x1^2 = 0, x2 = x3 = 0 has the regular rays (1, i, 0, 0) and (1, -i, 0, 0), for which
    e.e = 0.
    """
    x = ca.SX.sym("x", 4)
    rows = ca.vertcat(x[0] ** 2 + x[1] ** 2, x[2], x[3])
    system = AlgebraicSystem(1.0, (), x, ca.SX(0, 1), rows, (0, 1, 2, 3))
    found = certify(system, np.array([[1, 1j, 0, 0], [1, -1j, 0, 0]]).T / np.sqrt(2), ())
    assert found.certified.all()
    assert (found.distinct, found.pose.any()) == (2, False)
    assert list(found.real) == ["not real", "not real"]


def test_other_writings_of_a_root_are_found():
    """`find` knows a real root again by the other sign of its quaternion and by other turns, and
    tells the radius there.
    """
    for name in ("zhang2009", "yao2020"):
        problem, system, k, z = case(name)
        found = certify(system, z, k, problem.closure.characteristic_length)
        for i in np.flatnonzero(found.real == "real"):
            point = algebraic_point(problem, system, real_values(problem, system, z[:, i], k))
            for j, c in enumerate(system.unknowns):
                point[j] += 2 * np.pi * (c.kind == "angle")
            point[list(system.projective)] *= -1.0
            there = found.find(point)
            assert there is not None
            assert there[0] == i
            assert there[1] < 1e-9 * problem.closure.characteristic_length
        assert found.find(z[:, i] + 1e-3) is None


def test_random_platforms_are_certified_whole():
    """All 40 roots of random 6-6 platforms are certified, different poses, and real or not; as many
    real ones as modes.
    """
    rng = np.random.default_rng(8)
    for _ in range(2):
        platform = hexapod(rng.normal(size=(6, 3)), 0.6 * rng.normal(size=(6, 3)), 1.5)
        q = rng.normal(size=4)
        pose = symkin.Pose(rng.normal(size=3), q / np.linalg.norm(q))
        legs = symkin.solve(platform, pose=pose).solution.actuated_values
        problem = build_problem(platform, "direct")
        system = system_of(problem)
        start, _ = start_of(problem, system)
        k = known_values(problem, np.array(legs))
        found: Certificates = certify(
            system, instance(system, start, k).z, k, problem.closure.characteristic_length
        )
        assert found.certified.all()
        assert found.distinct == 40
        assert int(np.sum(found.real == "real")) == len(symkin.modes(platform, joints=legs))


@pytest.mark.parametrize("shift", [0.0, pytest.param(12.0, marks=pytest.mark.long)])
def test_poses_by_six_distances_with_passive_joints_beside_them(shift: float) -> None:
    """Six slides with U and S joints: the poses are those of the same machine with rods, each with
    two ways of every U joint.
    """
    joints = [shift, -shift, 0.0, 0.5 * shift, 0.0, -0.25 * shift]
    rods, hinged = (
        symkin.modes(machines.hexaglide(), joints=joints),
        symkin.modes(machines.hexaglide(rods=False), joints=joints),
    )
    assert len(rods) > 0
    assert (hinged.poses, len(hinged)) == (len(rods), 2**6 * len(rods))
    many = symkin.modes(machines.hexaglide(rods=False), joints=[joints, [0.0] * 6])
    assert [len(many[0]), many[0].completeness] == [len(hinged), hinged.completeness]
    positions = {tuple(np.round(mode.position, 6)) for mode in hinged}
    assert positions == {tuple(np.round(mode.position, 6)) for mode in rods}
