/* Test of zhao2000.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "zhao2000.h"
#include "zhao2000_vectors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define N ZHAO2000_JOINTS
#define MOST (6 * N + 13) /* numbers that any function takes or gives */

/* What is asked in plain numbers, of which a pose has seven. */
typedef zhao2000_status question(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info);

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
    const zhao2000_real *values;
    const zhao2000_real *guesses;
    const zhao2000_real *answers;
    const double *weights;
    question *step;
    const struct function *opposite;
    int blamed; /* which values info->joint is about: 1 given ones, 2 the guess, 0 neither */
    int few; /* steps that are not enough for the first vector */
    double share;
    double within;
} function;

static const zhao2000_real wrong[3] = { (zhao2000_real)NAN, (zhao2000_real)INFINITY,
    -(zhao2000_real)INFINITY };
static const char *tested = ""; /* the function that is asked */
static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, %s, case %d\n", tested, what, number);
    }
}

static void copy(const zhao2000_real *from, zhao2000_real *to, int count)
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

static zhao2000_pose pose_from(const zhao2000_real *numbers)
{
    zhao2000_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const zhao2000_pose *pose, zhao2000_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}
static zhao2000_status ask_direct(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose guess_pose = pose_from(guess);
    zhao2000_pose result_pose = pose_from(result);
    const zhao2000_status status = zhao2000_direct(config, given,
        (guess == result) ? &result_pose : &guess_pose, &result_pose, info);
    numbers_of(&result_pose, result);
    return status;
}

static zhao2000_status ask_track(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose result_pose = pose_from(result);
    (void)config;
    (void)guess;
    const zhao2000_status status = zhao2000_track(given, &result_pose, info);
    numbers_of(&result_pose, result);
    return status;
}

static zhao2000_status ask_inverse(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhao2000_status status = zhao2000_inverse(&given_pose, result);
    return status;
}

static zhao2000_status ask_jacobian(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhao2000_status status = zhao2000_jacobian(&given_pose, result);
    return status;
}

static zhao2000_status ask_rates(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhao2000_status status = zhao2000_rates(&given_pose, &given[7], result);
    return status;
}

static zhao2000_status ask_twist(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhao2000_status status = zhao2000_twist(&given_pose, &given[7], result);
    return status;
}

static zhao2000_status ask_feed(const zhao2000_config *config, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_real *result, zhao2000_info *info)
{
    zhao2000_pose given_pose = pose_from(given);
    (void)config;
    (void)guess;
    (void)info;
    const zhao2000_status status = zhao2000_feed(&given_pose, &given[7], &given[13], result);
    return status;
}
/* Largest weighed difference; of q and -q, one rotation, the nearer one. */
static double away(const function *asked, const zhao2000_real *a, const zhao2000_real *b)
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
    for (int k = 0; k < ZHAO2000_VECTORS; ++k) {
        const double bound = zhao2000_vector_bounds[k];
        const double most = asked->share * bound + asked->within;
        const zhao2000_real *const given = &asked->values[asked->given * k];
        const zhao2000_real *const guess = (asked->guesses == NULL)
            ? NULL : &asked->guesses[asked->found * k];
        const zhao2000_real *const answer = &asked->answers[asked->found * k];
        zhao2000_real result[MOST];
        zhao2000_real again[MOST];
        zhao2000_info info;
        for (int i = 0; i < asked->found; ++i) {
            result[i] = (guess != NULL) ? guess[i] : 4.0;
        }
        expect(asked->ask(NULL, given, (asked->step != NULL) ? result : guess, result,
            &info) == ZHAO2000_OK, "OK", k);
        expect(away(asked, result, answer) <= most, "answer", k);
        if (asked->step != NULL) {
            expect((double)info.residual <= 16.0 * bound, "residual", k);
            expect(info.min_pivot > 0.0, "smallest pivot", k);
            expect(info.joint == N, "no joint to blame", k);
            expect(asked->ask(NULL, given, guess, again, NULL) == ZHAO2000_OK, "without info", k);
            for (int i = 0; i < 2; ++i) {
                copy(result, again, asked->found);
                expect(still[i](NULL, given, again, again, &info) == ZHAO2000_OK, "standing still",
                    k);
                expect(away(asked, again, answer) <= most, "answer of standing still", k);
            }
        }
        if (asked->opposite != NULL) {
            expect(asked->opposite->ask(NULL, result, NULL, again, NULL) == ZHAO2000_OK,
                "asked back", k);
            expect(away(asked->opposite, again, given) <= bound, "answer asked back", k);
        }
    }
}

