/* Test of ankle.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "ankle.h"
#include "ankle_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N ANKLE_JOINTS
#define MOST (N * N * N + N * N + 7) /* numbers that any function takes or gives */

/* What is asked in plain numbers, of which a pose has seven. */
typedef ankle_status question(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info);

/* A function. kinds: of each number that is given, and then guessed, c: a coordinate, s: a speed,
 * l: what is never below 0. step: one step of tracking, of what reads a config and writes an info;
 * opposite: the problem by which answers are held where they are not the only ones. The numbers of
 * an answer, weighed, may be off by `share` times its bound and by `within` more. Where nothing is
 * solved there are no answers, where nothing is guessed no guesses. */
typedef struct function {
    const char *name;
    question *ask;
    const char *kinds;
    int given;
    int found;
    const ankle_real *values;
    const ankle_real *guesses;
    const ankle_real *answers;
    const double *weights;
    question *step;
    const struct function *opposite;
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const ankle_real wrong[3] = { (ankle_real)NAN, (ankle_real)INFINITY, -(ankle_real)INFINITY };
static const char *tested = ""; /* the function that is asked */
static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", tested, what, number);
    }
}

static void copy(const ankle_real *from, ankle_real *to, int count)
{
    for (int i = 0; i < count; ++i) {
        to[i] = from[i];
    }
}

/* The larger one; what is no number is above all. */
static double larger(double a, double b)
{
    return (a >= b) ? a : ((a < b) ? b : HUGE_VAL);
}

static ankle_status ask_direct(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    const ankle_status status = ankle_direct(config, given, guess, result, info);
    return status;
}

static ankle_status ask_inverse(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    const ankle_status status = ankle_inverse(config, given, guess, result, info);
    return status;
}

static ankle_status ask_track(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    const ankle_status status = ankle_track(given, result, info);
    return status;
}

static ankle_status ask_track_inverse(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    const ankle_status status = ankle_track_inverse(given, result, info);
    return status;
}

static ankle_status ask_jacobian(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_jacobian(given, &given[2], result);
    return status;
}

static ankle_status ask_rates(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_rates(given, &given[2], &given[4], result);
    return status;
}

static ankle_status ask_torques(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_torques(given, &given[2], &given[4], result);
    return status;
}

static ankle_status ask_inverse_jacobian(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_inverse_jacobian(given, &given[2], result);
    return status;
}

static ankle_status ask_second(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_second(given, &given[2], result, &result[4]);
    return status;
}

static ankle_status ask_inertia(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_inertia(given, &given[2], &given[4], result);
    return status;
}

static ankle_status ask_torque_limits(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_torque_limits(given, &given[2], &given[4], result);
    return status;
}

static ankle_status ask_rate_limits(const ankle_config *config, const ankle_real *given,
    const ankle_real *guess, ankle_real *result, ankle_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ankle_status status = ankle_rate_limits(given, &given[2], &given[4], result);
    return status;
}
/* Largest weighed difference; of q and -q, one rotation, the nearer one. */
static double away(const function *asked, const ankle_real *a, const ankle_real *b)
{
    double largest = 0.0;
    double cosine = 0.0;
    for (int i = 3; (i < 7) && (asked->found == 7); ++i) {
        cosine += (double)a[i] * (double)b[i];
    }
    for (int i = 0; i < asked->found; ++i) {
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
    for (int k = 0; k < ANKLE_VECTORS; ++k) {
        const double bound = ankle_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const ankle_real *const given = &asked->values[asked->given * k];
        const ankle_real *const guess = (asked->guesses == NULL)
            ? NULL : &asked->guesses[asked->found * k];
        const ankle_real *const answer = &asked->answers[asked->found * k];
        ankle_real result[MOST];
        ankle_real again[MOST];
        ankle_info info;
        for (int i = 0; i < asked->found; ++i) {
            result[i] = (guess != NULL) ? guess[i] : 4.0f;
        }
        expect(asked->ask(NULL, given, (asked->step != NULL) ? result : guess, result,
            &info) == ANKLE_OK, "OK", k);
        expect(away(asked, result, answer) <= most, "answer", k);
        if (asked->step != NULL) {
            expect((double)info.residual <= 16.0 * bound, "residual", k);
            expect(info.min_pivot > 0.0f, "smallest pivot", k);
            expect(info.joint == N, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == ANKLE_OK, "without info", k);
            for (int i = 0; i < 2; ++i) {
                copy(result, again, asked->found);
                expect(still[i](NULL, given, again, again, &info) == ANKLE_OK, "standing still", k);
                expect(away(asked, again, answer) <= most, "answer of standing still", k);
            }
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == ANKLE_OK, "asked back",
                k);
            expect(away(asked->opposite, again, given) <= bound, "answer asked back", k);
        }
    }
}

