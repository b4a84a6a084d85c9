/* Functions of real numbers, and extreme singular values, at many points at once.
 *
 * A function is a tape: instructions of four numbers, an operation, the place that it writes, and the places (of an
 * input or output: the argument or result, and the entry) that it reads. Every place holds BLOCK points, so that an
 * instruction is read once for all of them. Products and sums are not contracted and sines are those of the C library:
 * the digits are those that CasADi computes, one point after another.
 */
#pragma STDC FP_CONTRACT OFF
#ifndef __clang__
#pragma GCC optimize("O3", "fp-contract=off")
#endif
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lanes.h"

#define BLOCK 64
#define VECTORS (BLOCK / LANES)

enum { INPUT, CONSTANT, OUTPUT, ADD, SUBTRACT, MULTIPLY, DIVIDE, SQUARE, NEGATE, TWICE, INVERT, SINE, COSINE, ROOT,
       SIZE, LARGER, ANGLE };

struct array {
    double *begin;
    long long stride; /* from one point to the next; 0 where all points share the numbers */
};

#define EACH(expression) for (int i = 0; i < VECTORS; i++) { v a = x[i], b = y[i]; (void)b; z[i] = expression; } break
#define EACH_POINT(expression) for (int i = 0; i < BLOCK; i++) { \
    double a = ((double *)x)[i], b = ((double *)y)[i]; (void)b; ((double *)z)[i] = expression; } break

static void run(const int *line, int length, const double *constants, const struct array *in, const struct array *out,
                long long first, int count, v (*w)[VECTORS])
{
    for (const int *end = line + 4 * (size_t)length; line < end; line += 4) {
        if (line[0] == OUTPUT) {
            const double *x = (const double *)w[line[1]];
            double *to = out[line[2]].begin + first * out[line[2]].stride + line[3];
            for (int i = 0; i < count; i++)
                to[i * out[line[2]].stride] = x[i];
            continue;
        }
        v *z = w[line[1]];
        if (line[0] == INPUT) {
            const double *from = in[line[2]].begin + first * in[line[2]].stride + line[3];
            for (int i = 0; i < count; i++)
                ((double *)z)[i] = from[i * in[line[2]].stride];
            continue;
        }
        if (line[0] == CONSTANT) {
            for (int i = 0; i < VECTORS; i++)
                z[i] = all(constants[line[2]]);
            continue;
        }
        const v *x = w[line[2]], *y = w[line[3]];
        switch (line[0]) {
        case ADD: EACH(a + b);
        case SUBTRACT: EACH(a - b);
        case MULTIPLY: EACH(a * b);
        case DIVIDE: EACH(a / b);
        case SQUARE: EACH(a * a);
        case NEGATE: EACH(-a);
        case TWICE: EACH(a + a);
        case INVERT: EACH(1.0 / a);
        case SINE: EACH_POINT(sin(a));
        case COSINE: EACH_POINT(cos(a));
        case ROOT: EACH(root(a));
        case SIZE: EACH_POINT(fabs(a));
        case LARGER: EACH_POINT(fmax(a, b));
        case ANGLE: EACH_POINT(atan2(a, b));
        }
    }
}

/* A tape at n points; 0 where there is no memory. */
int symkin_evaluate(long long n, const int *instructions, int length, const double *constants, int places,
                    const struct array *in, const struct array *out)
{
    v(*w)[VECTORS] = aligned_alloc(sizeof(v), sizeof(*w) * (size_t)places);
    if (w == NULL)
        return 0;
    memset(w, 0, sizeof(*w) * (size_t)places);
    for (long long first = 0; first < n; first += BLOCK)
        run(instructions, length, constants, in, out, first, n - first < BLOCK ? (int)(n - first) : BLOCK, w);
    free(w);
    return 1;
}

/* --- extreme singular values ------------------------------------------------------------------------------------ */

#define MOST 8
#define ITERATIONS 60
#define BELOW 1e-14 /* of the trace: rounding leaves no eigenvalue farther below zero */
#define ROUNDED 1e-13 /* of a square: what cancels is known to this, and a step that is too short goes not past */
#define SETTLED 1e-16 /* of the trace: a shorter step is the last */

