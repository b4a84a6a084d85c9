"""The endgame: singular roots with their multiplicity, roots at infinity, sets that are not
isolated, and roots that nearly merge; every path is counted once.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    AlgebraicSystem,
    Coordinate,
    Ends,
    Fibre,
    Problem,
    Tracked,
    TrackSettings,
    are_regular,
    build_problem,
    distances,
    finish,
    known_values,
    read_given,
    real_values,
    start_of,
    system_of,
    universal_start,
    universal_system,
)
from helpers.inside import track_paths as track
from helpers.samples import delta, five_bar, hexapod, parallel_rrr, pieper, three_rrr
from symkin import Joint, LinkJoint, LinkRod, Mechanism, Pose


def ends_of(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Ends:
    """Ends of all paths, each counted once."""
    found = finish(system, start, target, track(system, start.z, start.k, target))
    assert found.paths == start.z.shape[1]
    return found


# --- equations with known roots -------------------------------------------------------------------


def small_system(rows: list[ca.SX], z: ca.SX, k: ca.SX, kind: str = "length") -> AlgebraicSystem:
    unknowns = tuple(Coordinate(f"x{i}", kind, "passive", (0.0,)) for i in range(z.shape[0]))  # type: ignore[arg-type]
    return AlgebraicSystem(1.0, unknowns, z, k, ca.vertcat(*rows), ())


def start_at(z: list[list[complex]], k: list[complex]) -> Fibre:
    columns = np.array(z, dtype=complex)
    return Fibre(
        columns, np.array(k, dtype=complex), np.zeros(columns.shape[1], dtype=int), np.inf, 0, 0
    )


def test_a_far_double_root_beside_far_regular_ones_stays_told():
    """(cos z - 1000)^2 (cos z - 500): more bits settle the regular pair, paths to the double pair
    are told as unresolved, and each is counted once.
    """
    z, k = ca.SX.sym("z", 1), ca.SX.sym("k", 3)
    system = small_system([(ca.cos(z) - k[0]) * (ca.cos(z) - k[1]) * (ca.cos(z) - k[2])], z, k)
    system = replace(system, unknowns=(Coordinate("x", "angle", "passive"),))
    begin = [0.3 + 0.4j, 0.8 - 0.7j, -0.2 + 0.1j]
    first = [[sign * complex(value) for sign in (1, -1) for value in np.arccos(begin)]]
    ends = ends_of(system, start_at(first, begin), np.array([1000.0, 1000.0, 500.0]) + 0j)
    assert np.allclose(np.cos(ends.z), 500.0)
    assert ends.z.shape == (1, 2)
    assert len(ends.unresolved) == 4


def cubic() -> tuple[AlgebraicSystem, Fibre]:
    """x^3 + p x + q = 0, k = (p, q)."""
    x, k = ca.SX.sym("x"), ca.SX.sym("k", 2)
    p, q = 0.7 + 0.4j, -0.3 + 0.8j
    return small_system([x**3 + k[0] * x + k[1]], x, k), start_at(
        [list(np.roots([1, 0, p, q]))], [p, q]
    )


@pytest.mark.parametrize(
    ("target", "simple", "double", "triple"),
    [
        ((-3, 2), [-2], [1], []),
        ((0, 0), [], [], [0]),
        ((-1, 0), [-1, 0, 1], [], []),
        ((1, 0), [-1j, 0, 1j], [], []),
    ],
)
def test_roots_of_a_cubic(target, simple, double, triple):
    """x^3 - 3x + 2 = (x - 1)^2 (x + 2); x^3; x^3 - x; x^3 + x: m paths end at a root of
    multiplicity m, m turns about it.
    """
    ends = ends_of(*cubic(), np.array(target, dtype=float))
    np.testing.assert_allclose(
        np.sort_complex(ends.z[0]), np.sort_complex(np.array(simple, dtype=complex)), atol=1e-12
    )
    np.testing.assert_allclose(ends.singular.z[0], double + triple, atol=1e-8)
    order = [2] * len(double) + [3] * len(triple)
    assert ends.singular.multiplicity.tolist() == ends.singular.turns.tolist() == order
    assert np.all(ends.singular.isolated)


def test_paths_that_cross_are_one_double_root():
    """x^2 = k^2 at k = 0: two paths of one turn each, one root."""
    x, k = ca.SX.sym("x"), ca.SX.sym("k")
    base = 0.6 + 0.5j
    ends = ends_of(
        small_system([x**2 - k**2], x, k), start_at([[base, -base]], [base]), np.zeros(1)
    )
    assert (ends.singular.multiplicity.tolist(), ends.singular.turns.tolist()) == ([2], [1])
    assert abs(ends.singular.z[0, 0]) < 1e-9


@pytest.mark.parametrize("exponent", range(2, 16))
def test_roots_that_nearly_merge_are_told_apart_or_one(exponent):
    """x^2 = k, k = 10^-n: two regular roots to rounding, or one double root within sqrt(k) of them,
    and flagged.
    """
    x, k = ca.SX.sym("x"), ca.SX.sym("k")
    base = 0.6 + 0.5j
    target = 10.0**-exponent
    ends = ends_of(
        small_system([x**2 - k], x, k),
        start_at([[np.sqrt(base), -np.sqrt(base)]], [base]),
        np.array([target]),
    )
    assert not ends.unresolved
    if len(ends.singular):
        assert target < 1e-12
        assert abs(ends.singular.z[0, 0]) <= math.sqrt(target)
    else:
        np.testing.assert_allclose(
            np.sort(ends.z[0].real), [-math.sqrt(target), math.sqrt(target)], rtol=1e-6
        )


def test_a_root_at_infinity_is_counted_there():
    """k x^2 + x - 1 = 0 at k = 0: one root x = 1, the other at infinity."""
    x, k = ca.SX.sym("x"), ca.SX.sym("k")
    base = 0.6 + 0.5j
    system, start = (
        small_system([k * x**2 + x - 1], x, k),
        start_at([list(np.roots([base, 1, -1]))], [base]),
    )
    ends = ends_of(system, start, np.zeros(1))
    assert ends.at_infinity == 1
    np.testing.assert_allclose(ends.z, [[1.0]], atol=1e-12)


@pytest.mark.parametrize("beside", [0.1, 0.01, 0.001, 1e-4])
def test_a_distant_root_is_not_at_infinity(beside):
    """k x^2 + x - 1 = 0: at k > 0 both roots are finite, one near -1/k, also where the endgame has
    to find them.
    """
    x, k = ca.SX.sym("x"), ca.SX.sym("k")
    base = 0.6 + 0.5j
    system, start = (
        small_system([k * x**2 + x - 1], x, k),
        start_at([list(np.roots([base, 1, -1]))], [base]),
    )
    ends = finish(system, start, np.array([beside]), _nothing(2))
    assert (ends.at_infinity, ends.unresolved) == (0, ())
    np.testing.assert_allclose(
        np.sort(ends.z[0].real), np.sort(np.roots([beside, 1, -1])), rtol=1e-9
    )


def test_an_angle_at_infinity_winds():
    """a cos x + b sin x = c at (1, i, 1) is exp(ix) = 1: x = 0, and the root with exp(-ix) = 0 is
    at infinity.
    """
    x, k = ca.SX.sym("x"), ca.SX.sym("k", 3)
    base = np.array([0.8 + 0.3j, 0.2 - 0.7j, 0.4 + 0.9j])
    a, b, c = base
    u = np.roots([(a - 1j * b) / 2, -c, (a + 1j * b) / 2])
    system = small_system([k[0] * ca.cos(x) + k[1] * ca.sin(x) - k[2]], x, k, "angle")
    ends = finish(
        system, start_at([list(-1j * np.log(u))], list(base)), np.array([1, 1j, 1]), _nothing(2)
    )
    assert (ends.at_infinity, ends.unresolved) == (1, ())
    np.testing.assert_allclose(ends.z, [[0.0]], atol=1e-10)


def _nothing(n: int) -> Tracked:
    """Paths that have not come anywhere."""
    return Tracked(
        np.full((1, n), np.nan, dtype=complex),
        np.zeros(n, dtype=bool),
        np.zeros(n),
        np.zeros(n, dtype=int),
    )


def test_an_end_on_a_set_is_not_isolated():
    """x y = a, x (y + 1) = b at a = b = 0: the path ends at x = 0, on the line of all (0, y)."""
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k", 2)
    a, b = 0.4 + 0.7j, -0.5 + 0.2j
    system = small_system([z[0] * z[1] - k[0], z[0] * (z[1] + 1) - k[1]], z, k)
    ends = ends_of(system, start_at([[b - a], [a / (b - a)]], [a, b]), np.zeros(2))
    assert (ends.singular.multiplicity.tolist(), ends.singular.isolated.tolist()) == ([1], [False])
    assert abs(ends.singular.z[0, 0]) < 1e-9


def test_a_path_that_jumped_is_found():
    """Two paths that claim one regular root are followed anew, to the roots of x^3 - x."""
    system, start = cubic()
    claimed = Tracked(
        np.array([[1.0, 1.0, 0.0]], dtype=complex),
        np.ones(3, dtype=bool),
        np.ones(3),
        np.ones(3, dtype=int),
    )
    assert are_regular(system, claimed, np.array([-1.0, 0.0])).tolist() == [False, False, True]
    ends = finish(system, start, np.array([-1.0, 0.0]), claimed)
    assert (ends.paths, ends.unresolved) == (3, ())
    np.testing.assert_allclose(np.sort(ends.z[0].real), [-1, 0, 1], atol=1e-12)


def test_rows_that_contradict_each_other_leave_paths_unresolved():
    """x = a, x = b followed to a != b: no root, no claim, a reason for the path."""
    x, k = ca.SX.sym("x"), ca.SX.sym("k", 2)
    system, start = (
        small_system([x - k[0], x - k[1]], x, k),
        start_at([[0.3 + 0.2j]], [0.3 + 0.2j, 0.3 + 0.2j]),
    )
    ends = finish(system, start, np.array([1.0, 2.0]), _nothing(1))
    assert (ends.z.shape[1], len(ends.singular), ends.at_infinity, len(ends.unresolved)) == (
        0,
        0,
        0,
        1,
    )
    assert ends.unresolved[0]


# --- mechanisms -----------------------------------------------------------------------------------


@cache
def problem_of(mechanism: Mechanism, kind: str) -> tuple[Problem, AlgebraicSystem, Fibre]:
    problem = build_problem(mechanism, kind)  # type: ignore[arg-type]
    system = system_of(problem)
    start, reason = start_of(problem, system)
    assert start is not None, reason
    return problem, system, start


def mechanism_ends(
    mechanism: Mechanism, **given
) -> tuple[Problem, AlgebraicSystem, Fibre, np.ndarray, Ends]:
    values = read_given(mechanism, given.get("joints"), given.get("pose"))
    problem, system, start = problem_of(mechanism, "inverse" if "pose" in given else "direct")
    k = known_values(problem, values.values)
    return problem, system, start, k, ends_of(system, start, k)


def fold_pose(mechanism: Mechanism, rng: np.random.Generator) -> Pose:
    """A pose at which the rods' six lines are dependent, by bisection on a random line of poses."""
    base, platform = (
        np.array([getattr(limb, end) for limb in mechanism.limbs]) for end in ("base", "platform")
    )
    scale = mechanism.characteristic_length

    def pose(share: float) -> Pose:
        q = first[3:] + share * (second[3:] - first[3:])
        return Pose(first[:3] + share * (second[:3] - first[:3]), q / np.linalg.norm(q))

    def lines(share: float) -> float:
        arms = platform @ pose(share).rotation.T
        rods = arms + pose(share).position - base
        rods /= np.linalg.norm(rods, axis=1, keepdims=True)
        return float(np.linalg.det(np.hstack([rods, np.cross(arms / scale, rods)])))

    while True:
        first, second = (
            np.concatenate([0.3 * scale * rng.normal(size=3), rng.normal(size=4)]) for _ in range(2)
        )
        shares = np.linspace(0, 1, 50)
        signs = np.sign([lines(share) for share in shares])
        changes = np.flatnonzero(signs[1:] != signs[:-1])
        if changes.size:
            low, high = shares[changes[0]], shares[changes[0] + 1]
            for _ in range(60):
                middle = (low + high) / 2
                low, high = (middle, high) if lines(middle) * lines(low) > 0 else (low, middle)
            return pose(low)


