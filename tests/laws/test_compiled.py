"""The compiled engine: the same roots as the vectorised one, failures that are seen, and no
compiler that is required.
"""

import os
import stat
import subprocess
import sys
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.gate import in_gate_but
from helpers.inside import (
    AlgebraicSystem,
    CompilerError,
    Coordinate,
    TrackSettings,
    build_problem,
    compiled,
    find_compilers,
    follow_somehow,
    start_of,
    structure_groups,
    system_of,
    tracker,
)
from helpers.samples import five_bar


def has_compiler() -> bool:
    try:
        next(find_compilers(os.environ.get("CC", ""), os.environ.get("PATH", "")))
    except CompilerError:
        return False
    return True


pytestmark = pytest.mark.skipif(not has_compiler(), reason="no C compiler")
MACHINES = [
    ("zhang2009", "direct"),
    ("zhao2000", "direct"),
    ("zhao2000_links", "direct"),
    ("gluon_6l3", "inverse"),
]


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    """A cache of this module's own, and the compiled engine on."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMKIN_CACHE", str(folder))
        patch.delenv("SYMKIN_ENGINE", raising=False)
        yield folder


@lru_cache(maxsize=8)
def machine(name, kind):
    """The system of a mechanism's first block and its generic roots."""
    whole = build_problem(five_bar() if name == "five_bar" else symkin.load(name), kind)
    problem = structure_groups(whole)[0]
    system = system_of(problem)
    start, reason = start_of(problem, system)
    assert start is not None, reason
    return system, start


def engine(system):
    found, reason = compiled.load(system)
    assert found is not None, reason
    return found


def small(rows, z, k):
    """A system without a mechanism; unknowns are lengths."""
    unknowns = tuple(Coordinate(f"x{i}", "length", "passive") for i in range(z.shape[0]))
    return AlgebraicSystem(1.0, unknowns, z, k, ca.vertcat(*rows), ())


def square():
    """z^2 = k."""
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    return small([z**2 - k], z, k)


def complex_normal(rng, *shape):
    return (rng.normal(size=shape) + 1j * rng.normal(size=shape)) / np.sqrt(2)


def farthest(system, a, b):
    """Largest distance of a root of either set to the nearest of the other one."""
    f, g = system.features(a), system.features(b)
    apart = np.max(np.abs(f[:, None] - g[None]), axis=2)
    return max(apart.min(axis=0).max(), apart.min(axis=1).max())


# --- agreement ------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("end", ["real", "complex"])
@pytest.mark.parametrize(
    ("name", "kind"),
    in_gate_but(
        [*MACHINES, ("five_bar", "direct")],
        [("zhao2000_links", "direct"), ("zhao2000", "direct"), ("five_bar", "direct")],
    ),
)
def test_both_engines_reach_the_same_roots(name, kind, end):
    """All paths of an instance arrive in either engine, path by path at the same root."""
    system, start = machine(name, kind)
    move = 0.5 * complex_normal(np.random.default_rng(3), len(start.k))
    target = start.k.real + 0.3 * move.real if end == "real" else start.k + move
    ours, theirs = (
        engine(system).track(start.z, start.k, target),
        tracker.track(system, start.z, start.k, target),
    )
    assert ours.arrived.all()
    assert theirs.arrived.all()
    a, b = (tracker.newton(system, tracked.z, target)[0] for tracked in (ours, theirs))
    np.testing.assert_allclose(system.features(a), system.features(b), atol=1e-9)
    polished, last = engine(system).newton(ours.z, target)
    assert np.max(last) < 1e-9
    np.testing.assert_allclose(system.features(polished), system.features(a), atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), [("zhang2009", "direct"), ("gluon_6l3", "inverse")])
def test_the_way_back_ends_where_it_began(name, kind):
    """A path and its reverse are one curve."""
    system, start = machine(name, kind)
    target = start.k + 0.5 * complex_normal(np.random.default_rng(4), len(start.k))
    there = engine(system).track(start.z, start.k, target)
    back = engine(system).track(there.z, target, start.k)
    assert there.arrived.all()
    assert back.arrived.all()
    np.testing.assert_allclose(system.features(back.z), system.features(start.z), atol=1e-8)


