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

/* A function of plain numbers, of which a pose has seven. kinds: of each number that is given, and
 * then guessed, c: a coordinate, s: a speed, l: what is never below 0. step: one step of tracking;
 * opposite: the problem by which answers are held where they are not the only ones. The numbers of
 * an answer, weighed, may be off by `share` times its bound and by `within` more. Where nothing is
 * solved there are no answers, where nothing is guessed no guesses. */
typedef struct function {
    const char *name;
    zhang2009_status (*ask)(const zhang2009_config *config, const zhang2009_real *given,
        const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info);
    const char *kinds;
    int given;
    int found;
    const zhang2009_real *values;
    const zhang2009_real *guesses;
    const zhang2009_real *answers;
    const double *weights;
    zhang2009_status (*step)(const zhang2009_config *config, const zhang2009_real *given,
        const zhang2009_real *guess, zhang2009_real *result, zhang2009_info *info);
    const struct function *opposite;
    int informs; /* whether a config is read and an info written */
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    unsigned int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const zhang2009_real wrong[3] = { (zhang2009_real)NAN, (zhang2009_real)INFINITY,
    -(zhang2009_real)INFINITY };
static int failures = 0;

static void expect(int right, const char *of, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", of, what, number);
    }
}

static void copy(const zhang2009_real *from, zhang2009_real *to, int count)
{
    for (int i = 0; i < count; ++i) {
        to[i] = from[i];
    }
}