/* Values that are refused, by a function or its step: the status (OK: any but this), the joint that
 * is blamed, the result untouched, info written. */
static void refuse(const function *asked, question *ask, const ankle_real *given,
    const ankle_real *guess, ankle_status wanted, int joint, int number)
{
    ankle_real before[MOST];
    ankle_real result[MOST];
    ankle_info info;
    for (int i = 0; i < MOST; ++i) {
        before[i] = 4.0f;
    }
    if (ask == asked->step) {
        copy(guess, before, asked->found);
    }
    copy(before, result, MOST);
    info.iterations = 255U;
    info.joint = N;
    tested = asked->name;
    const ankle_status status = ask(NULL, given, guess, result, &info);
    expect((wanted == ANKLE_OK) ? (status != ANKLE_OK) : (status == wanted), "status of a refusal",
        number);
    expect(memcmp(before, result, sizeof before) == 0, "result untouched by a refusal", number);
    if (asked->step != NULL) {
        expect(info.iterations != 255U, "info of a refusal", number);
        expect((joint < 0) || ((int)info.joint == joint), "joint of a refusal", number);
    }
}

/* Each number that is given or guessed in turn not finite, or out of all bounds; wrong configs, and
 * too few steps. */
static void refuse_values(const function *asked)
{
    const ankle_real bad[4] = { 0.0f, -1.0f, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    ankle_real given[2 * MOST];
    ankle_real *const guess = &given[asked->given];
    for (int i = 0; i < count; ++i) {
        const ankle_real out = (asked->kinds[i] == 'c')
            ? 2.6201145e+06f : ((asked->kinds[i] == 's') ? (ankle_real)1e30 : -1.0f);
        const int of_guess = i >= asked->given;
        for (int k = 0; k < 5; ++k) {
            const int joint = (asked->blamed != 1 + of_guess) ? -1 : (of_guess
                ? (i - asked->given) : i);
            const ankle_status status = (k < 3) ? ANKLE_NONFINITE : ANKLE_OUT_OF_RANGE;
            copy(asked->values, given, asked->given);
            if (asked->guesses != NULL) {
                copy(asked->guesses, guess, asked->found);
            }
            given[i] = (k < 3) ? wrong[k] : (((k == 3) || (out < 0.0f)) ? out : -out);
            refuse(asked, asked->ask, given, guess, status, joint, 5 * i + k);
            if (asked->step != NULL) {
                refuse(asked, asked->step, given, guess, status, joint, 5 * i + k);
            }
        }
    }
    for (int i = 0; (i < 9 + asked->few) && asked->step != NULL; ++i) {
        const ankle_config config = { (i < 4) ? bad[i] : ANKLE_TOLERANCE,
            (uint8_t)((i < 8) ? ANKLE_MAX_STEPS : (unsigned int)(i - 8)),
            ((i < 4) || (i >= 8)) ? ANKLE_MAX_STEP : bad[i - 4] };
        const ankle_status status = (i >= 8) ? ANKLE_MAX_ITERATIONS : ((i % 4 < 2)
            ? ANKLE_OUT_OF_RANGE : ANKLE_NONFINITE);
        expect(asked->ask(&config, asked->values, asked->guesses, given, NULL) == status,
            "status by a config", i);
    }
}

/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of
 * each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const ankle_real *rows, int count, int as_guess,
    ankle_status wanted, const int *blamed)
{
    for (int k = 0; k < count; ++k) {
        const ankle_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const ankle_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, asked->ask, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 0.0001;
    ankle_real jacobian[MOST];
    const ankle_real *const joints = ankle_vector_joints[k];
    const ankle_real *const found = ankle_vector_found[k];
    tested = "jacobian";
    expect(ankle_jacobian(joints, found, jacobian) == ANKLE_OK, "OK", k);
    for (int i = 0; i < N * N; ++i) {
        const double wanted = (double)ankle_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "entry", i);
    }
}

