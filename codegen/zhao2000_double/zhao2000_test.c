/* Test of zhao2000.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "zhao2000.h"
#include "zhao2000_vectors.h"

#include <math.h>
#include <stdio.h>

static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, case %d\n", what, number);
    }
}

static zhao2000_pose pose_from(const zhao2000_real numbers[7])
{
    zhao2000_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* Largest difference of two poses: lengths, and rotations times the size. */
static double difference(const zhao2000_pose *a, const zhao2000_real b[7])
{
    double largest = 0.0;
    double cosine = 0.0;
    for (int i = 0; i < 4; ++i) {
        cosine += (double)a->quaternion[i] * (double)b[3 + i];
    }
    for (int i = 0; i < 3; ++i) {
        largest = fmax(largest, fabs((double)a->position[i] - (double)b[i]));
    }
    for (int i = 0; i < 4; ++i) {
        const double other = (cosine < 0.0) ? -(double)b[3 + i] : (double)b[3 + i];
        largest = fmax(largest, 2.0 * (double)ZHAO2000_SIZE * fabs((double)a->quaternion[i]
            - other));
    }
    return (cosine == cosine) ? largest : HUGE_VAL;
}

static int same_pose(const zhao2000_pose *a, const zhao2000_pose *b)
{
    int same = 1;
    for (int i = 0; i < 3; ++i) {
        same = same && (a->position[i] == b->position[i]);
    }
    for (int i = 0; i < 4; ++i) {
        same = same && (a->quaternion[i] == b->quaternion[i]);
    }
    return same;
}

