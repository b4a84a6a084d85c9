"""Continuation: the algebraic closure, the tracker's roots, generic counts, and completeness that
says no more than it knows.
"""

import math
from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

import symkin
from campaigns.shipped_starts import prepared_groups
from helpers import inside
from helpers.inside import (
    BOUND,
    algebraic_point,
    build_closure,
    build_problem,
    instance,
    known_values,
    random_values,
    real_values,
    start_files,
    start_store,
    system_of,
    universal_start,
    universal_system,
    vectorise,
)
from helpers.known_roots import DIETMAIER, dietmaier
from helpers.samples import delta, five_bar, hexapod, three_rps, three_rrr
from symkin import Joint, Limb, LinkJoint, Mechanism, Pose

# --- the algebraic closure ------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["study", "homogeneous"])
@pytest.mark.parametrize("name", ["zhang2009", "zhao2000_links", "yao2020"])
def test_algebraic_rows_are_the_closure_rows_at_unit_quaternions(name, form):
    """With |e| = 1 and g = t e / 2 the weighted rows are the closure's own."""
    mechanism = symkin.load(name)
    closure = build_closure(mechanism)
    written = inside.algebraic_rows(closure, (("pose", form),))
    joints_of = closure.symbols(closure.role("actuated", "passive"))
    function = ca.Function("a", [joints_of, written.symbols["pose"]], [written.rows])
    rng = np.random.default_rng(1)
    for _ in range(5):
        values = random_values(closure.coordinates, closure.characteristic_length, rng)
        joints = np.concatenate(
            [values[closure.slices[c.name]] for c in closure.role("actuated", "passive")]
        )
        t, e = (
            values[closure.slices["pose.x"].start :][:3],
            values[closure.slices["pose.quaternion"]],
        )
        product = inside.multiply(np.array([0.0, *t]), e)
        pose = np.concatenate([e, 0.5 * product]) if form == "study" else np.concatenate([t, e])
        rows = function(joints, pose)
        expected = ca.Function("c", [closure.variables], [closure.bound(closure.rows)])(values)
        np.testing.assert_allclose(
            np.asarray(rows), np.asarray(expected), atol=1e-9 * closure.characteristic_length
        )


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000_links"])
def test_study_rows_are_homogeneous(name):
    """A ray is a pose: scaling (e, g) by any complex number keeps roots roots (rows scale by its
    powers 1 or 2).
    """
    system = system_of(build_problem(symkin.load(name), "direct"))
    rng = np.random.default_rng(2)
    z = rng.normal(size=(system.width, 1)) + 1j * rng.normal(size=(system.width, 1))
    k = rng.normal(size=(int(system.k.shape[0]), 1)) + 0j
    factor = 0.7 - 0.4j
    scaled = z.copy()
    scaled[list(system.projective)] *= factor
    ratio = system.linearise(scaled, k)[0] / system.linearise(z, k)[0]
    assert np.all(np.isclose(ratio, factor) | np.isclose(ratio, factor**2))


def test_vectorised_code_is_the_function():
    """The written NumPy code gives CasADi's values on real points, lane by lane, and is analytic on
    complex ones.
    """
    x = ca.SX.sym("x", 2)
    expression = ca.vertcat(
        ca.sin(x[0]) * x[1] ** 2 / (1 + x[0]), ca.sqrt(x[0] + 3) - 2 * ca.cos(x[1])
    )
    code = vectorise(ca.Function("f", [x], [expression]))
    points = np.random.default_rng(0).uniform(0.1, 1, (2, 7))
    out = np.zeros((7, 2, 1), dtype=complex)
    code(points + 0j, out)
    expected = np.array(
        [np.asarray(ca.Function("f", [x], [expression])(p)).ravel() for p in points.T]
    )
    np.testing.assert_allclose(out[:, :, 0], expected, rtol=1e-14)
    step, shifted = 1e-20, np.zeros((7, 2, 1), dtype=complex)
    code(points + step * np.array([[1j], [0]]), shifted)
    slope = np.array(
        [np.asarray(ca.Function("j", [x], [ca.jacobian(expression, x)])(p))[:, 0] for p in points.T]
    )
    np.testing.assert_allclose(shifted[:, :, 0].imag / step, slope, rtol=1e-12)