def random_platform(seed: int) -> tuple[Mechanism, np.random.Generator]:
    rng = np.random.default_rng(seed)
    return hexapod(100 * rng.normal(size=(6, 3)), 60 * rng.normal(size=(6, 3)), 150.0), rng


@pytest.mark.parametrize("seed", in_gate([1, 2, 3], [1]))
def test_two_modes_of_a_platform_merge_at_a_singular_pose(seed):
    """Where the six lines are dependent two of the 40 roots are one, and it is that pose: 38
    regular, one double.
    """
    platform, rng = random_platform(seed)
    pose = fold_pose(platform, rng)
    problem, system, _, k, ends = mechanism_ends(
        platform, joints=symkin.solve(platform, pose=pose).solution.actuated_values
    )
    singular = ends.singular
    assert (ends.z.shape[1], singular.multiplicity.tolist(), singular.turns.tolist()) == (
        38,
        [2],
        [2],
    )
    assert singular.isolated.all()
    values = real_values(problem, system, singular.z[:, 0], k)
    position = np.array([values[f"pose.{axis}"][0] for axis in "xyz"])
    assert np.max(np.abs(position - pose.position)) < 1e-8 * platform.characteristic_length
    assert abs(abs(values["pose.quaternion"] @ pose.quaternion) - 1) < 1e-12


