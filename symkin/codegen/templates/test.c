/* Test of @p.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "@p.h"
#include "name_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N NAME_JOINTS
#define MOST @most /* numbers that any function takes or gives */

/* A function of plain numbers, of which a pose has seven. kinds: of each number that is given, and then guessed, c: a coordinate, s: a
 * speed, l: what is never below 0. step: one step of tracking; opposite: the problem by which answers
 * are held where they are not the only ones. The numbers of an answer, weighed, may be off by `share` times its bound and by `within`
 * more. Where nothing is solved there are no answers, where nothing is guessed no guesses. */
typedef struct function {
    const char *name;
    name_status (*ask)(const name_config *config, const name_real *given, const name_real *guess, name_real *result, name_info *info);
    const char *kinds;
    int given;
    int found;
    const name_real *values;
    const name_real *guesses;
    const name_real *answers;
    const double *weights;
    name_status (*step)(const name_config *config, const name_real *given, const name_real *guess, name_real *result, name_info *info);
    const struct function *opposite;
    int informs; /* whether a config is read and an info written */
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    unsigned int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const name_real wrong[3] = { (name_real)NAN, (name_real)INFINITY, -(name_real)INFINITY };
static int failures = 0;

static void expect(int right, const char *of, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", of, what, number);
    }
}

static void copy(const name_real *from, name_real *to, int count)
{
    COPY(to, from, count)
}

static int all_are(const name_real *values, int count, name_real value)
{
    int same = 1;
    EACH(i, count) {
        same = same && (values[i] == value);
    }
    return same;
}

@poses
@wrappers
/* Largest weighed difference; of q and -q, one rotation, the nearer one. NaN is the largest. */
static double away(const function *asked, const name_real *a, const name_real *b)
{
    double largest = 0.0;
    double cosine = 0.0;
    for (int i = 3; (i < 7) && (asked->found == 7); ++i) {
        cosine += (double)a[i] * (double)b[i];
    }
    EACH(i, asked->found) {
        const double side = ((i >= 3) && (cosine < 0.0)) ? -1.0 : 1.0;
        const double off = asked->weights[i] * fabs((double)a[i] - side * (double)b[i]);
        largest = (off <= largest) ? largest : off;
    }
    return largest;
}

/* Answers of the vectors, and standing still at them. */
static void solve_all(const function *asked)
{
    const char *const name = asked->name;
    EACH(k, NAME_VECTORS) {
        const double bound = name_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const name_real *const given = &asked->values[asked->given * k];
        const name_real *const guess = (asked->guesses == NULL) ? NULL : &asked->guesses[asked->found * k];
        const name_real *const answer = &asked->answers[asked->found * k];
        name_real result[MOST];
        name_real again[MOST];
        name_info info;
        EACH(i, asked->found) {
            result[i] = (guess != NULL) ? guess[i] : @four;
        }
        expect(asked->ask(NULL, given, asked->informs ? result : guess, result, &info) == NAME_OK, name, "OK", k);
        expect(away(asked, result, answer) <= most, name, "answer", k);
        if (asked->informs) {
            expect((double)info.residual <= 16.0 * bound, name, "residual", k);
            expect(info.min_pivot > @zero, name, "smallest pivot", k);
            expect(info.joint == N, name, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == NAME_OK, name, "without info", k);
            copy(result, again, asked->found);
            expect(asked->ask(NULL, given, again, again, &info) == NAME_OK, name, "standing still", k);
            expect(away(asked, again, answer) <= most, name, "answer of standing still", k);
        }
        if (asked->step != NULL) {
            copy(result, again, asked->found);
            expect(asked->step(NULL, given, NULL, again, &info) == NAME_OK, name, "track", k);
            expect(away(asked, again, answer) <= most, name, "answer of track", k);
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == NAME_OK, name, "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, name, "answer asked back", k);
        }
    }
}