def test_real_points_come_back():
    """algebraic_point and real_values are inverse to each other."""
    problem = build_problem(symkin.load("zhao2000_links"), "direct")
    system = system_of(problem)
    mode = symkin.modes(problem.mechanism)[0]
    values = {c.name: np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns}
    back = real_values(problem, system, algebraic_point(problem, system, values), np.zeros(0))
    for name, value in values.items():
        assert np.allclose(back[name], value) or np.allclose(back[name], -value), name


def test_the_universal_start_has_forty_distinct_roots():
    """40 roots of six random complex distances, the bound of Ronga and Vust (1992), each to
    rounding.
    """
    start, system = universal_start(), universal_system()
    rows, _ = system.linearise(start.z, np.repeat(start.k[:, None], BOUND, axis=1))
    assert np.max(np.abs(rows)) < 1e-12
    f = system.features(start.z)
    distance = np.max(np.abs(f[:, None] - f[None]), axis=2) + np.eye(BOUND)
    assert distance.min() > 1e-4


# --- counts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mechanism", "given", "complex_count", "real"),
    [
        (dietmaier(), {"joints": DIETMAIER["legs"]}, 40, 40),
        (symkin.load("zhang2009"), {}, 28, 4),
        (symkin.load("zhao2000"), {}, 4, 4),
        (symkin.load("zhao2000_links"), {}, 64, 16),
        (symkin.load("yao2020"), {}, 8, 4),
        (symkin.load("gluon_6l3"), {"pose": symkin.modes(symkin.load("gluon_6l3"))[0].pose}, 8, 2),
        (symkin.load("zhang2009"), {"pose": [10, 20, 300, 1, 0, 0, 0]}, 1, 1),
        (symkin.load("zhao2000"), {"pose": [5, 5, 105, 1, 0, 0, 0]}, 8, 8),
    ],
    ids=[
        "dietmaier",
        "zhang2009",
        "zhao2000",
        "zhao2000_links",
        "yao2020",
        "gluon_6l3",
        "zhang inverse",
        "zhao inverse",
    ],
)
def test_counts_of_the_shipped_mechanisms_and_of_dietmaier(mechanism, given, complex_count, real):
    """Published or twice computed counts: Dietmaier 40 of 40; 28 and 4; 4 lines' poses; 64 = 8
    poses, 4 of them on its face, x 8; 8 for a Pieper arm with a slide; 8 for three parallel axes;
    rods one; 2 branches a plane. Proved where a theorem's bound is reached: 40 for six distances
    (Ronga and Vust 1992), one length a rod, two points of two circles; every real mode is
    certified.
    """
    found = symkin.modes(mechanism, **given, method="continuation")
    assert (found.complex_count, len(found), found.unresolved_paths) == (complex_count, real, 0)
    bounded = "pose" in given and mechanism.name != "gluon_6l3"
    bounded |= mechanism.name == "dietmaier1998"
    assert (found.completeness, found.method) == (
        "proved" if bounded else "probability one",
        "continuation",
    )
    assert max(mode.residual for mode in found) < 1e-12 * mechanism.characteristic_length
    assert all(
        mode.certified and mode.radius < 1e-9 * mechanism.characteristic_length for mode in found
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "complex_count"),
    [
        pytest.param(five_bar(), 2, id="five-bar", marks=pytest.mark.long),
        pytest.param(three_rrr("planar"), 6, id="3-RRR"),
        pytest.param(delta(), 2, id="delta", marks=pytest.mark.long),
        pytest.param(
            replace(delta(), motion="spatial"), 40, id="delta spatial", marks=pytest.mark.long
        ),
        pytest.param(three_rps(), 16, id="3-RPS", marks=pytest.mark.long),
    ],
)
def test_generic_counts_by_the_same_code(mechanism, complex_count):
    """Known counts: five-bar 2, planar 3-RRR 6 (Gosselin 1992), delta 2, and 40 when its platform
    may turn; 3-RPS 16, in two operation modes of 8 (Schadlbauer, Walter, Husty 2014). Nothing lost
    against multistart.
    """
    shift = np.random.default_rng(3).uniform(-0.15, 0.15, len(mechanism.actuated))
    joints = [
        mechanism.angle_out(c.reference[0] + d) if c.is_angular else c.reference[0] * (1 + 0.3 * d)
        for c, d in zip(mechanism.actuated, shift, strict=True)
    ]
    found = symkin.modes(mechanism, joints=joints)
    sampled = symkin.modes(mechanism, joints=joints, method="multistart", starts=2000)
    assert (found.complex_count, found.unresolved_paths) == (complex_count, 0)
    assert len(found) >= len(sampled)
    if mechanism.name == "three_rps":
        assert any("2 operation modes of 8, 8" in note for note in found.notes)


