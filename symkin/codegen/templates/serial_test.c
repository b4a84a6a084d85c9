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

/* An inverse call that must not succeed: the status, with the joints untouched and info written. */
static @{p}_status refused(const @{p}_config *config, const @{p}_pose *pose, const @{p}_real guess[@{P}_JOINTS], const char *what)
{
@{nominal}
    @{p}_real joints[@{P}_JOINTS];
    @{p}_info info;
    @{p}_status status;
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = @{four};
    }
    info.iterations = 255U;
    status = @{p}_inverse(@{ga}config, pose, guess, joints, &info);
    expect(status != @{P}_OK, what, 0);
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        expect(joints[i] == @{four}, "result untouched on failure", i);
    }
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
@{nominal}
    for (int k = 0; k < @{P}_VECTORS; ++k) {
        const double bound = @{p}_vector_bounds[k];
        @{p}_pose pose;
        @{p}_info info;
        @{p}_real joints[@{P}_JOINTS];
        expect(@{p}_direct(@{ga}@{p}_vector_joints[k], &pose) == @{P}_OK, "direct", k);
        for (int i = 0; i < 3; ++i) {
            expect(fabs((double)pose.position[i] - (double)@{p}_vector_poses[k][i]) <= bound, "direct's position", k);
        }
        for (int i = 0; i < 4; ++i) {
            const double off = fabs((double)pose.quaternion[i] - (double)@{p}_vector_poses[k][3 + i]);
            expect((double)@{P}_SIZE * off <= bound, "direct's quaternion", k);
        }
        pose = pose_from(@{p}_vector_poses[k]);
        expect(@{p}_inverse(@{ga}NULL, &pose, @{p}_vector_guesses[k], joints, &info) == @{P}_OK, "inverse", k);
        expect((double)info.residual <= 16.0 * bound, "inverse's residual", k);
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)@{p}_vector_inverse[k][i]) <= @{joint_bound}, "inverse's joints", k);
        }
@{again}
        expect(@{p}_inverse(@{ga}NULL, &pose, joints, joints, &info) == @{P}_OK, "standing still", k);
        if (k < @{P}_VECTOR_JACOBIANS) {
            @{p}_real jacobian[6 * @{P}_JOINTS];
            expect(@{p}_jacobian(@{ga}@{p}_vector_joints[k], jacobian) == @{P}_OK, "jacobian", k);
            for (int i = 0; i < 6 * @{P}_JOINTS; ++i) {
                const double wanted = (double)@{p}_vector_jacobians[k][i];
                const double scale = @{jacobian_unit} * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= @{jacobian_bound} * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const @{p}_pose *pose, const @{p}_real guess[@{P}_JOINTS])
{
    const @{p}_real wrong[4] = { @{zero}, -@{one}, (@{p}_real)NAN, (@{p}_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const @{p}_real other = wrong[i % 4];
        const @{p}_config config = { (i < 4) ? other : @{P}_TOLERANCE, @{P}_MAX_STEPS, (i < 4) ? @{P}_MAX_STEP : other };
        const @{p}_status wanted = (i % 4 < 2) ? @{P}_OUT_OF_RANGE : @{P}_NONFINITE;
        expect(refused(&config, pose, guess, "wrong config") == wanted, "status of a wrong config", i);
    }
}

static void refuse_all(void)
{
@{nominal}
    const @{p}_config none = { @{P}_TOLERANCE, 0U, @{P}_MAX_STEP };
    @{p}_pose pose = pose_from(@{p}_vector_poses[0]);
    @{p}_pose wrong = pose;
    @{p}_real joints[@{P}_JOINTS];
    @{p}_real other[@{P}_JOINTS];
    @{p}_info info;
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = @{p}_vector_guesses[0][i];
    }
    expect(refused(&none, &pose, joints, "no step is not enough") == @{P}_MAX_ITERATIONS, "MAX_ITERATIONS", 0);
    refuse_configs(&pose, joints);
    joints[@{P}_JOINTS - 1] = (@{p}_real)NAN;
    (void)@{p}_inverse(@{ga}NULL, &pose, joints, other, &info);
    expect(info.joint == @{P}_JOINTS - 1U, "joint of a NaN guess", 0);
    joints[@{P}_JOINTS - 1] = @{p}_vector_guesses[0][@{P}_JOINTS - 1];
    expect((@{p}_inverse(@{ga}NULL, &pose, joints, other, &info) == @{P}_OK) && (info.joint == @{P}_JOINTS), "no joint to blame", 0);
    joints[0] = (@{p}_real)NAN;
    expect(refused(NULL, &pose, joints, "NaN guess") == @{P}_NONFINITE, "NONFINITE", 0);
    expect(@{p}_direct(@{ga}joints, &wrong) == @{P}_NONFINITE, "NONFINITE of direct", 0);
    joints[0] = @{far};
    expect(@{p}_direct(@{ga}joints, &wrong) == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE of direct", 0);
    joints[0] = @{p}_vector_guesses[0][0];
    wrong.position[2] = (@{p}_real)INFINITY;
    expect(refused(NULL, &wrong, joints, "infinite pose") == @{P}_NONFINITE, "NONFINITE", 1);
    wrong = pose;
    wrong.quaternion[0] = @{two};
    expect(refused(NULL, &wrong, joints, "quaternion of length 2") == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE", 0);
    wrong = pose;
    wrong.position[0] = @{far};
    (void)refused(NULL, &wrong, joints, "pose out of reach");
#if @{P}_VECTOR_PAST > 0
    for (int k = 0; k < @{P}_VECTOR_PAST; ++k) {
        expect(@{p}_direct(@{ga}@{p}_vector_past[k], &wrong) == @{P}_OUT_OF_RANGE, "OUT_OF_RANGE of a limit", k);
@{guess_past}
    }
#endif
#if @{P}_VECTOR_SINGULAR > 0
    for (int k = 0; k < @{P}_VECTOR_SINGULAR; ++k) {
        expect(refused(NULL, &pose, @{p}_vector_singular[k], "singular start") == @{P}_SINGULAR, "SINGULAR", k);
    }
#endif
}

@{closed_test}
int main(void)
{
    solve_all();
    refuse_all();
@{closed_call}
    (void)printf("@{p}: %d cases, %d failures\n", @{P}_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
