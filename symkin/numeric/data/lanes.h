/* Complex numbers on lanes: one vector of real and one of imaginary parts, a path in each lane.
 *
 * Only what the vector extensions of GCC and Clang have; a machine without registers of this width gets its own.
 */
#ifndef LANES
#ifdef __AVX512F__
#define LANES 8
#else
#define LANES 4
#endif
#endif

typedef double v __attribute__((vector_size(8 * LANES)));
typedef long long mask __attribute__((vector_size(8 * LANES)));

static inline v all(double x) { return x - (v){0}; }
static inline v pick(mask yes, v a, v b) { return (v)((yes & (mask)a) | (~yes & (mask)b)); }
static inline v larger(v a, v b) { return pick(a > b, a, b); }
static inline v smaller(v a, v b) { return pick(a < b, a, b); }

static inline int any(mask lanes)
{
    long long found = 0;
    for (int i = 0; i < LANES; i++)
        found |= lanes[i];
    return found != 0;
}

static inline v root(v x)
{
    v r;
    for (int i = 0; i < LANES; i++)
        r[i] = __builtin_sqrt(x[i]);
    return r;
}

/* Adding it rounds a number below 2^51 to an integer, which then stands in the low bits. */
#define ROUND 6755399441055744.0

/* sin x and cos x: x = n pi/2 + r with |r| <= pi/4, Taylor polynomials in r; for |x| below about 1e5. */
static inline void real_sin_cos(v x, v *sine, v *cosine)
{
    v shifted = x * 0.63661977236758134308 + ROUND, n = shifted - ROUND;
    mask quarter = (mask)shifted;
    v r = x - n * 1.5707963267341256142;
    r = r - n * 6.0771005063039659765e-11;
    r = r - n * 2.0222662487959505738e-21;
    v y = r * r, s = all(-7.6471637318198164759e-13), c = all(4.7794773323873852974e-14);
    s = s * y + 1.6059043836821614599e-10;
    s = s * y - 2.5052108385441718775e-08;
    s = s * y + 2.7557319223985890653e-06;
    s = s * y - 1.9841269841269841270e-04;
    s = s * y + 8.3333333333333333333e-03;
    s = s * y - 1.6666666666666666667e-01;
    s = r + r * (y * s);
    c = c * y - 1.1470745597729724714e-11;
    c = c * y + 2.0876756987868098979e-09;
    c = c * y - 2.7557319223985890653e-07;
    c = c * y + 2.4801587301587301587e-05;
    c = c * y - 1.3888888888888888889e-03;
    c = c * y + 4.1666666666666666667e-02;
    c = 1.0 + y * (c * y - 0.5);
    mask odd = -(quarter & 1);
    *sine = (v)((mask)pick(odd, c, s) ^ ((quarter & 2) << 62));
    *cosine = (v)((mask)pick(odd, s, c) ^ (((quarter + 1) & 2) << 62));
}

/* e^x = 2^n e^r with |r| <= log(2)/2, Taylor polynomial in r; x is held within 700 of zero. */
static inline v real_exp(v x)
{
    x = smaller(larger(x, all(-700.0)), all(700.0));
    v shifted = x * 1.4426950408889634074 + ROUND, n = shifted - ROUND;
    v r = x - n * 6.93147180369123816490e-01;
    r = r - n * 1.90821492927058770002e-10;
    v p = all(1.6059043836821614599e-10);
    p = p * r + 2.0876756987868098979e-09;
    p = p * r + 2.5052108385441718775e-08;
    p = p * r + 2.7557319223985890653e-07;
    p = p * r + 2.7557319223985890653e-06;
    p = p * r + 2.4801587301587301587e-05;
    p = p * r + 1.9841269841269841270e-04;
    p = p * r + 1.3888888888888888889e-03;
    p = p * r + 8.3333333333333333333e-03;
    p = p * r + 4.1666666666666666667e-02;
    p = p * r + 1.6666666666666666667e-01;
    p = 1.0 + (r + (r * r) * (p * r + 0.5));
    return (v)((mask)p + ((mask)shifted << 52));
}

/* sin(x + iy) = sin x cosh y + i cos x sinh y and cos(x + iy) = cos x cosh y - i sin x sinh y */
static inline void sin_cos(v x, v y, v *sr, v *si, v *cr, v *ci)
{
    v s, c, e = real_exp(y), d = 1.0 / e, cosh = 0.5 * (e + d), sinh = 0.5 * (e - d);
    real_sin_cos(x, &s, &c);
    *sr = s * cosh, *si = c * sinh, *cr = c * cosh, *ci = -(s * sinh);
}

static inline void exponential(v x, v y, v *er, v *ei)
{
    v s, c, e = real_exp(x);
    real_sin_cos(y, &s, &c);
    *er = e * c, *ei = e * s;
}

/* The root whose real part is not negative. */
static inline void square_root(v x, v y, v *rr, v *ri)
{
    v length = root(x * x + y * y), a = root(0.5 * larger(length + x, all(0.0))), b = root(0.5 * larger(length - x, all(0.0)));
    *rr = a, *ri = pick(y < 0.0, -b, b);
}
