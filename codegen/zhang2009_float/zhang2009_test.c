/* Test of zhang2009.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "zhang2009.h"
#include "zhang2009_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N ZHANG2009_JOINTS
#define MOST (6 * N + 13) /* numbers that any function takes or gives */

/* What is asked in plain numbers, of which a pose has seven. */
typedef zhang2009_status question(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info);

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
    const zhang2009_real *values;
    const zhang2009_real *guesses;
    const zhang2009_real *answers;
    const double *weights;
    question *step;
    const struct function *opposite;
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const zhang2009_real wrong[3] = { (zhang2009_real)NAN, (zhang2009_real)INFINITY,
    -(zhang2009_real)INFINITY };
static const char *tested = ""; /* the function that is asked */
static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", tested, what, number);
    }
}

static void copy(const zhang2009_real *from, zhang2009_real *to, int count)
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

static zhang2009_pose pose_from(const zhang2009_real *numbers)
{
    zhang2009_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const zhang2009_pose *pose, zhang2009_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}
static zhang2009_status ask_direct(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose guess_pose = pose_from(guess);
    zhang2009_pose result_pose = pose_from(result);
    const zhang2009_status status = zhang2009_direct(config, given,
        (guess == result) ? &result_pose : &guess_pose, &result_pose, info);
    numbers_of(&result_pose, result);
    return status;
}

static zhang2009_status ask_track(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose result_pose = pose_from(result);
    (void)config;
    (void)guess;
    const zhang2009_status status = zhang2009_track(given, &result_pose, info);
    numbers_of(&result_pose, result);
    return status;
}

static zhang2009_status ask_inverse(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhang2009_status status = zhang2009_inverse(&given_pose, result);
    return status;
}

static zhang2009_status ask_jacobian(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhang2009_status status = zhang2009_jacobian(&given_pose, result);
    return status;
}

static zhang2009_status ask_rates(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhang2009_status status = zhang2009_rates(&given_pose, &given[7], result);
    return status;
}

static zhang2009_status ask_twist(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhang2009_status status = zhang2009_twist(&given_pose, &given[7], result);
    return status;
}

static zhang2009_status ask_feed(const zhang2009_config *config, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info)
{
    zhang2009_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhang2009_status status = zhang2009_feed(&given_pose, &given[7], &given[13], result);
    return status;
}
/* Largest weighed difference; of q and -q, one rotation, the nearer one. */
static double away(const function *asked, const zhang2009_real *a, const zhang2009_real *b)
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
    for (int k = 0; k < ZHANG2009_VECTORS; ++k) {
        const double bound = zhang2009_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const zhang2009_real *const given = &asked->values[asked->given * k];
        const zhang2009_real *const guess = (asked->guesses == NULL)
            ? NULL : &asked->guesses[asked->found * k];
        const zhang2009_real *const answer = &asked->answers[asked->found * k];
        zhang2009_real result[MOST];
        zhang2009_real again[MOST];
        zhang2009_info info;
        for (int i = 0; i < asked->found; ++i) {
            result[i] = (guess != NULL) ? guess[i] : 4.0f;
        }
        expect(asked->ask(NULL, given, (asked->step != NULL) ? result : guess, result,
            &info) == ZHANG2009_OK, "OK", k);
        expect(away(asked, result, answer) <= most, "answer", k);
        if (asked->step != NULL) {
            expect((double)info.residual <= 16.0 * bound, "residual", k);
            expect(info.min_pivot > 0.0f, "smallest pivot", k);
            expect(info.joint == N, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == ZHANG2009_OK, "without info", k);
            for (int i = 0; i < 2; ++i) {
                copy(result, again, asked->found);
                expect(still[i](NULL, given, again, again, &info) == ZHANG2009_OK,
                    "standing still", k);
                expect(away(asked, again, answer) <= most, "answer of standing still", k);
            }
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == ZHANG2009_OK,
                "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, "answer asked back", k);
        }
    }
}

/* Values that are refused, by a function or its step: the status (OK: any but this), the joint that
 * is blamed, the result untouched, info written. */