/* Householder's reflections: the diagonal d of a tridiagonal matrix, and the squares e of what stands beside it. */
static void tridiagonal(int n, v g[MOST][MOST], v *d, v *e)
{
    for (int k = 0; k + 1 < n; k++) {
        v square = all(0.0), u[MOST], p[MOST], along = all(0.0);
        for (int i = k + 1; i < n; i++)
            u[i] = g[i][k], square += u[i] * u[i];
        e[k] = square;
        if (k + 2 == n)
            break;
        v length = root(square), half = square + pick(u[k + 1] < 0.0, -u[k + 1], u[k + 1]) * length;
        u[k + 1] += pick(u[k + 1] < 0.0, -length, length);
        v factor = 1.0 / pick(half > 0.0, half, all(1.0));
        for (int i = k + 1; i < n; i++) {
            p[i] = all(0.0);
            for (int j = k + 1; j < n; j++)
                p[i] += (i > j ? g[i][j] : g[j][i]) * u[j];
            p[i] *= factor;
            along += p[i] * u[i];
        }
        along *= 0.5 * factor;
        for (int i = k + 1; i < n; i++)
            p[i] -= along * u[i];
        for (int i = k + 1; i < n; i++)
            for (int j = k + 1; j <= i; j++)
                g[i][j] -= u[i] * p[j] + p[i] * u[j];
    }
    for (int k = 0; k < n; k++)
        d[k] = g[k][k];
}

/* Laguerre's steps from x, with all eigenvalues on one side of it, to the nearest: each covers more than half of the
 * way, however many meet there, and none goes past. A lane that has arrived stays. */
static v nearest(int n, const v *d, const v *e, v x, double side, v trace)
{
    v before = all(INFINITY), least = 1e-300 + 1e-40 * trace;
    for (int t = 0; t < ITERATIONS; t++) {
        v slope = all(0.0), bend = slope, inverse = slope, sum = slope, squares = slope;
        for (int k = 0; k < n; k++) {
            /* q = d - x - e / q over the one before; its derivatives over x, divided by it */
            v beside = k ? e[k - 1] * inverse : all(0.0), q = d[k] - x - beside;
            q = pick((q < least) & (q > -least), least, q);
            inverse = 1.0 / q;
            bend = beside * (bend - 2.0 * slope * slope) * inverse;
            slope = (beside * slope - 1.0) * inverse;
            sum += slope;
            squares += slope * slope - bend;
        }
        v square = sum * sum, apart = larger((n - 1.0) * (n * squares - square), all(0.0));
        v step = n / (sum + side * root(apart + ROUNDED * square));
        v size = side * step;
        mask going = (size > SETTLED * trace) & (size < before) & (side * sum > 0.0);
        if (!any(going))
            break;
        x = pick(going, x - step, x);
        before = pick(going, size, all(0.0));
    }
    return x;
}

/* Squares of the largest and smallest of the n <= MOST singular values of matrices of `rows` rows and n columns, of
 * which `strides` are the distances between matrices, rows and columns. Zeros where one is not finite. */
void symkin_extremes(long long count, int rows, int n, const double *matrices, const long long *strides, double *found)
{
    for (long long first = 0; first < count; first += LANES) {
        v g[MOST][MOST], x[MOST], d[MOST], e[MOST], trace = all(0.0);
        memset(g, 0, sizeof g);
        for (int r = 0; r < rows; r++)
            for (int a = 0; a < n; a++) {
                for (int l = 0; l < LANES; l++) {
                    long long one = first + l < count ? first + l : count - 1;
                    x[a][l] = matrices[one * strides[0] + r * strides[1] + a * strides[2]];
                }
                for (int b = 0; b <= a; b++)
                    g[a][b] += x[a] * x[b];
            }
        for (int a = 0; a < n; a++)
            trace += g[a][a];
        mask finite = (trace < INFINITY) & (trace > 0.0);
        tridiagonal(n, g, d, e);
        v largest = nearest(n, d, e, trace, 1.0, trace), smallest = nearest(n, d, e, -BELOW * trace, -1.0, trace);
        for (int l = 0; l < LANES && first + l < count; l++) {
            found[2 * (first + l)] = finite[l] ? largest[l] : 0.0;
            found[2 * (first + l) + 1] = finite[l] ? smallest[l] : 0.0;
        }
    }
}
