/* Test of ren2008.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "ren2008.h"
#include "ren2008_vectors.h"

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

static ren2008_pose pose_from(const ren2008_real numbers[7])
{
    ren2008_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* Largest difference of two poses: lengths, and rotations times the size. */
static double difference(const ren2008_pose *a, const ren2008_real b[7])
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
        largest = fmax(largest, 2.0 * (double)REN2008_SIZE * fabs((double)a->quaternion[i]
            - other));
    }
    return (cosine == cosine) ? largest : HUGE_VAL;
}

static int same_pose(const ren2008_pose *a, const ren2008_pose *b)
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
static ren2008_status refused(const ren2008_config *config,
    const ren2008_real joints[REN2008_JOINTS], const ren2008_pose *guess, const char *what)
{
    const ren2008_real marks[7] = { 1.0f, 2.0f, 4.0f, 1.0f, 2.0f, 4.0f, 1.0f };
    const ren2008_pose untouched = pose_from(marks);
    ren2008_pose pose = untouched;
    ren2008_info info;
    ren2008_status status;
    info.iterations = 255U;
    status = ren2008_direct(config, joints, guess, &pose, &info);
    expect(status != REN2008_OK, what, 0);
    expect(same_pose(&pose, &untouched), "result untouched on failure", 0);
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < REN2008_VECTORS; ++k) {
        const double bound = ren2008_vector_bounds[k];
        const ren2008_pose guess = pose_from(ren2008_vector_guesses[k]);
        ren2008_pose pose = guess;
        ren2008_info info;
        ren2008_real joints[REN2008_JOINTS];
        expect(ren2008_direct(NULL, ren2008_vector_joints[k], &pose, &pose, &info) == REN2008_OK,
            "direct", k);
        expect(difference(&pose, ren2008_vector_poses[k]) <= bound, "direct's pose", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > 0.0f, "direct's smallest pivot", k);
        expect(info.joint == REN2008_JOINTS, "no joint to blame", k);
        expect(ren2008_direct(NULL, ren2008_vector_joints[k], &pose, &pose, &info) == REN2008_OK,
            "standing still", k);
        expect(difference(&pose, ren2008_vector_poses[k]) <= bound, "standing still's pose", k);
        pose = guess;
        expect(ren2008_direct(NULL, ren2008_vector_joints[k], &guess, &pose, NULL) == REN2008_OK,
            "direct without info", k);
        expect(ren2008_track(ren2008_vector_joints[k], &pose, &info) == REN2008_OK, "track", k);
        expect(difference(&pose, ren2008_vector_poses[k]) <= bound, "track's pose", k);
        pose = pose_from(ren2008_vector_poses[k]);
        expect(ren2008_inverse(&pose, joints) == REN2008_OK, "inverse", k);
        for (int i = 0; i < REN2008_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)ren2008_vector_inverse[k][i]) <= bound,
                "inverse's joints", k);
        }
        if (k < REN2008_VECTOR_JACOBIANS) {
            ren2008_real jacobian[REN2008_JOINTS * 6];
            expect(ren2008_jacobian(&pose, jacobian) == REN2008_OK, "jacobian", k);
            for (int i = 0; i < REN2008_JOINTS * 6; ++i) {
                const double wanted = (double)ren2008_vector_jacobians[k][i];
                const double scale = 1.6901663379679528 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-4 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const ren2008_real joints[REN2008_JOINTS], const ren2008_pose *home)
{
    const ren2008_real wrong[4] = { 0.0f, -1.0f, (ren2008_real)NAN, (ren2008_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const ren2008_real other = wrong[i % 4];
        const ren2008_config config = { (i < 4) ? other : REN2008_TOLERANCE, REN2008_MAX_STEPS,
            (i < 4) ? REN2008_MAX_STEP : other };
        const ren2008_status wanted = (i % 4 < 2) ? REN2008_OUT_OF_RANGE : REN2008_NONFINITE;
        expect(refused(&config, joints, home, "wrong config") == wanted,
            "status of a wrong config", i);
    }
}

static void refuse_all(void)
{
    const ren2008_pose home = pose_from(ren2008_vector_home);
    const ren2008_config one_step = { REN2008_TOLERANCE, 1U, REN2008_MAX_STEP };
    const ren2008_config none = { REN2008_TOLERANCE, 0U, REN2008_MAX_STEP };
    ren2008_pose wrong = home;
    ren2008_pose pose = home;
    ren2008_info info;
    ren2008_real joints[REN2008_JOINTS];
    ren2008_real jacobian[REN2008_JOINTS * 6];
    for (int i = 0; i < REN2008_JOINTS; ++i) {
        joints[i] = ren2008_vector_joints[0][i];
    }
    expect(refused(&one_step, joints, &home, "one step is not enough") == REN2008_MAX_ITERATIONS,
        "MAX_ITERATIONS", 0);
    expect(refused(&none, joints, &home, "no step is not enough") == REN2008_MAX_ITERATIONS,
        "MAX_ITERATIONS", 1);
    refuse_configs(joints, &home);
    joints[REN2008_JOINTS - 1] = (ren2008_real)NAN;
    (void)ren2008_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == REN2008_JOINTS - 1U, "joint of a NaN", 0);
    joints[REN2008_JOINTS - 1] = -16901.664f;
    (void)ren2008_direct(NULL, joints, &home, &pose, &info);
    expect(info.joint == REN2008_JOINTS - 1U, "joint out of range", 0);
    (void)ren2008_track(joints, &pose, &info);
    expect(info.joint == REN2008_JOINTS - 1U, "joint out of range of track", 0);
    joints[REN2008_JOINTS - 1] = ren2008_vector_joints[0][REN2008_JOINTS - 1];
    pose = home;
    joints[0] = (ren2008_real)NAN;
    expect(refused(NULL, joints, &home, "NaN joint") == REN2008_NONFINITE, "NONFINITE", 0);
    joints[0] = (ren2008_real)INFINITY;
    expect(refused(NULL, joints, &home, "infinite joint") == REN2008_NONFINITE, "NONFINITE", 1);
    joints[0] = -16901.664f;
    expect(refused(NULL, joints, &home, "joint out of range") == REN2008_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    joints[0] = 16901.664f;
    (void)refused(NULL, joints, &home, "joint beyond reach");
    joints[0] = ren2008_vector_joints[0][0];
    wrong.quaternion[0] = 2.0f;
    expect(refused(NULL, joints, &wrong, "quaternion of length 2") == REN2008_OUT_OF_RANGE,
        "OUT_OF_RANGE", 1);
    expect(ren2008_inverse(&wrong, joints) == REN2008_OUT_OF_RANGE, "OUT_OF_RANGE of inverse", 0);
    expect(ren2008_jacobian(&wrong, jacobian) == REN2008_OUT_OF_RANGE, "OUT_OF_RANGE of jacobian",
        0);
    wrong = home;
    wrong.position[1] = (ren2008_real)NAN;
    expect(refused(NULL, joints, &wrong, "NaN guess") == REN2008_NONFINITE, "NONFINITE", 2);
    expect(ren2008_inverse(&wrong, joints) == REN2008_NONFINITE, "NONFINITE of inverse", 0);
    expect(ren2008_track(joints, &wrong, NULL) == REN2008_NONFINITE, "NONFINITE of track", 0);
    wrong = pose_from(ren2008_vector_far);
    pose = wrong;
#if REN2008_VECTOR_FAR > 0
    expect(ren2008_track(joints, &wrong, &info) == REN2008_WRONG_BRANCH,
        "WRONG_BRANCH of a long step", 0);
    expect(same_pose(&pose, &wrong), "pose untouched by a long step", 0);
#else
    (void)ren2008_track(joints, &pose, &info);
#endif
#if REN2008_VECTOR_SINGULAR > 0
    for (int k = 0; k < REN2008_VECTOR_SINGULAR; ++k) {
        wrong = pose_from(ren2008_vector_singular[k]);
        expect(refused(NULL, joints, &wrong, "singular start") == REN2008_SINGULAR, "SINGULAR", k);
    }
#endif
}

/* Poses that the mechanism cannot take, and joints beyond their limits. */
static void refuse_infeasible(void)
{
#if REN2008_VECTOR_INFEASIBLE > 0 || REN2008_VECTOR_PAST > 0
#endif
#if REN2008_VECTOR_INFEASIBLE > 0
    for (int k = 0; k < REN2008_VECTOR_INFEASIBLE; ++k) {
        const ren2008_pose pose = pose_from(ren2008_vector_infeasible[k]);
        ren2008_real joints[REN2008_JOINTS];
        for (int i = 0; i < REN2008_JOINTS; ++i) {
            joints[i] = 4.0f;
        }
        expect(ren2008_inverse(&pose, joints) == REN2008_OUT_OF_RANGE,
            "a pose that cannot be taken", k);
        for (int i = 0; i < REN2008_JOINTS; ++i) {
            expect(joints[i] == 4.0f, "joints untouched on failure", k);
        }
    }
#endif
#if REN2008_VECTOR_PAST > 0
    for (int k = 0; k < REN2008_VECTOR_PAST; ++k) {
        const ren2008_pose home = pose_from(ren2008_vector_home);
        ren2008_pose pose = home;
        ren2008_info info;
        expect(refused(NULL, ren2008_vector_past[k], &home,
            "a joint beyond a limit") == REN2008_OUT_OF_RANGE, "OUT_OF_RANGE of a limit", k);
        (void)ren2008_direct(NULL, ren2008_vector_past[k], &home, &pose, &info);
        expect(info.joint == (unsigned int)ren2008_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
}

/* Rates of the twist of rates are these rates; the feed keeps the limits, and one joint reaches its
 * own. */
static void speeds_of(const ren2008_pose *pose, int k)
{
    ren2008_real rates[REN2008_JOINTS];
    ren2008_real again[REN2008_JOINTS];
    ren2008_real limits[REN2008_JOINTS];
    ren2008_real twist[6] = { 0.0f };
    ren2008_real feed = 0.0f;
    double largest = 0.0;
    for (int i = 0; i < REN2008_JOINTS; ++i) {
        rates[i] = (ren2008_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1)
            ? -0.5 : 0.25) * ((double)REN2008_SIZE));
    }
    expect(ren2008_twist(pose, rates, twist) == REN2008_OK, "twist", k);
    expect(ren2008_rates(pose, twist, again) == REN2008_OK, "rates", k);
    for (int i = 0; i < REN2008_JOINTS; ++i) {
        expect(fabs((double)again[i] - (double)rates[i]) <= 1e-3 * ((double)REN2008_SIZE),
            "rates of the twist of rates", i);
        limits[i] = (ren2008_real)(0.125 * ((double)REN2008_SIZE));
    }
    expect(ren2008_feed(pose, twist, limits, &feed) == REN2008_OK, "feed", k);
    for (int i = 0; i < REN2008_JOINTS; ++i) {
        largest = fmax(largest, fabs((double)feed * (double)again[i]) / ((double)REN2008_SIZE));
    }
    expect(fabs(largest - 0.125) <= 1e-6, "feed reaches a limit", k);
    for (int i = 0; i < REN2008_JOINTS; ++i) {
        limits[i] = (ren2008_real)(4.0 * ((double)REN2008_SIZE));
    }
    expect((ren2008_feed(pose, twist, limits, &feed) == REN2008_OK)
        && (feed == 1.0f), "no need for a feed", k);
    limits[0] = -1.0f;
    expect(ren2008_feed(pose, twist, limits, &feed) == REN2008_OUT_OF_RANGE, "a limit below 0", k);
    limits[0] = (ren2008_real)NAN;
    expect(ren2008_feed(pose, twist, limits, &feed) == REN2008_NONFINITE,
        "a limit that is not a number", k);
    twist[5] = (ren2008_real)INFINITY;
    expect(ren2008_rates(pose, twist, again) == REN2008_NONFINITE, "infinite twist", k);
    rates[0] = (ren2008_real)NAN;
    expect(ren2008_twist(pose, rates, twist) == REN2008_NONFINITE, "NaN among rates", k);
    rates[0] = (ren2008_real)1e30;
    expect(ren2008_twist(pose, rates, twist) == REN2008_OUT_OF_RANGE, "rates beyond all bounds", k);
}

int main(void)
{
    solve_all();
    for (int k = 0; k < REN2008_VECTOR_JACOBIANS; ++k) {
        const ren2008_pose pose = pose_from(ren2008_vector_poses[k]);
        speeds_of(&pose, k);
    }
    refuse_all();
    refuse_infeasible();
    (void)printf("ren2008: %d cases, %d failures\n", REN2008_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
