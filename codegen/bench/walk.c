/* The configurations that a machine reaches when its known values move in straight lines: a reference beside the generated code,
 * of which it uses nothing. CasADi's own C of all rows of the closure (rows.c), Newton's method by a dense factorisation, fine
 * steps. N: unknowns' tangent; M: rows, at least N; WIDTH: numbers of the unknowns; KNOWN: known values; SIZE: of the machine.
 *
 * All numbers are long doubles, of 64 bits or more: beside a fold of condition 1e7 a step of Newton's method moves by 1e-9 of the size
 * by a double's rounding alone, and a goal short of the fold cannot be told from one beyond it.
 *
 * A step follows the tangent and is corrected by Newton's method. It is kept where
 * - the first correction is at most a tenth of the tangent's step, the second at most a tenth of the first: the steps are short
 *   beside the distance to a fold, at which the tangent's length is without bound;
 * - the matrices at both ends and at the tangent's end have one orientation: det(A^T B) > 0, which is the sign of the
 *   determinant and serves more rows than unknowns too. A gap between two folds is not leapt: the tangent into it ends on the far
 *   side of the fold, where the matrix has turned over.
 * Else it is halved, down to SHORTEST of the line: there the line meets a singularity. A goal short of a fold by 1e-14 of the line, a
 * hundred roundings of a double, is still told from one beyond it. Lines of poses that an arm of few joints leaves by far are followed by
 * least squares, whose steps stay short: after MOST of them they are called singular too. */
#include <string.h>
#include <tgmath.h>

typedef long double real;
#define casadi_real real
#include "rows.c"

#define SHORTEST 1e-16L
#define MOST 100000

typedef struct {
    real f[M];     /* rows */
    real j[M * N]; /* their matrix by tangent steps, column-major */
    real r[M];     /* their rate along the line */
} point;

static casadi_int iw[SZ_IW + 1];
static real w[SZ_W + 1];

static void moved(real *z, const real *step)
{
    real to[WIDTH];
    const real *arg[SZ_ARG] = { z, step };
    real *res[SZ_RES] = { to };
    retracted(arg, res, iw, w, 0);
    memcpy(z, to, sizeof to);
}

static real norm(const real *v, int count)
{
    real sum = 0.0;
    for (int i = 0; i < count; ++i) {
        sum += v[i] * v[i];
    }
    return sqrt(sum);
}

/* Householder's reflections make the n columns of a (m rows each) a triangle, and act on `count` columns b too. The sign of the product of
 * the triangle's diagonal and of the reflections; 0 where it is singular. */
static int triangle(real *a, int m, int n, real *b, int count)
{
    int sign = 1;
    for (int k = 0; k < n; ++k) {
        real *column = a + k * m;
        const real length = norm(column + k, m - k);
        if (!(length > 0.0)) {
            return 0;
        }
        const real head = (column[k] > 0.0) ? -length : length;
        real v[M];
        real square = 0.0;
        for (int i = k; i < m; ++i) {
            v[i] = column[i] - ((i == k) ? head : 0.0);
            square += v[i] * v[i];
        }
        sign *= (head > 0.0) ? -1 : 1;
        column[k] = head;
        for (int c = k + 1; c < n + count; ++c) {
            real *other = (c < n) ? (a + c * m) : (b + (c - n) * m);
            real dot = 0.0;
            for (int i = k; i < m; ++i) {
                dot += v[i] * other[i];
            }
            for (int i = k; i < m; ++i) {
                other[i] -= 2.0 / square * dot * v[i];
            }
        }
    }
    return sign;
}

/* Whether det(a^T b) > 0. */
static int alike(const real *a, const real *b)
{
    real m[N * N];
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j < N; ++j) {
            m[j * N + i] = 0.0;
            for (int k = 0; k < M; ++k) {
                m[j * N + i] += a[i * M + k] * b[j * M + k];
            }
        }
    }
    return triangle(m, N, N, NULL, 0) > 0;
}

