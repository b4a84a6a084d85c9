/* Test of zhang2009.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "zhang2009.h"
#include "zhang2009_vectors.h"

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

static zhang2009_pose pose_from(const zhang2009_real numbers[7])
{
    zhang2009_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* Largest difference of two poses: lengths, and rotations times the size. */
static double difference(const zhang2009_pose *a, const zhang2009_real b[7])
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
        largest = fmax(largest, 2.0 * (double)ZHANG2009_SIZE * fabs((double)a->quaternion[i]
            - other));
    }
    return (cosine == cosine) ? largest : HUGE_VAL;
}

static int same_pose(const zhang2009_pose *a, const zhang2009_pose *b)
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
static zhang2009_status refused(const zhang2009_config *config,
    const zhang2009_real joints[ZHANG2009_JOINTS], const zhang2009_pose *guess, const char *what)
{
    const zhang2009_real marks[7] = { 1.0f, 2.0f, 4.0f, 1.0f, 2.0f, 4.0f, 1.0f };
    const zhang2009_pose untouched = pose_from(marks);
    zhang2009_pose pose = untouched;
    zhang2009_info info;
    zhang2009_status status;
    info.iterations = 255U;
    status = zhang2009_direct(config, joints, guess, &pose, &info);
    expect(status != ZHANG2009_OK, what, 0);
    expect(same_pose(&pose, &untouched), "result untouched on failure", 0);
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < ZHANG2009_VECTORS; ++k) {
        const double bound = zhang2009_vector_bounds[k];
        const zhang2009_pose guess = pose_from(zhang2009_vector_guesses[k]);
        zhang2009_pose pose = guess;
        zhang2009_info info;
        zhang2009_real joints[ZHANG2009_JOINTS];
        expect(zhang2009_direct(NULL, zhang2009_vector_joints[k], &pose, &pose,
            &info) == ZHANG2009_OK, "direct", k);
        expect(difference(&pose, zhang2009_vector_poses[k]) <= bound, "direct's pose", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > 0.0f, "direct's smallest pivot", k);
        expect(info.joint == ZHANG2009_JOINTS, "no joint to blame", k);
        expect(zhang2009_direct(NULL, zhang2009_vector_joints[k], &pose, &pose,
            &info) == ZHANG2009_OK, "standing still", k);
        expect(difference(&pose, zhang2009_vector_poses[k]) <= bound, "standing still's pose", k);
        pose = guess;
        expect(zhang2009_direct(NULL, zhang2009_vector_joints[k], &guess, &pose,
            NULL) == ZHANG2009_OK, "direct without info", k);
        expect(zhang2009_track(zhang2009_vector_joints[k], &pose, &info) == ZHANG2009_OK, "track",
            k);
        expect(difference(&pose, zhang2009_vector_poses[k]) <= bound, "track's pose", k);
        pose = pose_from(zhang2009_vector_poses[k]);
        expect(zhang2009_inverse(&pose, joints) == ZHANG2009_OK, "inverse", k);
        for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)zhang2009_vector_inverse[k][i]) <= bound,
                "inverse's joints", k);
        }
        if (k < ZHANG2009_VECTOR_JACOBIANS) {
            zhang2009_real jacobian[ZHANG2009_JOINTS * 6];
            expect(zhang2009_jacobian(&pose, jacobian) == ZHANG2009_OK, "jacobian", k);
            for (int i = 0; i < ZHANG2009_JOINTS * 6; ++i) {
                const double wanted = (double)zhang2009_vector_jacobians[k][i];
                const double scale = 531.2592044589876 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-4 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const zhang2009_real joints[ZHANG2009_JOINTS],
    const zhang2009_pose *home)
{
    const zhang2009_real wrong[4] = { 0.0f, -1.0f, (zhang2009_real)NAN, (zhang2009_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const zhang2009_real other = wrong[i % 4];
        const zhang2009_config config = { (i < 4) ? other : ZHANG2009_TOLERANCE,
            ZHANG2009_MAX_STEPS, (i < 4) ? ZHANG2009_MAX_STEP : other };
        const zhang2009_status wanted = (i % 4 < 2) ? ZHANG2009_OUT_OF_RANGE : ZHANG2009_NONFINITE;
        expect(refused(&config, joints, home, "wrong config") == wanted,
            "status of a wrong config", i);
    }
}

static void refuse_all(void)
{
    const zhang2009_pose home = pose_from(zhang2009_vector_home);
    const zhang2009_config one_step = { ZHANG2009_TOLERANCE, 1U, ZHANG2009_MAX_STEP };
    const zhang2009_config none = { ZHANG2009_TOLERANCE, 0U, ZHANG2009_MAX_STEP };
    zhang2009_pose wrong = home;
    zhang2009_pose pose = home;
    zhang2009_info info;
    zhang2009_real joints[ZHANG2009_JOINTS];
    zhang2009_real jacobian[ZHANG2009_JOINTS * 6];
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        joints[i] = zhang2009_vector_joints[0][i];
    }
    expect(refused(&one_step, joints, &home, "one step is not enough") == ZHANG2009_MAX_ITERATIONS,
        "MAX_ITERATIONS", 0);
    expect(refused(&none, joints, &home, "no step is not enough") == ZHANG2009_MAX_ITERATIONS,
        "MAX_ITERATIONS", 1);
    refuse_configs(joints, &home);
    joints[ZHANG2009_JOINTS - 1] = (zhang2009_real)NAN;
    (void)zhang2009_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == ZHANG2009_JOINTS - 1U, "joint of a NaN", 0);
    joints[ZHANG2009_JOINTS - 1] = -5.312592e+06f;
    (void)zhang2009_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == ZHANG2009_JOINTS - 1U, "joint out of range", 0);
    (void)zhang2009_track(joints, &pose, &info);
    expect(info.joint == ZHANG2009_JOINTS - 1U, "joint out of range of track", 0);
    joints[ZHANG2009_JOINTS - 1] = zhang2009_vector_joints[0][ZHANG2009_JOINTS - 1];
    pose = home;
    joints[0] = (zhang2009_real)NAN;
    expect(refused(NULL, joints, &home, "NaN joint") == ZHANG2009_NONFINITE, "NONFINITE", 0);
    joints[0] = (zhang2009_real)INFINITY;
    expect(refused(NULL, joints, &home, "infinite joint") == ZHANG2009_NONFINITE, "NONFINITE", 1);
    joints[0] = -5.312592e+06f;
    expect(refused(NULL, joints, &home, "joint out of range") == ZHANG2009_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    joints[0] = 5.312592e+06f;
    (void)refused(NULL, joints, &home, "joint beyond reach");
    joints[0] = zhang2009_vector_joints[0][0];
    wrong.quaternion[0] = 2.0f;
    expect(refused(NULL, joints, &wrong, "quaternion of length 2") == ZHANG2009_OUT_OF_RANGE,
        "OUT_OF_RANGE", 1);
    expect(zhang2009_inverse(&wrong, joints) == ZHANG2009_OUT_OF_RANGE, "OUT_OF_RANGE of inverse",
        0);
    expect(zhang2009_jacobian(&wrong, jacobian) == ZHANG2009_OUT_OF_RANGE,
        "OUT_OF_RANGE of jacobian", 0);
    wrong = home;
    wrong.position[1] = (zhang2009_real)NAN;
    expect(refused(NULL, joints, &wrong, "NaN guess") == ZHANG2009_NONFINITE, "NONFINITE", 2);
    expect(zhang2009_inverse(&wrong, joints) == ZHANG2009_NONFINITE, "NONFINITE of inverse", 0);
    expect(zhang2009_track(joints, &wrong, NULL) == ZHANG2009_NONFINITE, "NONFINITE of track", 0);
    wrong = pose_from(zhang2009_vector_far);
    pose = wrong;
#if ZHANG2009_VECTOR_FAR > 0
    expect(zhang2009_track(joints, &wrong, &info) == ZHANG2009_WRONG_BRANCH,
        "WRONG_BRANCH of a long step", 0);
    expect(same_pose(&pose, &wrong), "pose untouched by a long step", 0);
#else
    (void)zhang2009_track(joints, &pose, &info);
#endif
#if ZHANG2009_VECTOR_SINGULAR > 0
    for (int k = 0; k < ZHANG2009_VECTOR_SINGULAR; ++k) {
        wrong = pose_from(zhang2009_vector_singular[k]);
        expect(refused(NULL, joints, &wrong, "singular start") == ZHANG2009_SINGULAR, "SINGULAR",
            k);
    }
#endif
}