static void refuse(const function *asked, question *ask, const zhang2009_real *given,
    const zhang2009_real *guess, zhang2009_status wanted, int joint, int number)
{
    zhang2009_real before[MOST];
    zhang2009_real result[MOST];
    zhang2009_info info;
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
    const zhang2009_status status = ask(NULL, given, guess, result, &info);
    expect((wanted == ZHANG2009_OK) ? (status != ZHANG2009_OK) : (status == wanted),
        "status of a refusal", number);
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
    const zhang2009_real bad[4] = { 0.0f, -1.0f, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    zhang2009_real given[2 * MOST];
    zhang2009_real *const guess = &given[asked->given];
    for (int i = 0; i < count; ++i) {
        const zhang2009_real out = (asked->kinds[i] == 'c')
            ? 5.312592e+06f : ((asked->kinds[i] == 's') ? (zhang2009_real)1e30 : -1.0f);
        const int of_guess = i >= asked->given;
        for (int k = 0; k < 5; ++k) {
            const int joint = (asked->blamed != 1 + of_guess) ? -1 : (of_guess
                ? (i - asked->given) : i);
            const zhang2009_status status = (k < 3) ? ZHANG2009_NONFINITE : ZHANG2009_OUT_OF_RANGE;
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
        const zhang2009_config config = { (i < 4) ? bad[i] : ZHANG2009_TOLERANCE,
            (uint8_t)((i < 8) ? ZHANG2009_MAX_STEPS : (unsigned int)(i - 8)),
            ((i < 4) || (i >= 8)) ? ZHANG2009_MAX_STEP : bad[i - 4] };
        const zhang2009_status status = (i >= 8) ? ZHANG2009_MAX_ITERATIONS : ((i % 4 < 2)
            ? ZHANG2009_OUT_OF_RANGE : ZHANG2009_NONFINITE);
        expect(asked->ask(&config, asked->values, asked->guesses, given, NULL) == status,
            "status by a config", i);
    }
}

/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of
 * each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const zhang2009_real *rows, int count, int as_guess,
    zhang2009_status wanted, const int *blamed)
{
    for (int k = 0; k < count; ++k) {
        const zhang2009_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const zhang2009_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, asked->ask, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 0.0531259;
    zhang2009_real jacobian[MOST];
    const zhang2009_pose pose = pose_from(zhang2009_vector_poses[k]);
    tested = "jacobian";
    expect(zhang2009_jacobian(&pose, jacobian) == ZHANG2009_OK, "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)zhang2009_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "entry", i);
    }
}

/* Rates of the twist of rates are these rates. The feed keeps the limits, and one joint reaches its
 * own where it is below 1. */
static void speeds_of(int k)
{
    const zhang2009_pose pose = pose_from(zhang2009_vector_poses[k]);
    zhang2009_real rates[N];
    zhang2009_real again[N];
    zhang2009_real twist[6] = { 0.0f };
    zhang2009_real limits[N];
    zhang2009_real feed = 0.0f;
    for (int i = 0; i < N; ++i) {
        rates[i] = (zhang2009_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1)
            ? -0.5 : 0.25) * ((double)ZHANG2009_SIZE));
    }
    tested = "twist";
    expect(zhang2009_twist(&pose, rates, twist) == ZHANG2009_OK, "OK", k);
    tested = "rates";
    expect(zhang2009_rates(&pose, twist, again) == ZHANG2009_OK, "OK", k);
    for (int i = 0; i < N; ++i) {
        const double off = fabs((double)again[i] - (double)rates[i]);
        expect(off <= 1e-3 * ((double)ZHANG2009_SIZE), "rates of the twist of rates", i);
    }
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (zhang2009_real)(limit * ((double)ZHANG2009_SIZE));
        }
        tested = "feed";
        expect(zhang2009_feed(&pose, twist, limits, &feed) == ZHANG2009_OK, "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = larger(largest, fabs((double)feed
                * (double)again[i]) / ((double)ZHANG2009_SIZE));
        }
        expect(largest <= limit * (1.0 + 1e-5), "keeps limits", k);
        expect((feed == 1.0f) || (largest >= limit * (1.0 - 1e-5)), "reaches a limit", k);
    }
    expect(feed == 1.0f, "no need for one", k);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 1062.5184089179752,
        1062.5184089179752, 1062.5184089179752, 1062.5184089179752 };
    const function of_direct = { "direct", ask_direct, "ccccccccccccc", 6, 7,
        &zhang2009_vector_joints[0][0], &zhang2009_vector_guesses[0][0],
        &zhang2009_vector_poses[0][0], weights_of_direct, ask_track, NULL, 1, 1, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 1.0, 1.0, 1.0, 1.0, 1.0, 1.0 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccc", 7, 6,
        &zhang2009_vector_poses[0][0], NULL, &zhang2009_vector_inverse[0][0], weights_of_inverse,
        NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhang2009_real numbers_of_jacobian[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f };
    const function of_jacobian = { "jacobian", ask_jacobian, "ccccccc", 7, 36, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhang2009_real numbers_of_rates[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_rates = { "rates", ask_rates, "cccccccssssss", 13, 6, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhang2009_real numbers_of_twist[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_twist = { "twist", ask_twist, "cccccccssssss", 13, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhang2009_real numbers_of_feed[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_feed = { "feed", ask_feed, "cccccccssssssllllll", 19, 1, numbers_of_feed,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    const function *const all[] = { &of_direct, &of_inverse, &of_jacobian, &of_rates, &of_twist,
        &of_feed };
    for (int i = 0; i < 6; ++i) {
        if (all[i]->answers != NULL) {
            solve_all(all[i]);
        }
        refuse_values(all[i]);
    }
    for (int k = 0; k < ZHANG2009_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        speeds_of(k);
    }
    refuse_rows(&of_direct, &zhang2009_vector_singular[0][0], 1, 1, ZHANG2009_SINGULAR, NULL);
    refuse_rows(&of_direct, &zhang2009_vector_doubled[0][0], 1, 1, ZHANG2009_OUT_OF_RANGE, NULL);
    refuse_rows(&of_inverse, &zhang2009_vector_doubled[0][0], 1, 0, ZHANG2009_OUT_OF_RANGE, NULL);
    refuse(&of_direct, ask_track, zhang2009_vector_joints[0], zhang2009_vector_far,
        ZHANG2009_WRONG_BRANCH, -1, 0);
    (void)printf("zhang2009: %d cases, %d failures\n", ZHANG2009_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