@pytest.mark.parametrize("seed", [4, 5])
def test_mirror_modes_merge_in_mirror_pairs(seed):
    """Base and platform in parallel planes: a singular pose and its mirror image, two double roots,
    24 regular ones.
    """
    platform = symkin.load("zhang2009")
    pose = fold_pose(platform, np.random.default_rng(seed))
    *_, ends = mechanism_ends(
        platform, joints=symkin.solve(platform, pose=pose).solution.actuated_values
    )
    assert (ends.z.shape[1], ends.singular.multiplicity.tolist()) == (24, [2, 2])


@pytest.mark.parametrize("exponent", in_gate([3, 5, 7, 9, 11], [5, 11]))
def test_near_a_singular_pose_nothing_is_lost(exponent):
    """Lengths changed by a share 10^-n: 40 paths end at finite roots, merged ones flagged, none
    unresolved.
    """
    platform, rng = random_platform(6)
    lengths = np.array(
        symkin.solve(platform, pose=fold_pose(platform, rng)).solution.actuated_values
    )
    *_, ends = mechanism_ends(
        platform, joints=lengths * (1 + 10.0**-exponent * rng.uniform(-1, 1, 6))
    )
    assert (ends.z.shape[1] + ends.singular.multiplicity.sum(), ends.unresolved) == (40, ())