static int all_are(const zhang2009_real *values, int count, zhang2009_real value)
{
    int same = 1;
    for (int i = 0; i < count; ++i) {
        same = same && (values[i] == value);
    }
    return same;
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
/* Largest weighed difference; of q and -q, one rotation, the nearer one. NaN is the largest. */
static double away(const function *asked, const zhang2009_real *a, const zhang2009_real *b)
{
    double largest = 0.0;
    double cosine = 0.0;
    for (int i = 3; (i < 7) && (asked->found == 7); ++i) {
        cosine += (double)a[i] * (double)b[i];
    }
    for (int i = 0; i < asked->found; ++i) {
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
        expect(asked->ask(NULL, given, asked->informs ? result : guess, result,
            &info) == ZHANG2009_OK, name, "OK", k);
        expect(away(asked, result, answer) <= most, name, "answer", k);
        if (asked->informs) {
            expect((double)info.residual <= 16.0 * bound, name, "residual", k);
            expect(info.min_pivot > 0.0f, name, "smallest pivot", k);
            expect(info.joint == N, name, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == ZHANG2009_OK, name,
                "without info", k);
            copy(result, again, asked->found);
            expect(asked->ask(NULL, given, again, again, &info) == ZHANG2009_OK, name,
                "standing still", k);
            expect(away(asked, again, answer) <= most, name, "answer of standing still", k);
        }
        if (asked->step != NULL) {
            copy(result, again, asked->found);
            expect(asked->step(NULL, given, NULL, again, &info) == ZHANG2009_OK, name, "track", k);
            expect(away(asked, again, answer) <= most, name, "answer of track", k);
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == ZHANG2009_OK, name,
                "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, name, "answer asked back", k);
        }
    }
}

/* Values that are refused: the status (OK: any but this), the joint that is blamed, the result
 * untouched, info written. */
static void refuse(const function *asked, const zhang2009_real *given, const zhang2009_real *guess,
    zhang2009_status wanted, int joint, int number)
{
    zhang2009_real result[MOST];
    zhang2009_info info;
    for (int i = 0; i < MOST; ++i) {
        result[i] = 4.0f;
    }
    info.iterations = 255U;
    info.joint = N;
    const zhang2009_status status = asked->ask(NULL, given, guess, result, &info);
    expect((wanted == ZHANG2009_OK) ? (status != ZHANG2009_OK) : (status == wanted), asked->name,
        "status of a refusal", number);
    expect(all_are(result, MOST, 4.0f), asked->name, "result untouched by a refusal", number);
    if (asked->informs) {
        expect(info.iterations != 255U, asked->name, "info of a refusal", number);
        expect((joint < 0) || ((int)info.joint == joint), asked->name, "joint of a refusal",
            number);
    }
}

/* A step that is refused: the status, the result untouched. */
static void refuse_step(const function *asked, const zhang2009_real *given,
    const zhang2009_real *last, zhang2009_status wanted, int number)
{
    zhang2009_real result[MOST];
    copy(last, result, asked->found);
    expect(asked->step(NULL, given, NULL, result, NULL) == wanted, asked->name,
        "status of a step refused", number);
    expect(memcmp(last, result, (size_t)asked->found * sizeof result[0]) == 0, asked->name,
        "result untouched by a step refused", number);
}

/* Each number that is given or guessed in turn not finite, or out of all bounds; wrong configs, and
 * too few steps. */
static void refuse_values(const function *asked)
{
    const zhang2009_real bad[4] = { 0.0f, -1.0f, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    zhang2009_real given[MOST];
    zhang2009_real guess[MOST];
    for (int i = 0; i < count; ++i) {
        const zhang2009_real out = (asked->kinds[i] == 'c')
            ? 5.312592e+06f : ((asked->kinds[i] == 's') ? (zhang2009_real)1e30 : -1.0f);
        for (int k = 0; k < 5; ++k) {
            const int place = (i < asked->given) ? i : (i - asked->given);
            const int joint = (asked->blamed == ((i < asked->given) ? 1 : 2)) ? place : -1;
            const zhang2009_status status = (k < 3) ? ZHANG2009_NONFINITE : ZHANG2009_OUT_OF_RANGE;
            copy(asked->values, given, asked->given);
            if (asked->guesses != NULL) {
                copy(asked->guesses, guess, asked->found);
            }
            *((i < asked->given) ? &given[place] : &guess[place]) = (k < 3)
                ? wrong[k] : (((k == 3) || (out < 0.0f)) ? out : -out);
            refuse(asked, given, guess, status, joint, 5 * i + k);
            if (asked->step != NULL) {
                refuse_step(asked, given, guess, status, 5 * i + k);
            }
        }
    }
    for (int i = 0; (i < 8) && asked->informs; ++i) {
        const zhang2009_config config = { (i < 4) ? bad[i] : ZHANG2009_TOLERANCE,
            ZHANG2009_MAX_STEPS, (i < 4) ? ZHANG2009_MAX_STEP : bad[i - 4] };
        const zhang2009_status status = asked->ask(&config, asked->values, asked->guesses, guess,
            NULL);
        expect(status == ((i % 4 < 2) ? ZHANG2009_OUT_OF_RANGE : ZHANG2009_NONFINITE), asked->name,
            "status of a wrong config", i);
    }
    for (unsigned int steps = 0U; (steps <= asked->few) && asked->informs; ++steps) {
        const zhang2009_config config = { ZHANG2009_TOLERANCE, (uint8_t)steps, ZHANG2009_MAX_STEP };
        const zhang2009_status status = asked->ask(&config, asked->values, asked->guesses, guess,
            NULL);
        expect(status == ZHANG2009_MAX_ITERATIONS, asked->name, "status of too few steps",
            (int)steps);
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
        refuse(asked, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 0.0531259;
    zhang2009_real jacobian[MOST];
    const zhang2009_pose pose = pose_from(zhang2009_vector_poses[k]);
    expect(zhang2009_jacobian(&pose, jacobian) == ZHANG2009_OK, "jacobian", "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)zhang2009_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "jacobian",
            "entry", i);
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
    expect(zhang2009_twist(&pose, rates, twist) == ZHANG2009_OK, "twist", "OK", k);
    expect(zhang2009_rates(&pose, twist, again) == ZHANG2009_OK, "rates", "OK", k);
    for (int i = 0; i < N; ++i) {
        const double off = fabs((double)again[i] - (double)rates[i]);
        expect(off <= 1e-3 * ((double)ZHANG2009_SIZE), "rates", "rates of the twist of rates", i);
    }
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (zhang2009_real)(limit * ((double)ZHANG2009_SIZE));
        }
        expect(zhang2009_feed(&pose, twist, limits, &feed) == ZHANG2009_OK, "feed", "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = fmax(largest, fabs((double)feed
                * (double)again[i]) / ((double)ZHANG2009_SIZE));
        }
        expect(largest <= limit * (1.0 + 1e-5), "feed", "keeps limits", k);
        expect((feed == 1.0f) || (largest >= limit * (1.0 - 1e-5)), "feed", "reaches a limit", k);
    }
    expect(feed == 1.0f, "feed", "no need for one", k);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 1062.5184089179752,
        1062.5184089179752, 1062.5184089179752, 1062.5184089179752 };
    const function of_direct = { "direct", ask_direct, "ccccccccccccc", 6, 7,
        &zhang2009_vector_joints[0][0], &zhang2009_vector_guesses[0][0],
        &zhang2009_vector_poses[0][0], weights_of_direct, ask_track, NULL, 1, 1, 1U, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 1.0, 1.0, 1.0, 1.0, 1.0, 1.0 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccc", 7, 6,
        &zhang2009_vector_poses[0][0], NULL, &zhang2009_vector_inverse[0][0], weights_of_inverse,
        NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const zhang2009_real numbers_of_jacobian[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f };
    const function of_jacobian = { "jacobian", ask_jacobian, "ccccccc", 7, 36, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const zhang2009_real numbers_of_rates[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_rates = { "rates", ask_rates, "cccccccssssss", 13, 6, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const zhang2009_real numbers_of_twist[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_twist = { "twist", ask_twist, "cccccccssssss", 13, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const zhang2009_real numbers_of_feed[] = { -0x1.2f77ea0000000p+3f,
        0x1.2748d80000000p+5f, 0x1.958b800000000p+8f, 0x1.ffdfa00000000p-1f, 0x1.d0f84a0000000p-7f,
        -0x1.04d8520000000p-8f, 0x1.108b580000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_feed = { "feed", ask_feed, "cccccccssssssllllll", 19, 1, numbers_of_feed,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
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
    refuse_step(&of_direct, zhang2009_vector_joints[0], zhang2009_vector_far,
        ZHANG2009_WRONG_BRANCH, 0);
    (void)printf("zhang2009: %d cases, %d failures\n", ZHANG2009_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
