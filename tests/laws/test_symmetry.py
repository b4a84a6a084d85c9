"""Symmetries: maps that keep the rows, orbits that partition the roots, and the reflection of flat
platforms.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given

import symkin
from helpers.inside import (
    AlgebraicSystem,
    Symmetries,
    algebraic_point,
    binary_null_space,
    build_problem,
    distance_frames,
    engine,
    find_symmetries,
    known_values,
    matrix_from_quaternion,
    orbits,
    plane_frame,
    reflection,
    start_of,
    structure_groups,
    system_of,
    tracker,
    universal_system,
)
from helpers.samples import hexapod, pieper, seeds, three_rrr
from symkin import Mechanism, RodLimb


def lengths_only(mechanism: Mechanism):
    """Draws complex lengths of a platform on six rods, at its own points."""
    fixed = known_values(build_problem(mechanism, "direct"), np.ones(6))

    def draw(rng: np.random.Generator) -> np.ndarray:
        k = fixed.copy()
        k[::7] = rng.normal(size=6) + 1j * rng.normal(size=6)
        return k

    return draw


@lru_cache
def case(name: str) -> tuple[AlgebraicSystem, Symmetries, object]:
    mechanism, kind = {
        "zhang2009": (symkin.load("zhang2009"), "direct"),
        "zhao2000": (symkin.load("zhao2000"), "direct"),
        "zhao2000 limb": (symkin.load("zhao2000"), "inverse"),
        "three_rrr": (three_rrr(), "direct"),
        "pieper": (pieper(), "inverse"),
    }[name]
    system = system_of(structure_groups(build_problem(mechanism, kind))[0])
    draw = lengths_only(mechanism) if name == "zhang2009" else None
    return system, find_symmetries(system, draw), draw


NAMES = ["zhang2009", "zhao2000", "zhao2000 limb", "three_rrr", "pieper"]


def random_rows(
    system: AlgebraicSystem, symmetries: Symmetries, draw, rng: np.random.Generator
) -> np.ndarray:
    """Rows (maps, rows) at the images of a random complex point."""
    z = rng.normal(size=system.width) + 1j * rng.normal(size=system.width)
    known = int(system.k.shape[0])
    k = draw(rng) if draw else rng.normal(size=known) + 1j * rng.normal(size=known)
    images = symmetries.apply(z[:, None])[:, :, 0].T
    return system.linearise(images, np.repeat(k[:, None], images.shape[1], axis=1))[0]


# --- maps that keep the rows ----------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@given(rng=seeds)
def test_every_row_keeps_its_absolute_value(name, rng):
    """F_i(S z, k) = F_i(z, k) or -F_i(z, k) at any point, and there is a map besides the
    identity.
    """
    system, symmetries, draw = case(name)
    rows = random_rows(system, symmetries, draw, rng)
    assert len(symmetries) > 1
    assert np.all(
        np.minimum(np.abs(rows - rows[0]), np.abs(rows + rows[0])) < 1e-10 * np.max(np.abs(rows))
    )


@pytest.mark.parametrize("name", NAMES)
def test_the_maps_are_a_group(name):
    """The identity is first, and the product of two maps takes a point where one map takes it."""
    system, symmetries, _ = case(name)
    rng = np.random.default_rng(0)
    z = rng.normal(size=(system.width, 1)) + 1j * rng.normal(size=(system.width, 1))
    images = symmetries.apply(z)[:, :, 0].T
    np.testing.assert_allclose(images[:, 0], z[:, 0])
    places = system.features(images)
    for image in images.T:
        again = system.features(symmetries.apply(image[:, None])[:, :, 0].T)
        distance = np.max(np.abs(again[:, None] - places[None]), axis=2)
        assert np.all(np.min(distance, axis=1) < 1e-9)
        assert len(set(np.argmin(distance, axis=1))) == len(symmetries)


def test_a_wrist_turns_over():
    """Three axes z y z that meet: (a, b, c) and (a + pi, -b, c + pi) are one rotation."""
    system, symmetries, _ = case("pieper")
    names = [c.name for c in system.unknowns]
    a, b = names.index("q4"), names.index("q5")
    signs, shifts = np.diag(symmetries.matrices[1]).real, symmetries.shifts[1]
    assert signs[b] == -1.0
    assert shifts[a] == pytest.approx(np.pi)
    assert np.sum(signs != 1.0) == 1


@pytest.mark.parametrize("name", ["yao2020", "gluon_6l3"])
def test_arms_of_general_shape_have_none(name):
    """Neither arm's closure keeps its rows under a change of signs."""
    system = system_of(build_problem(symkin.load(name), "inverse"))
    assert len(find_symmetries(system)) == 1