def test_paths_may_have_known_values_of_their_own():
    """Known values (known, n) are n separate problems."""
    system, rng = square(), np.random.default_rng(5)
    begin, end = complex_normal(rng, 1, 21), complex_normal(rng, 1, 21)
    z = np.sqrt(begin)
    together = engine(system).track(z, begin, end)
    for i in range(21):
        alone = engine(system).track(z[:, [i]], begin[:, i], end[:, i])
        assert together.arrived[i] == alone.arrived[0]
        np.testing.assert_allclose(together.z[:, i], alone.z[:, 0], atol=1e-12)
    np.testing.assert_allclose(together.z[0] ** 2, end[0], atol=1e-9)


FUNCTIONS = {
    "sin": (ca.sin, np.sin),
    "cos": (ca.cos, np.cos),
    "tan": (ca.tan, np.tan),
    "sin of -x": (lambda x: ca.sin(-x), lambda x: -np.sin(x)),
    "exp": (ca.exp, np.exp),
    "sqrt": (ca.sqrt, np.sqrt),
    "quotient": (lambda x: (1 + x) / (2 - x), lambda x: (1 + x) / (2 - x)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_of_lanes_are_the_complex_functions(name):
    """One Newton step on z - f(k) from zero gives f(k)."""
    ours, theirs = FUNCTIONS[name]
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    rng = np.random.default_rng(6)
    known = np.concatenate([complex_normal(rng, 1, 300) * s for s in (1e-9, 0.1, 1.0, 4.0)], axis=1)
    known = np.concatenate(
        [known, 10.0 * rng.normal(size=(1, 300)) + 1j * rng.normal(size=(1, 300))], axis=1
    )
    found, _ = engine(small([z - ours(k)], z, k)).newton(np.zeros_like(known), known, 2)
    expected = theirs(known)
    assert np.max(np.abs(found - expected) / (np.abs(expected) + 1e-3)) < 1e-12


# --- failures -------------------------------------------------------------------------------------


def test_paths_that_merge_do_not_arrive():
    """At a double root the derivative of the path is infinite: both stop short of the end, at
    finite points.
    """
    tracked = engine(square()).track(
        np.sqrt(np.array([[0.6 + 0.8j]])) * [[1, -1]], np.array([0.6 + 0.8j]), np.zeros(1)
    )
    assert not tracked.arrived.any()
    assert np.all((tracked.s > 0.9) & (tracked.s < 1.0))
    np.testing.assert_allclose(tracked.z**2, [(0.6 + 0.8j) * (1 - tracked.s)], atol=1e-7)


def test_a_path_through_a_double_root_stops_there():
    """From k = 1 to -1 through 0 along the real line no path may jump the branch point, whose roots
    are lost.
    """
    tracked = engine(square()).track(np.array([[1.0, -1.0]]), np.array([1.0]), np.array([-1.0]))
    assert not tracked.arrived.any()
    assert np.all(tracked.s < 0.5 + 1e-8)


def test_numbers_that_are_not_finite_spoil_only_their_own_path():
    """NaN and infinity do not arrive; their neighbours in the lanes do, at the same points as
    without them.
    """
    system, start = machine("zhang2009", "direct")
    target = start.k + 0.3 * complex_normal(np.random.default_rng(7), len(start.k))
    z = start.z[:, :9].copy()
    whole = engine(system).track(z, start.k, target)
    z[2, 1], z[0, 4] = np.nan, np.inf
    spoiled = engine(system).track(z, start.k, target)
    healthy = ~np.isin(np.arange(9), [1, 4])
    assert not spoiled.arrived[~healthy].any()
    assert spoiled.arrived[healthy].all()
    np.testing.assert_array_equal(spoiled.z[:, healthy], whole.z[:, healthy])
    assert not engine(system).track(start.z, start.k, target * np.nan).arrived.any()


def test_steps_are_bounded():
    """No path takes more steps than are allowed; those that would need more have not arrived."""
    system, start = machine("zhang2009", "direct")
    tracked = engine(system).track(start.z, start.k, start.k + 1.0, TrackSettings(most_steps=3))
    assert tracked.steps <= 3
    assert not tracked.arrived.any()


def test_long_ways_that_are_given_up_are_not_followed_twice(monkeypatch):
    """Where the compiled engine needs thousands of steps NumPy does too: of the PR2's gripper it
    took twenty times as long to come as far.
    """
    system, start = machine("zhang2009", "direct")
    monkeypatch.setattr(tracker, "track", lambda *_: pytest.fail("followed twice"))
    end, settings = start.k + 1e4, TrackSettings(smallest_step=1e-14)
    long = engine(system).track(start.z, start.k, end, settings).tries == settings.most_steps
    assert long.any()
    assert not follow_somehow(system, start.z[:, long], start.k, end, settings)[1].any()


def test_rows_that_contradict_each_other_at_the_end_are_seen():
    """z = k1 and z = k2 have a root only where k1 = k2, whatever combination of the rows is
    tracked.
    """
    z, k = ca.SX.sym("z"), ca.SX.sym("k", 2)
    follow = engine(small([z - k[0], z - k[1]], z, k))
    begin = np.array([1.0 + 1j, 1.0 + 1j])
    assert follow.track(np.array([[1.0 + 1j]]), begin, np.array([2.0, 2.0])).arrived.all()
    assert not follow.track(np.array([[1.0 + 1j]]), begin, np.array([2.0, 2.1])).arrived.any()
    assert np.isinf(follow.newton(np.array([[1.0 + 1j]]), np.array([2.0, 2.1]))[1]).all()


def test_arrays_that_do_not_fit_are_refused():
    """Nothing reaches C that it would read beyond its end."""
    follow = engine(square())
    with pytest.raises(ValueError, match="unknowns"):
        follow.track(np.ones((2, 1)), np.ones(1), np.ones(1))
    with pytest.raises(ValueError, match="known values"):
        follow.track(np.ones((1, 1)), np.ones(1), np.ones(2))
    assert follow.track(np.ones((1, 0)), np.ones(1), np.ones(1)).arrived.shape == (0,)


# --- compilers and the cache ----------------------------------------------------------------------


def script(folder, text):
    """An executable that stands for a compiler."""
    path = folder / "compiler"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.mark.parametrize("named", ["/bin/false", "/no/such/compiler", "'unbalanced", "true"])
def test_a_compiler_that_fails_gives_a_reason(monkeypatch, named):
    """No exception and no other compiler than the one named: None and a sentence about it."""
    monkeypatch.setenv("CC", named)
    found, reason = compiled.load(square())
    assert found is None
    assert named.strip("'") in reason


def test_a_compiler_that_fails_on_the_source_gives_its_message(monkeypatch, tmp_path):
    """One that answers questions but compiles nothing."""
    real = next(find_compilers("", os.environ["PATH"])).command[0]
    fails = script(
        tmp_path, f'case "$*" in *-dM*) exec {real} "$@";; esac; echo "disk is full" >&2; exit 4'
    )
    monkeypatch.setenv("CC", fails)
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path / "cache"))
    found, reason = compiled.load(square())
    assert found is None
    assert "status 4: disk is full" in reason