/* Values that are refused: the status (OK: any but this), the joint that is blamed, the result untouched, info written. */
static void refuse(const function *asked, const name_real *given, const name_real *guess, name_status wanted, int joint, int number)
{
    name_real result[MOST];
    name_info info;
    EACH(i, MOST) {
        result[i] = @four;
    }
    info.iterations = 255U;
    info.joint = N;
    const name_status status = asked->ask(NULL, given, guess, result, &info);
    expect((wanted == NAME_OK) ? (status != NAME_OK) : (status == wanted), asked->name, "status of a refusal", number);
    expect(all_are(result, MOST, @four), asked->name, "result untouched by a refusal", number);
    if (asked->informs) {
        expect(info.iterations != 255U, asked->name, "info of a refusal", number);
        expect((joint < 0) || ((int)info.joint == joint), asked->name, "joint of a refusal", number);
    }
}

/* A step that is refused: the status, the result untouched. */
static void refuse_step(const function *asked, const name_real *given, const name_real *last, name_status wanted, int number)
{
    name_real result[MOST];
    copy(last, result, asked->found);
    expect(asked->step(NULL, given, NULL, result, NULL) == wanted, asked->name, "status of a step refused", number);
    expect(memcmp(last, result, (size_t)asked->found * sizeof result[0]) == 0, asked->name, "result untouched by a step refused", number);
}

/* Each number that is given or guessed in turn not finite, or out of all bounds; wrong configs, and too few steps. */
static void refuse_values(const function *asked)
{
    const name_real bad[4] = { @zero, -@one, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    name_real given[MOST];
    name_real guess[MOST];
    EACH(i, count) {
        const name_real out = (asked->kinds[i] == 'c') ? @far : ((asked->kinds[i] == 's') ? (name_real)1e30 : -@one);
        EACH(k, 5) {
            const int place = (i < asked->given) ? i : (i - asked->given);
            const int joint = (asked->blamed == ((i < asked->given) ? 1 : 2)) ? place : -1;
            const name_status status = (k < 3) ? NAME_NONFINITE : NAME_OUT_OF_RANGE;
            copy(asked->values, given, asked->given);
            if (asked->guesses != NULL) {
                copy(asked->guesses, guess, asked->found);
            }
            *((i < asked->given) ? &given[place] : &guess[place]) = (k < 3) ? wrong[k] : (((k == 3) || (out < @zero)) ? out : -out);
            refuse(asked, given, guess, status, joint, 5 * i + k);
            if (asked->step != NULL) {
                refuse_step(asked, given, guess, status, 5 * i + k);
            }
        }
    }
    EACH_WHILE(i, 8, asked->informs) {
        const name_config config = { (i < 4) ? bad[i] : NAME_TOLERANCE, NAME_MAX_STEPS, (i < 4) ? NAME_MAX_STEP : bad[i - 4] };
        const name_status status = asked->ask(&config, asked->values, asked->guesses, guess, NULL);
        expect(status == ((i % 4 < 2) ? NAME_OUT_OF_RANGE : NAME_NONFINITE), asked->name, "status of a wrong config", i);
    }
    for (unsigned int steps = 0U; (steps <= asked->few) && asked->informs; ++steps) {
        const name_config config = { NAME_TOLERANCE, (uint8_t)steps, NAME_MAX_STEP };
        const name_status status = asked->ask(&config, asked->values, asked->guesses, guess, NULL);
        expect(status == NAME_MAX_ITERATIONS, asked->name, "status of too few steps", (int)steps);
    }
}

@refuse_rows
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = @jacobian_most;
    name_real jacobian[MOST];
@nominal
    @configuration_of_k
    expect(name_jacobian(@ga@configuration, jacobian) == NAME_OK, "jacobian", "OK", k);
    @feasible
    EACH(i, @entries) {
        const double wanted = (double)name_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "jacobian", "entry", i);
    }
}

@more
int main(void)
{
    @tables
    @calls
    (void)printf("@p: %d cases, %d failures\n", NAME_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
