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

/* A function of plain numbers, of which a pose has seven. kinds: of each number that is given, and
 * then guessed, c: a coordinate, s: a speed, l: what is never below 0. step: one step of tracking;
 * opposite: the problem by which answers are held where they are not the only ones. The numbers of
 * an answer, weighed, may be off by `share` times its bound and by `within` more. Where nothing is
 * solved there are no answers, where nothing is guessed no guesses. */
typedef struct function {
    const char *name;
    ren2008_status (*ask)(const ren2008_config *config, const ren2008_real *given,
        const ren2008_real *guess, ren2008_real *result, ren2008_info *info);
    const char *kinds;
    int given;
    int found;
    const ren2008_real *values;
    const ren2008_real *guesses;
    const ren2008_real *answers;
    const double *weights;
    ren2008_status (*step)(const ren2008_config *config, const ren2008_real *given,
        const ren2008_real *guess, ren2008_real *result, ren2008_info *info);
    const struct function *opposite;
    int informs; /* whether a config is read and an info written */
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    unsigned int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const ren2008_real wrong[3] = { (ren2008_real)NAN, (ren2008_real)INFINITY,
    -(ren2008_real)INFINITY };
static int failures = 0;

static void expect(int right, const char *of, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", of, what, number);
    }
}

static void copy(const ren2008_real *from, ren2008_real *to, int count)
{
    for (int i = 0; i < count; ++i) {
        to[i] = from[i];
    }
}

static int all_are(const ren2008_real *values, int count, ren2008_real value)
{
    int same = 1;
    for (int i = 0; i < count; ++i) {
        same = same && (values[i] == value);
    }
    return same;
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
/* Largest weighed difference; of q and -q, one rotation, the nearer one. NaN is the largest. */
static double away(const function *asked, const ren2008_real *a, const ren2008_real *b)
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
        expect(asked->ask(NULL, given, asked->informs ? result : guess, result,
            &info) == REN2008_OK, name, "OK", k);
        expect(away(asked, result, answer) <= most, name, "answer", k);
        if (asked->informs) {
            expect((double)info.residual <= 16.0 * bound, name, "residual", k);
            expect(info.min_pivot > 0.0f, name, "smallest pivot", k);
            expect(info.joint == N, name, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == REN2008_OK, name, "without info",
                k);
            copy(result, again, asked->found);
            expect(asked->ask(NULL, given, again, again, &info) == REN2008_OK, name,
                "standing still", k);
            expect(away(asked, again, answer) <= most, name, "answer of standing still", k);
        }
        if (asked->step != NULL) {
            copy(result, again, asked->found);
            expect(asked->step(NULL, given, NULL, again, &info) == REN2008_OK, name, "track", k);
            expect(away(asked, again, answer) <= most, name, "answer of track", k);
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == REN2008_OK, name,
                "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, name, "answer asked back", k);
        }
    }
}

/* Values that are refused: the status (OK: any but this), the joint that is blamed, the result
 * untouched, info written. */
static void refuse(const function *asked, const ren2008_real *given, const ren2008_real *guess,
    ren2008_status wanted, int joint, int number)
{
    ren2008_real result[MOST];
    ren2008_info info;
    for (int i = 0; i < MOST; ++i) {
        result[i] = 4.0f;
    }
    info.iterations = 255U;
    info.joint = N;
    const ren2008_status status = asked->ask(NULL, given, guess, result, &info);
    expect((wanted == REN2008_OK) ? (status != REN2008_OK) : (status == wanted), asked->name,
        "status of a refusal", number);
    expect(all_are(result, MOST, 4.0f), asked->name, "result untouched by a refusal", number);
    if (asked->informs) {
        expect(info.iterations != 255U, asked->name, "info of a refusal", number);
        expect((joint < 0) || ((int)info.joint == joint), asked->name, "joint of a refusal",
            number);
    }
}

