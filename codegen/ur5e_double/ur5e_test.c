/* Test of ur5e.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "ur5e.h"
#include "ur5e_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N UR5E_JOINTS
#define MOST (6 * N + 13) /* numbers that any function takes or gives */

/* What is asked in plain numbers, of which a pose has seven. */
typedef ur5e_status question(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info);

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
    const ur5e_real *values;
    const ur5e_real *guesses;
    const ur5e_real *answers;
    const double *weights;
    question *step;
    const struct function *opposite;
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const ur5e_real wrong[3] = { (ur5e_real)NAN, (ur5e_real)INFINITY, -(ur5e_real)INFINITY };
static const char *tested = ""; /* the function that is asked */
static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", tested, what, number);
    }
}

static void copy(const ur5e_real *from, ur5e_real *to, int count)
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

static ur5e_pose pose_from(const ur5e_real *numbers)
{
    ur5e_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const ur5e_pose *pose, ur5e_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}
static ur5e_status ask_direct(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    ur5e_pose result_pose = pose_from(result);
    (void)config;
    (void)guess;
    (void)info;
    const ur5e_status status = ur5e_direct(given, &result_pose);
    numbers_of(&result_pose, result);
    return status;
}

static ur5e_status ask_inverse(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    ur5e_pose given_pose = pose_from(given);
    const ur5e_status status = ur5e_inverse(config, &given_pose, guess, result, info);
    return status;
}

static ur5e_status ask_inverse_branch(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    ur5e_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const ur5e_status status = ur5e_inverse_branch(&given_pose, 0U, result);
    return status;
}

static ur5e_status ask_inverse_nearest(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    ur5e_pose given_pose = pose_from(given);
    (void)config;
    (void)info;
    const ur5e_status status = ur5e_inverse_nearest(&given_pose, guess, result);
    return status;
}

static ur5e_status ask_jacobian(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ur5e_status status = ur5e_jacobian(given, result);
    return status;
}

static ur5e_status ask_rates(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    (void)config;
    (void)guess;
    const ur5e_status status = ur5e_rates(given, &given[6], result, info);
    return status;
}

static ur5e_status ask_twist(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ur5e_status status = ur5e_twist(given, &given[6], result);
    return status;
}

static ur5e_status ask_feed(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    (void)config;
    (void)guess;
    (void)info;
    const ur5e_status status = ur5e_feed(given, &given[6], &given[12], result);
    return status;
}

static ur5e_status ask_track(const ur5e_config *config, const ur5e_real *given,
    const ur5e_real *guess, ur5e_real *result, ur5e_info *info)
{
    ur5e_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    const ur5e_status status = ur5e_track(&given_pose, result, info);
    return status;
}
/* Largest weighed difference; of q and -q, one rotation, the nearer one. */
static double away(const function *asked, const ur5e_real *a, const ur5e_real *b)
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
    for (int k = 0; k < UR5E_VECTORS; ++k) {
        const double bound = ur5e_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const ur5e_real *const given = &asked->values[asked->given * k];
        const ur5e_real *const guess = (asked->guesses == NULL)
            ? NULL : &asked->guesses[asked->found * k];
        const ur5e_real *const answer = &asked->answers[asked->found * k];
        ur5e_real result[MOST];
        ur5e_real again[MOST];
        ur5e_info info;
        for (int i = 0; i < asked->found; ++i) {
            result[i] = (guess != NULL) ? guess[i] : 4.0;
        }
        expect(asked->ask(NULL, given, (asked->step != NULL) ? result : guess, result,
            &info) == UR5E_OK, "OK", k);
        expect(away(asked, result, answer) <= most, "answer", k);
        if (asked->step != NULL) {
            expect((double)info.residual <= 16.0 * bound, "residual", k);
            expect(info.min_pivot > 0.0, "smallest pivot", k);
            expect(info.joint == N, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == UR5E_OK, "without info", k);
            for (int i = 0; i < 2; ++i) {
                copy(result, again, asked->found);
                expect(still[i](NULL, given, again, again, &info) == UR5E_OK, "standing still", k);
                expect(away(asked, again, answer) <= most, "answer of standing still", k);
            }
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == UR5E_OK, "asked back",
                k);
            expect(away(asked->opposite, again, given) <= bound, "answer asked back", k);
        }
    }
}

/* Values that are refused, by a function or its step: the status (OK: any but this), the joint that
 * is blamed, the result untouched, info written. */