@pytest.mark.long
@pytest.mark.slow
def test_random_platforms_lose_nothing(cache):
    """Random 6-6 geometries: 40 complex roots, an even number of real ones, the pose that made the
    lengths among them.
    """
    rng = np.random.default_rng(4)
    for _ in range(4):
        platform = hexapod(rng.normal(size=(6, 3)), 0.6 * rng.normal(size=(6, 3)), 1.5)
        q, t = rng.normal(size=4), rng.normal(size=3)
        pose = Pose(t, q / np.linalg.norm(q))
        found = symkin.modes(
            platform, joints=symkin.solve(platform, pose=pose).solution.actuated_values
        )
        assert (found.complex_count, found.unresolved_paths, len(found) % 2) == (40, 0, 0)
        errors = [
            max(np.max(np.abs(m.position - t)), np.max(np.abs(m.rotation - pose.rotation)))
            for m in found
        ]
        assert min(errors) < 1e-8


def test_random_legs_of_a_symmetric_platform():
    """Base and platform in parallel planes of one symmetry: 28 complex roots, real ones in mirror
    pairs z -> -z.
    """
    platform = symkin.load("zhang2009")
    rng = np.random.default_rng(6)
    for _ in range(12):
        q = np.array([1.0, 0, 0, 0]) + 0.2 * rng.normal(size=4)
        pose = Pose(rng.normal(size=3) * 80 + [0, 0, 300], q / np.linalg.norm(q))
        found = symkin.modes(
            platform, joints=symkin.solve(platform, pose=pose).solution.actuated_values
        )
        assert (found.complex_count, found.unresolved_paths) == (28, 0)
        heights = sorted(m.position[2] for m in found)
        np.testing.assert_allclose(heights, [-h for h in reversed(heights)], atol=1e-6)


def test_complex_roots_come_in_conjugate_pairs():
    """At real known values the conjugate of a root is a root."""
    problem = build_problem(symkin.load("zhang2009"), "direct")
    system = system_of(problem)
    start, _ = start_store.start_of(problem, system)
    ends = instance(
        system, start, known_values(problem, np.array(symkin.load("zhang2009").example.joints))
    )
    f, g = system.features(ends.z), system.features(np.conj(ends.z))
    assert np.max(np.min(np.max(np.abs(f[:, None] - g[None]), axis=2), axis=0)) < 1e-8


@pytest.mark.parametrize("asked", ["joints", "pose"])
def test_the_search_for_generic_solutions_is_told(asked, tmp_path, monkeypatch):
    """In a cache that holds nothing: percents of each search, in the direct and in the inverse
    problem; there is nothing to tell the second time.
    """
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    machine, told = three_rps(), []
    given = {
        "joints": [c.reference[0] + 1.0 for c in machine.actuated],
        "pose": machine.reference_pose,
    }[asked]
    first, again = (
        symkin.modes(machine, **{asked: given}, progress=lambda *now, k=k: told.append((k, *now)))
        for k in range(2)
    )
    assert len(first) == len(again)
    assert told
    assert {k for k, _, _ in told} == {0}
    assert all(0 <= done <= total == 100 for _, done, total in told)


# --- what is not claimed --------------------------------------------------------------------------


@pytest.mark.slow
def test_symmetric_joint_values_are_not_claimed():
    """At the delta's symmetric reference with a free platform, roots run to infinity together: what
    is listed closes, and completeness is claimed only if no path is unresolved.
    """
    found = symkin.modes(replace(delta(), motion="spatial"))
    assert all(mode.residual < 1e-9 * found.problem.closure.characteristic_length for mode in found)
    assert (found.completeness == "probability one") == (found.unresolved_paths == 0)