def links_stretched() -> list[float]:
    """Joint values (deg, mm) of the four-freedom platform with limbs of 70 + 70 mm at a pose at
    which each reaches 140 mm.
    """
    across = 40 * math.sqrt(3)
    return [90.0, 210.0, 330.0, math.sqrt(140**2 - across**2)]


@pytest.mark.parametrize("apart", [5e-3, 2e-4, 2e-5])
def test_poses_with_large_complex_entries_are_counted_beside_a_symmetry(apart):
    """Where two of a delta's joints are equal four complex poses are at infinity: beside, their
    rotations have entries of 1e6 and more, and they are poses like others.
    """
    free = replace(delta(), motion="spatial")
    found = [symkin.modes(free, joints=[0.1, 0.03, 0.1 + away]) for away in (0.2, apart)]
    assert found[0].complex_count == found[1].complex_count
    assert symkin.modes(free, joints=[0.1, 0.03, 0.1]).complex_count == found[0].complex_count - 4


CASES = {
    "delta, free platform, symmetric": lambda: (
        replace(delta(), motion="spatial"),
        {"joints": [0.2, 0.2, 0.2]},
    ),
    "delta, free platform, two equal": lambda: (
        replace(delta(), motion="spatial"),
        {"joints": [0.2, 0.2, -0.1]},
    ),
    "flat hexapod": lambda: (
        flat := symkin.load("zhang2009"),
        {"joints": [c.reference[0] for c in flat.actuated]},
    ),
    "3-RRR, symmetric": lambda: (three_rrr("planar"), {}),
    "3-RRR, spatial, symmetric": lambda: (three_rrr("spatial"), {}),
    "five-bar, couplers in line": lambda: (five_bar(), {"joints": [120, 60]}),
    "limbs in line": lambda: (symkin.load("zhao2000_links"), {"joints": links_stretched()}),
}
"""Symmetric and singular joint values whose ends are isolated or at infinity."""


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_nearby_instances_have_as_many_roots_near_each_end_as_paths_end_there(name):
    """At known values 1e-6 away, by another road: one root near each regular end, m near one where
    m paths end, as many far from all of them as ended at infinity.
    """
    mechanism, given = CASES[name]()
    _, system, start, k, ends = mechanism_ends(mechanism, **given)
    assert not ends.unresolved
    assert ends.singular.isolated.all()
    shift = np.random.default_rng(0).normal(size=(2, len(k)))
    shift[:, k == start.k] = 0.0
    careful = TrackSettings(tolerance=1e-6, smallest_step=1e-10, most_steps=800)
    beside = track(system, start.z, start.k, k + 1e-6 * (shift[0] + 1j * shift[1]), careful).z
    apart = distances(system, beside, ends.points)
    near = apart.min(axis=1) < 0.02
    counts = np.bincount(np.argmin(apart, axis=1)[near], minlength=ends.points.shape[1])
    assert counts.tolist() == [1] * ends.z.shape[1] + ends.singular.multiplicity.tolist()
    assert np.sum(~near) == ends.at_infinity


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    in_gate(CASES, ["flat hexapod", "limbs in line"]),
)
def test_ends_satisfy_the_rows(name):
    """Regular roots to 1e-12 of the size, singular ones to 1e-13."""
    mechanism, given = CASES[name]()
    _, system, _, k, ends = mechanism_ends(mechanism, **given)
    for roots, tolerance in ((ends.z, 1e-12), (ends.singular.z, 1e-13)):
        rows, _ = system.linearise(roots, np.repeat(k[:, None] + 0j, roots.shape[1], axis=1))
        assert np.max(np.abs(rows), initial=0.0) < tolerance