static void refuse(const function *asked, question *ask, const ur5e_real *given,
    const ur5e_real *guess, ur5e_status wanted, int joint, int number)
{
    ur5e_real before[MOST];
    ur5e_real result[MOST];
    ur5e_info info;
    for (int i = 0; i < MOST; ++i) {
        before[i] = 4.0;
    }
    if (ask == asked->step) {
        copy(guess, before, asked->found);
    }
    copy(before, result, MOST);
    info.iterations = 255U;
    info.joint = N;
    tested = asked->name;
    const ur5e_status status = ask(NULL, given, guess, result, &info);
    expect((wanted == UR5E_OK) ? (status != UR5E_OK) : (status == wanted), "status of a refusal",
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
    const ur5e_real bad[4] = { 0.0, -1.0, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    ur5e_real given[2 * MOST];
    ur5e_real *const guess = &given[asked->given];
    for (int i = 0; i < count; ++i) {
        const ur5e_real out = (asked->kinds[i] == 'c')
            ? 8437955.795096347 : ((asked->kinds[i] == 's') ? (ur5e_real)1e30 : -1.0);
        const int of_guess = i >= asked->given;
        for (int k = 0; k < 5; ++k) {
            const int joint = (asked->blamed != 1 + of_guess) ? -1 : (of_guess
                ? (i - asked->given) : i);
            const ur5e_status status = (k < 3) ? UR5E_NONFINITE : UR5E_OUT_OF_RANGE;
            copy(asked->values, given, asked->given);
            if (asked->guesses != NULL) {
                copy(asked->guesses, guess, asked->found);
            }
            given[i] = (k < 3) ? wrong[k] : (((k == 3) || (out < 0.0)) ? out : -out);
            refuse(asked, asked->ask, given, guess, status, joint, 5 * i + k);
            if (asked->step != NULL) {
                refuse(asked, asked->step, given, guess, status, joint, 5 * i + k);
            }
        }
    }
    for (int i = 0; (i < 9 + asked->few) && asked->step != NULL; ++i) {
        const ur5e_config config = { (i < 4) ? bad[i] : UR5E_TOLERANCE,
            (uint8_t)((i < 8) ? UR5E_MAX_STEPS : (unsigned int)(i - 8)),
            ((i < 4) || (i >= 8)) ? UR5E_MAX_STEP : bad[i - 4] };
        const ur5e_status status = (i >= 8) ? UR5E_MAX_ITERATIONS : ((i % 4 < 2)
            ? UR5E_OUT_OF_RANGE : UR5E_NONFINITE);
        expect(asked->ask(&config, asked->values, asked->guesses, given, NULL) == status,
            "status by a config", i);
    }
}

/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of
 * each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const ur5e_real *rows, int count, int as_guess,
    ur5e_status wanted, const int *blamed)
{
    for (int k = 0; k < count; ++k) {
        const ur5e_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const ur5e_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, asked->ask, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 8.43796e-06;
    ur5e_real jacobian[MOST];
    tested = "jacobian";
    expect(ur5e_jacobian(ur5e_vector_joints[k], jacobian) == UR5E_OK, "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)ur5e_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "entry", i);
    }
}

/*  The feed keeps the limits, and one joint reaches its own where it is below 1. */
static void speeds_of(int k)
{
    ur5e_real rates[N];
    ur5e_real again[N];
    ur5e_real twist[6] = { 0.0 };
    ur5e_real limits[N];
    ur5e_real feed = 0.0;
    for (int i = 0; i < N; ++i) {
        rates[i] = (ur5e_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (1.0));
    }
    tested = "twist";
    expect(ur5e_twist(ur5e_vector_joints[k], rates, twist) == UR5E_OK, "OK", k);
    tested = "rates";
    expect(ur5e_rates(ur5e_vector_joints[k], twist, again, NULL) == UR5E_OK, "OK", k);
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (ur5e_real)(limit * (1.0));
        }
        tested = "feed";
        expect(ur5e_feed(ur5e_vector_joints[k], twist, limits, &feed) == UR5E_OK, "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = larger(largest, fabs((double)feed * (double)again[i]) / (1.0));
        }
        expect(largest <= limit * (1.0 + 1e-5), "keeps limits", k);
        expect((feed == 1.0) || (largest >= limit * (1.0 - 1e-5)), "reaches a limit", k);
    }
    expect(feed == 1.0, "no need for one", k);
}

/* Whether two lists of joint values are the same within a bound (of angles times half of the size),
 * whole turns left aside. */