def test_helical_joints_are_sampled_with_the_reason():
    """A closure with an unknown helix angle is not algebraic: multistart, and the note names the
    joint.
    """
    z = (0, 0, 1)
    left = Limb(
        "left",
        [Joint("a", "R", (0, 0, 0), z, actuated=True), Joint("h", "H", (1, 0, 0), z, pitch=0.3)],
    )
    right = Limb("right", [Joint("b", "R", (4, 0, 0), z), Joint("s", "S", (2, 1, 0))])
    found = symkin.modes(Mechanism("helix", [left, right], platform_position=(2, 1, 0)), starts=200)
    assert found.completeness == "sampled"
    assert any("helical" in note and "h" in note for note in found.notes)


@pytest.mark.slow
def test_a_continuum_is_incomplete_and_named(cache):
    """Equal base and platform, parallel legs: a sphere of translations. No mode of it is counted,
    nothing is claimed.
    """
    ends = np.random.default_rng(0).uniform(-100, 100, (6, 3))
    found = symkin.modes(hexapod(ends, ends), joints=[150.0] * 6)
    assert found.positive_dimensional
    assert found.completeness == "incomplete"
    assert not any(np.allclose(mode.rotation, np.eye(3), atol=1e-4) for mode in found)


def test_a_double_root_is_one_and_flagged():
    """All legs at the flat, coincident position: one multiple root, returned once, called singular
    and double.
    """
    platform = symkin.load("zhang2009")
    reference = [c.reference[0] for c in platform.actuated]
    found = symkin.modes(platform, joints=reference)
    assert len(found) == 1
    assert any("singular" in note for note in found[0].notes)
    assert any("double" in note for note in found[0].notes)
    assert "double" in str(found)


def test_operation_modes_are_told_at_every_input():
    """A note of the machine does not hang on the input: it is told where no path is in doubt."""
    delta = symkin.load("delta_parallelograms")
    doubtful, plain = symkin.modes(delta), symkin.modes(delta, joints=[-4.9, -10.2, -2.7])
    told = [{n for n in found.notes if "operation modes" in n} for found in (doubtful, plain)]
    assert told[0] == told[1] != set()


@pytest.mark.parametrize(("combined", "count"), [(False, 1), (True, 0)])
def test_roots_of_combinations_are_no_operation_modes(combined, count):
    """Rows that given values must agree with are followed as combinations, whose generic roots are
    no modes: a planar machine of four legs told 14 operation modes of one.
    """
    start = SimpleNamespace(orbits=np.array([0, 1, 1]))
    assert len(inside.block_paths.BlockPaths(None, None, start, combined=combined).notes) == count


def _leg(tilt: float) -> Mechanism:
    """Two cranks that turn about one axis, in line at the reference; a motor's axis is tilted."""
    hip, foot, z = (0.0, 0.0, 0.0), (0.0, 0.165, 0.009), (0.0, 0.0, 1.0)
    knees = [(x, 0.0, 0.0) for x in (0.095, -0.095)]
    axes = [(tilt, 0.0, 1.0), z]
    cranks = [
        LinkJoint(Joint(name, "R", hip, axis, actuated=True), ("base", f"crank {name}"))
        for name, axis in zip("ab", axes, strict=True)
    ]
    legs = [
        LinkJoint(Joint(f"knee {n}", "U", at, z, (1.0, 0.0, 0.0)), (f"crank {n}", f"shank {n}"))
        for n, at in zip("ab", knees, strict=True)
    ]
    last = LinkJoint(Joint("foot", "R", foot, z), ("shank a", "shank b"))
    return Mechanism("leg", link_joints=[*cranks, *legs, last])


@pytest.mark.parametrize("tilt", [0.0, 4.6e-5, 1e-3])
def test_loops_that_close_nowhere_else_exactly_are_told_without_a_search(tilt, monkeypatch):
    """A leg that is singular at the reference, and that no given values beside it close to
    rounding, as least squares tell: it has no generic solutions, which takes no loops to find out.
    One without the tilt has its four.
    """
    problem = build_problem(_leg(tilt), ("a", "b"), None)
    (group,) = inside.structure_groups(problem)
    given = np.random.default_rng(2).uniform(-0.3, 0.3, (20, 2))
    ends = group.system.polish_many(np.zeros((20, group.system.width)), given).points
    closes = group.system.residuals(ends, given) <= 1e-12
    asked = []
    search = start_store.agreeing_searches
    monkeypatch.setattr(
        start_store, "agreeing_searches", lambda *a: (asked.append(a), search(*a))[1]
    )
    found, why = start_store.compute_start(group, system_of(group))
    if tilt:
        assert found is None
        assert not asked
        assert not closes.any()
        assert "satisfy conditions" in why
    else:
        assert closes.any()
        assert found.z.shape[1] == 4


