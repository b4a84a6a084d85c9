"""The choice of a start: a base that keeps all roots, and no base that was tried takes fewer steps
to real instances.
"""

from functools import lru_cache

import numpy as np

import symkin
from helpers.inside import (
    Fibre,
    Tracked,
    bases_beside,
    best_start,
    build_problem,
    engine,
    known_values,
    start_of,
    universal_system,
)


@lru_cache
def setting() -> tuple[Fibre, list[np.ndarray]]:
    """The generic roots of the flat hexapod, and lengths near its example."""
    problem = build_problem(symkin.load("zhang2009"), "direct")
    start, _ = start_of(problem, universal_system())
    joints, rng = np.array(problem.mechanism.example.joints), np.random.default_rng(0)
    return start, [known_values(problem, joints + rng.uniform(-20, 20, 6)) for _ in range(4)]


def test_bases_stand_beside_the_targets():
    """Bases are complex where targets differ, equal to them where they do not, and the same for the
    same seed.
    """
    _, targets = setting()
    bases = bases_beside(targets, 6, seed=3)
    geometry = np.ones(42, dtype=bool)
    geometry[::7] = False
    for base, again in zip(bases, bases_beside(targets, 6, seed=3), strict=True):
        assert np.array_equal(base, again)
        np.testing.assert_allclose(base[geometry], targets[0][geometry])
        assert np.all(np.abs(base[~geometry].imag) > 0.1)
    assert not np.allclose(bases[0], bases_beside(targets, 1, seed=4)[0])


def test_the_best_start_is_a_start_with_the_fewest_steps():
    """Its columns are all roots at its base, and no candidate took fewer steps without more
    failures.
    """
    start, targets = setting()
    system = universal_system()
    choice = best_start(system, start, bases_beside(targets, 4, seed=0), targets)
    rows, _ = system.linearise(
        choice.start.z, np.repeat(choice.start.k[:, None], choice.start.z.shape[1], axis=1)
    )
    assert np.max(np.abs(rows)) < 1e-10
    assert choice.start.z.shape == start.z.shape
    steps = np.mean(
        [engine.track(system, choice.start.z, choice.start.k, target).steps for target in targets]
    )
    assert (min(choice.failures), steps) == min(zip(choice.failures, choice.steps, strict=True))


def test_a_base_that_loses_roots_is_no_candidate():
    """Where no path reaches another base, the given start stays."""
    start, targets = setting()

    def stuck(system, roots, lines, settings=None) -> list[Tracked]:
        if any(np.array_equal(lines[0][1], target) for target in targets):
            return engine.track_lines(system, roots, lines, settings)
        none, one = np.zeros(start.z.shape[1]), np.ones(start.z.shape[1], dtype=int)
        return [Tracked(z, none > 0, none, one) for z in roots]

    choice = best_start(universal_system(), start, bases_beside(targets, 3, seed=0), targets, stuck)
    assert choice.start is start
    assert choice.steps[1:] == (np.inf,) * 3


def test_a_base_at_which_roots_merge_is_no_candidate():
    """All paths arrive, two of them at one root: what is left is no whole start."""
    start, targets = setting()

    def merged(system, roots, lines, settings=None) -> list[Tracked]:
        if any(np.array_equal(lines[0][1], target) for target in targets):
            return engine.track_lines(system, roots, lines, settings)
        moved = [np.hstack([z[:, :1], z[:, :1], z[:, 2:]]) for z in roots]
        one = np.ones(start.z.shape[1], dtype=int)
        return [Tracked(z, one > 0, one, one) for z in moved]

    choice = best_start(
        universal_system(), start, bases_beside(targets, 3, seed=0), targets, merged
    )
    assert choice.start is start
    assert choice.steps[1:] == (np.inf,) * 3


def test_orbits_of_operation_modes_go_with_the_roots():
    """Roots keep their order, so that what was known of each still belongs to it."""
    start, targets = setting()
    choice = best_start(universal_system(), start, bases_beside(targets, 2, seed=1), targets)
    back = engine.track(universal_system(), choice.start.z, choice.start.k, start.k)
    assert back.arrived.all()
    np.testing.assert_allclose(
        universal_system().features(back.z), universal_system().features(start.z), atol=1e-7
    )
    assert np.array_equal(choice.start.orbits, start.orbits)
