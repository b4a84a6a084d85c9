/* Test of yao2020.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "yao2020.h"
#include "yao2020_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N YAO2020_JOINTS
#define MOST (6 * N + 13) /* numbers that any function takes or gives */

/* A function of plain numbers, of which a pose has seven. kinds: of each number that is given, and
 * then guessed, c: a coordinate, s: a speed, l: what is never below 0. step: one step of tracking;
 * opposite: the problem by which answers are held where they are not the only ones. The numbers of
 * an answer, weighed, may be off by `share` times its bound and by `within` more. Where nothing is
 * solved there are no answers, where nothing is guessed no guesses. */
typedef struct function {
    const char *name;
    yao2020_status (*ask)(const yao2020_config *config, const yao2020_real *given,
        const yao2020_real *guess, yao2020_real *result, yao2020_info *info);
    const char *kinds;
    int given;
    int found;
    const yao2020_real *values;
    const yao2020_real *guesses;
    const yao2020_real *answers;
    const double *weights;
    yao2020_status (*step)(const yao2020_config *config, const yao2020_real *given,
        const yao2020_real *guess, yao2020_real *result, yao2020_info *info);
    const struct function *opposite;
    int informs; /* whether a config is read and an info written */
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    unsigned int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const yao2020_real wrong[3] = { (yao2020_real)NAN, (yao2020_real)INFINITY,
    -(yao2020_real)INFINITY };
static int failures = 0;

static void expect(int right, const char *of, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", of, what, number);
    }
}

static void copy(const yao2020_real *from, yao2020_real *to, int count)
{
    for (int i = 0; i < count; ++i) {
        to[i] = from[i];
    }
}

static int all_are(const yao2020_real *values, int count, yao2020_real value)
{
    int same = 1;
    for (int i = 0; i < count; ++i) {
        same = same && (values[i] == value);
    }
    return same;
}

static yao2020_pose pose_from(const yao2020_real *numbers)
{
    yao2020_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const yao2020_pose *pose, yao2020_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}
static yao2020_status ask_direct(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    yao2020_pose result_pose = pose_from(result);
    (void)config;
    (void)guess;
    (void)info;
    const yao2020_status status = yao2020_direct(given, &result_pose);
    numbers_of(&result_pose, result);
    return status;
}

static yao2020_status ask_inverse(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    yao2020_pose given_pose = pose_from(given);
    const yao2020_status status = yao2020_inverse(config, &given_pose, guess, result, info);
    return status;
}

static yao2020_status ask_inverse_nearest(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    yao2020_pose given_pose = pose_from(given);
    (void)config;
    (void)info;
    const yao2020_status status = yao2020_inverse_nearest(&given_pose, guess, result);
    return status;
}

static yao2020_status ask_jacobian(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const yao2020_status status = yao2020_jacobian(given, result);
    return status;
}

static yao2020_status ask_rates(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    (void)config;
    (void)guess;
    const yao2020_status status = yao2020_rates(given, &given[6], result, info);
    return status;
}

static yao2020_status ask_twist(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const yao2020_status status = yao2020_twist(given, &given[6], result);
    return status;
}

static yao2020_status ask_feed(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const yao2020_status status = yao2020_feed(given, &given[6], &given[12], result);
    return status;
}

