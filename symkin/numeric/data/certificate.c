/* Discs and Krawczyk's test for many points at once: see discs.h and krawczyk.h. Compiled once, for all mechanisms.
 *
 * Nothing here may be compiled with -ffast-math. Products and sums may be contracted, which rounds less often.
 */
#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lanes.h"

#if FLT_EVAL_METHOD != 0 || defined __FAST_MATH__
#error "doubles are rounded to nearest, each result once"
#endif

#define VECTORS 2 /* vectors of points that go through a tape together */
#define BLOCK (VECTORS * LANES)
#define APART __attribute__((noinline)) /* once in the library, not once for each use: it compiles sooner */
#define U 0x1p-53
#define UP (1.0 + 0x1p-48)
#define MANY (1.0 + 0x1p-44)
#define TINY 0x1p-1000
#define SMALLEST 0x1p-400
#define LARGEST 0x1p+400
#define FLOOR 0x1p-600
#define MOST_RADIANS 1e5
#define MOST_EXPONENT 300.0

/* Errors of `real_sin_cos` and `real_exp` of lanes.h within these bounds, u = 2^-53:
 *
 * sin, cos: n pi/2 is subtracted in three parts. The first two have 33 bits, so that their products with |n| < 2^20 are exact; the
 * three differences, of size at most 0.79, are each off by at most 0.79 u, the last product and the rest of pi by far less: r is
 * off by 2.4 u, and so are sin r and cos r. The polynomials leave out r^17 / 17! < 0.5 u and r^18 / 18!. Of r + r (y s) with
 * |y s| < 0.11 the last sum is off by 0.71 u and the rest by 0.11 * 8 u; of 1 + y (c y - 1/2) by u and 0.31 * 8 u. Less than 8 u.
 *
 * exp: n log 2 is subtracted in two parts, the first exact, differences of size at most 0.35: r is off by 0.8 u. The polynomial
 * leaves out r^14 / 14! < 0.1 u; of 1 + (r + r^2 (p r + 1/2)) the sums are off by 1.5 u and 0.5 u, the rest by less than u.
 * e^r > 0.7: the relative error is less than 8 u. The factor 2^n is exact.
 *
 * cosh = (e + d) / 2 and sinh = (e - d) / 2 with d = 1 / e: both off by less than 10 u cosh; each part of the complex sine and cosine
 * by less than 20 u cosh, together 32 u cosh. */

enum { INPUT, CONSTANT, OUTPUT, ADD, SUBTRACT, MULTIPLY, SQUARE, NEGATE, TWICE, INVERT, SINE, COSINE, ROOT, EXPONENTIAL, ANGLE };

struct code {
    const int *instructions; /* (length, 4): operation, places a and b, place of the result */
    const double *constants;
    int length, places, outputs;
};

/* F(z) and the nonzeros of dF/dz, at rows and columns; `before` takes known values, followed by `count` others, to what
 * both read behind z. */
struct problem {
    struct code value, slope, before;
    const int *row, *column;
    const double *values;
    int width, count;
};

static inline v absolute(v x) { return (v)((mask)x & 0x7fffffffffffffffLL); }

static void *reserve(size_t size) { return aligned_alloc(64, (size + 63) / 64 * 64); }

/* Points of a block, the last one again where there are no more, and their instances. */
static void choose(int n, int begin, const int *instance, int *of, int *at)
{
    for (int l = 0; l < BLOCK; l++) {
        of[l] = begin + l < n ? begin + l : n - 1;
        at[l] = instance[of[l]];
    }
}

#define COMPLEX 0
#include "discs.h"
#include "krawczyk.h"
#undef COMPLEX
#define COMPLEX 1
#include "discs.h"
#include "krawczyk.h"

/* Rounding is to nearest and subnormal numbers are numbers while these work, whatever the thread had set. Both give 0 where there
 * is no memory. */
int symkin_run(int complex_numbers, int n, int width, int kept, const struct code *code, const double *z, const double *radii,
               const double *known, const double *spread, const int *instance, double *middle, double *radius)
{
    fenv_t own;
    fegetenv(&own);
    fesetenv(FE_DFL_ENV);
    int done = (complex_numbers ? complex_run_all : real_run_all)(n, width, kept, code, z, radii, known, spread, instance, middle, radius);
    fesetenv(&own);
    return done;
}

/* What the known discs (m, given) of m instances determine alone: `middle`, of as many parts as `known` has, and `radius`. */
static int prepare(int parts, const struct problem *p, int m, int given, const double *known, const double *spread,
                   double *middle, double *radius)
{
    size_t width = given + p->count;
    double *z = reserve((width * (parts + 1) + 1) * m * sizeof *z), *radii = z + width * parts * m;
    if (!z)
        return 0;
    int *instance = (int *)(radii + width * m);
    memset(z, 0, (width * (parts + 1) + 1) * m * sizeof *z);
    for (int j = 0; j < m; j++) {
        for (int i = 0; i < given * parts; i++)
            z[j * width * parts + i] = known[(size_t)j * given * parts + i];
        for (int i = 0; i < given; i++)
            radii[j * width + i] = spread[(size_t)j * given + i];
        for (int i = 0; i < p->count; i++)
            z[(j * width + given + i) * parts] = p->values[i];
    }
    int done = (parts == 2 ? complex_run_all : real_run_all)(m, width, 0, &p->before, z, radii, 0, 0, instance, middle, radius);
    free(z);
    return done;
}

/* Of points with one or two `parts`, at known discs (m, given) with `known_parts`, no more. */
int symkin_enclose(int parts, int known_parts, const struct problem *p, int n, int m, int given, const double *z, const double *patch,
                   const double *known, const double *spread, const int *instance, double wide, double *centre, double *half_width)
{
    size_t size = (size_t)m * p->before.outputs;
    double *middle = reserve((size * (parts + 1) + 1) * sizeof *middle), *radius = middle + size * parts;
    if (!middle)
        return 0;
    fenv_t own;
    fegetenv(&own);
    fesetenv(FE_DFL_ENV);
    int done = prepare(known_parts, p, m, given, known, spread, middle, radius);
    for (size_t i = parts > known_parts ? size : 0; i-- > 0;)
        middle[2 * i] = middle[i], middle[2 * i + 1] = 0.0;
    done = done && (parts == 2 ? complex_enclose_all : real_enclose_all)(p, n, z, patch, middle, radius, instance, wide, centre, half_width);
    fesetenv(&own);
    free(middle);
    return done;
}
