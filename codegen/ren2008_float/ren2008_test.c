/* Test of ren2008.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "ren2008.h"
#include "ren2008_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N REN2008_JOINTS
#define MOST (6 * N + 13) /* numbers that any function takes or gives */

/* What is asked in plain numbers, of which a pose has seven. */
typedef ren2008_status question(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info);

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
    const ren2008_real *values;
    const ren2008_real *guesses;
    const ren2008_real *answers;
    const double *weights;
    question *step;
    const struct function *opposite;
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const ren2008_real wrong[3] = { (ren2008_real)NAN, (ren2008_real)INFINITY,
    -(ren2008_real)INFINITY };
static const char *tested = ""; /* the function that is asked */
static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", tested, what, number);
    }
}

static void copy(const ren2008_real *from, ren2008_real *to, int count)
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

static ren2008_pose pose_from(const ren2008_real *numbers)
{
    ren2008_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const ren2008_pose *pose, ren2008_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}
static ren2008_status ask_direct(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose guess_pose = pose_from(guess);
    ren2008_pose result_pose = pose_from(result);
    const ren2008_status status = ren2008_direct(config, given,
        (guess == result) ? &result_pose : &guess_pose, &result_pose, info);
    numbers_of(&result_pose, result);
    return status;
}

static ren2008_status ask_track(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose result_pose = pose_from(result);
    (void)config;
    (void)guess;
    const ren2008_status status = ren2008_track(given, &result_pose, info);
    numbers_of(&result_pose, result);
    return status;
}

static ren2008_status ask_inverse(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const ren2008_status status = ren2008_inverse(&given_pose, result);
    return status;
}

static ren2008_status ask_jacobian(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const ren2008_status status = ren2008_jacobian(&given_pose, result);
    return status;
}

static ren2008_status ask_rates(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const ren2008_status status = ren2008_rates(&given_pose, &given[7], result);
    return status;
}

static ren2008_status ask_twist(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const ren2008_status status = ren2008_twist(&given_pose, &given[7], result);
    return status;
}

static ren2008_status ask_feed(const ren2008_config *config, const ren2008_real *given,
    const ren2008_real *guess, ren2008_real *result, ren2008_info *info)
{
    ren2008_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const ren2008_status status = ren2008_feed(&given_pose, &given[7], &given[13], result);
    return status;
}
/* Largest weighed difference; of q and -q, one rotation, the nearer one. */
static double away(const function *asked, const ren2008_real *a, const ren2008_real *b)
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
    for (int k = 0; k < REN2008_VECTORS; ++k) {
        const double bound = ren2008_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const ren2008_real *const given = &asked->values[asked->given * k];
        const ren2008_real *const guess = (asked->guesses == NULL)
            ? NULL : &asked->guesses[asked->found * k];
        const ren2008_real *const answer = &asked->answers[asked->found * k];
        ren2008_real result[MOST];
        ren2008_real again[MOST];
        ren2008_info info;
        for (int i = 0; i < asked->found; ++i) {
            result[i] = (guess != NULL) ? guess[i] : 4.0f;
        }
        expect(asked->ask(NULL, given, (asked->step != NULL) ? result : guess, result,
            &info) == REN2008_OK, "OK", k);
        expect(away(asked, result, answer) <= most, "answer", k);
        if (asked->step != NULL) {
            expect((double)info.residual <= 16.0 * bound, "residual", k);
            expect(info.min_pivot > 0.0f, "smallest pivot", k);
            expect(info.joint == N, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == REN2008_OK, "without info", k);
            for (int i = 0; i < 2; ++i) {
                copy(result, again, asked->found);
                expect(still[i](NULL, given, again, again, &info) == REN2008_OK, "standing still",
                    k);
                expect(away(asked, again, answer) <= most, "answer of standing still", k);
            }
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == REN2008_OK,
                "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, "answer asked back", k);
        }
    }
}

/* Values that are refused, by a function or its step: the status (OK: any but this), the joint that
 * is blamed, the result untouched, info written. */
