/* Test of @{p}.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

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

static @{p}_pose pose_from(const @{p}_real numbers[7])
{
    @{p}_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* Largest difference of two poses: lengths, and rotations times the size. */
static double difference(const @{p}_pose *a, const @{p}_real b[7])
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
        largest = fmax(largest, 2.0 * (double)@{P}_SIZE * fabs((double)a->quaternion[i] - other));
    }
    return (cosine == cosine) ? largest : HUGE_VAL;
}

static int same_pose(const @{p}_pose *a, const @{p}_pose *b)
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
static @{p}_status refused(const @{p}_config *config, const @{p}_real joints[@{P}_JOINTS], const @{p}_pose *guess, const char *what)
{
    const @{p}_real marks[7] = { @{one}, @{two}, @{four}, @{one}, @{two}, @{four}, @{one} };
    const @{p}_pose untouched = pose_from(marks);
@{nominal}
    @{p}_pose pose = untouched;
    @{p}_info info;
    @{p}_status status;
    info.iterations = 255U;
    status = @{p}_direct(@{ga}config, joints, guess, &pose, &info);
    expect(status != @{P}_OK, what, 0);
    expect(same_pose(&pose, &untouched), "result untouched on failure", 0);
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
@{nominal}
    for (int k = 0; k < @{P}_VECTORS; ++k) {
        const double bound = @{p}_vector_bounds[k];
        const @{p}_pose guess = pose_from(@{p}_vector_guesses[k]);
        @{p}_pose pose = guess;
        @{p}_info info;
        @{p}_real joints[@{P}_JOINTS];
        expect(@{p}_direct(@{ga}NULL, @{p}_vector_joints[k], &pose, &pose, &info) == @{P}_OK, "direct", k);
        expect(difference(&pose, @{p}_vector_poses[k]) <= bound, "direct's pose", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > @{zero}, "direct's smallest pivot", k);
        expect(info.joint == @{P}_JOINTS, "no joint to blame", k);
        expect(@{p}_direct(@{ga}NULL, @{p}_vector_joints[k], &pose, &pose, &info) == @{P}_OK, "standing still", k);
        expect(difference(&pose, @{p}_vector_poses[k]) <= bound, "standing still's pose", k);
        pose = guess;
        expect(@{p}_direct(@{ga}NULL, @{p}_vector_joints[k], &guess, &pose, NULL) == @{P}_OK, "direct without info", k);
        expect(@{p}_track(@{ga}@{p}_vector_joints[k], &pose, &info) == @{P}_OK, "track", k);
        expect(difference(&pose, @{p}_vector_poses[k]) <= bound, "track's pose", k);
        pose = pose_from(@{p}_vector_poses[k]);
        expect(@{p}_inverse(@{ga}&pose, joints) == @{P}_OK, "inverse", k);
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)@{p}_vector_inverse[k][i]) <= bound@{angle_bound}, "inverse's joints", k);
        }
        if (k < @{P}_VECTOR_JACOBIANS) {
            @{p}_real jacobian[@{P}_JOINTS * 6];
            expect(@{p}_jacobian(@{ga}&pose, jacobian) == @{P}_OK, "jacobian", k);
            for (int i = 0; i < @{P}_JOINTS * 6; ++i) {
                const double wanted = (double)@{p}_vector_jacobians[k][i];
                const double scale = @{jacobian_unit} * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= @{jacobian_bound} * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const @{p}_real joints[@{P}_JOINTS], const @{p}_pose *home)
{
    const @{p}_real wrong[4] = { @{zero}, -@{one}, (@{p}_real)NAN, (@{p}_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const @{p}_real other = wrong[i % 4];
        const @{p}_config config = { (i < 4) ? other : @{P}_TOLERANCE, @{P}_MAX_STEPS, (i < 4) ? @{P}_MAX_STEP : other };
        const @{p}_status wanted = (i % 4 < 2) ? @{P}_OUT_OF_RANGE : @{P}_NONFINITE;
        expect(refused(&config, joints, home, "wrong config") == wanted, "status of a wrong config", i);
    }
}

static void refuse_all(void)
{
@{nominal}
    const @{p}_pose home = pose_from(@{p}_vector_home);
@{one_step}
    const @{p}_config none = { @{P}_TOLERANCE, 0U, @{P}_MAX_STEP };
    @{p}_pose wrong = home;
    @{p}_pose pose = home;
    @{p}_info info;
    @{p}_real joints[@{P}_JOINTS];
    @{p}_real jacobian[@{P}_JOINTS * 6];
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = @{p}_vector_joints[0][i];
    }
@{one_step_is_few}
    expect(refused(&none, joints, &home, "no step is not enough") == @{P}_MAX_ITERATIONS, "MAX_ITERATIONS", 1);
    refuse_configs(joints, &home);
    joints[@{P}_JOINTS - 1] = (@{p}_real)NAN;
    (void)@{p}_direct(@{ga}NULL, joints, &home, &pose, &info);
    expect(info.joint == @{P}_JOINTS - 1U, "joint of a NaN", 0);
    joints[@{P}_JOINTS - 1] = -@{far};
    (void)@{p}_direct(@{ga}NULL, joints, &home, &pose, &info);
    expect(info.joint == @{P}_JOINTS - 1U, "joint out of range", 0);
    (void)@{p}_track(@{ga}joints, &pose, &info);
    expect(info.joint == @{P}_JOINTS - 1U, "joint out of range of track", 0);
    joints[@{P}_JOINTS - 1] = @{p}_vector_joints[0][@{P}_JOINTS - 1];
    pose = home;
    joints[0] = (@{p}_real)NAN;
    expect(refused(NULL, joints, &home, "NaN joint") == @{P}_NONFINITE, "NONFINITE", 0);
    joints[0] = (@{p}_real)INFINITY;
    expect(refused(NULL, joints, &home, "infinite joint") == @{P}_NONFINITE, "NONFINITE", 1);
    joints[0] = -@{far};
    expect(refused(NULL, joints, &home, "joint out of range") == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE", 0);
    joints[0] = @{far};
    (void)refused(NULL, joints, &home, "joint beyond reach");
    joints[0] = @{p}_vector_joints[0][0];
    wrong.quaternion[0] = @{two};
    expect(refused(NULL, joints, &wrong, "quaternion of length 2") == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE", 1);
    expect(@{p}_inverse(@{ga}&wrong, joints) == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE of inverse", 0);
    expect(@{p}_jacobian(@{ga}&wrong, jacobian) == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE of jacobian", 0);
    wrong = home;
    wrong.position[1] = (@{p}_real)NAN;
    expect(refused(NULL, joints, &wrong, "NaN guess") == @{P}_NONFINITE, "NONFINITE", 2);
    expect(@{p}_inverse(@{ga}&wrong, joints) == @{P}_NONFINITE, "NONFINITE of inverse", 0);
    expect(@{p}_track(@{ga}joints, &wrong, NULL) == @{P}_NONFINITE, "NONFINITE of track", 0);
    wrong = pose_from(@{p}_vector_far);
    pose = wrong;
#if @{P}_VECTOR_FAR > 0
    expect(@{p}_track(@{ga}joints, &wrong, &info) == @{P}_WRONG_BRANCH, "WRONG_BRANCH of a long step", 0);
    expect(same_pose(&pose, &wrong), "pose untouched by a long step", 0);
#else
    (void)@{p}_track(@{ga}joints, &pose, &info);
#endif
#if @{P}_VECTOR_SINGULAR > 0
    for (int k = 0; k < @{P}_VECTOR_SINGULAR; ++k) {
        wrong = pose_from(@{p}_vector_singular[k]);
        expect(refused(NULL, joints, &wrong, "singular start") == @{P}_SINGULAR, "SINGULAR", k);
    }
#endif
}

/* Poses that the mechanism cannot take, and joints beyond their limits. */
static void refuse_infeasible(void)
{
#if @{P}_VECTOR_INFEASIBLE > 0 || @{P}_VECTOR_PAST > 0
@{nominal}
#endif
#if @{P}_VECTOR_INFEASIBLE > 0
    for (int k = 0; k < @{P}_VECTOR_INFEASIBLE; ++k) {
        const @{p}_pose pose = pose_from(@{p}_vector_infeasible[k]);
        @{p}_real joints[@{P}_JOINTS];
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            joints[i] = @{four};
        }
        expect(@{p}_inverse(@{ga}&pose, joints) == @{P}_OUT_OF_RANGE, "a pose that cannot be taken", k);
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            expect(joints[i] == @{four}, "joints untouched on failure", k);
        }
    }
#endif
#if @{P}_VECTOR_PAST > 0
    for (int k = 0; k < @{P}_VECTOR_PAST; ++k) {
        const @{p}_pose home = pose_from(@{p}_vector_home);
        @{p}_pose pose = home;
        @{p}_info info;
        expect(refused(NULL, @{p}_vector_past[k], &home, "a joint beyond a limit") == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE of a limit", k);
        (void)@{p}_direct(@{ga}NULL, @{p}_vector_past[k], &home, &pose, &info);
        expect(info.joint == (unsigned int)@{p}_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
}

/* Rates of the twist of rates are these rates; the feed keeps the limits, and one joint reaches its own. */
static void speeds_of(const @{p}_pose *pose, int k)
{
@{nominal}
    @{p}_real rates[@{P}_JOINTS];
    @{p}_real again[@{P}_JOINTS];
    @{p}_real limits[@{P}_JOINTS];
    @{p}_real twist[6] = { @{zero} };
    @{p}_real feed = @{zero};
    double largest = 0.0;
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        rates[i] = (@{p}_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (@{speed_unit}));
    }
    expect(@{p}_twist(@{ga}pose, rates, twist) == @{P}_OK, "twist", k);
    expect(@{p}_rates(@{ga}pose, twist, again) == @{P}_OK, "rates", k);
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        expect(fabs((double)again[i] - (double)rates[i]) <= @{speed_bound} * (@{speed_unit}), "rates of the twist of rates", i);
        limits[i] = (@{p}_real)(0.125 * (@{speed_unit}));
    }
    expect(@{p}_feed(@{ga}pose, twist, limits, &feed) == @{P}_OK, "feed", k);
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        largest = fmax(largest, fabs((double)feed * (double)again[i]) / (@{speed_unit}));
    }
    expect(fabs(largest - 0.125) <= 1e-6, "feed reaches a limit", k);
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        limits[i] = (@{p}_real)(4.0 * (@{speed_unit}));
    }
    expect((@{p}_feed(@{ga}pose, twist, limits, &feed) == @{P}_OK) && (feed == @{one}), "no need for a feed", k);
    limits[0] = -@{one};
    expect(@{p}_feed(@{ga}pose, twist, limits, &feed) == @{P}_OUT_OF_RANGE, "a limit below 0", k);
    limits[0] = (@{p}_real)NAN;
    expect(@{p}_feed(@{ga}pose, twist, limits, &feed) == @{P}_NONFINITE, "a limit that is not a number", k);
    twist[5] = (@{p}_real)INFINITY;
    expect(@{p}_rates(@{ga}pose, twist, again) == @{P}_NONFINITE, "infinite twist", k);
    rates[0] = (@{p}_real)NAN;
    expect(@{p}_twist(@{ga}pose, rates, twist) == @{P}_NONFINITE, "NaN among rates", k);
    rates[0] = (@{p}_real)1e30;
    expect(@{p}_twist(@{ga}pose, rates, twist) == @{P}_OUT_OF_RANGE, "rates beyond all bounds", k);
}

int main(void)
{
    solve_all();
    for (int k = 0; k < @{P}_VECTOR_JACOBIANS; ++k) {
        const @{p}_pose pose = pose_from(@{p}_vector_poses[k]);
        speeds_of(&pose, k);
    }
    refuse_all();
    refuse_infeasible();
    (void)printf("@{p}: %d cases, %d failures\n", @{P}_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