def test_far_solutions_are_not_said_to_be_at_infinity():
    """Two circles whose centres are 1e-9 apart meet some 1e12 away: the count leaves these two
    out, and says so.
    """
    joints = [
        LinkJoint(Joint(name, "P", (at, 0.0, 0.0), along), links)
        for name, at, along, links in (
            ("x", 0.0, (1.0, 0.0, 0.0), ("base", "slide")),
            ("y", 0.0, (0.0, 1.0, 0.0), ("slide", "tip")),
            ("s", 60.0, (1.0, 0.0, 0.0), ("base", "foot")),
        )
    ]
    rods = [
        LinkRod(f"rod{at:g}", (link, "tip"), (at, 0.0, 0.0), (50.0, 30.0, 0.0))
        for link, at in (("base", 10.0), ("foot", 60.0))
    ]
    found = symkin.modes(
        Mechanism("circles", link_joints=joints, link_rods=rods), given={"s": 1e-9 - 50.0}
    )
    assert (len(found), found.complex_count) == (0, 0)
    assert any("2 are at infinity, or too far off to be told" in note for note in found.notes)


def test_singular_ends_do_not_depend_on_the_way():
    """From another base in the same complex line the eight paths of the flat hexapod end at the
    same root.
    """
    mechanism, given = CASES["flat hexapod"]()
    _, system, start, k, ends = mechanism_ends(mechanism, **given)
    base = start.k + (0.2 - 0.6j) * (k - start.k)
    moved = track(system, start.z, start.k, base, TrackSettings(tolerance=1e-6))
    again = ends_of(system, replace(start, z=moved.z, k=base), k)
    assert again.singular.multiplicity.tolist() == ends.singular.multiplicity.tolist()
    assert np.max(distances(system, again.singular.z, ends.singular.z)) < 1e-8