static int same_joints(const ur5e_real *a, const ur5e_real *b, double bound)
{
    static const int angular[N] = { 1, 1, 1, 1, 1, 1 };
    int same = 1;
    for (int i = 0; i < N; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)UR5E_SIZE * fabs(remainder(gap,
            6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name; what is no pose
 * or no branch has none. */
static void branches_of(const function *direct, int k)
{
    const double most = 8.0 * ur5e_vector_bounds[k];
    const ur5e_real *const given = ur5e_vector_poses[k];
    ur5e_pose pose = pose_from(given);
    ur5e_real all[UR5E_BRANCHES][N];
    ur5e_real one[MOST];
    const int count = ur5e_inverse_all(&pose, all);
    int found = 0;
    int named = 0;
    tested = "inverse_all";
    expect((count > 0) && (count <= UR5E_BRANCHES), "count", k);
    for (int row = 0; row < count; ++row) {
        expect(direct->ask(NULL, all[row], NULL, one, NULL) == UR5E_OK, "direct of a branch", k);
        expect(away(direct, one, given) <= 3.8e-09, "a branch's pose", k);
        found += same_joints(all[row], ur5e_vector_inverse[k], most);
    }
    expect(found == 1, "one branch is the arm", k);
    for (unsigned int branch = 0U; branch < UR5E_BRANCHES; ++branch) {
        if (ur5e_inverse_branch(&pose, branch, one) == UR5E_OK) {
            expect((named < count) && same_joints(one, all[named], most), "a branch by its name",
                k);
            ++named;
        }
    }
    expect(named == count, "count of the branches by name", k);
    copy(all[0], one, N);
    expect(ur5e_inverse_branch(&pose, UR5E_BRANCHES, one) == UR5E_OUT_OF_RANGE, "no such branch",
        k);
    expect(memcmp(all[0], one, sizeof all[0]) == 0, "result untouched", k);
    pose.position[2] = wrong[1];
    expect(ur5e_inverse_all(&pose, all) == 0, "infinite pose", k);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 843.7955795096346,
        843.7955795096346, 843.7955795096346, 843.7955795096346 };
    const function of_direct = { "direct", ask_direct, "cccccc", 6, 7, &ur5e_vector_joints[0][0],
        NULL, &ur5e_vector_poses[0][0], weights_of_direct, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 421.8977897548173, 421.8977897548173,
        421.8977897548173, 421.8977897548173, 421.8977897548173, 421.8977897548173 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccccccccc", 7, 6,
        &ur5e_vector_poses[0][0], &ur5e_vector_guesses[0][0], &ur5e_vector_inverse[0][0],
        weights_of_inverse, ask_track, NULL, 2, 0, 1.0, 0.0 };
    static const double weights_of_inverse_nearest[] = { 421.8977897548173, 421.8977897548173,
        421.8977897548173, 421.8977897548173, 421.8977897548173, 421.8977897548173 };
    const function of_inverse_nearest = { "inverse_nearest", ask_inverse_nearest, "ccccccccccccc",
        7, 6, &ur5e_vector_poses[0][0], &ur5e_vector_guesses[0][0], &ur5e_vector_inverse[0][0],
        weights_of_inverse_nearest, NULL, NULL, 0, 0, 8.0, 0.0 };
    static const ur5e_real numbers_of_inverse_branch[] = { -0x1.84196f4fa96c9p+8,
        -0x1.3edc2ae93c760p+9, -0x1.bc0be9f824101p+7, 0x1.5dab2146e9a29p-1, 0x1.5b8ae6500e8a9p-1,
        0x1.c35e7cc2695d3p-3, 0x1.3eeaa2f078e8fp-3 };
    const function of_inverse_branch = { "inverse_branch", ask_inverse_branch, "ccccccc", 7, 6,
        numbers_of_inverse_branch, NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ur5e_real numbers_of_jacobian[] = { 0x1.6af3a14cec41ep-1, 0x1.28f190d173fb8p-6,
        0x1.86238da3c2118p-1, -0x1.576102795703fp-1, 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3 };
    const function of_jacobian = { "jacobian", ask_jacobian, "cccccc", 6, 36, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ur5e_real numbers_of_rates[] = { 0x1.6af3a14cec41ep-1, 0x1.28f190d173fb8p-6,
        0x1.86238da3c2118p-1, -0x1.576102795703fp-1, 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0 };
    const function of_rates = { "rates", ask_rates, "ccccccssssss", 12, 6, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ur5e_real numbers_of_twist[] = { 0x1.6af3a14cec41ep-1, 0x1.28f190d173fb8p-6,
        0x1.86238da3c2118p-1, -0x1.576102795703fp-1, 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0 };
    const function of_twist = { "twist", ask_twist, "ccccccssssss", 12, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const ur5e_real numbers_of_feed[] = { 0x1.6af3a14cec41ep-1, 0x1.28f190d173fb8p-6,
        0x1.86238da3c2118p-1, -0x1.576102795703fp-1, 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0 };
    const function of_feed = { "feed", ask_feed, "ccccccssssssllllll", 18, 1, numbers_of_feed,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    const function *const all[] = { &of_direct, &of_inverse, &of_inverse_nearest,
        &of_inverse_branch, &of_jacobian, &of_rates, &of_twist, &of_feed };
    for (int i = 0; i < 8; ++i) {
        if (all[i]->answers != NULL) {
            solve_all(all[i]);
        }
        refuse_values(all[i]);
    }
    for (int k = 0; k < UR5E_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        speeds_of(k);
    }
    for (int k = 0; k < UR5E_VECTORS; ++k) {
        branches_of(&of_direct, k);
    }
    refuse_rows(&of_inverse, &ur5e_vector_singular[0][0], 1, 1, UR5E_SINGULAR, NULL);
    refuse_rows(&of_inverse, &ur5e_vector_doubled[0][0], 1, 0, UR5E_OUT_OF_RANGE, NULL);
    (void)printf("ur5e: %d cases, %d failures\n", UR5E_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
