/* Arithmetic of discs on lanes, and tapes of it; read twice, with COMPLEX 0 and 1.
 *
 * A disc stands for all numbers within `rad` of a middle, which is a double or a pair of doubles: real numbers with COMPLEX 0.
 * The result of an operation holds the exact results for all numbers in its operands. With u = 2^-53, roundings to nearest and
 * |x| for a bound of a middle's modulus, its radius is a bound of three things:
 *   what the operands' radii do:   sum  r + s;   product  |x| s + r |y| + r s;   inverse  r / (|x| (|x| - r))
 *   the rounding of the middle:    sum  u |m|;   product  u |m|, complex 2 sqrt(2) u |x| |y| (1 + 4 u), of which 4 u is taken
 *   underflow of the middle and of the radius: at most a few times 2^-1074, of which TINY is taken.
 * A radius is computed from numbers that are not negative by fewer than 30 operations, each with an error of at most u of its
 * result, and multiplied by UP, which is more than (1 - u)^-30. What cannot be bounded has an infinite radius; what overflows has
 * an infinite middle or none, or an infinite radius, and no comparison proves anything of it.
 */
#if COMPLEX
#define NAME(x) complex_##x
#define NUMBER 2
#else
#define NAME(x) real_##x
#define NUMBER 1
#endif

typedef struct {
    v re;
#if COMPLEX
    v im;
#endif
    v rad;
} NAME(disc);
#define disc NAME(disc)

/* A bound of the modulus: max + min / 2 of the two parts, as 3/4 (a + b) + |a - b| / 4, at most 1.12 times it. */
static inline v NAME(modulus)(const disc *x)
{
#if COMPLEX
    v a = absolute(x->re), b = absolute(x->im);
    return 0.75 * (a + b) + 0.25 * absolute(a - b);
#else
    return absolute(x->re);
#endif
}

static inline disc NAME(add)(disc x, disc y, double sign)
{
    disc m;
    m.re = x.re + sign * y.re;
#if COMPLEX
    m.im = x.im + sign * y.im;
#endif
    m.rad = (x.rad + y.rad + U * NAME(modulus)(&m)) * UP;
    return m;
}

/* By a power of two: exact. */
static inline disc NAME(scale)(disc x, double factor)
{
    x.re = factor * x.re;
#if COMPLEX
    x.im = factor * x.im;
#endif
    x.rad = __builtin_fabs(factor) * x.rad;
    return x;
}

static inline disc NAME(multiply)(disc x, disc y)
{
    disc m;
    v a = NAME(modulus)(&x), b = NAME(modulus)(&y);
#if COMPLEX
    m.re = x.re * y.re - x.im * y.im;
    m.im = x.re * y.im + x.im * y.re;
    m.rad = (a * y.rad + x.rad * (b + y.rad) + 4.0 * U * (a * b) + TINY) * UP;
#else
    m.re = x.re * y.re;
    m.rad = (a * y.rad + x.rad * (b + y.rad) + U * absolute(m.re) + TINY) * UP;
#endif
    return m;
}

/* 1 / x: of the middle, conj(x) / |x|^2, each part is computed with a relative error of at most 4 u (1 + 4 u). */
APART static disc NAME(invert)(disc x)
{
    disc m;
    v size = larger(absolute(x.re), all(0.0));
#if COMPLEX
    size = larger(size, absolute(x.im));
    v square = x.re * x.re + x.im * x.im;
    m.re = x.re / square;
    m.im = -x.im / square;
#else
    m.re = 1.0 / x.re;
#endif
    v room = size - x.rad;
    mask fine = (size > SMALLEST) & (size < LARGEST) & (room > 0.0);
    m.rad = pick(fine, (x.rad / (size * room) + 8.0 * U / size + TINY) * UP, all(INFINITY));
    return m;
}

/* The root with a real part that is not negative. Where the disc keeps away from the cut, the negative numbers and zero, no
 * slope 1 / (2 sqrt(w)) on it is larger than at |w| = |x| - r, nor, with the distance from the cut d, than 1 / (2 sqrt(d)). */
APART static disc NAME(root)(disc x)
{
    disc m;
#if COMPLEX
    v a = absolute(x.re), length = root(x.re * x.re + x.im * x.im);
    v first = root(0.5 * (length + a)), second = 0.5 * x.im / first;
    mask right = x.re > 0.0;
    v other = absolute(second);
    m.re = pick(right, first, other);
    m.im = pick(right, second, pick(x.im < 0.0, -first, first));
    v away = pick(right, larger(x.re, absolute(x.im)), absolute(x.im));
    v error = 8.0 * U * (first + other);
#else
    m.re = root(x.re);
    v away = x.re, error = U * m.re;
#endif
    v room = away - x.rad;
    mask fine = (away > SMALLEST) & (NAME(modulus)(&x) < LARGEST) & (room > 0.0);
    m.rad = pick(fine, (0.5 * x.rad / root(room) + error + TINY) * UP, all(INFINITY));
    return m;
}

/* sin x and cos x. |sin(m + d) - sin m| <= r sup |cos| <= r cosh(|Im m| + r) <= r (1 + 2 r) cosh(Im m) for r <= 1, and the same
 * for cos. The errors of `real_sin_cos` and `real_exp` are bounded in certificate.c. */