/* Poses that the mechanism cannot take, and joints beyond their limits. */
static void refuse_infeasible(void)
{
#if ZHANG2009_VECTOR_INFEASIBLE > 0 || ZHANG2009_VECTOR_PAST > 0
#endif
#if ZHANG2009_VECTOR_INFEASIBLE > 0
    for (int k = 0; k < ZHANG2009_VECTOR_INFEASIBLE; ++k) {
        const zhang2009_pose pose = pose_from(zhang2009_vector_infeasible[k]);
        zhang2009_real joints[ZHANG2009_JOINTS];
        for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
            joints[i] = 4.0f;
        }
        expect(zhang2009_inverse(&pose, joints) == ZHANG2009_OUT_OF_RANGE,
            "a pose that cannot be taken", k);
        for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
            expect(joints[i] == 4.0f, "joints untouched on failure", k);
        }
    }
#endif
#if ZHANG2009_VECTOR_PAST > 0
    for (int k = 0; k < ZHANG2009_VECTOR_PAST; ++k) {
        const zhang2009_pose home = pose_from(zhang2009_vector_home);
        zhang2009_pose pose = home;
        zhang2009_info info;
        expect(refused(NULL, zhang2009_vector_past[k], &home,
            "a joint beyond a limit") == ZHANG2009_OUT_OF_RANGE, "OUT_OF_RANGE of a limit", k);
        (void)zhang2009_direct(NULL, zhang2009_vector_past[k], &home, &pose, &info);
        expect(info.joint == (unsigned int)zhang2009_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
}

/* Rates of the twist of rates are these rates; the feed keeps the limits, and one joint reaches its
 * own. */
static void speeds_of(const zhang2009_pose *pose, int k)
{
    zhang2009_real rates[ZHANG2009_JOINTS];
    zhang2009_real again[ZHANG2009_JOINTS];
    zhang2009_real limits[ZHANG2009_JOINTS];
    zhang2009_real twist[6] = { 0.0f };
    zhang2009_real feed = 0.0f;
    double largest = 0.0;
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        rates[i] = (zhang2009_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1)
            ? -0.5 : 0.25) * ((double)ZHANG2009_SIZE));
    }
    expect(zhang2009_twist(pose, rates, twist) == ZHANG2009_OK, "twist", k);
    expect(zhang2009_rates(pose, twist, again) == ZHANG2009_OK, "rates", k);
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        expect(fabs((double)again[i] - (double)rates[i]) <= 1e-3 * ((double)ZHANG2009_SIZE),
            "rates of the twist of rates", i);
        limits[i] = (zhang2009_real)(0.125 * ((double)ZHANG2009_SIZE));
    }
    expect(zhang2009_feed(pose, twist, limits, &feed) == ZHANG2009_OK, "feed", k);
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        largest = fmax(largest, fabs((double)feed * (double)again[i]) / ((double)ZHANG2009_SIZE));
    }
    expect(fabs(largest - 0.125) <= 1e-6, "feed reaches a limit", k);
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        limits[i] = (zhang2009_real)(4.0 * ((double)ZHANG2009_SIZE));
    }
    expect((zhang2009_feed(pose, twist, limits, &feed) == ZHANG2009_OK)
        && (feed == 1.0f), "no need for a feed", k);
    limits[0] = -1.0f;
    expect(zhang2009_feed(pose, twist, limits, &feed) == ZHANG2009_OUT_OF_RANGE, "a limit below 0",
        k);
    limits[0] = (zhang2009_real)NAN;
    expect(zhang2009_feed(pose, twist, limits, &feed) == ZHANG2009_NONFINITE,
        "a limit that is not a number", k);
    twist[5] = (zhang2009_real)INFINITY;
    expect(zhang2009_rates(pose, twist, again) == ZHANG2009_NONFINITE, "infinite twist", k);
    rates[0] = (zhang2009_real)NAN;
    expect(zhang2009_twist(pose, rates, twist) == ZHANG2009_NONFINITE, "NaN among rates", k);
    rates[0] = (zhang2009_real)1e30;
    expect(zhang2009_twist(pose, rates, twist) == ZHANG2009_OUT_OF_RANGE,
        "rates beyond all bounds", k);
}

int main(void)
{
    solve_all();
    for (int k = 0; k < ZHANG2009_VECTOR_JACOBIANS; ++k) {
        const zhang2009_pose pose = pose_from(zhang2009_vector_poses[k]);
        speeds_of(&pose, k);
    }
    refuse_all();
    refuse_infeasible();
    (void)printf("zhang2009: %d cases, %d failures\n", ZHANG2009_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