/* A step that is refused: the status, the result untouched. */
static void refuse_step(const function *asked, const ren2008_real *given, const ren2008_real *last,
    ren2008_status wanted, int number)
{
    ren2008_real result[MOST];
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
    const ren2008_real bad[4] = { 0.0f, -1.0f, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    ren2008_real given[MOST];
    ren2008_real guess[MOST];
    for (int i = 0; i < count; ++i) {
        const ren2008_real out = (asked->kinds[i] == 'c') ? 16901.664f : ((asked->kinds[i] == 's')
            ? (ren2008_real)1e30 : -1.0f);
        for (int k = 0; k < 5; ++k) {
            const int place = (i < asked->given) ? i : (i - asked->given);
            const int joint = (asked->blamed == ((i < asked->given) ? 1 : 2)) ? place : -1;
            const ren2008_status status = (k < 3) ? REN2008_NONFINITE : REN2008_OUT_OF_RANGE;
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
        const ren2008_config config = { (i < 4) ? bad[i] : REN2008_TOLERANCE, REN2008_MAX_STEPS,
            (i < 4) ? REN2008_MAX_STEP : bad[i - 4] };
        const ren2008_status status = asked->ask(&config, asked->values, asked->guesses, guess,
            NULL);
        expect(status == ((i % 4 < 2) ? REN2008_OUT_OF_RANGE : REN2008_NONFINITE), asked->name,
            "status of a wrong config", i);
    }
    for (unsigned int steps = 0U; (steps <= asked->few) && asked->informs; ++steps) {
        const ren2008_config config = { REN2008_TOLERANCE, (uint8_t)steps, REN2008_MAX_STEP };
        const ren2008_status status = asked->ask(&config, asked->values, asked->guesses, guess,
            NULL);
        expect(status == REN2008_MAX_ITERATIONS, asked->name, "status of too few steps",
            (int)steps);
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
        refuse(asked, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 0.000169017;
    ren2008_real jacobian[MOST];
    const ren2008_pose pose = pose_from(ren2008_vector_poses[k]);
    expect(ren2008_jacobian(&pose, jacobian) == REN2008_OK, "jacobian", "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)ren2008_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "jacobian",
            "entry", i);
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
    expect(ren2008_twist(&pose, rates, twist) == REN2008_OK, "twist", "OK", k);
    expect(ren2008_rates(&pose, twist, again) == REN2008_OK, "rates", "OK", k);
    for (int i = 0; i < N; ++i) {
        const double off = fabs((double)again[i] - (double)rates[i]);
        expect(off <= 1e-3 * ((double)REN2008_SIZE), "rates", "rates of the twist of rates", i);
    }
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (ren2008_real)(limit * ((double)REN2008_SIZE));
        }
        expect(ren2008_feed(&pose, twist, limits, &feed) == REN2008_OK, "feed", "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = fmax(largest, fabs((double)feed * (double)again[i]) / ((double)REN2008_SIZE));
        }
        expect(largest <= limit * (1.0 + 1e-5), "feed", "keeps limits", k);
        expect((feed == 1.0f) || (largest >= limit * (1.0 - 1e-5)), "feed", "reaches a limit", k);
    }
    expect(feed == 1.0f, "feed", "no need for one", k);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 3.3803326759359056,
        3.3803326759359056, 3.3803326759359056, 3.3803326759359056 };
    const function of_direct = { "direct", ask_direct, "ccccccccccccc", 6, 7,
        &ren2008_vector_joints[0][0], &ren2008_vector_guesses[0][0], &ren2008_vector_poses[0][0],
        weights_of_direct, ask_track, NULL, 1, 1, 1U, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 1.0, 1.0, 1.0, 1.0, 1.0, 1.0 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccc", 7, 6,
        &ren2008_vector_poses[0][0], NULL, &ren2008_vector_inverse[0][0], weights_of_inverse, NULL,
        NULL, 0, 0, 0U, 1.0, 0.0 };
    static const ren2008_real numbers_of_jacobian[] = { -0x1.306dd80000000p-2f,
        0x1.95e8ca0000000p-2f, 0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f };
    const function of_jacobian = { "jacobian", ask_jacobian, "ccccccc", 7, 36, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const ren2008_real numbers_of_rates[] = { -0x1.306dd80000000p-2f, 0x1.95e8ca0000000p-2f,
        0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_rates = { "rates", ask_rates, "cccccccssssss", 13, 6, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const ren2008_real numbers_of_twist[] = { -0x1.306dd80000000p-2f, 0x1.95e8ca0000000p-2f,
        0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_twist = { "twist", ask_twist, "cccccccssssss", 13, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const ren2008_real numbers_of_feed[] = { -0x1.306dd80000000p-2f, 0x1.95e8ca0000000p-2f,
        0x1.3b06e80000000p+0f, 0x1.ff9c1c0000000p-1f, 0x1.98aeea0000000p-6f,
        -0x1.9d67f00000000p-7f, 0x1.be5b9a0000000p-6f, 0x1.0000000000000p+0f,
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
    for (int k = 0; k < REN2008_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        speeds_of(k);
    }
    static const int blamed[] = { 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5 };
    refuse_rows(&of_direct, &ren2008_vector_past[0][0], 12, 0, REN2008_OUT_OF_RANGE, blamed);
    refuse_rows(&of_direct, &ren2008_vector_singular[0][0], 1, 1, REN2008_SINGULAR, NULL);
    refuse_rows(&of_direct, &ren2008_vector_doubled[0][0], 1, 1, REN2008_OUT_OF_RANGE, NULL);
    refuse_rows(&of_inverse, &ren2008_vector_doubled[0][0], 1, 0, REN2008_OUT_OF_RANGE, NULL);
    refuse_step(&of_direct, ren2008_vector_joints[0], ren2008_vector_far, REN2008_WRONG_BRANCH, 0);
    (void)printf("ren2008: %d cases, %d failures\n", REN2008_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