APART static void NAME(sine_cosine)(disc x, disc *sine, disc *cosine)
{
    v s, c;
    real_sin_cos(x.re, &s, &c);
#if COMPLEX
    v e = real_exp(x.im), d = 1.0 / e, cosh = 0.5 * (e + d), sinh = 0.5 * (e - d);
    sine->re = s * cosh, sine->im = c * sinh;
    cosine->re = c * cosh, cosine->im = -(s * sinh);
    v error = cosh * (32.0 * U + x.rad * (1.0 + 2.0 * x.rad));
    mask fine = (absolute(x.re) < MOST_RADIANS) & (absolute(x.im) < MOST_EXPONENT) & (x.rad < 1.0);
#else
    sine->re = s;
    cosine->re = c;
    v error = 8.0 * U + x.rad;
    mask fine = (absolute(x.re) < MOST_RADIANS) & (x.rad < 1.0);
#endif
    sine->rad = cosine->rad = pick(fine, error * UP, all(INFINITY));
}

/* e^x: |e^(m + d) - e^m| <= |e^m| (e^r - 1) <= |e^m| r (1 + 2 r) for r <= 1. */
APART static disc NAME(exponential)(disc x)
{
    disc m;
    v e = real_exp(x.re);
#if COMPLEX
    v s, c;
    real_sin_cos(x.im, &s, &c);
    m.re = e * c, m.im = e * s;
    mask fine = (absolute(x.re) < MOST_EXPONENT) & (absolute(x.im) < MOST_RADIANS) & (x.rad < 1.0);
#else
    m.re = e;
    mask fine = (absolute(x.re) < MOST_EXPONENT) & (x.rad < 1.0);
#endif
    m.rad = pick(fine, e * (32.0 * U + x.rad * (1.0 + 2.0 * x.rad)) * UP, all(INFINITY));
    return m;
}

/* The angle of (x, y), of real numbers only: the library's value t is off by an angle d with sin d = (y cos t - x sin t) / |(x, y)|,
 * whatever it is, and |d| <= 2 |sin d| if cos d > 0. Radii turn it by at most asin(s / |(x, y)|) <= 2 s / |(x, y)|, with s their
 * sum, if s is less than a quarter of |(x, y)|. */
APART static disc NAME(angle)(disc y, disc x)
{
    disc m = x;
#if COMPLEX
    m.rad = y.rad + all(INFINITY);
#else
    disc sine, cosine;
    for (int i = 0; i < LANES; i++)
        m.re[i] = atan2(y.re[i], x.re[i]);
    m.rad = all(0.0);
    NAME(sine_cosine)(m, &sine, &cosine);
    v across = absolute(y.re * cosine.re - x.re * sine.re), along = y.re * sine.re + x.re * cosine.re;
    v sum = absolute(x.re) + absolute(y.re), size = larger(absolute(x.re), absolute(y.re)), spread = x.rad + y.rad;
    mask fine = (size > SMALLEST) & (sum < LARGEST) & (along > 0.25 * size) & (spread < 0.25 * size);
    m.rad = pick(fine, (2.0 * (across + sum * (sine.rad + 4.0 * U) + spread) / size + TINY) * UP, all(INFINITY));
#endif
    return m;
}

/* Runs a tape for one block: `input` and `output` hold VECTORS vectors of discs for each entry, `place` for each place. */
APART static void NAME(run)(const struct code *code, const disc *input, disc *restrict place, disc *restrict output)
{
    const int *line = code->instructions, *end = line + 4 * code->length;
    for (; line < end; line += 4) {
        const disc *a = place + line[1] * VECTORS, *b = place + line[2] * VECTORS;
        disc *out = place + line[3] * VECTORS, unused;
        switch (line[0]) {
        case INPUT:
            memcpy(out, input + line[1] * VECTORS, VECTORS * sizeof *out);
            break;
        case CONSTANT:
            for (int i = 0; i < VECTORS; i++) {
                memset(out + i, 0, sizeof *out);
                out[i].re = all(code->constants[line[1]]);
            }
            break;
        case OUTPUT:
            memcpy(output + line[3] * VECTORS, a, VECTORS * sizeof *out);
            break;
#define EACH(expression) \
    for (int i = 0; i < VECTORS; i++) \
        expression; \
    break
        case ADD: EACH(out[i] = NAME(add)(a[i], b[i], 1.0));
        case SUBTRACT: EACH(out[i] = NAME(add)(a[i], b[i], -1.0));
        case MULTIPLY: EACH(out[i] = NAME(multiply)(a[i], b[i]));
        case SQUARE: EACH(out[i] = NAME(multiply)(a[i], a[i]));
        case NEGATE: EACH(out[i] = NAME(scale)(a[i], -1.0));
        case TWICE: EACH(out[i] = NAME(scale)(a[i], 2.0));
        case INVERT: EACH(out[i] = NAME(invert)(a[i]));
        case SINE: EACH(NAME(sine_cosine)(a[i], out + i, &unused));
        case COSINE: EACH(NAME(sine_cosine)(a[i], &unused, out + i));
        case ROOT: EACH(out[i] = NAME(root)(a[i]));
        case EXPONENTIAL: EACH(out[i] = NAME(exponential)(a[i]));
        case ANGLE: EACH(out[i] = NAME(angle)(a[i], b[i]));
#undef EACH
        }
    }
}