/* The sum of products of N numbers each, which stand so far apart, and in *size of their
 * magnitudes. */
static double product(const ankle_real *a, int apart, const ankle_real *b, int from, double *size)
{
    double sum = 0.0;
    *size = 1.0;
    for (int i = 0; i < N; ++i) {
        const double part = (double)a[apart * i] * (double)b[from * i];
        sum += part;
        *size += fabs(part);
    }
    return sum;
}

/* The law of virtual power: joint torques on joint rates do what found torques do on found rates.
 * Second derivatives; the inverse Jacobian against the Jacobian; that joints and found coordinates
 * have the same kinetic energy; that a found torque, and a rate, at its limit has one joint at its
 * own, and none beyond. */
static void derivatives_of(int k)
{
    const ankle_real *const joints = ankle_vector_joints[k];
    const ankle_real *const found = ankle_vector_found[k];
    ankle_real own[N];
    ankle_real speeds[N];
    ankle_real jacobian[N * N];
    ankle_real inverse[N * N];
    ankle_real inertia[N * N];
    ankle_real again[N * N];
    ankle_real second[N * N * N];
    ankle_real torques[N];
    ankle_real rates[N];
    double most = 1.0;
    double off = 0.0;
    double size;
    double other;
    for (int i = 0; i < N; ++i) {
        own[i] = (ankle_real)(1 + i);
        speeds[i] = (ankle_real)(2 - i);
    }
    tested = "rates";
    expect(ankle_rates(joints, found, speeds, rates) == ANKLE_OK, "OK", k);
    tested = "torques";
    expect(ankle_torques(joints, found, own, torques) == ANKLE_OK, "OK", k);
    const double power = product(own, 1, rates, 1, &size) - product(torques, 1, speeds, 1, &other);
    expect(fabs(power) <= 1e-4 * size, "power", k);
    tested = "jacobian";
    expect(ankle_jacobian(joints, found, jacobian) == ANKLE_OK, "OK", k);
    tested = "inverse_jacobian";
    expect(ankle_inverse_jacobian(joints, found, inverse) == ANKLE_OK, "OK", k);
    tested = "second";
    expect(ankle_second(joints, found, NULL, second) == ANKLE_OK, "OK", k);
    tested = "second";
    expect(ankle_second(joints, found, again, second) == ANKLE_OK, "OK", k);
    expect(memcmp(again, jacobian, sizeof again) == 0, "jacobian", k);
    for (int i = 0; i < N * N * N; ++i) {
        const double wanted = (double)ankle_vector_seconds[k][i];
        most = larger(most, fabs(wanted));
        off = larger(off, fabs((double)second[i] - wanted));
    }
    expect(off <= 10.0 * 1e-4 * most, "entry", k);
    tested = "inertia";
    expect(ankle_inertia(joints, found, own, inertia) == ANKLE_OK, "OK", k);
    tested = "torque_limits";
    expect(ankle_torque_limits(joints, found, own, torques) == ANKLE_OK, "OK", k);
    tested = "rate_limits";
    expect(ankle_rate_limits(joints, found, own, rates) == ANKLE_OK, "OK", k);
    for (int i = 0; i < N; ++i) {
        const ankle_real *const row = &jacobian[N * i];
        double torque = 0.0;
        double rate = 0.0;
        for (int j = 0; j < N; ++j) {
            const double one = product(row, 1, &inverse[j], N, &size) - ((i == j) ? 1.0 : 0.0);
            expect(fabs(one) <= 10.0 * 1e-4 * size, "the Jacobian times its inverse", k);
            /* the inertia times a column of the Jacobian is that of the joint times one of the
             * inverse */
            const double there = product(&inertia[N * i], 1, &jacobian[j], N, &size);
            const double here = (double)own[j] * (double)inverse[N * j + i];
            expect(fabs(there - here) <= 10.0 * 1e-4 * size, "inertia", k);
            torque = larger(torque, fabs((double)row[j] * (double)torques[i]) / (double)own[j]);
            rate = larger(rate, fabs((double)inverse[N * j
                + i] * (double)rates[i]) / (double)own[j]);
        }
        expect(fabs(torque - 1.0) <= 1e-4, "torque at its limit", i);
        expect(fabs(rate - 1.0) <= 1e-4, "rate at its limit", i);
    }
}
int main(void)
{
    static const double weights_of_direct[] = { 262.01145013147806, 262.01145013147806 };
    const function of_direct = { "direct", ask_direct, "cccc", 2, 2, &ankle_vector_joints[0][0],
        &ankle_vector_guesses[0][0], &ankle_vector_found[0][0], weights_of_direct, ask_track, NULL,
        1, 0, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 262.01145013147806, 262.01145013147806 };
    const function of_inverse = { "inverse", ask_inverse, "cccc", 2, 2, &ankle_vector_found[0][0],
        &ankle_vector_joint_guesses[0][0], &ankle_vector_inverse[0][0], weights_of_inverse,
        ask_track_inverse, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_jacobian[] = { -0x1.0e3e1c0000000p-3f,
        -0x1.7df2080000000p-6f, -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f };
    const function of_jacobian = { "jacobian", ask_jacobian, "cccc", 4, 4, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_rates[] = { -0x1.0e3e1c0000000p-3f, -0x1.7df2080000000p-6f,
        -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_rates = { "rates", ask_rates, "ccccss", 6, 2, numbers_of_rates, NULL, NULL,
        NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_torques[] = { -0x1.0e3e1c0000000p-3f,
        -0x1.7df2080000000p-6f, -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_torques = { "torques", ask_torques, "ccccss", 6, 2, numbers_of_torques, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_inverse_jacobian[] = { -0x1.0e3e1c0000000p-3f,
        -0x1.7df2080000000p-6f, -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f };
    const function of_inverse_jacobian = { "inverse_jacobian", ask_inverse_jacobian, "cccc", 4, 4,
        numbers_of_inverse_jacobian, NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_second[] = { -0x1.0e3e1c0000000p-3f, -0x1.7df2080000000p-6f,
        -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f };
    const function of_second = { "second", ask_second, "cccc", 4, 12, numbers_of_second, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_inertia[] = { -0x1.0e3e1c0000000p-3f,
        -0x1.7df2080000000p-6f, -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_inertia = { "inertia", ask_inertia, "ccccll", 6, 4, numbers_of_inertia, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_torque_limits[] = { -0x1.0e3e1c0000000p-3f,
        -0x1.7df2080000000p-6f, -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_torque_limits = { "torque_limits", ask_torque_limits, "ccccll", 6, 2,
        numbers_of_torque_limits, NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ankle_real numbers_of_rate_limits[] = { -0x1.0e3e1c0000000p-3f,
        -0x1.7df2080000000p-6f, -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_rate_limits = { "rate_limits", ask_rate_limits, "ccccll", 6, 2,
        numbers_of_rate_limits, NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    const function *const all[] = { &of_direct, &of_inverse, &of_jacobian, &of_rates, &of_torques,
        &of_inverse_jacobian, &of_second, &of_inertia, &of_torque_limits, &of_rate_limits };
    for (int i = 0; i < 10; ++i) {
        if (all[i]->answers != NULL) {
            solve_all(all[i]);
        }
        refuse_values(all[i]);
    }
    for (int k = 0; k < ANKLE_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        derivatives_of(k);
    }
    refuse_rows(&of_direct, &ankle_vector_infeasible_joints[0][0], 5, 0, ANKLE_OK, NULL);
    refuse_rows(&of_inverse, &ankle_vector_infeasible_found[0][0], 3, 0, ANKLE_OK, NULL);
    (void)printf("ankle: %d cases, %d failures\n", ANKLE_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
