"""Arithmetic of discs: a result holds the exact results for all numbers in its operands, in C and
by balls; and what cannot be bounded is said to be unbounded.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from flint import acb, arb
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.gate import in_gate
from helpers.inside import (
    COMPLEX,
    REAL,
    BallFunction,
    DiscFunction,
    Discs,
    build_tape,
    precision,
    shared_library,
)
from helpers.samples import seeds

UNIT = 2.0**-53
engines = pytest.mark.parametrize("engine", ["compiled", "numpy"])
compiled = pytest.mark.parametrize("engine", ["compiled"])
EXTREMES = [
    0.0,
    -0.0,
    5e-324,
    1e-310,
    1e-300,
    1e-160,
    1e-20,
    1.0,
    -3.0,
    1e20,
    1e160,
    1e300,
    1.7e308,
    np.inf,
    -np.inf,
    np.nan,
]


@pytest.fixture(autouse=True)
def chosen_engine(request, monkeypatch):
    """The arithmetic that a test names."""
    engine = (
        request.node.callspec.params.get("engine") if hasattr(request.node, "callspec") else None
    )
    if engine == "numpy":
        monkeypatch.setenv("SYMKIN_ENGINE", "numpy")
    else:
        monkeypatch.delenv("SYMKIN_ENGINE", raising=False)
        if engine == "compiled" and shared_library() is None:
            pytest.skip("no C compiler")


def random_graph(rng: np.random.Generator, z: ca.SX, k: ca.SX, operations: int = 14) -> ca.SX:
    """A graph of all operations that tapes have, but angles."""
    nodes = [*ca.vertsplit(z), *ca.vertsplit(k)]
    for _ in range(operations):
        x, y = (nodes[i] for i in rng.integers(len(nodes), size=2))
        forms = [
            x + y,
            x - y,
            x * y,
            x * x,
            -x,
            x + x,
            1 / (x - 3),
            x / (y + 2.5),
            ca.sin(x),
            ca.cos(y),
            ca.sqrt(x + 4),
            0.1 * x,
            ca.exp(ca.sin(x)),
            ca.tan(0.2 * x),
        ]
        nodes.append(forms[rng.integers(len(forms))])
    return ca.vertcat(*nodes[-4:])


def somewhere(rng: np.random.Generator, discs: Discs, *, inside: float = 0.9) -> np.ndarray:
    """Numbers within the discs, half of them near the rim, and away from it by more than their own
    rounding.
    """
    turn = np.exp(2j * np.pi * rng.uniform(size=discs.middle.shape))
    turn = np.sign(turn.real) if discs.is_real else turn
    return discs.middle + inside * discs.radius * turn * rng.choice(
        [1.0, 0.3], size=discs.middle.shape
    )


def exact_values(function: BallFunction, z: np.ndarray, k: np.ndarray, *, real: bool) -> list[acb]:
    ring = REAL if real else COMPLEX
    with precision(4000):
        numbers = [
            [ring.number(v) if real else ring.number(v.real, v.imag) for v in x.tolist()]
            for x in (z, k)
        ]
        values = function.evaluate(0, numbers[0], function.prepare(ring, numbers[1]))
        return [acb(v) for v in values]


def holds(middle: complex, radius: float, value: acb) -> bool:
    """Whether a disc holds a number; one without bounds holds all."""
    if not (np.isfinite(radius) and np.isfinite(middle)):
        return True
    with precision(4000):
        away = value - acb(middle.real, middle.imag)
        return bool(abs(away) <= arb(radius)) or not value.is_finite()


@pytest.mark.slow
@engines
@settings(max_examples=30, deadline=None)
@given(seeds, st.booleans(), st.sampled_from([0.0, 1e-14, 1e-9, 1e-3]))
def test_discs_hold_the_exact_values(engine, rng, real, radius):
    """Of a random graph, for points and known values anywhere in their discs."""
    z, k = ca.SX.sym("z", 3), ca.SX.sym("k", 2)
    f = random_graph(rng, z, k)
    function, kind = DiscFunction(build_tape(z, k, f, ("value",))), float if real else complex
    middles = (rng.normal(size=(5, 5)) + (0 if real else 0.3j) * rng.normal(size=(5, 5))).astype(
        kind
    )
    points, known = (
        Discs(m, radius * rng.uniform(0.5, 1, m.shape)) for m in (middles[:, :3], middles[:, 3:])
    )
    values = function.evaluate(0, points, function.prepare(known), np.arange(5))
    balls = BallFunction(z, k, f)
    bounded = 0
    for i in range(5):
        place = [somewhere(rng, d) if radius else d.middle for d in (points, known)]
        for j, value in enumerate(exact_values(balls, place[0][i], place[1][i], real=real)):
            assert holds(complex(values.middle[i, j]), float(values.radius[i, j]), value)
            bounded += bool(np.isfinite(values.radius[i, j]))
    assert bounded or radius > 1e-9


@pytest.mark.slow
@engines
@pytest.mark.parametrize("radius", in_gate([0.0, 1e-310, 1e-16, 1.0], [1e-310, 1.0]))
@pytest.mark.parametrize("real", [True, False])
def test_extreme_numbers_are_held_or_unbounded(engine, radius, real):
    """Zeros, subnormal, huge and missing numbers, each with each: no operation states a bound that
    is false.
    """
    z, k = ca.SX.sym("z", 2), ca.SX(0, 1)
    a, b = z[0], z[1]
    of_a = [a * a, ca.sqrt(a), ca.sin(a), ca.cos(a), ca.exp(a)]
    of_both = [a + b, a - b, a * b, a / b, (a * b) * (a * b), a * b * 1e300, a * b * 1e-300]
    f = ca.vertcat(*of_a, *of_both)
    uses = np.array([[True, False]] * len(of_a) + [[True, True]] * len(of_both))
    pairs = np.array([(x, y) for x in EXTREMES for y in EXTREMES])
    numbers = pairs.copy() if real else pairs.astype(complex)
    if not real:
        numbers.imag = np.where(np.isfinite(pairs[:, ::-1]), pairs[:, ::-1], 0.5)
    function = DiscFunction(build_tape(z, k, f, ("value",)))
    points = Discs(numbers, np.full(numbers.shape, radius))
    with np.errstate(all="ignore"):
        values = function.evaluate(
            0,
            points,
            function.prepare(Discs.exact(np.zeros((1, 0)))),
            np.zeros(len(pairs), dtype=int),
        )
    stated = np.isfinite(values.middle) & np.isfinite(values.radius)
    for i, given_ones in enumerate(np.isfinite(numbers)):
        assert not np.any(stated[i] & np.any(uses & ~given_ones, axis=1))
        if given_ones.all():
            exact = exact_values(BallFunction(z, k, f), numbers[i], np.zeros(0), real=real)
            for j, value in enumerate(exact):
                assert holds(complex(values.middle[i, j]), float(values.radius[i, j]), value)


@compiled
def test_sines_and_exponentials_keep_their_bounds(engine):
    """Within 8 units for sine and cosine and 8 relative units for e^x, also next to multiples of
    pi / 2 and log 2, to the largest arguments that are allowed.
    """
    rng = np.random.default_rng(0)
    z = ca.SX.sym("z")
    function = DiscFunction(
        build_tape(z, ca.SX(0, 1), ca.vertcat(ca.sin(z), ca.cos(z), ca.exp(z)), ("value",))
    )
    near = np.concatenate(
        [np.arange(-40, 40) * np.pi / 4, rng.integers(-60000, 60000, 40) * np.pi / 2]
    )
    x = np.concatenate(
        [
            rng.uniform(-7, 7, 400),
            rng.uniform(-1e5, 1e5, 100),
            near,
            near + 1e-9,
            [0.0, 1e-300, 99999.0, -99999.0],
        ]
    )
    x = np.concatenate([x, rng.uniform(-299, 299, 100), np.arange(-50, 50) * np.log(2) / 2])
    values = function.evaluate(
        0,
        Discs.exact(x[:, None]),
        function.prepare(Discs.exact(np.zeros((1, 0)))),
        np.zeros(len(x), dtype=int),
    )
    with precision(200):
        for i, v in enumerate(x.tolist()):
            for j, true in enumerate((arb(v).sin(), arb(v).cos(), arb(v).exp())):
                scale = float(true) if j == 2 else 1.0
                if j < 2 or abs(v) < 300.0:
                    assert abs(float(arb(values.middle[i, j]) - true)) <= 4 * UNIT * scale
                    assert 8 * UNIT * scale <= values.radius[i, j] <= 40 * UNIT * scale


@compiled
def test_no_bound_beyond_the_range_of_the_functions(engine):
    """Sines of huge angles, logarithms' ends, roots across the cut and inverses of zero have no
    bound.
    """
    z = ca.SX.sym("z")
    function = DiscFunction(
        build_tape(z, ca.SX(0, 1), ca.vertcat(ca.sin(z), ca.exp(z), ca.sqrt(z), 1 / z), ("value",))
    )
    nothing = function.prepare(Discs.exact(np.zeros((1, 0))))

    def unbounded(number, radius=0.0):
        values = function.evaluate(
            0, Discs(np.array([[number]]), np.array([[radius]])), nothing, np.zeros(1, dtype=int)
        )
        return (~np.isfinite(values.radius[0])).tolist()

    assert unbounded(2e5) == [True, True, False, False]
    assert unbounded(400.0) == [False, True, False, False]
    assert unbounded(1.0, 1.5) == [True, True, True, True]
    assert unbounded(-1.0) == [False, False, True, False]
    assert unbounded(-1.0 + 0.1j, 0.2) == [False, False, True, False]
    assert unbounded(-1.0 + 0.3j, 0.2) == [False, False, False, False]
    assert unbounded(0.0) == [False, False, True, True]
    assert unbounded(1e160) == [True, True, True, True]


@settings(max_examples=30, deadline=None)
@given(seeds, st.booleans())
def test_c_and_balls_agree(rng, real):
    """Discs of both engines meet, and those of balls are as narrow, but for a square about a disc
    in each of several steps.
    """
    if shared_library() is None:
        pytest.skip("no C compiler")
    z, k = ca.SX.sym("z", 3), ca.SX.sym("k", 2)
    function = DiscFunction(build_tape(z, k, random_graph(rng, z, k), ("value", "slope")))
    m = rng.normal(size=(11, 5)) + (0 if real else 0.3j * rng.normal(size=(11, 5)))
    points, known = Discs(m[:, :3], np.full((11, 3), 1e-10)), Discs.exact(m[:, 3:])
    for part in (0, 1):
        results = []
        for engine in ("", "numpy"):
            with pytest.MonkeyPatch.context() as patch:
                patch.setenv("SYMKIN_ENGINE", engine)
                results.append(
                    function.evaluate(part, points, function.prepare(known), np.arange(11))
                )
        first, second = results
        fine = np.isfinite(first.radius)
        assert np.isfinite(second.radius[fine]).all()
        apart = np.abs(first.middle - second.middle)
        assert np.all(apart[fine] <= (first.radius + second.radius)[fine])
        assert np.all(second.radius[fine] <= 10.0 * first.radius[fine])


@engines
@given(st.floats(-4, 4), st.floats(-3, 3), st.sampled_from([0.0, 1e-12, 1e-3]), seeds)
def test_angles_are_held_modulo_turns(engine, angle, exponent, radius, rng):
    """atan2 of two real discs holds the angle of any point in them."""
    z = ca.SX.sym("z", 2)
    function = DiscFunction(build_tape(z, ca.SX(0, 1), ca.atan2(z[0], z[1]), ("value",)))
    size = 10.0**exponent
    discs = Discs(size * np.array([[np.sin(angle), np.cos(angle)]]), np.full((1, 2), radius * size))
    value = function.evaluate(
        0, discs, function.prepare(Discs.exact(np.zeros((1, 0)))), np.zeros(1, dtype=int)
    )
    y, x = somewhere(rng, discs)[0]
    with precision(200):
        away = float(arb.atan2(arb(y), arb(x)) - arb(value.middle[0, 0]))
    assert (
        abs(away - 2 * np.pi * round(away / (2 * np.pi))) <= value.radius[0, 0] * (1 + 1e-9) + 1e-15
    )
    assert value.radius[0, 0] < 6 * (radius + 1e-14)