@given(rng=seeds)
def test_nullspaces_over_two_elements(rng):
    """The basis spans exactly the vectors that meet all equations, counted by trying them all."""
    a = rng.uniform(size=(rng.integers(0, 7), 6)) < 0.4
    everything = (np.arange(64)[:, None] >> np.arange(6)) % 2 == 1
    solutions = ~(everything.astype(int) @ a.T.astype(int) % 2).any(axis=1)
    basis = binary_null_space(a)
    assert 2 ** len(basis) == solutions.sum()
    assert not (basis.astype(int) @ a.T.astype(int) % 2).any()
    assert len(
        np.unique(everything[:, : len(basis)].astype(int) @ basis.astype(int) % 2, axis=0)
    ) == 2 ** len(basis)


# --- flat platforms -------------------------------------------------------------------------------


def flat_data(rng: np.random.Generator) -> np.ndarray:
    """Six distances between coplanar points of base and platform, each plane anywhere."""
    data = np.zeros((6, 7))
    data[:, 0] = rng.uniform(1, 2, 6)
    for columns in (slice(1, 4), slice(4, 7)):
        q = rng.normal(size=4)
        flat = np.concatenate([rng.uniform(-1, 1, (6, 2)), np.zeros((6, 1))], axis=1)
        data[:, columns] = flat @ matrix_from_quaternion(q / np.linalg.norm(q)).T + rng.normal(
            size=3
        )
    return data


@given(rng=seeds)
def test_frames_of_flat_points(rng):
    """In their frames the points lie in z = 0, at the same distances from each other; the frames
    are right-handed.
    """
    points = flat_data(rng)[:, 1:4]
    frame = plane_frame(points)
    inside = frame.coordinates(points)
    np.testing.assert_allclose(inside[:, 2], 0.0, atol=1e-13)
    apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (points, inside)]
    np.testing.assert_allclose(apart[0], apart[1], atol=1e-12)
    assert np.linalg.det(frame.rotation) == pytest.approx(1.0)


@pytest.mark.slow
@given(rng=seeds)
def test_the_reflection_keeps_the_distances(rng):
    """In any frames the reflection of flat base and platform keeps the rows of six distances, is
    its own inverse on rays, and becomes a change of signs between the planes' frames.
    """
    data, system = flat_data(rng), universal_system()
    frames = distance_frames(data)
    mirror = reflection(frames)
    z = rng.normal(size=(8, 1)) + 1j * rng.normal(size=(8, 1))
    k = data.ravel().astype(complex)
    k[::7] = rng.normal(size=6) + 1j * rng.normal(size=6)
    here, there = (system.linearise(p, k[:, None])[0] for p in (z, mirror @ z))
    np.testing.assert_allclose(np.abs(there), np.abs(here), atol=1e-10 * np.max(np.abs(here)))
    np.testing.assert_allclose(mirror @ mirror, np.eye(8), atol=1e-10)
    np.testing.assert_allclose(frames.into @ frames.back, np.eye(8), atol=1e-10)
    inner = frames.into @ mirror @ frames.back
    np.testing.assert_allclose(inner, np.diag(np.diag(inner)), atol=1e-10)


@pytest.mark.slow
@given(rng=seeds)
def test_the_reflection_is_found_among_others(rng):
    """Given as a matrix, it is taken where it holds, and refused at the points of another
    platform.
    """
    data, system = flat_data(rng), universal_system()
    mirror = reflection(distance_frames(data))

    def draw(points: np.ndarray):
        def values(inner: np.random.Generator) -> np.ndarray:
            k = points.ravel().astype(complex)
            k[::7] = inner.normal(size=6) + 1j * inner.normal(size=6)
            return k

        return values

    assert len(find_symmetries(system, draw(data), [mirror])) == 2
    assert len(find_symmetries(system, draw(flat_data(rng)), [mirror])) == 1


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-9])
def test_a_point_off_the_plane_leaves_no_mirror(off):
    """One platform point off by a thousandth of the size, or far less, breaks the reflection."""
    flat = symkin.load("zhang2009")
    first = flat.limbs[0]
    assert isinstance(first, RodLimb)
    x, y, z = first.platform
    bent = replace(
        flat,
        name="bent",
        limbs=(
            replace(first, platform=(x, y, z + off * flat.characteristic_length)),
            *flat.limbs[1:],
        ),
    )
    assert len(find_symmetries(universal_system(), lengths_only(flat))) == 2
    assert len(find_symmetries(universal_system(), lengths_only(bent))) == 1
    assert (
        distance_frames(known_values(build_problem(bent, "direct"), np.ones(6)).real.reshape(6, 7))
        is None
    )