static yao2020_status ask_track(const yao2020_config *config, const yao2020_real *given,
    const yao2020_real *guess, yao2020_real *result, yao2020_info *info)
{
    yao2020_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    const yao2020_status status = yao2020_track(&given_pose, result, info);
    return status;
}
/* Largest weighed difference; of q and -q, one rotation, the nearer one. NaN is the largest. */
static double away(const function *asked, const yao2020_real *a, const yao2020_real *b)
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
    for (int k = 0; k < YAO2020_VECTORS; ++k) {
        const double bound = yao2020_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const yao2020_real *const given = &asked->values[asked->given * k];
        const yao2020_real *const guess = (asked->guesses == NULL)
            ? NULL : &asked->guesses[asked->found * k];
        const yao2020_real *const answer = &asked->answers[asked->found * k];
        yao2020_real result[MOST];
        yao2020_real again[MOST];
        yao2020_info info;
        for (int i = 0; i < asked->found; ++i) {
            result[i] = (guess != NULL) ? guess[i] : 4.0f;
        }
        expect(asked->ask(NULL, given, asked->informs ? result : guess, result,
            &info) == YAO2020_OK, name, "OK", k);
        expect(away(asked, result, answer) <= most, name, "answer", k);
        if (asked->informs) {
            expect((double)info.residual <= 16.0 * bound, name, "residual", k);
            expect(info.min_pivot > 0.0f, name, "smallest pivot", k);
            expect(info.joint == N, name, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == YAO2020_OK, name, "without info",
                k);
            copy(result, again, asked->found);
            expect(asked->ask(NULL, given, again, again, &info) == YAO2020_OK, name,
                "standing still", k);
            expect(away(asked, again, answer) <= most, name, "answer of standing still", k);
        }
        if (asked->step != NULL) {
            copy(result, again, asked->found);
            expect(asked->step(NULL, given, NULL, again, &info) == YAO2020_OK, name, "track", k);
            expect(away(asked, again, answer) <= most, name, "answer of track", k);
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == YAO2020_OK, name,
                "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, name, "answer asked back", k);
        }
    }
}

/* Values that are refused: the status (OK: any but this), the joint that is blamed, the result
 * untouched, info written. */
static void refuse(const function *asked, const yao2020_real *given, const yao2020_real *guess,
    yao2020_status wanted, int joint, int number)
{
    yao2020_real result[MOST];
    yao2020_info info;
    for (int i = 0; i < MOST; ++i) {
        result[i] = 4.0f;
    }
    info.iterations = 255U;
    info.joint = N;
    const yao2020_status status = asked->ask(NULL, given, guess, result, &info);
    expect((wanted == YAO2020_OK) ? (status != YAO2020_OK) : (status == wanted), asked->name,
        "status of a refusal", number);
    expect(all_are(result, MOST, 4.0f), asked->name, "result untouched by a refusal", number);
    if (asked->informs) {
        expect(info.iterations != 255U, asked->name, "info of a refusal", number);
        expect((joint < 0) || ((int)info.joint == joint), asked->name, "joint of a refusal",
            number);
    }
}

/* A step that is refused: the status, the result untouched. */
static void refuse_step(const function *asked, const yao2020_real *given, const yao2020_real *last,
    yao2020_status wanted, int number)
{
    yao2020_real result[MOST];
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
    const yao2020_real bad[4] = { 0.0f, -1.0f, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    yao2020_real given[MOST];
    yao2020_real guess[MOST];
    for (int i = 0; i < count; ++i) {
        const yao2020_real out = (asked->kinds[i] == 'c')
            ? 5.550225e+06f : ((asked->kinds[i] == 's') ? (yao2020_real)1e30 : -1.0f);
        for (int k = 0; k < 5; ++k) {
            const int place = (i < asked->given) ? i : (i - asked->given);
            const int joint = (asked->blamed == ((i < asked->given) ? 1 : 2)) ? place : -1;
            const yao2020_status status = (k < 3) ? YAO2020_NONFINITE : YAO2020_OUT_OF_RANGE;
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
        const yao2020_config config = { (i < 4) ? bad[i] : YAO2020_TOLERANCE, YAO2020_MAX_STEPS,
            (i < 4) ? YAO2020_MAX_STEP : bad[i - 4] };
        const yao2020_status status = asked->ask(&config, asked->values, asked->guesses, guess,
            NULL);
        expect(status == ((i % 4 < 2) ? YAO2020_OUT_OF_RANGE : YAO2020_NONFINITE), asked->name,
            "status of a wrong config", i);
    }
    for (unsigned int steps = 0U; (steps <= asked->few) && asked->informs; ++steps) {
        const yao2020_config config = { YAO2020_TOLERANCE, (uint8_t)steps, YAO2020_MAX_STEP };
        const yao2020_status status = asked->ask(&config, asked->values, asked->guesses, guess,
            NULL);
        expect(status == YAO2020_MAX_ITERATIONS, asked->name, "status of too few steps",
            (int)steps);
    }
}

/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of
 * each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const yao2020_real *rows, int count, int as_guess,
    yao2020_status wanted, const int *blamed)
{
    for (int k = 0; k < count; ++k) {
        const yao2020_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const yao2020_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 0.0555023;
    yao2020_real jacobian[MOST];
    expect(yao2020_jacobian(yao2020_vector_joints[k], jacobian) == YAO2020_OK, "jacobian", "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)yao2020_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "jacobian",
            "entry", i);
    }
}

/*  The feed keeps the limits, and one joint reaches its own where it is below 1. */
static void speeds_of(int k)
{
    yao2020_real rates[N];
    yao2020_real again[N];
    yao2020_real twist[6] = { 0.0f };
    yao2020_real limits[N];
    yao2020_real feed = 0.0f;
    for (int i = 0; i < N; ++i) {
        rates[i] = (yao2020_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (((i == 5))
            ? (double)YAO2020_SIZE : 1.0));
    }
    expect(yao2020_twist(yao2020_vector_joints[k], rates, twist) == YAO2020_OK, "twist", "OK", k);
    expect(yao2020_rates(yao2020_vector_joints[k], twist, again, NULL) == YAO2020_OK, "rates",
        "OK", k);
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (yao2020_real)(limit * (((i == 5)) ? (double)YAO2020_SIZE : 1.0));
        }
        expect(yao2020_feed(yao2020_vector_joints[k], twist, limits, &feed) == YAO2020_OK, "feed",
            "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = fmax(largest, fabs((double)feed * (double)again[i]) / (((i == 5))
                ? (double)YAO2020_SIZE : 1.0));
        }
        expect(largest <= limit * (1.0 + 1e-5), "feed", "keeps limits", k);
        expect((feed == 1.0f) || (largest >= limit * (1.0 - 1e-5)), "feed", "reaches a limit", k);
    }
    expect(feed == 1.0f, "feed", "no need for one", k);
}

