/* Test of yao2020.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "yao2020.h"
#include "yao2020_vectors.h"

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

static yao2020_pose pose_from(const yao2020_real numbers[7])
{
    yao2020_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* An inverse call that must not succeed: the status, with the joints untouched and info written. */
static yao2020_status refused(const yao2020_config *config, const yao2020_pose *pose,
    const yao2020_real guess[YAO2020_JOINTS], const char *what)
{
    yao2020_real joints[YAO2020_JOINTS];
    yao2020_info info;
    yao2020_status status;
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        joints[i] = 4.0f;
    }
    info.iterations = 255U;
    status = yao2020_inverse(config, pose, guess, joints, &info);
    expect(status != YAO2020_OK, what, 0);
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        expect(joints[i] == 4.0f, "result untouched on failure", i);
    }
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < YAO2020_VECTORS; ++k) {
        const double bound = yao2020_vector_bounds[k];
        yao2020_pose pose;
        yao2020_info info;
        yao2020_real joints[YAO2020_JOINTS];
        expect(yao2020_direct(yao2020_vector_joints[k], &pose) == YAO2020_OK, "direct", k);
        for (int i = 0; i < 3; ++i) {
            expect(fabs((double)pose.position[i] - (double)yao2020_vector_poses[k][i]) <= bound,
                "direct's position", k);
        }
        for (int i = 0; i < 4; ++i) {
            const double off = fabs((double)pose.quaternion[i] - (double)yao2020_vector_poses[k][3
                + i]);
            expect((double)YAO2020_SIZE * off <= bound, "direct's quaternion", k);
        }
        pose = pose_from(yao2020_vector_poses[k]);
        expect(yao2020_inverse(NULL, &pose, yao2020_vector_guesses[k], joints,
            &info) == YAO2020_OK, "inverse", k);
        expect((double)info.residual <= 16.0 * bound, "inverse's residual", k);
        for (int i = 0; i < YAO2020_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)yao2020_vector_inverse[k][i]) <= bound
                * (((i == 5)) ? 1.0 : 0.003603457374228511), "inverse's joints", k);
        }
        expect(yao2020_inverse(NULL, &pose, joints, joints, &info) == YAO2020_OK, "standing still",
            k);
        if (k < YAO2020_VECTOR_JACOBIANS) {
            yao2020_real jacobian[6 * YAO2020_JOINTS];
            expect(yao2020_jacobian(yao2020_vector_joints[k], jacobian) == YAO2020_OK, "jacobian",
                k);
            for (int i = 0; i < 6 * YAO2020_JOINTS; ++i) {
                const double wanted = (double)yao2020_vector_jacobians[k][i];
                const double scale = 555.0225220655465 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-4 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const yao2020_pose *pose, const yao2020_real guess[YAO2020_JOINTS])
{
    const yao2020_real wrong[4] = { 0.0f, -1.0f, (yao2020_real)NAN, (yao2020_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const yao2020_real other = wrong[i % 4];
        const yao2020_config config = { (i < 4) ? other : YAO2020_TOLERANCE, YAO2020_MAX_STEPS,
            (i < 4) ? YAO2020_MAX_STEP : other };
        const yao2020_status wanted = (i % 4 < 2) ? YAO2020_OUT_OF_RANGE : YAO2020_NONFINITE;
        expect(refused(&config, pose, guess, "wrong config") == wanted, "status of a wrong config",
            i);
    }
}

static void refuse_all(void)
{
    const yao2020_config none = { YAO2020_TOLERANCE, 0U, YAO2020_MAX_STEP };
    yao2020_pose pose = pose_from(yao2020_vector_poses[0]);
    yao2020_pose wrong = pose;
    yao2020_real joints[YAO2020_JOINTS];
    yao2020_real other[YAO2020_JOINTS];
    yao2020_info info;
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        joints[i] = yao2020_vector_guesses[0][i];
    }
    expect(refused(&none, &pose, joints, "no step is not enough") == YAO2020_MAX_ITERATIONS,
        "MAX_ITERATIONS", 0);
    refuse_configs(&pose, joints);
    joints[YAO2020_JOINTS - 1] = (yao2020_real)NAN;
    (void)yao2020_inverse(NULL, &pose, joints, other, &info);
    expect(info.joint == YAO2020_JOINTS - 1U, "joint of a NaN guess", 0);
    joints[YAO2020_JOINTS - 1] = yao2020_vector_guesses[0][YAO2020_JOINTS - 1];
    expect((yao2020_inverse(NULL, &pose, joints, other, &info) == YAO2020_OK)
        && (info.joint == YAO2020_JOINTS), "no joint to blame", 0);
    joints[0] = (yao2020_real)NAN;
    expect(refused(NULL, &pose, joints, "NaN guess") == YAO2020_NONFINITE, "NONFINITE", 0);
    expect(yao2020_direct(joints, &wrong) == YAO2020_NONFINITE, "NONFINITE of direct", 0);
    joints[0] = 5.550225e+06f;
    expect(yao2020_direct(joints, &wrong) == YAO2020_OUT_OF_RANGE, "OUT_OF_RANGE of direct", 0);
    joints[0] = yao2020_vector_guesses[0][0];
    wrong.position[2] = (yao2020_real)INFINITY;
    expect(refused(NULL, &wrong, joints, "infinite pose") == YAO2020_NONFINITE, "NONFINITE", 1);
    wrong = pose;
    wrong.quaternion[0] = 2.0f;
    expect(refused(NULL, &wrong, joints, "quaternion of length 2") == YAO2020_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    wrong = pose;
    wrong.position[0] = 5.550225e+06f;
    (void)refused(NULL, &wrong, joints, "pose out of reach");
#if YAO2020_VECTOR_PAST > 0
    for (int k = 0; k < YAO2020_VECTOR_PAST; ++k) {
        expect(yao2020_direct(yao2020_vector_past[k], &wrong) == YAO2020_OUT_OF_RANGE,
            "OUT_OF_RANGE of a limit", k);
        expect(refused(NULL, &pose, yao2020_vector_past[k],
            "a guess beyond a limit") == YAO2020_OUT_OF_RANGE, "guess beyond a limit", k);
        (void)yao2020_inverse(NULL, &pose, yao2020_vector_past[k], other, &info);
        expect(info.joint == (unsigned int)yao2020_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
#if YAO2020_VECTOR_SINGULAR > 0
    for (int k = 0; k < YAO2020_VECTOR_SINGULAR; ++k) {
        expect(refused(NULL, &pose, yao2020_vector_singular[k],
            "singular start") == YAO2020_SINGULAR, "SINGULAR", k);
    }
#endif
}


/* Whether two lists of joint values are the same within a bound (of angles times half of the size),
 * whole turns left aside. */
static int same_joints(const yao2020_real a[YAO2020_JOINTS], const yao2020_real b[YAO2020_JOINTS],
    double bound)
{
    static const int angular[YAO2020_JOINTS] = { 1, 1, 1, 1, 1, 0 };
    int same = 1;
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)YAO2020_SIZE * fabs(remainder(gap,
            6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name, the guess's is
 * the nearest. */
static void closed_form(void)
{
    for (int k = 0; k < YAO2020_VECTORS; ++k) {
        const double bound = yao2020_vector_bounds[k];
        const double most = 8.0 * bound;
        const yao2020_pose pose = pose_from(yao2020_vector_poses[k]);
        yao2020_real all[YAO2020_BRANCHES][YAO2020_JOINTS];
        yao2020_real one[YAO2020_JOINTS];
        const int count = yao2020_inverse_all(&pose, all);
        int found = 0;
        int named = 0;
        expect((count > 0) && (count <= YAO2020_BRANCHES), "count of all branches", k);
        for (int row = 0; row < count; ++row) {
            yao2020_pose again;
            expect(yao2020_direct(all[row], &again) == YAO2020_OK, "direct of a branch", k);
            for (int i = 0; i < 3; ++i) {
                expect(fabs((double)again.position[i] - (double)pose.position[i]) <= 0.017,
                    "a branch's position", k);
            }
            for (int i = 0; i < 4; ++i) {
                const double off = fabs(fabs((double)again.quaternion[i])
                    - fabs((double)pose.quaternion[i]));
                expect((double)YAO2020_SIZE * off <= 0.017, "a branch's quaternion", k);
            }
            found += same_joints(all[row], yao2020_vector_inverse[k], most);
        }
        expect(found == 1, "one branch is the arm", k);
        for (unsigned int branch = 0U; branch < YAO2020_BRANCHES; ++branch) {
            if (yao2020_inverse_branch(&pose, branch, one) == YAO2020_OK) {
                expect((named < count) && same_joints(one, all[named], most),
                    "a branch by its name", k);
                ++named;
            }
        }
        expect(named == count, "count of the branches by name", k);
        expect(yao2020_inverse_nearest(&pose, yao2020_vector_guesses[k], one) == YAO2020_OK,
            "nearest branch", k);
        for (int i = 0; i < YAO2020_JOINTS; ++i) {
            expect(fabs((double)one[i] - (double)yao2020_vector_inverse[k][i]) <= most
                * (((i == 5)) ? 1.0 : 0.003603457374228511), "nearest branch's joints", k);
        }
    }
}

/* What is no pose, no branch or out of reach is refused, results untouched. */
static void closed_refusals(void)
{
    const yao2020_pose pose = pose_from(yao2020_vector_poses[0]);
    yao2020_pose wrong = pose;
    yao2020_real all[YAO2020_BRANCHES][YAO2020_JOINTS];
    yao2020_real joints[YAO2020_JOINTS];
    yao2020_real guess[YAO2020_JOINTS];
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        joints[i] = 4.0f;
        guess[i] = yao2020_vector_guesses[0][i];
    }
    expect(yao2020_inverse_branch(&pose, YAO2020_BRANCHES, joints) == YAO2020_OUT_OF_RANGE,
        "no such branch", 0);
    guess[0] = (yao2020_real)NAN;
    expect(yao2020_inverse_nearest(&pose, guess, joints) == YAO2020_NONFINITE,
        "NaN guess of the closed form", 0);
    guess[0] = yao2020_vector_guesses[0][0];
    wrong.position[2] = (yao2020_real)INFINITY;
    expect(yao2020_inverse_nearest(&wrong, guess, joints) == YAO2020_NONFINITE,
        "infinite pose of the closed form", 0);
    expect(yao2020_inverse_branch(&wrong, 0U, joints) == YAO2020_NONFINITE,
        "infinite pose of the closed form", 1);
    expect(yao2020_inverse_all(&wrong, all) == 0, "infinite pose of the closed form", 2);
    wrong = pose;
    wrong.quaternion[1] = 2.0f;
    expect(yao2020_inverse_nearest(&wrong, guess, joints) == YAO2020_OUT_OF_RANGE,
        "quaternion of length 2 of the closed form", 0);
    wrong = pose;
    wrong.position[0] = 5.550225e+06f;
    wrong.position[1] = 5.550225e+06f;
    wrong.position[2] = 5.550225e+06f;
    (void)yao2020_inverse_nearest(&wrong, guess, joints);
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        expect(joints[i] == 4.0f, "result of the closed form untouched on failure", i);
    }
}
int main(void)
{
    solve_all();
    refuse_all();
    closed_form();
    closed_refusals();
    (void)printf("yao2020: %d cases, %d failures\n", YAO2020_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