def test_a_compiler_that_hangs_is_waited_for_once(monkeypatch, tmp_path, caplog):
    """A short wait, a sentence, and no second try, whatever is to be compiled."""
    monkeypatch.setattr(inside.c_library, "_ANSWERS_S", 0.2)
    calls = tmp_path / "calls"
    monkeypatch.setenv("CC", script(tmp_path, f'echo >> "{calls}"; exec sleep 60'))
    for system in (square(), machine("zhang2009", "direct")[0]):
        found, reason = compiled.load(system)
        assert found is None
        assert "has not answered" in reason
    assert calls.read_text() == "\n"
    assert [record.levelname for record in caplog.records] == ["WARNING"]


def test_without_a_compiler_there_is_a_reason(monkeypatch):
    """An empty PATH."""
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    found, reason = compiled.load(square())
    assert found is None
    assert "no C compiler" in reason


@pytest.mark.slow
def test_flags_for_the_processor_are_dropped_where_they_are_refused(monkeypatch, tmp_path):
    """Code for any processor of the architecture gives the same roots."""
    system, start = machine("zhao2000", "direct")
    target = start.k + 0.3 * complex_normal(np.random.default_rng(8), len(start.k))
    native = engine(system).track(start.z, start.k, target)
    real = next(find_compilers("", os.environ["PATH"])).command[0]
    monkeypatch.setenv(
        "CC", script(tmp_path, f'case "$*" in *-march=native*) exit 1;; esac; exec {real} "$@"')
    )
    plain = engine(system).track(start.z, start.k, target)
    assert native.arrived.all()
    assert plain.arrived.all()
    np.testing.assert_allclose(system.features(plain.z), system.features(native.z), atol=1e-9)


