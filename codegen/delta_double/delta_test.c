/* Test of delta.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "delta.h"
#include "delta_vectors.h"

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

static delta_pose pose_from(const delta_real numbers[7])
{
    delta_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* Largest difference of two poses: lengths, and rotations times the size. */
static double difference(const delta_pose *a, const delta_real b[7])
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
        largest = fmax(largest, 2.0 * (double)DELTA_SIZE * fabs((double)a->quaternion[i] - other));
    }
    return (cosine == cosine) ? largest : HUGE_VAL;
}

static int same_pose(const delta_pose *a, const delta_pose *b)
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
static delta_status refused(const delta_config *config, const delta_real joints[DELTA_JOINTS],
    const delta_pose *guess, const char *what)
{
    const delta_real marks[7] = { 1.0, 2.0, 4.0, 1.0, 2.0, 4.0, 1.0 };
    const delta_pose untouched = pose_from(marks);
    delta_pose pose = untouched;
    delta_info info;
    delta_status status;
    info.iterations = 255U;
    status = delta_direct(config, joints, guess, &pose, &info);
    expect(status != DELTA_OK, what, 0);
    expect(same_pose(&pose, &untouched), "result untouched on failure", 0);
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < DELTA_VECTORS; ++k) {
        const double bound = delta_vector_bounds[k];
        const delta_pose guess = pose_from(delta_vector_guesses[k]);
        delta_pose pose = guess;
        delta_info info;
        delta_real joints[DELTA_JOINTS];
        expect(delta_direct(NULL, delta_vector_joints[k], &pose, &pose, &info) == DELTA_OK,
            "direct", k);
        expect(difference(&pose, delta_vector_poses[k]) <= bound, "direct's pose", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > 0.0, "direct's smallest pivot", k);
        expect(info.joint == DELTA_JOINTS, "no joint to blame", k);
        expect(delta_direct(NULL, delta_vector_joints[k], &pose, &pose, &info) == DELTA_OK,
            "standing still", k);
        expect(difference(&pose, delta_vector_poses[k]) <= bound, "standing still's pose", k);
        pose = guess;
        expect(delta_direct(NULL, delta_vector_joints[k], &guess, &pose, NULL) == DELTA_OK,
            "direct without info", k);
        expect(delta_track(delta_vector_joints[k], &pose, &info) == DELTA_OK, "track", k);
        expect(difference(&pose, delta_vector_poses[k]) <= bound, "track's pose", k);
        pose = pose_from(delta_vector_poses[k]);
        expect(delta_inverse(&pose, joints) == DELTA_OK, "inverse", k);
        for (int i = 0; i < DELTA_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)delta_vector_inverse[k][i]) <= bound
                * 0.004518347638407824, "inverse's joints", k);
        }
        if (k < DELTA_VECTOR_JACOBIANS) {
            delta_real jacobian[DELTA_JOINTS * 6];
            expect(delta_jacobian(&pose, jacobian) == DELTA_OK, "jacobian", k);
            for (int i = 0; i < DELTA_JOINTS * 6; ++i) {
                const double wanted = (double)delta_vector_jacobians[k][i];
                const double scale = 442.63969044771426 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-8 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const delta_real joints[DELTA_JOINTS], const delta_pose *home)
{
    const delta_real wrong[4] = { 0.0, -1.0, (delta_real)NAN, (delta_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const delta_real other = wrong[i % 4];
        const delta_config config = { (i < 4) ? other : DELTA_TOLERANCE, DELTA_MAX_STEPS,
            (i < 4) ? DELTA_MAX_STEP : other };
        const delta_status wanted = (i % 4 < 2) ? DELTA_OUT_OF_RANGE : DELTA_NONFINITE;
        expect(refused(&config, joints, home, "wrong config") == wanted,
            "status of a wrong config", i);
    }
}

static void refuse_all(void)
{
    const delta_pose home = pose_from(delta_vector_home);
    const delta_config none = { DELTA_TOLERANCE, 0U, DELTA_MAX_STEP };
    delta_pose wrong = home;
    delta_pose pose = home;
    delta_info info;
    delta_real joints[DELTA_JOINTS];
    delta_real jacobian[DELTA_JOINTS * 6];
    for (int i = 0; i < DELTA_JOINTS; ++i) {
        joints[i] = delta_vector_joints[0][i];
    }
    expect(refused(&none, joints, &home, "no step is not enough") == DELTA_MAX_ITERATIONS,
        "MAX_ITERATIONS", 1);
    refuse_configs(joints, &home);
    joints[DELTA_JOINTS - 1] = (delta_real)NAN;
    (void)delta_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == DELTA_JOINTS - 1U, "joint of a NaN", 0);
    joints[DELTA_JOINTS - 1] = -4426396.904477143;
    (void)delta_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == DELTA_JOINTS - 1U, "joint out of range", 0);
    (void)delta_track(joints, &pose, &info);
    expect(info.joint == DELTA_JOINTS - 1U, "joint out of range of track", 0);
    joints[DELTA_JOINTS - 1] = delta_vector_joints[0][DELTA_JOINTS - 1];
    pose = home;
    joints[0] = (delta_real)NAN;
    expect(refused(NULL, joints, &home, "NaN joint") == DELTA_NONFINITE, "NONFINITE", 0);
    joints[0] = (delta_real)INFINITY;
    expect(refused(NULL, joints, &home, "infinite joint") == DELTA_NONFINITE, "NONFINITE", 1);
    joints[0] = -4426396.904477143;
    expect(refused(NULL, joints, &home, "joint out of range") == DELTA_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    joints[0] = 4426396.904477143;
    (void)refused(NULL, joints, &home, "joint beyond reach");
    joints[0] = delta_vector_joints[0][0];
    wrong.quaternion[0] = 2.0;
    expect(refused(NULL, joints, &wrong, "quaternion of length 2") == DELTA_OUT_OF_RANGE,
        "OUT_OF_RANGE", 1);
    expect(delta_inverse(&wrong, joints) == DELTA_OUT_OF_RANGE, "OUT_OF_RANGE of inverse", 0);
    expect(delta_jacobian(&wrong, jacobian) == DELTA_OUT_OF_RANGE, "OUT_OF_RANGE of jacobian", 0);
    wrong = home;
    wrong.position[1] = (delta_real)NAN;
    expect(refused(NULL, joints, &wrong, "NaN guess") == DELTA_NONFINITE, "NONFINITE", 2);
    expect(delta_inverse(&wrong, joints) == DELTA_NONFINITE, "NONFINITE of inverse", 0);
    expect(delta_track(joints, &wrong, NULL) == DELTA_NONFINITE, "NONFINITE of track", 0);
    wrong = pose_from(delta_vector_far);
    pose = wrong;
#if DELTA_VECTOR_FAR > 0
    expect(delta_track(joints, &wrong, &info) == DELTA_WRONG_BRANCH, "WRONG_BRANCH of a long step",
        0);
    expect(same_pose(&pose, &wrong), "pose untouched by a long step", 0);
#else
    (void)delta_track(joints, &pose, &info);
#endif
#if DELTA_VECTOR_SINGULAR > 0
    for (int k = 0; k < DELTA_VECTOR_SINGULAR; ++k) {
        wrong = pose_from(delta_vector_singular[k]);
        expect(refused(NULL, joints, &wrong, "singular start") == DELTA_SINGULAR, "SINGULAR", k);
    }
#endif
}

/* Poses that the mechanism cannot take, and joints beyond their limits. */
static void refuse_infeasible(void)
{
#if DELTA_VECTOR_INFEASIBLE > 0 || DELTA_VECTOR_PAST > 0
#endif
#if DELTA_VECTOR_INFEASIBLE > 0
    for (int k = 0; k < DELTA_VECTOR_INFEASIBLE; ++k) {
        const delta_pose pose = pose_from(delta_vector_infeasible[k]);
        delta_real joints[DELTA_JOINTS];
        for (int i = 0; i < DELTA_JOINTS; ++i) {
            joints[i] = 4.0;
        }
        expect(delta_inverse(&pose, joints) == DELTA_OUT_OF_RANGE, "a pose that cannot be taken",
            k);
        for (int i = 0; i < DELTA_JOINTS; ++i) {
            expect(joints[i] == 4.0, "joints untouched on failure", k);
        }
    }
#endif
#if DELTA_VECTOR_PAST > 0
    for (int k = 0; k < DELTA_VECTOR_PAST; ++k) {
        const delta_pose home = pose_from(delta_vector_home);
        delta_pose pose = home;
        delta_info info;
        expect(refused(NULL, delta_vector_past[k], &home,
            "a joint beyond a limit") == DELTA_OUT_OF_RANGE, "OUT_OF_RANGE of a limit", k);
        (void)delta_direct(NULL, delta_vector_past[k], &home, &pose, &info);
        expect(info.joint == (unsigned int)delta_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
}

/* Rates of the twist of rates are these rates; the feed keeps the limits, and one joint reaches its
 * own. */
static void speeds_of(const delta_pose *pose, int k)
{
    delta_real rates[DELTA_JOINTS];
    delta_real again[DELTA_JOINTS];
    delta_real limits[DELTA_JOINTS];
    delta_real twist[6] = { 0.0 };
    delta_real feed = 0.0;
    double largest = 0.0;
    for (int i = 0; i < DELTA_JOINTS; ++i) {
        rates[i] = (delta_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (1.0));
    }
    expect(delta_twist(pose, rates, twist) == DELTA_OK, "twist", k);
    expect(delta_rates(pose, twist, again) == DELTA_OK, "rates", k);
    for (int i = 0; i < DELTA_JOINTS; ++i) {
        expect(fabs((double)again[i] - (double)rates[i]) <= 1e-9 * (1.0),
            "rates of the twist of rates", i);
        limits[i] = (delta_real)(0.125 * (1.0));
    }
    expect(delta_feed(pose, twist, limits, &feed) == DELTA_OK, "feed", k);
    for (int i = 0; i < DELTA_JOINTS; ++i) {
        largest = fmax(largest, fabs((double)feed * (double)again[i]) / (1.0));
    }
    expect(fabs(largest - 0.125) <= 1e-6, "feed reaches a limit", k);
    for (int i = 0; i < DELTA_JOINTS; ++i) {
        limits[i] = (delta_real)(4.0 * (1.0));
    }
    expect((delta_feed(pose, twist, limits, &feed) == DELTA_OK)
        && (feed == 1.0), "no need for a feed", k);
    limits[0] = -1.0;
    expect(delta_feed(pose, twist, limits, &feed) == DELTA_OUT_OF_RANGE, "a limit below 0", k);
    limits[0] = (delta_real)NAN;
    expect(delta_feed(pose, twist, limits, &feed) == DELTA_NONFINITE,
        "a limit that is not a number", k);
    twist[5] = (delta_real)INFINITY;
    expect(delta_rates(pose, twist, again) == DELTA_NONFINITE, "infinite twist", k);
    rates[0] = (delta_real)NAN;
    expect(delta_twist(pose, rates, twist) == DELTA_NONFINITE, "NaN among rates", k);
    rates[0] = (delta_real)1e30;
    expect(delta_twist(pose, rates, twist) == DELTA_OUT_OF_RANGE, "rates beyond all bounds", k);
}

int main(void)
{
    solve_all();
    for (int k = 0; k < DELTA_VECTOR_JACOBIANS; ++k) {
        const delta_pose pose = pose_from(delta_vector_poses[k]);
        speeds_of(&pose, k);
    }
    refuse_all();
    refuse_infeasible();
    (void)printf("delta: %d cases, %d failures\n", DELTA_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