# --- orbits ---------------------------------------------------------------------------------------


@lru_cache
def flat_start():
    problem = build_problem(symkin.load("zhang2009"), "direct")
    system = system_of(problem)
    start, _ = start_of(problem, system)
    return problem, system, start, orbits(system, case("zhang2009")[1], start.z)


def test_orbits_partition_the_roots():
    """28 roots of the flat hexapod are 14 pairs; the roots that stand for the orbits unfold to all
    roots, in order.
    """
    _, system, start, found = flat_start()
    assert found.whole
    assert np.array_equal(np.bincount(found.labels), np.full(14, 2))
    assert np.array_equal(found.labels[found.first], np.arange(14))
    unfolded = found.unfold(start.z[:, found.first])
    np.testing.assert_allclose(system.features(unfolded), system.features(start.z), atol=1e-8)


def test_orbits_say_what_is_missing():
    """Without one root of a pair its image is among no roots, and the pair's other root stands
    alone.
    """
    _, system, start, found = flat_start()
    less = orbits(system, case("zhang2009")[1], start.z[:, 1:])
    assert not less.whole
    assert len(less.first) == len(found.first)


def test_one_path_of_each_orbit_is_enough():
    """Tracked and unfolded, half of the paths give the ends of all of them."""
    problem, system, start, found = flat_start()
    target = known_values(problem, np.array(problem.mechanism.example.joints))
    everything = engine.track(system, start.z, start.k, target)
    half = found.unfold_tracked(engine.track(system, start.z[:, found.first], start.k, target))
    assert everything.arrived.all()
    assert half.arrived.all()
    np.testing.assert_allclose(system.features(half.z), system.features(everything.z), atol=1e-8)


def test_unfolding_keeps_what_paths_came_to():
    """Each root has the status of the path that stands for it."""
    _, _, _, found = flat_start()
    arrived = np.arange(14) % 3 > 0
    unfolded = found.unfold_tracked(
        tracker.Tracked(
            np.ones((8, 14), dtype=complex), arrived, np.linspace(0, 1, 14), np.full(14, 5)
        )
    )
    assert np.array_equal(unfolded.arrived, arrived[found.labels])
    assert np.array_equal(unfolded.s, np.linspace(0, 1, 14)[found.labels])


def test_the_mirror_permutes_the_modes():
    """The real modes of the flat hexapod are two and their reflections: z -> -z, and the rotation's
    axis x, y -> -x, -y.
    """
    problem, system, _, _ = flat_start()
    found = symkin.modes(problem.mechanism)
    points = []
    for mode in found:
        values = {name: np.atleast_1d(value) for name, value in mode.values.items()}
        points.append(algebraic_point(problem, system, values))
    grouped = orbits(system, case("zhang2009")[1], np.array(points).T)
    assert grouped.whole
    assert np.array_equal(np.bincount(grouped.labels), [2, 2])
    for orbit in range(2):
        a, b = (found[int(i)].position for i in np.flatnonzero(grouped.labels == orbit))
        np.testing.assert_allclose(
            a * np.array([1, 1, -1]), b, atol=1e-8 * problem.mechanism.characteristic_length
        )


def test_planar_roots_are_their_own_mirror_images():
    """The reference of a planar mechanism lies in the plane of reflection: an orbit of one, which
    unfolds to itself.
    """
    problem = build_problem(three_rrr(), "direct")
    system, symmetries, _ = case("three_rrr")
    closure = problem.closure
    values = {c.name: closure.reference[closure.slices[c.name]] for c in closure.coordinates}
    z = algebraic_point(problem, system, values)[:, None]
    grouped = orbits(system, symmetries, z)
    assert grouped.whole
    assert len(grouped.first) == 1
    np.testing.assert_allclose(grouped.unfold(z), z)


def test_a_spatial_hexapod_has_no_mirror():
    """Six points in general position on either side leave only the identity."""
    rng = np.random.default_rng(5)
    machine = hexapod(rng.uniform(-100, 100, (6, 3)), rng.uniform(-50, 50, (6, 3)))
    assert len(find_symmetries(universal_system(), lengths_only(machine))) == 1
