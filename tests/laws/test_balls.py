"""Ball arithmetic over graphs: enclosures hold what they enclose, values and derivatives alike."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from flint import arb, fmpq
from hypothesis import given
from hypothesis import strategies as st

from helpers.inside import (
    COMPLEX,
    REAL,
    AlgebraicSystem,
    BallFunction,
    BallSystem,
    precision,
    upper,
)
from helpers.samples import seeds


def exact(function: ca.Function, *inputs: list[Fraction]) -> list[Fraction]:
    """A rational graph in rational arithmetic, each constant the double that it is; the first
    input's derivative follows as dual numbers: entries are (value, gradient).
    """
    width = len(inputs[0])
    work, out = {}, {}
    for i in range(function.n_instructions()):
        op, a, o = (
            function.instruction_id(i),
            function.instruction_input(i),
            function.instruction_output(i),
        )
        if op == ca.OP_INPUT:
            gradient = [Fraction(int(a[0] == 0 and j == a[1])) for j in range(width)]
            work[o[0]] = (inputs[a[0]][a[1]], gradient)
        elif op == ca.OP_CONST:
            work[o[0]] = (Fraction(function.instruction_constant(i)), [Fraction(0)] * width)
        elif op == ca.OP_OUTPUT:
            out[o[1]] = work[a[0]]
        else:
            work[o[0]] = _operation(op, *(work[j] for j in a))
    return [out.get(i, (Fraction(0), [Fraction(0)] * width)) for i in range(function.nnz_out(0))]


def _operation(op, x, y=None):
    f, g = x[0], (y[0] if y else None)
    both = list(zip(x[1], y[1] if y else x[1], strict=True))
    match op:
        case ca.OP_ADD:
            return f + g, [a + b for a, b in both]
        case ca.OP_SUB:
            return f - g, [a - b for a, b in both]
        case ca.OP_MUL:
            return f * g, [a * g + f * b for a, b in both]
        case ca.OP_DIV:
            return f / g, [(a * g - f * b) / g**2 for a, b in both]
        case ca.OP_SQ:
            return f * f, [2 * f * a for a, _ in both]
        case ca.OP_TWICE:
            return 2 * f, [2 * a for a, _ in both]
        case ca.OP_NEG:
            return -f, [-a for a, _ in both]
        case ca.OP_INV:
            return 1 / f, [-a / f**2 for a, _ in both]
    raise AssertionError(op)


def random_graph(rng: np.random.Generator, z: ca.SX, k: ca.SX, *, quadratic: bool = False) -> ca.SX:
    """Rational expressions with constants such as 0.1 and 1 / 3 that double precision does not
    hold.
    """
    if quadratic:
        a, b, c = rng.normal(size=(3, 3, 3)), rng.normal(size=(3, 3)) / 3, rng.normal(size=3) / 7
        forms = [
            ca.bilin(ca.DM(a[i]), z, z) * k[0] + ca.dot(ca.DM(b[i]), z) / (1 + k[1] ** 2)
            for i in range(3)
        ]
        return ca.vertcat(*(form + c[i] * k[1] for i, form in enumerate(forms)))
    nodes = [z[0], z[1], z[2], k[0], k[1]]
    for _ in range(12):
        x, y = (nodes[i] for i in rng.integers(len(nodes), size=2))
        constant = float(rng.choice([0.1, 1 / 3, -2.7, 5.0, 0.2]))
        nodes.append(
            [
                x + constant * y,
                x * y,
                constant * x - y,
                x / (7 + y * y),
                constant * (0.3 * x),
                x * x,
            ][rng.integers(6)]
        )
    return ca.vertcat(*nodes[-3:])


def holds(ball: arb, value: Fraction) -> bool:
    with precision(4000):  # python-flint rounds a fraction to a ball before it compares
        return bool(ball.contains(fmpq(value.numerator, value.denominator)))


@pytest.mark.slow
@given(seeds, st.booleans(), st.sampled_from([0.0, 1e-12, 0.1]))
def test_balls_hold_the_exact_values_and_derivatives(rng, quadratic, radius):
    """Over a box, the enclosures of F and dF/dz hold the rational values at any point of the box,
    for real and complex boxes, by the graph and by the coefficients of quadratic rows.
    """
    z, k = ca.SX.sym("z", 3), ca.SX.sym("k", 2)
    system = AlgebraicSystem(1.0, (), z, k, random_graph(rng, z, k, quadratic=quadratic), ())
    centre, known = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 2)
    point = [
        Fraction(c) + Fraction(radius) * Fraction(float(s))
        for c, s in zip(centre, rng.uniform(-1, 1, 3), strict=True)
    ]
    expected = exact(
        ca.Function("f", [z, k], [ca.densify(system.rows)]), point, [Fraction(v) for v in known]
    )
    balls = BallSystem(system, tuple(known.tolist()))
    for ring in (REAL, COMPLEX):
        box = [ring.number(c) + ring.around_zero(radius) for c in centre.tolist()]
        rows, slope = (
            [ring.number(f) for f in part]
            for part in (balls.rows(ring, box), balls.jacobian(ring, box))
        )
        assert all(
            holds(f.real, value) and f.imag.contains(0)
            for f, (value, _) in zip(rows, expected, strict=True)
        )
        gradients = [d for _, gradient in expected for d in gradient]
        assert all(
            holds(f.real, value) and f.imag.contains(0)
            for f, value in zip(slope, gradients, strict=True)
        )


def test_derivatives_are_of_the_exact_constants():
    """d/dz of 0.1 sin(0.3 z) at 0 is the exact product of the two doubles; CasADi's own derivative
    holds their rounded product.
    """
    z = ca.SX.sym("z")
    function = BallFunction(z, ca.SX(0, 1), 0.1 * ca.sin(0.3 * z), ("slope",))
    with precision(256):
        (slope,) = function.evaluate(0, [arb(0)], function.prepare(REAL, ()))
        assert holds(slope, Fraction(0.1) * Fraction(0.3))
        assert not slope.contains(arb(0.1 * 0.3))


def test_a_root_across_its_cut_has_no_value():
    """The square root is not analytic on a ball that meets the negative axis: nothing can be proved
    there.
    """
    z = ca.SX.sym("z")
    function = BallFunction(z, ca.SX(0, 1), ca.sqrt(z))
    (crossing,) = function.evaluate(
        0, [COMPLEX.number(-1.0) + COMPLEX.around_zero(1e-3)], function.prepare(COMPLEX, ())
    )
    (beside,) = function.evaluate(
        0, [COMPLEX.number(1.0) + COMPLEX.around_zero(1e-3)], function.prepare(COMPLEX, ())
    )
    assert not crossing.is_finite()
    assert beside.contains(1)


@given(st.floats(-4, 4), st.floats(-4, 4), st.sampled_from([0.0, 1e-9, 0.05]))
def test_the_angle_of_a_direction_is_continuous(x, y, radius):
    """atan2 over a box that misses the origin is thin, also across the negative axis, and right
    modulo whole turns.
    """
    if np.hypot(x, y) < 0.2:
        return
    z = ca.SX.sym("z", 2)
    function = BallFunction(z, ca.SX(0, 1), ca.atan2(z[0], z[1]))
    (angle,) = function.evaluate(0, [arb(y, radius), arb(x, radius)], function.prepare(REAL, ()))
    assert upper(angle.rad()) <= 2 * radius / np.hypot(x, y) + 1e-12
    assert (angle.cos() * arb(y) - angle.sin() * arb(x)).contains(0)


def test_precision_comes_back():
    """Work at other bits leaves the caller's precision as it was, also through an error."""
    from flint import ctx

    before = ctx.prec
    try:
        with precision(300):
            assert ctx.prec == 300
            raise KeyError
    except KeyError:
        assert ctx.prec == before