/* One Newton step at a part of the line, from z; returns its length, or -1. at: the point before it; rate: the tangent there. */
static real corrected(real *z, const real *begin, const real *goal, real part, point *at, real *rate)
{
    real a[M * N];
    real b[2 * M];
    const real *arg[SZ_ARG] = { z, begin, goal, &part };
    real *res[SZ_RES] = { at->f, at->j, at->r };
    linearised(arg, res, iw, w, 0);
    memcpy(a, at->j, sizeof a);
    for (int i = 0; i < M; ++i) {
        b[i] = -at->f[i];
        b[M + i] = -at->r[i];
    }
    /* least squares: both solutions stand in the first N entries of each right-hand side */
    const int regular = triangle(a, M, N, b, 2) != 0;
    for (real *x = b; regular && x < b + 2 * M; x += M) {
        for (int k = N - 1; k >= 0; --k) {
            for (int i = k + 1; i < N; ++i) {
                x[k] -= a[i * M + k] * x[i];
            }
            x[k] /= a[k * M + k];
        }
    }
    const real length = norm(b, N);
    if (!regular || !(length < SIZE)) {
        return -1.0;
    }
    moved(z, b);
    memcpy(rate, b + M, N * sizeof *rate);
    return length;
}

/* Follows one line from the unknowns z, which are at its begin. Returns the shortest step that was tried, 0 where the line met a singularity;
 * *done: how far it came, z: the unknowns there. */
static real follow(real *z, const real *begin, const real *goal, real longest, real *done)
{
    point here;
    point there;
    real rate[N];
    real step = longest;
    real shortest = longest;
    *done = 0.0;
    for (int i = 0; i < 3; ++i) {
        if (corrected(z, begin, goal, 0.0, &here, rate) < 0.0) {
            return 0.0;
        }
    }
    for (int tries = 0; *done < 1.0; ++tries) {
        const real part = (*done + step < 1.0) ? (*done + step) : 1.0;
        real to[WIDTH];
        real tangent[N];
        real after[N];
        int fine = 0;
        for (int i = 0; i < N; ++i) {
            tangent[i] = (part - *done) * rate[i];
        }
        const real length = norm(tangent, N);
        if (length < 0.1 * SIZE) {
            memcpy(to, z, sizeof to);
            moved(to, tangent);
            const real first = corrected(to, begin, goal, part, &there, after);
            if ((first >= 0.0) && (first <= 0.1 * length + 1e-6 * SIZE) && alike(here.j, there.j)) {
                const real second = corrected(to, begin, goal, part, &there, after);
                fine = (second >= 0.0) && (second <= 0.1 * first + 1e-11 * SIZE) && alike(here.j, there.j);
            }
        }
        if (fine) {
            memcpy(z, to, sizeof to);
            memcpy(rate, after, sizeof after);
            here = there;
            *done = part;
            step = (2.0 * step < longest) ? 2.0 * step : longest;
        } else {
            step *= 0.5;
            shortest = (step < shortest) ? step : shortest;
            if ((step < SHORTEST) || (tries > MOST)) {
                return 0.0;
            }
        }
    }
    for (int i = 0; i < 2; ++i) {
        if (corrected(z, begin, goal, 1.0, &there, rate) < 0.0) {
            return 0.0;
        }
    }
    return (corrected(z, begin, goal, 1.0, &there, rate) < 1e-9 * SIZE) ? shortest : 0.0;
}

/* Many lines; z: begins, overwritten by ends. */
void follow_all(int count, double longest, real *z, const real *begin, const real *goal, double *shortest, double *done)
{
    for (int k = 0; k < count; ++k) {
        real part;
        shortest[k] = (double)follow(z + k * WIDTH, begin + k * KNOWN, goal + k * KNOWN, longest, &part);
        done[k] = (double)part;
    }
}