/* Values that are refused, by a function or its step: the status (OK: any but this), the joint that
 * is blamed, the result untouched, info written. */
static void refuse(const function *asked, question *ask, const zhao2000_real *given,
    const zhao2000_real *guess, zhao2000_status wanted, int joint, int number)
{
    zhao2000_real before[MOST];
    zhao2000_real result[MOST];
    zhao2000_info info;
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
    const zhao2000_status status = ask(NULL, given, guess, result, &info);
    expect((wanted == ZHAO2000_OK) ? (status != ZHAO2000_OK) : (status == wanted),
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
    const zhao2000_real bad[4] = { 0.0, -1.0, wrong[0], wrong[1] };
    const int count = (int)strlen(asked->kinds);
    zhao2000_real given[2 * MOST];
    zhao2000_real *const guess = &given[asked->given];
    for (int i = 0; i < count; ++i) {
        const zhao2000_real out = (asked->kinds[i] == 'c') ? 2400000.0 : ((asked->kinds[i] == 's')
            ? (zhao2000_real)1e30 : -1.0);
        const int of_guess = i >= asked->given;
        for (int k = 0; k < 5; ++k) {
            const int joint = (asked->blamed != 1 + of_guess) ? -1 : (of_guess
                ? (i - asked->given) : i);
            const zhao2000_status status = (k < 3) ? ZHAO2000_NONFINITE : ZHAO2000_OUT_OF_RANGE;
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
        const zhao2000_config config = { (i < 4) ? bad[i] : ZHAO2000_TOLERANCE,
            (uint8_t)((i < 8) ? ZHAO2000_MAX_STEPS : (unsigned int)(i - 8)),
            ((i < 4) || (i >= 8)) ? ZHAO2000_MAX_STEP : bad[i - 4] };
        const zhao2000_status status = (i >= 8) ? ZHAO2000_MAX_ITERATIONS : ((i % 4 < 2)
            ? ZHAO2000_OUT_OF_RANGE : ZHAO2000_NONFINITE);
        expect(asked->ask(&config, asked->values, asked->guesses, given, NULL) == status,
            "status by a config", i);
    }
}

/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of
 * each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const zhao2000_real *rows, int count, int as_guess,
    zhao2000_status wanted, const int *blamed)
{
    for (int k = 0; k < count; ++k) {
        const zhao2000_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const zhao2000_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, asked->ask, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}
/* Jacobians of the first vectors. */
static void jacobian_of(int k)
{
    const double most = 2.4e-06;
    zhao2000_real jacobian[MOST];
    const zhao2000_pose pose = pose_from(zhao2000_vector_poses[k]);
    tested = "jacobian";
    expect(zhao2000_jacobian(&pose, jacobian) == ZHAO2000_OK, "OK", k);
    for (int i = 0; i < 6 * N; ++i) {
        const double wanted = (double)zhao2000_vector_jacobians[k][i];
        expect(fabs((double)jacobian[i] - wanted) <= most * (1.0 + fabs(wanted)), "entry", i);
    }
}

/* Rates of the twist of rates are these rates. The feed keeps the limits, and one joint reaches its
 * own where it is below 1. */
static void speeds_of(int k)
{
    const zhao2000_pose pose = pose_from(zhao2000_vector_poses[k]);
    zhao2000_real rates[N];
    zhao2000_real again[N];
    zhao2000_real twist[6] = { 0.0 };
    zhao2000_real limits[N];
    zhao2000_real feed = 0.0;
    for (int i = 0; i < N; ++i) {
        rates[i] = (zhao2000_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (((i == 3))
            ? (double)ZHAO2000_SIZE : 1.0));
    }
    tested = "twist";
    expect(zhao2000_twist(&pose, rates, twist) == ZHAO2000_OK, "OK", k);
    tested = "rates";
    expect(zhao2000_rates(&pose, twist, again) == ZHAO2000_OK, "OK", k);
    for (int i = 0; i < N; ++i) {
        const double off = fabs((double)again[i] - (double)rates[i]);
        expect(off <= 1e-9 * (((i == 3)) ? (double)ZHAO2000_SIZE : 1.0),
            "rates of the twist of rates", i);
    }
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (zhao2000_real)(limit * (((i == 3)) ? (double)ZHAO2000_SIZE : 1.0));
        }
        tested = "feed";
        expect(zhao2000_feed(&pose, twist, limits, &feed) == ZHAO2000_OK, "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = larger(largest, fabs((double)feed * (double)again[i]) / (((i == 3))
                ? (double)ZHAO2000_SIZE : 1.0));
        }
        expect(largest <= limit * (1.0 + 1e-5), "keeps limits", k);
        expect((feed == 1.0) || (largest >= limit * (1.0 - 1e-5)), "reaches a limit", k);
    }
    expect(feed == 1.0, "no need for one", k);
}
int main(void)
{
    static const double weights_of_direct[] = { 1.0, 1.0, 1.0, 480.0, 480.0, 480.0, 480.0 };
    const function of_direct = { "direct", ask_direct, "ccccccccccc", 4, 7,
        &zhao2000_vector_joints[0][0], &zhao2000_vector_guesses[0][0],
        &zhao2000_vector_poses[0][0], weights_of_direct, ask_track, NULL, 1, 0, 1.0, 0.0 };
    static const double weights_of_inverse[] = { 120.0, 120.0, 120.0, 1.0 };
    const function of_inverse = { "inverse", ask_inverse, "ccccccc", 7, 4,
        &zhao2000_vector_poses[0][0], NULL, &zhao2000_vector_inverse[0][0], weights_of_inverse,
        NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhao2000_real numbers_of_jacobian[] = { -0x1.eab59b1a06c34p-4,
        -0x1.0df5b4fcbb40dp+2, 0x1.9240216261854p+6, 0x1.ffbcfc022c50fp-1, 0x0.0p+0, 0x0.0p+0,
        0x1.05eda39db42f9p-5 };
    const function of_jacobian = { "jacobian", ask_jacobian, "ccccccc", 7, 24, numbers_of_jacobian,
        NULL, NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhao2000_real numbers_of_rates[] = { -0x1.eab59b1a06c34p-4, -0x1.0df5b4fcbb40dp+2,
        0x1.9240216261854p+6, 0x1.ffbcfc022c50fp-1, 0x0.0p+0, 0x0.0p+0, 0x1.05eda39db42f9p-5,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0 };
    const function of_rates = { "rates", ask_rates, "cccccccssssss", 13, 4, numbers_of_rates, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhao2000_real numbers_of_twist[] = { -0x1.eab59b1a06c34p-4, -0x1.0df5b4fcbb40dp+2,
        0x1.9240216261854p+6, 0x1.ffbcfc022c50fp-1, 0x0.0p+0, 0x0.0p+0, 0x1.05eda39db42f9p-5,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0 };
    const function of_twist = { "twist", ask_twist, "cccccccssss", 11, 6, numbers_of_twist, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    static const zhao2000_real numbers_of_feed[] = { -0x1.eab59b1a06c34p-4, -0x1.0df5b4fcbb40dp+2,
        0x1.9240216261854p+6, 0x1.ffbcfc022c50fp-1, 0x0.0p+0, 0x0.0p+0, 0x1.05eda39db42f9p-5,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0,
        0x1.0000000000000p+0, 0x1.0000000000000p+0 };
    const function of_feed = { "feed", ask_feed, "cccccccssssssllll", 17, 1, numbers_of_feed, NULL,
        NULL, NULL, NULL, NULL, 0, 0, 1.0, 0.0 };
    const function *const all[] = { &of_direct, &of_inverse, &of_jacobian, &of_rates, &of_twist,
        &of_feed };
    for (int i = 0; i < 6; ++i) {
        if (all[i]->answers != NULL) {
            solve_all(all[i]);
        }
        refuse_values(all[i]);
    }
    for (int k = 0; k < ZHAO2000_VECTOR_JACOBIANS; ++k) {
        jacobian_of(k);
        speeds_of(k);
    }
    refuse_rows(&of_inverse, &zhao2000_vector_infeasible[0][0], 4, 0, ZHAO2000_OUT_OF_RANGE, NULL);
    refuse_rows(&of_direct, &zhao2000_vector_doubled[0][0], 1, 1, ZHAO2000_OUT_OF_RANGE, NULL);
    refuse_rows(&of_inverse, &zhao2000_vector_doubled[0][0], 1, 0, ZHAO2000_OUT_OF_RANGE, NULL);
    (void)printf("zhao2000: %d cases, %d failures\n", ZHAO2000_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