/* A direct call that must not succeed: the status, with the pose untouched and info written. */
static zhao2000_status refused(const zhao2000_config *config,
    const zhao2000_real joints[ZHAO2000_JOINTS], const zhao2000_pose *guess, const char *what)
{
    const zhao2000_real marks[7] = { 1.0, 2.0, 4.0, 1.0, 2.0, 4.0, 1.0 };
    const zhao2000_pose untouched = pose_from(marks);
    zhao2000_pose pose = untouched;
    zhao2000_info info;
    zhao2000_status status;
    info.iterations = 255U;
    status = zhao2000_direct(config, joints, guess, &pose, &info);
    expect(status != ZHAO2000_OK, what, 0);
    expect(same_pose(&pose, &untouched), "result untouched on failure", 0);
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < ZHAO2000_VECTORS; ++k) {
        const double bound = zhao2000_vector_bounds[k];
        const zhao2000_pose guess = pose_from(zhao2000_vector_guesses[k]);
        zhao2000_pose pose = guess;
        zhao2000_info info;
        zhao2000_real joints[ZHAO2000_JOINTS];
        expect(zhao2000_direct(NULL, zhao2000_vector_joints[k], &pose, &pose,
            &info) == ZHAO2000_OK, "direct", k);
        expect(difference(&pose, zhao2000_vector_poses[k]) <= bound, "direct's pose", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > 0.0, "direct's smallest pivot", k);
        expect(info.joint == ZHAO2000_JOINTS, "no joint to blame", k);
        expect(zhao2000_direct(NULL, zhao2000_vector_joints[k], &pose, &pose,
            &info) == ZHAO2000_OK, "standing still", k);
        expect(difference(&pose, zhao2000_vector_poses[k]) <= bound, "standing still's pose", k);
        pose = guess;
        expect(zhao2000_direct(NULL, zhao2000_vector_joints[k], &guess, &pose,
            NULL) == ZHAO2000_OK, "direct without info", k);
        expect(zhao2000_track(zhao2000_vector_joints[k], &pose, &info) == ZHAO2000_OK, "track", k);
        expect(difference(&pose, zhao2000_vector_poses[k]) <= bound, "track's pose", k);
        pose = pose_from(zhao2000_vector_poses[k]);
        expect(zhao2000_inverse(&pose, joints) == ZHAO2000_OK, "inverse", k);
        for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)zhao2000_vector_inverse[k][i]) <= bound
                * (((i == 3)) ? 1.0 : 0.008333333333333333), "inverse's joints", k);
        }
        if (k < ZHAO2000_VECTOR_JACOBIANS) {
            zhao2000_real jacobian[ZHAO2000_JOINTS * 6];
            expect(zhao2000_jacobian(&pose, jacobian) == ZHAO2000_OK, "jacobian", k);
            for (int i = 0; i < ZHAO2000_JOINTS * 6; ++i) {
                const double wanted = (double)zhao2000_vector_jacobians[k][i];
                const double scale = 240.0 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-8 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const zhao2000_real joints[ZHAO2000_JOINTS], const zhao2000_pose *home)
{
    const zhao2000_real wrong[4] = { 0.0, -1.0, (zhao2000_real)NAN, (zhao2000_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const zhao2000_real other = wrong[i % 4];
        const zhao2000_config config = { (i < 4) ? other : ZHAO2000_TOLERANCE, ZHAO2000_MAX_STEPS,
            (i < 4) ? ZHAO2000_MAX_STEP : other };
        const zhao2000_status wanted = (i % 4 < 2) ? ZHAO2000_OUT_OF_RANGE : ZHAO2000_NONFINITE;
        expect(refused(&config, joints, home, "wrong config") == wanted,
            "status of a wrong config", i);
    }
}

static void refuse_all(void)
{
    const zhao2000_pose home = pose_from(zhao2000_vector_home);
    const zhao2000_config none = { ZHAO2000_TOLERANCE, 0U, ZHAO2000_MAX_STEP };
    zhao2000_pose wrong = home;
    zhao2000_pose pose = home;
    zhao2000_info info;
    zhao2000_real joints[ZHAO2000_JOINTS];
    zhao2000_real jacobian[ZHAO2000_JOINTS * 6];
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        joints[i] = zhao2000_vector_joints[0][i];
    }
    expect(refused(&none, joints, &home, "no step is not enough") == ZHAO2000_MAX_ITERATIONS,
        "MAX_ITERATIONS", 1);
    refuse_configs(joints, &home);
    joints[ZHAO2000_JOINTS - 1] = (zhao2000_real)NAN;
    (void)zhao2000_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == ZHAO2000_JOINTS - 1U, "joint of a NaN", 0);
    joints[ZHAO2000_JOINTS - 1] = -2400000.0;
    (void)zhao2000_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == ZHAO2000_JOINTS - 1U, "joint out of range", 0);
    (void)zhao2000_track(joints, &pose, &info);
    expect(info.joint == ZHAO2000_JOINTS - 1U, "joint out of range of track", 0);
    joints[ZHAO2000_JOINTS - 1] = zhao2000_vector_joints[0][ZHAO2000_JOINTS - 1];
    pose = home;
    joints[0] = (zhao2000_real)NAN;
    expect(refused(NULL, joints, &home, "NaN joint") == ZHAO2000_NONFINITE, "NONFINITE", 0);
    joints[0] = (zhao2000_real)INFINITY;
    expect(refused(NULL, joints, &home, "infinite joint") == ZHAO2000_NONFINITE, "NONFINITE", 1);
    joints[0] = -2400000.0;
    expect(refused(NULL, joints, &home, "joint out of range") == ZHAO2000_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    joints[0] = 2400000.0;
    (void)refused(NULL, joints, &home, "joint beyond reach");
    joints[0] = zhao2000_vector_joints[0][0];
    wrong.quaternion[0] = 2.0;
    expect(refused(NULL, joints, &wrong, "quaternion of length 2") == ZHAO2000_OUT_OF_RANGE,
        "OUT_OF_RANGE", 1);
    expect(zhao2000_inverse(&wrong, joints) == ZHAO2000_OUT_OF_RANGE, "OUT_OF_RANGE of inverse", 0);
    expect(zhao2000_jacobian(&wrong, jacobian) == ZHAO2000_OUT_OF_RANGE,
        "OUT_OF_RANGE of jacobian", 0);
    wrong = home;
    wrong.position[1] = (zhao2000_real)NAN;
    expect(refused(NULL, joints, &wrong, "NaN guess") == ZHAO2000_NONFINITE, "NONFINITE", 2);
    expect(zhao2000_inverse(&wrong, joints) == ZHAO2000_NONFINITE, "NONFINITE of inverse", 0);
    expect(zhao2000_track(joints, &wrong, NULL) == ZHAO2000_NONFINITE, "NONFINITE of track", 0);
    wrong = pose_from(zhao2000_vector_far);
    pose = wrong;
#if ZHAO2000_VECTOR_FAR > 0
    expect(zhao2000_track(joints, &wrong, &info) == ZHAO2000_WRONG_BRANCH,
        "WRONG_BRANCH of a long step", 0);
    expect(same_pose(&pose, &wrong), "pose untouched by a long step", 0);
#else
    (void)zhao2000_track(joints, &pose, &info);
#endif
#if ZHAO2000_VECTOR_SINGULAR > 0
    for (int k = 0; k < ZHAO2000_VECTOR_SINGULAR; ++k) {
        wrong = pose_from(zhao2000_vector_singular[k]);
        expect(refused(NULL, joints, &wrong, "singular start") == ZHAO2000_SINGULAR, "SINGULAR", k);
    }
#endif
}