/* Whether two lists of joint values are the same within a bound (of angles times half of the size),
 * whole turns left aside. */
static int same_joints(const yao2020_real *a, const yao2020_real *b, double bound)
{
    static const int angular[N] = { 1, 1, 1, 1, 1, 0 };
    int same = 1;
    for (int i = 0; i < N; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)YAO2020_SIZE * fabs(remainder(gap,
            6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name. */
static void branches_of(const function *direct, int k)
{
    const double most = 8.0 * yao2020_vector_bounds[k];
    const yao2020_real *const given = yao2020_vector_poses[k];
    const yao2020_pose pose = pose_from(given);
    yao2020_real all[YAO2020_BRANCHES][N];
    yao2020_real one[MOST];
    const int count = yao2020_inverse_all(&pose, all);
    int found = 0;
    int named = 0;
    expect((count > 0) && (count <= YAO2020_BRANCHES), "inverse_all", "count", k);
    for (int row = 0; row < count; ++row) {
        expect(direct->ask(NULL, all[row], NULL, one, NULL) == YAO2020_OK, "inverse_all",
            "direct of a branch", k);
        expect(away(direct, one, given) <= 0.017, "inverse_all", "a branch's pose", k);
        found += same_joints(all[row], yao2020_vector_inverse[k], most);
    }
    expect(found == 1, "inverse_all", "one branch is the arm", k);
    for (unsigned int branch = 0U; branch < YAO2020_BRANCHES; ++branch) {
        if (yao2020_inverse_branch(&pose, branch, one) == YAO2020_OK) {
            expect((named < count) && same_joints(one, all[named], most), "inverse_branch",
                "a branch by its name", k);
            ++named;
        }
    }
    expect(named == count, "inverse_branch", "count of the branches by name", k);
}

/* What is no pose or no branch is refused, results untouched. */
static void refuse_branches(void)
{
    const yao2020_pose pose = pose_from(yao2020_vector_poses[0]);
    yao2020_pose infinite = pose;
    yao2020_real all[YAO2020_BRANCHES][N];
    yao2020_real joints[N];
    for (int i = 0; i < N; ++i) {
        joints[i] = 4.0f;
    }
    infinite.position[2] = wrong[1];
    expect(yao2020_inverse_branch(&pose, YAO2020_BRANCHES, joints) == YAO2020_OUT_OF_RANGE,
        "inverse_branch", "no such branch", 0);
    expect(yao2020_inverse_branch(&infinite, 0U, joints) == YAO2020_NONFINITE, "inverse_branch",
        "infinite pose", 0);
    expect(yao2020_inverse_all(&infinite, all) == 0, "inverse_all", "infinite pose", 0);
    expect(all_are(joints, N, 4.0f), "inverse_branch", "result untouched", 0);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 555.0225220655465,
        555.0225220655465, 555.0225220655465, 555.0225220655465 };
    const function of_direct = { "direct", ask_direct, "cccccc", 6, 7,
        &yao2020_vector_joints[0][0], NULL, &yao2020_vector_poses[0][0], weights_of_direct, NULL,
        NULL, 0, 0, 0U, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 277.51126103277323, 277.51126103277323,
        277.51126103277323, 277.51126103277323, 277.51126103277323, 1.0 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccccccccc", 7, 6,
        &yao2020_vector_poses[0][0], &yao2020_vector_guesses[0][0], &yao2020_vector_inverse[0][0],
        weights_of_inverse, ask_track, NULL, 1, 2, 0U, 1.0, 0.0 };
    static const double weights_of_inverse_nearest[] = { 277.51126103277323, 277.51126103277323,
        277.51126103277323, 277.51126103277323, 277.51126103277323, 1.0 };
    const function of_inverse_nearest = { "inverse_nearest", ask_inverse_nearest, "ccccccccccccc",
        7, 6, &yao2020_vector_poses[0][0], &yao2020_vector_guesses[0][0],
        &yao2020_vector_inverse[0][0], weights_of_inverse_nearest, NULL, NULL, 0, 0, 0U, 8.0, 0.0 };
    static const yao2020_real numbers_of_jacobian[] = { 0x1.6af3a20000000p-1f,
        0x1.28f1900000000p-6f, 0x1.86238e0000000p-1f, -0x1.5761020000000p-1f,
        0x1.5fc86c0000000p-3f, -0x1.b6be3a0000000p+3f };
    const function of_jacobian = { "jacobian", ask_jacobian, "cccccc", 6, 36, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const yao2020_real numbers_of_rates[] = { 0x1.6af3a20000000p-1f, 0x1.28f1900000000p-6f,
        0x1.86238e0000000p-1f, -0x1.5761020000000p-1f, 0x1.5fc86c0000000p-3f,
        -0x1.b6be3a0000000p+3f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_rates = { "rates", ask_rates, "ccccccssssss", 12, 6, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const yao2020_real numbers_of_twist[] = { 0x1.6af3a20000000p-1f, 0x1.28f1900000000p-6f,
        0x1.86238e0000000p-1f, -0x1.5761020000000p-1f, 0x1.5fc86c0000000p-3f,
        -0x1.b6be3a0000000p+3f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f };
    const function of_twist = { "twist", ask_twist, "ccccccssssss", 12, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    static const yao2020_real numbers_of_feed[] = { 0x1.6af3a20000000p-1f, 0x1.28f1900000000p-6f,
        0x1.86238e0000000p-1f, -0x1.5761020000000p-1f, 0x1.5fc86c0000000p-3f,
        -0x1.b6be3a0000000p+3f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f, 0x1.0000000000000p+0f,
        0x1.0000000000000p+0f, 0x1.0000000000000p+0f };
    const function of_feed = { "feed", ask_feed, "ccccccssssssllllll", 18, 1, numbers_of_feed,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 0U, 1.0, 0.0 };
    const function *const all[] = { &of_direct, &of_inverse, &of_inverse_nearest, &of_jacobian,
        &of_rates, &of_twist, &of_feed };
    for (int i = 0; i < 7; ++i) {
        if (all[i]->answers != NULL) {
            solve_all(all[i]);
        }
        refuse_values(all[i]);
    }
    for (int k = 0; k < YAO2020_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        speeds_of(k);
    }
    for (int k = 0; k < YAO2020_VECTORS; ++k) {
        branches_of(&of_direct, k);
    }
    refuse_branches();
    refuse_rows(&of_inverse, &yao2020_vector_doubled[0][0], 1, 0, YAO2020_OUT_OF_RANGE, NULL);
    (void)printf("yao2020: %d cases, %d failures\n", YAO2020_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
