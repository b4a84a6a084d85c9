/* The configurations that a machine reaches when its known values move in straight lines: a reference beside the generated code,
 * of which it uses nothing. CasADi's own C of all rows of the closure (rows.c), Newton's method by a dense factorisation, fine
 * steps. N: unknowns' tangent; M: rows, at least N; WIDTH: numbers of the unknowns; KNOWN: known values; SIZE: of the machine.
 *
 * A step follows the tangent and is corrected by Newton's method. It is kept where
 * - the first correction is at most a tenth of the tangent's step, the second at most a tenth of the first: the steps are short
 *   beside the distance to a fold, at which the tangent's length is without bound;
 * - the matrices at both ends and at the tangent's end have one orientation: det(A^T B) > 0, which is the sign of the
 *   determinant and serves more rows than unknowns too. A gap between two folds is not leapt: the tangent into it ends on the far
 *   side of the fold, where the matrix has turned over.
 * Else it is halved, down to SHORTEST of the line: there the line meets a singularity. A goal whose distance to the singularity is
 * that of a crank of 1e-5 rad beside a dead centre, 1e-11 of its length, is still told from one beyond it. */
#include <math.h>
#include <string.h>
#include "rows.c"

#define SHORTEST 1e-13

typedef struct {
    double f[M];      /* rows */
    double j[M * N];  /* their matrix by tangent steps, column-major */
    double r[M];      /* their rate along the line */
} point;

static void evaluate(const double *z, const double *begin, const double *goal, double part, point *at)
{
    static casadi_int iw[point_SZ_IW + 1];
    static casadi_real w[point_SZ_W + 1];
    const casadi_real *arg[point_SZ_ARG];
    casadi_real *res[point_SZ_RES];
    arg[0] = z;
    arg[1] = begin;
    arg[2] = goal;
    arg[3] = &part;
    res[0] = at->f;
    res[1] = at->j;
    res[2] = at->r;
    linearised(arg, res, iw, w, 0);
}

static void moved(double *z, const double *step)
{
    static casadi_int iw[point_SZ_IW + 1];
    static casadi_real w[point_SZ_W + 1];
    const casadi_real *arg[point_SZ_ARG];
    casadi_real *res[point_SZ_RES];
    double to[WIDTH];
    arg[0] = z;
    arg[1] = step;
    res[0] = to;
    retracted(arg, res, iw, w, 0);
    memcpy(z, to, sizeof to);
}

static double norm(const double *v, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        sum += v[i] * v[i];
    }
    return sqrt(sum);
}

/* Solves a x = b for `count` right-hand sides in the least-squares sense by Householder's reflections; a is column-major, overwritten;
 * false where it is singular. Solutions stand in the first N entries of each b. */
static int least_squares(double *a, double *b, int count)
{
    for (int k = 0; k < N; ++k) {
        double *column = a + k * M;
        const double length = norm(column + k, M - k);
        if (!(length > 0.0)) {
            return 0;
        }
        const double head = (column[k] > 0.0) ? -length : length;
        double v[M];
        double square = 0.0;
        for (int i = k; i < M; ++i) {
            v[i] = column[i];
        }
        v[k] -= head;
        for (int i = k; i < M; ++i) {
            square += v[i] * v[i];
        }
        column[k] = head;
        for (int c = k + 1; c < N + count; ++c) {
            double *other = (c < N) ? (a + c * M) : (b + (c - N) * M);
            double dot = 0.0;
            for (int i = k; i < M; ++i) {
                dot += v[i] * other[i];
            }
            dot *= 2.0 / square;
            for (int i = k; i < M; ++i) {
                other[i] -= dot * v[i];
            }
        }
    }
    for (int c = 0; c < count; ++c) {
        double *x = b + c * M;
        for (int k = N - 1; k >= 0; --k) {
            for (int i = k + 1; i < N; ++i) {
                x[k] -= a[i * M + k] * x[i];
            }
            x[k] /= a[k * M + k];
        }
    }
    return 1;
}

/* Whether det(a^T b) > 0. */
static int alike(const double *a, const double *b)
{
    double m[N * N];
    int positive = 1;
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j < N; ++j) {
            double sum = 0.0;
            for (int k = 0; k < M; ++k) {
                sum += a[i * M + k] * b[j * M + k];
            }
            m[i * N + j] = sum;
        }
    }
    for (int k = 0; k < N; ++k) {
        int best = k;
        for (int i = k + 1; i < N; ++i) {
            best = (fabs(m[i * N + k]) > fabs(m[best * N + k])) ? i : best;
        }
        if (!(fabs(m[best * N + k]) > 0.0)) {
            return 0;
        }
        if (best != k) {
            positive = !positive;
            for (int j = k; j < N; ++j) {
                const double kept = m[k * N + j];
                m[k * N + j] = m[best * N + j];
                m[best * N + j] = kept;
            }
        }
        positive = (m[k * N + k] > 0.0) ? positive : !positive;
        for (int i = k + 1; i < N; ++i) {
            const double factor = m[i * N + k] / m[k * N + k];
            for (int j = k + 1; j < N; ++j) {
                m[i * N + j] -= factor * m[k * N + j];
            }
        }
    }
    return positive;
}

/* One Newton step at a part of the line, from z; returns its length, or -1. at: the point before it; rate: the tangent there. */
static double corrected(double *z, const double *begin, const double *goal, double part, point *at, double *rate)
{
    double a[M * N];
    double b[2 * M];
    evaluate(z, begin, goal, part, at);
    memcpy(a, at->j, sizeof a);
    for (int i = 0; i < M; ++i) {
        b[i] = -at->f[i];
        b[M + i] = -at->r[i];
    }
    if (!least_squares(a, b, 2)) {
        return -1.0;
    }
    const double length = norm(b, N);
    if (!(length < SIZE)) {
        return -1.0;
    }
    moved(z, b);
    memcpy(rate, b + M, N * sizeof *rate);
    return length;
}

/* Follows one line from the unknowns z, which are at its begin. Returns the shortest step that was tried, 0 where the line met a singularity;
 * *done: how far it came, z: the unknowns there. */
static double follow(double *z, const double *begin, const double *goal, double longest, double *done)
{
    point here;
    point there;
    double rate[N];
    double step = longest;
    double shortest = longest;
    *done = 0.0;
    for (int i = 0; i < 3; ++i) {
        if (corrected(z, begin, goal, 0.0, &here, rate) < 0.0) {
            return 0.0;
        }
    }
    while (*done < 1.0) {
        const double part = (*done + step < 1.0) ? (*done + step) : 1.0;
        double to[WIDTH];
        double tangent[N];
        double after[N];
        int fine = 0;
        for (int i = 0; i < N; ++i) {
            tangent[i] = (part - *done) * rate[i];
        }
        const double length = norm(tangent, N);
        if (length < 0.1 * SIZE) {
            memcpy(to, z, sizeof to);
            moved(to, tangent);
            const double first = corrected(to, begin, goal, part, &there, after);
            if ((first >= 0.0) && (first <= 0.1 * length + 1e-6 * SIZE) && alike(here.j, there.j)) {
                const double second = corrected(to, begin, goal, part, &there, after);
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
            if (step < SHORTEST) {
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
void follow_all(int count, double *z, const double *begin, const double *goal, double longest, double *shortest, double *done)
{
    for (int k = 0; k < count; ++k) {
        shortest[k] = follow(z + k * WIDTH, begin + k * KNOWN, goal + k * KNOWN, longest, done + k);
    }
}