/* Poses that the mechanism cannot take, and joints beyond their limits. */
static void refuse_infeasible(void)
{
#if ZHAO2000_VECTOR_INFEASIBLE > 0 || ZHAO2000_VECTOR_PAST > 0
#endif
#if ZHAO2000_VECTOR_INFEASIBLE > 0
    for (int k = 0; k < ZHAO2000_VECTOR_INFEASIBLE; ++k) {
        const zhao2000_pose pose = pose_from(zhao2000_vector_infeasible[k]);
        zhao2000_real joints[ZHAO2000_JOINTS];
        for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
            joints[i] = 4.0;
        }
        expect(zhao2000_inverse(&pose, joints) == ZHAO2000_OUT_OF_RANGE,
            "a pose that cannot be taken", k);
        for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
            expect(joints[i] == 4.0, "joints untouched on failure", k);
        }
    }
#endif
#if ZHAO2000_VECTOR_PAST > 0
    for (int k = 0; k < ZHAO2000_VECTOR_PAST; ++k) {
        const zhao2000_pose home = pose_from(zhao2000_vector_home);
        zhao2000_pose pose = home;
        zhao2000_info info;
        expect(refused(NULL, zhao2000_vector_past[k], &home,
            "a joint beyond a limit") == ZHAO2000_OUT_OF_RANGE, "OUT_OF_RANGE of a limit", k);
        (void)zhao2000_direct(NULL, zhao2000_vector_past[k], &home, &pose, &info);
        expect(info.joint == (unsigned int)zhao2000_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
}

/* Rates of the twist of rates are these rates; the feed keeps the limits, and one joint reaches its
 * own. */
static void speeds_of(const zhao2000_pose *pose, int k)
{
    zhao2000_real rates[ZHAO2000_JOINTS];
    zhao2000_real again[ZHAO2000_JOINTS];
    zhao2000_real limits[ZHAO2000_JOINTS];
    zhao2000_real twist[6] = { 0.0 };
    zhao2000_real feed = 0.0;
    double largest = 0.0;
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        rates[i] = (zhao2000_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (((i == 3))
            ? (double)ZHAO2000_SIZE : 1.0));
    }
    expect(zhao2000_twist(pose, rates, twist) == ZHAO2000_OK, "twist", k);
    expect(zhao2000_rates(pose, twist, again) == ZHAO2000_OK, "rates", k);
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        expect(fabs((double)again[i] - (double)rates[i]) <= 1e-9 * (((i == 3))
            ? (double)ZHAO2000_SIZE : 1.0), "rates of the twist of rates", i);
        limits[i] = (zhao2000_real)(0.125 * (((i == 3)) ? (double)ZHAO2000_SIZE : 1.0));
    }
    expect(zhao2000_feed(pose, twist, limits, &feed) == ZHAO2000_OK, "feed", k);
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        largest = fmax(largest, fabs((double)feed * (double)again[i]) / (((i == 3))
            ? (double)ZHAO2000_SIZE : 1.0));
    }
    expect(fabs(largest - 0.125) <= 1e-6, "feed reaches a limit", k);
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        limits[i] = (zhao2000_real)(4.0 * (((i == 3)) ? (double)ZHAO2000_SIZE : 1.0));
    }
    expect((zhao2000_feed(pose, twist, limits, &feed) == ZHAO2000_OK)
        && (feed == 1.0), "no need for a feed", k);
    limits[0] = -1.0;
    expect(zhao2000_feed(pose, twist, limits, &feed) == ZHAO2000_OUT_OF_RANGE, "a limit below 0",
        k);
    limits[0] = (zhao2000_real)NAN;
    expect(zhao2000_feed(pose, twist, limits, &feed) == ZHAO2000_NONFINITE,
        "a limit that is not a number", k);
    twist[5] = (zhao2000_real)INFINITY;
    expect(zhao2000_rates(pose, twist, again) == ZHAO2000_NONFINITE, "infinite twist", k);
    rates[0] = (zhao2000_real)NAN;
    expect(zhao2000_twist(pose, rates, twist) == ZHAO2000_NONFINITE, "NaN among rates", k);
    rates[0] = (zhao2000_real)1e30;
    expect(zhao2000_twist(pose, rates, twist) == ZHAO2000_OUT_OF_RANGE, "rates beyond all bounds",
        k);
}

int main(void)
{
    solve_all();
    for (int k = 0; k < ZHAO2000_VECTOR_JACOBIANS; ++k) {
        const zhao2000_pose pose = pose_from(zhao2000_vector_poses[k]);
        speeds_of(&pose, k);
    }
    refuse_all();
    refuse_infeasible();
    (void)printf("zhao2000: %d cases, %d failures\n", ZHAO2000_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