# --- sets that are not isolated -------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "given", "isolated"),
    [
        (parallel_rrr("planar"), {}, 2),
        (parallel_rrr("spatial"), {}, 2),
        (
            five_bar(),
            {"joints": [math.degrees(math.acos(50 / 60)), 180 - math.degrees(math.acos(50 / 60))]},
            0,
        ),
        (pieper(), {"pose": [90, 0, 220, 1, 0, 0, 0]}, 4),
    ],
    ids=["parallel links", "parallel links, spatial", "elbows that meet", "wrist axes in line"],
)
def test_paths_that_end_on_sets_are_told_from_isolated_ones(mechanism, given, isolated):
    """Parallel links move on a circle beside two isolated modes; a five-bar whose elbows meet turns
    about them; aligned first and last wrist axes turn against each other, with four wrist-flipped
    solutions left.
    """
    *_, ends = mechanism_ends(mechanism, **given)
    assert not ends.unresolved
    assert ends.z.shape[1] == isolated
    assert len(ends.singular) > 0
    assert not ends.singular.isolated.any()


def distances_of(platform: Mechanism, pose: Pose) -> np.ndarray:
    """Known values of the universal system: length, base and platform point of each rod at a pose,
    in sizes.
    """
    rows = []
    for limb in platform.limbs:
        length = np.linalg.norm(pose.apply(np.array(limb.platform)) - np.array(limb.base))
        rows.append(
            np.concatenate([[length], limb.base, limb.platform]) / platform.characteristic_length
        )
    return np.concatenate(rows)


def test_an_architecture_singular_platform_moves_wherever_it_is_assembled():
    """Corners of one triangle on side midpoints of another and the reverse (Griffis and Duffy): six
    dependent rows wherever they can be met, so that no path ends at an isolated root.
    """
    corners = np.array(
        [[200 * math.cos(a), 200 * math.sin(a), 0] for a in np.radians([90, 210, 330])]
    )
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    base = np.stack([corners, middles], axis=1).reshape(6, 3)
    platform = hexapod(
        base, np.stack([middles, np.roll(corners, -1, axis=0)], axis=1).reshape(6, 3)
    )
    pose = Pose(
        np.array([10.0, 20.0, 100.0]),
        np.array([0.98, 0.1, 0.15, 0.05]) / np.linalg.norm([0.98, 0.1, 0.15, 0.05]),
    )
    ends = ends_of(universal_system(), universal_start(), distances_of(platform, pose))
    assert (ends.z.shape[1], ends.unresolved) == (0, ())
    assert not ends.singular.isolated.any()


@pytest.mark.parametrize(
    ("base", "platform", "finite"),
    [
        ((0, 1, 2, 3, 4, 5), (0, 0, 1, 1, 2, 3), 32),
        ((0, 0, 1, 1, 2, 3), (0, 1, 1, 2, 2, 3), 24),
        ((0, 1, 1, 2, 2, 0), (0, 0, 1, 1, 2, 2), 16),
    ],
    ids=["6-4", "4-4", "3-3"],
)
def test_shared_joint_centres_send_paths_to_infinity(base, platform, finite):
    """Of the 40 roots of six distances platforms with shared joint centres keep 32, 24 and 16
    (Faugere and Lazard 1995); the others have e = 0.
    """
    rng = np.random.default_rng(8)
    b, m = rng.normal(size=(6, 3))[list(base)], rng.normal(size=(6, 3))[list(platform)]
    lengths = rng.normal(size=6) + 1j * rng.normal(size=6)
    ends = ends_of(
        universal_system(), universal_start(), np.hstack([lengths[:, None], b, m]).ravel()
    )
    assert (ends.z.shape[1], len(ends.singular), ends.at_infinity) == (finite, 0, 40 - finite)