def test_the_engine_can_be_turned_off(monkeypatch):
    """SYMKIN_ENGINE=numpy."""
    monkeypatch.setenv("SYMKIN_ENGINE", "numpy")
    found, reason = compiled.load(square())
    assert found is None
    assert "SYMKIN_ENGINE" in reason


def test_nothing_is_built_that_was_not_asked_for(monkeypatch, tmp_path):
    """build=False finds only what the cache has, and finds it as soon as it is there."""
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    system = square()
    assert compiled.load(system, build=False)[0] is None
    assert not list(tmp_path.iterdir())
    assert compiled.load(system)[0] is not None
    assert compiled.load(system, build=False)[0] is not None


@pytest.mark.parametrize("damage", ["truncated", "other content", "a folder"])
def test_a_damaged_library_is_built_again(monkeypatch, tmp_path, damage):
    """Its name tells its content; what does not match is not loaded."""
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    engine(square())
    (library,) = tmp_path.glob("*.so")
    content = library.read_bytes()
    library.unlink()
    if damage == "a folder":
        library.mkdir()
    else:
        library.write_bytes(
            content[: len(content) // 2] if damage == "truncated" else content[:-1] + b"x"
        )
    tracked = engine(square()).track(np.ones((1, 1)), np.ones(1), np.full(1, 2.0 + 1j))
    np.testing.assert_allclose(tracked.z**2, 2.0 + 1j, atol=1e-9)


def test_a_cache_that_cannot_be_written_only_costs_time(monkeypatch, tmp_path):
    """The library is then used from where it was compiled."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path / "file" / "cache"))
    assert engine(square()).track(np.ones((1, 1)), np.ones(1), np.full(1, 2.0)).arrived.all()


BUILD = f"""
import casadi as ca, numpy as np
from {inside.where("AlgebraicSystem")} import AlgebraicSystem
from {inside.where("compiled")} import load
z, k = ca.SX.sym("z"), ca.SX.sym("k")
found, reason = load(AlgebraicSystem(1.0, (), z, k, z**2 - k, ()))
print(complex(found.track(np.ones((1, 1)), np.ones(1), np.full(1, 2.0 + 1j)).z[0, 0] ** 2))
"""


@pytest.mark.slow
def test_two_processes_may_build_at_once(tmp_path):
    """Both work, and the cache holds nothing half-written."""
    environment = {**os.environ, "SYMKIN_CACHE": str(tmp_path)}
    command = [sys.executable, "-c", BUILD]
    runs = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    for run in runs:
        out, _ = run.communicate(timeout=120)
        assert run.returncode == 0
        assert abs(complex(out.strip()) - (2.0 + 1j)) < 1e-9
    assert list(tmp_path.iterdir()) == list(tmp_path.glob("*.so"))


# --- what has no lane code ------------------------------------------------------------------------


def test_operations_without_a_complex_form_are_refused():
    """A reason, no exception."""
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    found, reason = compiled.load(small([z - ca.atan2(k, 2 * k)], z, k))
    assert found is None
    assert "no complex form" in reason


def test_too_few_rows_are_refused():
    """One row does not determine two unknowns."""
    z, k = ca.SX.sym("z", 2), ca.SX.sym("k")
    found, reason = compiled.load(small([z[0] * z[1] - k], z, k))
    assert found is None
    assert "1 rows" in reason
