/* Test of @p.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "@p.h"
#include "name_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N NAME_JOINTS
#define MOST @most /* numbers that any function takes or gives */

/* What is asked in plain numbers, of which a pose has seven. */
typedef name_status question(const name_config *config, const name_real *given, const name_real *guess, name_real *result, name_info *info);

/* A function. kinds: of each number that is given, and then guessed, c: a coordinate, s: a speed, l: what is never below 0. step: one step
 * of tracking, of what reads a config and writes an info; opposite: the problem by which answers are held where they are not the only ones.
 * The numbers of an answer, weighed, may be off by `share` times its bound and by `within` more. Where nothing is solved there are no
 * answers, where nothing is guessed no guesses. */
typedef struct function {
    const char *name;
    question *ask;
    const char *kinds;
    int given;
    int found;
    const name_real *values;
    const name_real *guesses;
    const name_real *answers;
    const double *weights;
    question *step;
    const struct function *opposite;
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const name_real wrong[3] = { (name_real)NAN, (name_real)INFINITY, -(name_real)INFINITY };
static const char *tested = ""; /* the function that is asked */
static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", tested, what, number);
    }
}

static void copy(const name_real *from, name_real *to, int count)
{
    COPY(to, from, count)
}

/* The larger one; what is no number is above all. */
static double larger(double a, double b)
{
    return (a >= b) ? a : ((a < b) ? b : HUGE_VAL);
}

@poses
@wrappers
/* Largest weighed difference; of q and -q, one rotation, the nearer one. */
static double away(const function *asked, const name_real *a, const name_real *b)
{
    double largest = 0.0;
    double cosine = 0.0;
    for (int i = 3; (i < 7) && (asked->found == 7); ++i) {
        cosine += (double)a[i] * (double)b[i];
    }
    EACH(i, asked->found) {
        const double side = ((i >= 3) && (cosine < 0.0)) ? -1.0 : 1.0;
        largest = larger(largest, asked->weights[i] * fabs((double)a[i] - side * (double)b[i]));
    }
    return largest;
}

/* Answers of the vectors, and standing still at them. */
static void solve_all(const function *asked)
{
    question *const still[2] = { asked->ask, asked->step };
    tested = asked->name;
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
        expect(asked->ask(NULL, given, (asked->step != NULL) ? result : guess, result, &info) == NAME_OK, "OK", k);
        expect(away(asked, result, answer) <= most, "answer", k);
        if (asked->step != NULL) {
            expect((double)info.residual <= 16.0 * bound, "residual", k);
            expect(info.min_pivot > @zero, "smallest pivot", k);
            expect(info.joint == N, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == NAME_OK, "without info", k);
            EACH(i, 2) {
                copy(result, again, asked->found);
                expect(still[i](NULL, given, again, again, &info) == NAME_OK, "standing still", k);
                expect(away(asked, again, answer) <= most, "answer of standing still", k);
            }
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == NAME_OK, "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, "answer asked back", k);
        }
    }
}

/* Values that are refused, by a function or its step: the status (OK: any but this), the joint that is blamed, the result untouched,
 * info written. */
static void refuse(const function *asked, question *ask, const name_real *given, const name_real *guess, name_status wanted, int joint, int number)
{
    name_real before[MOST];
    name_real result[MOST];
    name_info info;
    EACH(i, MOST) {
        before[i] = @four;
    }
    if (ask == asked->step) {
        copy(guess, before, asked->found);
    }
    copy(before, result, MOST);
    info.iterations = 255U;
    info.joint = N;
    tested = asked->name;
    const name_status status = ask(NULL, given, guess, result, &info);
    expect((wanted == NAME_OK) ? (status != NAME_OK) : (status == wanted), "status of a refusal", number);
    expect(memcmp(before, result, sizeof before) == 0, "result untouched by a refusal", number);
    if (asked->step != NULL) {
        expect(info.iterations != 255U, "info of a refusal", number);
        expect((joint < 0) || ((int)info.joint == joint), "joint of a refusal", number);
    }
}

/* Each number that is given or guessed in turn not finite, or out of all bounds; wrong configs, and too few steps. */
static void refuse_values(const function *asked)
{
    const name_real bad[4] = { @zero, -@one, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    name_real given[2 * MOST];
    name_real *const guess = &given[asked->given];
    EACH(i, count) {
        const name_real out = (asked->kinds[i] == 'c') ? @far : ((asked->kinds[i] == 's') ? (name_real)1e30 : -@one);
        const int of_guess = i >= asked->given;
        EACH(k, 5) {
            const int joint = (asked->blamed != 1 + of_guess) ? -1 : (of_guess ? (i - asked->given) : i);
            const name_status status = (k < 3) ? NAME_NONFINITE : NAME_OUT_OF_RANGE;
            copy(asked->values, given, asked->given);
            if (asked->guesses != NULL) {
                copy(asked->guesses, guess, asked->found);
            }
            given[i] = (k < 3) ? wrong[k] : (((k == 3) || (out < @zero)) ? out : -out);
            refuse(asked, asked->ask, given, guess, status, joint, 5 * i + k);
            if (asked->step != NULL) {
                refuse(asked, asked->step, given, guess, status, joint, 5 * i + k);
            }
        }
    }
    EACH_WHILE(i, 9 + asked->few, asked->step != NULL) {
        const name_config config = { (i < 4) ? bad[i] : NAME_TOLERANCE, (uint8_t)((i < 8) ? NAME_MAX_STEPS : (unsigned int)(i - 8)),
            ((i < 4) || (i >= 8)) ? NAME_MAX_STEP : bad[i - 4] };
        const name_status status = (i >= 8) ? NAME_MAX_ITERATIONS : ((i % 4 < 2) ? NAME_OUT_OF_RANGE : NAME_NONFINITE);
        expect(asked->ask(&config, asked->values, asked->guesses, given, NULL) == status, "status by a config", i);
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
    ASK(jacobian, (@ga@configuration, jacobian))
    @feasible
    EACH(i, @entries) {
        const double wanted = (double)name_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "entry", i);
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