# --- the store ------------------------------------------------------------------------------------


@pytest.mark.parametrize("damage", ["empty", "no zip", "cut"])
def test_starts_are_kept_and_damage_is_survived(cache, damage):
    """A start is written once, read again, and computed anew where its file is damaged; the roots
    are the same.
    """
    problem = build_problem(symkin.load("zhang2009"), "direct")
    system, computed = system_of(problem), []
    start, _ = start_store.start_of(problem, system)

    def kept():
        found, _ = start_files.kept_or_computed(
            "own", system, lambda: computed.append(1) or (start, "")
        )
        np.testing.assert_array_equal(found.z, start.z)
        return len(computed)

    assert (kept(), kept()) == (1, 1)
    (file,) = cache.glob("*.npz")
    file.write_bytes({"empty": b"", "no zip": b"no zip", "cut": file.read_bytes()[:100]}[damage])
    assert (kept(), kept()) == (2, 2)
    assert list(cache.glob("*.part")) == []


def test_every_shipped_start_is_read(monkeypatch, tmp_path):
    """The wheel carries a start for each block of each shipped mechanism of limbs, and for the
    parts of those that implied rows take apart: none is computed.
    """
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    problems = set()
    for problem in prepared_groups():
        assert list(tmp_path.glob("*.npz")) == [], (problem.mechanism.name, problem.name)
        problems.add((problem.mechanism.name, bool(problem.implied)))
    assert {("zhang2009", False), ("zhao2000_links", True)} < problems


@pytest.mark.slow
def test_an_unwritable_cache_only_costs_time(monkeypatch):
    """A cache folder that cannot be made changes nothing in the answer."""
    monkeypatch.setenv("SYMKIN_CACHE", "/dev/null/cache")
    assert len(symkin.modes(five_bar())) == 2


@pytest.mark.slow
def test_whole_turns_change_nothing():
    """Joint values of many turns are the same problem: the same modes and counts as without the
    turns.
    """
    plain = symkin.modes(five_bar(), joints=[math.degrees(0.3), math.degrees(-0.2)])
    far = symkin.modes(
        five_bar(), joints=[math.degrees(0.3) + 360 * 10**6, math.degrees(-0.2) - 360 * 10**6]
    )
    assert (far.complex_count, far.completeness, len(far)) == (
        plain.complex_count,
        plain.completeness,
        len(plain),
    )
    for a, b in zip(plain, far, strict=True):
        np.testing.assert_allclose(
            a.position, b.position, atol=1e-6 * plain.problem.closure.characteristic_length
        )


def test_screws_of_many_turns_are_followed_to_the_end() -> None:
    """Six screws of 0.005 a turn that lift a platform by legs: 60 turns are 0.3, and the paths to
    them turn as often.
    """
    limbs = []
    for i in range(6):
        a = i * math.pi / 3 + (0.2 if i % 2 else -0.2)
        b = (i // 2) * 2 * math.pi / 3 + (0.5 if i % 2 else -0.4)
        x, y = math.cos(a), math.sin(a)
        screw = Joint(f"h{i}", "H", (x, y, 0.0), (0.0, 0.0, 1.0), actuated=True, pitch=0.005)
        foot = Joint(f"u{i}", "S", (x + 0.1, y + 0.05, 0.2))
        head = Joint(f"s{i}", "S", (0.5 * math.cos(b), 0.5 * math.sin(b), 1.0))
        limbs.append(Limb(f"leg{i}", [screw, foot, head]))
    mechanism = Mechanism("lifts", limbs, platform_position=(0.0, 0.0, 1.0), angle_unit="deg")
    found = symkin.modes(mechanism, joints=[360.0 * 60 + 40.0 * i * i for i in range(6)])
    assert (len(found), found.complex_count, found.completeness) == (4, 40, "probability one")


def test_an_unknown_engine_is_refused(monkeypatch):
    """SYMKIN_ENGINE is numpy, compiled or nothing."""
    monkeypatch.setenv("SYMKIN_ENGINE", "bogus")
    with pytest.raises(symkin.InputError, match="allowed: numpy, compiled"):
        symkin.modes(symkin.load("zhang2009"))