static void refuse(const function *asked, question *ask, const ren2008_real *given,
    const ren2008_real *guess, ren2008_status wanted, int joint, int number)
{
    ren2008_real before[MOST];
    ren2008_real result[MOST];
    ren2008_info info;
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
    const ren2008_status status = ask(NULL, given, guess, result, &info);
    expect((wanted == REN2008_OK) ? (status != REN2008_OK) : (status == wanted),
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
    const ren2008_real bad[4] = { 0.0f, -1.0f, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    ren2008_real given[2 * MOST];
    ren2008_real *const guess = &given[asked->given];
    for (int i = 0; i < count; ++i) {
        const ren2008_real out = (asked->kinds[i] == 'c') ? 16901.664f : ((asked->kinds[i] == 's')
            ? (ren2008_real)1e30 : -1.0f);
        const int of_guess = i >= asked->given;
        for (int k = 0; k < 5; ++k) {
            const int joint = (asked->blamed != 1 + of_guess) ? -1 : (of_guess
                ? (i - asked->given) : i);
            const ren2008_status status = (k < 3) ? REN2008_NONFINITE : REN2008_OUT_OF_RANGE;
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
        const ren2008_config config = { (i < 4) ? bad[i] : REN2008_TOLERANCE,
            (uint8_t)((i < 8) ? REN2008_MAX_STEPS : (unsigned int)(i - 8)),
            ((i < 4) || (i >= 8)) ? REN2008_MAX_STEP : bad[i - 4] };
        const ren2008_status status = (i >= 8) ? REN2008_MAX_ITERATIONS : ((i % 4 < 2)
            ? REN2008_OUT_OF_RANGE : REN2008_NONFINITE);
        expect(asked->ask(&config, asked->values, asked->guesses, given, NULL) == status,
            "status by a config", i);
    }
}

/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of
 * each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const ren2008_real *rows, int count, int as_guess,
    ren2008_status wanted, const int *blamed)
{
    for (int k = 0; k < count; ++k) {
        const ren2008_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const ren2008_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, asked->ask, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 0.000169017;
    ren2008_real jacobian[MOST];
    const ren2008_pose pose = pose_from(ren2008_vector_poses[k]);
    tested = "jacobian";
    expect(ren2008_jacobian(&pose, jacobian) == REN2008_OK, "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)ren2008_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "entry", i);
    }
}

/* Rates of the twist of rates are these rates. The feed keeps the limits, and one joint reaches its
 * own where it is below 1. */
static void speeds_of(int k)
{
    const ren2008_pose pose = pose_from(ren2008_vector_poses[k]);
    ren2008_real rates[N];
    ren2008_real again[N];
    ren2008_real twist[6] = { 0.0f };
    ren2008_real limits[N];
    ren2008_real feed = 0.0f;
    for (int i = 0; i < N; ++i) {
        rates[i] = (ren2008_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1)
            ? -0.5 : 0.25) * ((double)REN2008_SIZE));
    }
    tested = "twist";
    expect(ren2008_twist(&pose, rates, twist) == REN2008_OK, "OK", k);
    tested = "rates";
    expect(ren2008_rates(&pose, twist, again) == REN2008_OK, "OK", k);
    for (int i = 0; i < N; ++i) {
        const double off = fabs((double)again[i] - (double)rates[i]);
        expect(off <= 1e-3 * ((double)REN2008_SIZE), "rates of the twist of rates", i);
    }
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (ren2008_real)(limit * ((double)REN2008_SIZE));
        }
        tested = "feed";
        expect(ren2008_feed(&pose, twist, limits, &feed) == REN2008_OK, "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = larger(largest, fabs((double)feed
                * (double)again[i]) / ((double)REN2008_SIZE));
        }
        expect(largest <= limit * (1.0 + 1e-5), "keeps limits", k);
        expect((feed == 1.0f) || (largest >= limit * (1.0 - 1e-5)), "reaches a limit", k);
    }
    expect(feed == 1.0f, "no need for one", k);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 3.3803326759359056,
        3.3803326759359056, 3.3803326759359056, 3.3803326759359056 };
    const function of_direct = { "direct", ask_direct, "ccccccccccccc", 6, 7,
        &ren2008_vector_joints[0][0], &ren2008_vector_guesses[0][0], &ren2008_vector_poses[0][0],
        weights_of_direct, ask_track, NULL, 1, 1, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 1.0, 1.0, 1.0, 1.0, 1.0, 1.0 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccc", 7, 6,
        &ren2008_vector_poses[0][0], NULL, &ren2008_vector_inverse[0][0], weights_of_inverse, NULL,
        NULL, 0, 0, 1.0, 0.0 };
    static const ren2008_real numbers_of_jacobian[] = { -0x1.306dd80000000p-2f,
        0x1.95e8ca0000000p-2f, 0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f };
    const function of_jacobian = { "jacobian", ask_jacobian, "ccccccc", 7, 36, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ren2008_real numbers_of_rates[] = { -0x1.306dd80000000p-2f, 0x1.95e8ca0000000p-2f,
        0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_rates = { "rates", ask_rates, "cccccccssssss", 13, 6, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ren2008_real numbers_of_twist[] = { -0x1.306dd80000000p-2f, 0x1.95e8ca0000000p-2f,
        0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_twist = { "twist", ask_twist, "cccccccssssss", 13, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ren2008_real numbers_of_feed[] = { -0x1.306dd80000000p-2f, 0x1.95e8ca0000000p-2f,
        0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f, 0x1.0000000000000p+0f,
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
    for (int k = 0; k < REN2008_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        speeds_of(k);
    }
    static const int blamed[] = { 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5 };
    refuse_rows(&of_direct, &ren2008_vector_past[0][0], 12, 0, REN2008_OUT_OF_RANGE, blamed);
    refuse_rows(&of_direct, &ren2008_vector_singular[0][0], 1, 1, REN2008_SINGULAR, NULL);
    refuse_rows(&of_direct, &ren2008_vector_doubled[0][0], 1, 1, REN2008_OUT_OF_RANGE, NULL);
    refuse_rows(&of_inverse, &ren2008_vector_doubled[0][0], 1, 0, REN2008_OUT_OF_RANGE, NULL);
    refuse(&of_direct, ask_track, ren2008_vector_joints[0], ren2008_vector_far,
        REN2008_WRONG_BRANCH, -1, 0);
    (void)printf("ren2008: %d cases, %d failures\n", REN2008_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
