/* Lines of tool poses that a generated arm calls OK, followed finely on the branch of the guess: every point must have it, and the
 * joints must end where the answer is, within their limits at every point. Lines that are not OK are followed too: regular ones have the
 * branch everywhere and keep off limits by a hundredth of the range. Includes NAME.c for its closed form.
 *
 *     arm_lines COUNT SEED POINTS REACH      (REACH: largest change of an angle, rad, and of slides, a third of it of the size)
 *
 * Macros: NAME, UPPER, SOURCE (NAME.c), ANGULAR, LIMITED (flags of joints), LOW, HIGH (what joints are drawn between). */
#include SOURCE
#include <stdio.h>
#include <stdlib.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define F(what) JOIN(NAME, _##what)
#define M(what) JOIN(UPPER, _##what)
#define N M(JOINTS)

typedef F(real) real;

static unsigned long long state;

/* -1 to 1 */
static double uniform(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53 * 2.0 - 1.0;
}

static const double low[N] = LOW;
static const double high[N] = HIGH;

/* How far joints are within their ranges, as a part of these, at the nearest. */
static double spare_of(const real q[N])
{
    static const bool limited[N] = LIMITED;
    double least = 1.0;
    for (int i = 0; i < N; ++i) {
        const double a = ((double)q[i] - low[i]) / (high[i] - low[i]);
        least = limited[i] ? fmin(least, fmin(a, 1.0 - a)) : least;
    }
    return least;
}

/* Whether the guess's branch reaches all points of the line and ends at the answer (any one: NULL), and how far joints stay within
 * their ranges. */
static int followed(const real guess[N], const real to[7], const real *answer, int points, double *spare)
{
    static const real near[64];
    static const bool angular[N] = ANGULAR;
    real at[7], margin[64], found[1][N], q[N];
    const unsigned int wanted = F(read_joints)(guess, at, margin);
    double cosine = 0.0;
    for (int i = 3; i < 7; ++i) {
        cosine += (double)at[i] * (double)to[i];
    }
    for (int i = 0; i < N; ++i) {
        q[i] = guess[i];
    }
    *spare = spare_of(q);
    for (int k = 1; k <= points; ++k) {
        real x[7];
        double norm = 0.0;
        bool undecided = false;
        for (int i = 0; i < 7; ++i) {
            const double goal = ((i > 2) && (cosine < 0.0)) ? -(double)to[i] : (double)to[i];
            x[i] = (real)((double)at[i] + (double)k / points * (goal - (double)at[i]));
            norm += (i > 2) ? (double)x[i] * (double)x[i] : 0.0;
        }
        for (int i = 3; i < 7; ++i) {
            x[i] = (real)((double)x[i] / sqrt(norm));
        }
        if (F(branches)(x, near, wanted, found, &undecided, margin) != 1) {
            return 0;
        }
        for (int i = 0; i < N; ++i) {
            const double way = (double)(found[0][i] - q[i]);
            q[i] = (real)((double)q[i] + (angular[i] ? remainder(way, 6.283185307179586476925) : way));
        }
        *spare = fmin(*spare, spare_of(q));
    }
    for (int i = 0; i < N; ++i) {
        if ((answer != NULL) && (fabs((double)(q[i] - answer[i])) > 1e-2 * (angular[i] ? 1.0 : (double)M(SIZE)))) {
            return 0;
        }
    }
    return 1;
}

int main(int argc, char **argv)
{
    const long count = (argc > 1) ? atol(argv[1]) : 1000L;
    const int points = (argc > 3) ? atoi(argv[3]) : 2000;
    const double reach = (argc > 4) ? atof(argv[4]) : 1.0;
    static const bool angular[N] = ANGULAR;
    long ok = 0L, wrong = 0L, samples = 0L, all = 0L, regular = 0L, answered = 0L, outside = 0L;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)((argc > 2) ? atol(argv[2]) : 0L);
    for (long k = 0L; k < count; ++k) {
        real guess[N], goal[N], answer[N], to[7];
        F(pose) pose;
        F(info) info;
        for (int i = 0; i < N; ++i) {
            const double unit = angular[i] ? 1.0 : (double)M(SIZE) / 3.0;
            guess[i] = (real)(low[i] + 0.5 * (1.0 + uniform()) * (high[i] - low[i]));
            goal[i] = (real)fmin(fmax((double)guess[i] + reach * unit * uniform(), low[i]), high[i]);
        }
        if ((F(direct)(goal, &pose) == M(OK)) && (F(direct)(guess, &pose) == M(OK))) {
            double spare;
            int reached, good;
            (void)F(direct)(goal, &pose);
            ++all;
            good = F(inverse)(NULL, &pose, guess, answer, &info) == M(OK);
            samples += (long)info.iterations;
            (void)F(normalise_pose)(&pose, to);
            reached = followed(guess, to, good ? answer : NULL, points, &spare);
            outside += (reached && (spare < 0.0));
            regular += (reached && (spare > 0.01));
            answered += (good && reached && (spare > 0.01));
            ok += good;
            /* limits have room for 16 roundings */
            if (good && (!reached || (spare < ((sizeof(real) == 4) ? -1e-5 : -1e-8)))) {
                ++wrong;
                (void)printf("line %ld: %s, %g within\n", k, reached ? "followed" : "not followed", spare);
            }
        }
    }
    (void)printf("%ld lines, %ld OK, %ld of them wrong, %.2f points of a line; %ld regular, %ld of them OK; %ld leave limits\n", all, ok,
        wrong, (double)samples / (double)all, regular, answered, outside);
    return (wrong == 0L) ? 0 : 1;
}
