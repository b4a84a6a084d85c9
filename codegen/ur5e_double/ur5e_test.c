/* Test of ur5e.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "ur5e.h"
#include "ur5e_vectors.h"

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

static ur5e_pose pose_from(const ur5e_real numbers[7])
{
    ur5e_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* An inverse call that must not succeed: the status, with the joints untouched and info written. */
static ur5e_status refused(const ur5e_config *config, const ur5e_pose *pose,
    const ur5e_real guess[UR5E_JOINTS], const char *what)
{
    ur5e_real joints[UR5E_JOINTS];
    ur5e_info info;
    ur5e_status status;
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        joints[i] = 4.0;
    }
    info.iterations = 255U;
    status = ur5e_inverse(config, pose, guess, joints, &info);
    expect(status != UR5E_OK, what, 0);
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        expect(joints[i] == 4.0, "result untouched on failure", i);
    }
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < UR5E_VECTORS; ++k) {
        const double bound = ur5e_vector_bounds[k];
        ur5e_pose pose;
        ur5e_info info;
        ur5e_real joints[UR5E_JOINTS];
        expect(ur5e_direct(ur5e_vector_joints[k], &pose) == UR5E_OK, "direct", k);
        for (int i = 0; i < 3; ++i) {
            expect(fabs((double)pose.position[i] - (double)ur5e_vector_poses[k][i]) <= bound,
                "direct's position", k);
        }
        for (int i = 0; i < 4; ++i) {
            const double off = fabs((double)pose.quaternion[i] - (double)ur5e_vector_poses[k][3
                + i]);
            expect((double)UR5E_SIZE * off <= bound, "direct's quaternion", k);
        }
        pose = pose_from(ur5e_vector_poses[k]);
        expect(ur5e_inverse(NULL, &pose, ur5e_vector_guesses[k], joints, &info) == UR5E_OK,
            "inverse", k);
        expect((double)info.residual <= 16.0 * bound, "inverse's residual", k);
        for (int i = 0; i < UR5E_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)ur5e_vector_inverse[k][i]) <= bound
                * 0.0023702423295015184, "inverse's joints", k);
        }
        expect(ur5e_inverse(NULL, &pose, joints, joints, &info) == UR5E_OK, "standing still", k);
        if (k < UR5E_VECTOR_JACOBIANS) {
            ur5e_real jacobian[6 * UR5E_JOINTS];
            expect(ur5e_jacobian(ur5e_vector_joints[k], jacobian) == UR5E_OK, "jacobian", k);
            for (int i = 0; i < 6 * UR5E_JOINTS; ++i) {
                const double wanted = (double)ur5e_vector_jacobians[k][i];
                const double scale = 843.7955795096346 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-8 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const ur5e_pose *pose, const ur5e_real guess[UR5E_JOINTS])
{
    const ur5e_real wrong[4] = { 0.0, -1.0, (ur5e_real)NAN, (ur5e_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const ur5e_real other = wrong[i % 4];
        const ur5e_config config = { (i < 4) ? other : UR5E_TOLERANCE, UR5E_MAX_STEPS,
            (i < 4) ? UR5E_MAX_STEP : other };
        const ur5e_status wanted = (i % 4 < 2) ? UR5E_OUT_OF_RANGE : UR5E_NONFINITE;
        expect(refused(&config, pose, guess, "wrong config") == wanted, "status of a wrong config",
            i);
    }
}

static void refuse_all(void)
{
    const ur5e_config none = { UR5E_TOLERANCE, 0U, UR5E_MAX_STEP };
    ur5e_pose pose = pose_from(ur5e_vector_poses[0]);
    ur5e_pose wrong = pose;
    ur5e_real joints[UR5E_JOINTS];
    ur5e_real other[UR5E_JOINTS];
    ur5e_info info;
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        joints[i] = ur5e_vector_guesses[0][i];
    }
    expect(refused(&none, &pose, joints, "no step is not enough") == UR5E_MAX_ITERATIONS,
        "MAX_ITERATIONS", 0);
    refuse_configs(&pose, joints);
    joints[UR5E_JOINTS - 1] = (ur5e_real)NAN;
    (void)ur5e_inverse(NULL, &pose, joints, other, &info);
    expect(info.joint == UR5E_JOINTS - 1U, "joint of a NaN guess", 0);
    joints[UR5E_JOINTS - 1] = ur5e_vector_guesses[0][UR5E_JOINTS - 1];
    expect((ur5e_inverse(NULL, &pose, joints, other, &info) == UR5E_OK)
        && (info.joint == UR5E_JOINTS), "no joint to blame", 0);
    joints[0] = (ur5e_real)NAN;
    expect(refused(NULL, &pose, joints, "NaN guess") == UR5E_NONFINITE, "NONFINITE", 0);
    expect(ur5e_direct(joints, &wrong) == UR5E_NONFINITE, "NONFINITE of direct", 0);
    joints[0] = 8437955.795096347;
    expect(ur5e_direct(joints, &wrong) == UR5E_OUT_OF_RANGE, "OUT_OF_RANGE of direct", 0);
    joints[0] = ur5e_vector_guesses[0][0];
    wrong.position[2] = (ur5e_real)INFINITY;
    expect(refused(NULL, &wrong, joints, "infinite pose") == UR5E_NONFINITE, "NONFINITE", 1);
    wrong = pose;
    wrong.quaternion[0] = 2.0;
    expect(refused(NULL, &wrong, joints, "quaternion of length 2") == UR5E_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    wrong = pose;
    wrong.position[0] = 8437955.795096347;
    (void)refused(NULL, &wrong, joints, "pose out of reach");
#if UR5E_VECTOR_PAST > 0
    for (int k = 0; k < UR5E_VECTOR_PAST; ++k) {
        expect(ur5e_direct(ur5e_vector_past[k], &wrong) == UR5E_OUT_OF_RANGE,
            "OUT_OF_RANGE of a limit", k);
        expect(refused(NULL, &pose, ur5e_vector_past[k],
            "a guess beyond a limit") == UR5E_OUT_OF_RANGE, "guess beyond a limit", k);
        (void)ur5e_inverse(NULL, &pose, ur5e_vector_past[k], other, &info);
        expect(info.joint == (unsigned int)ur5e_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
#if UR5E_VECTOR_SINGULAR > 0
    for (int k = 0; k < UR5E_VECTOR_SINGULAR; ++k) {
        expect(refused(NULL, &pose, ur5e_vector_singular[k], "singular start") == UR5E_SINGULAR,
            "SINGULAR", k);
    }
#endif
}


/* Whether two lists of joint values are the same within a bound (of angles times half of the size),
 * whole turns left aside. */
static int same_joints(const ur5e_real a[UR5E_JOINTS], const ur5e_real b[UR5E_JOINTS], double bound)
{
    static const int angular[UR5E_JOINTS] = { 1, 1, 1, 1, 1, 1 };
    int same = 1;
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)UR5E_SIZE * fabs(remainder(gap,
            6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name, the guess's is
 * the nearest. */
static void closed_form(void)
{
    for (int k = 0; k < UR5E_VECTORS; ++k) {
        const double bound = ur5e_vector_bounds[k];
        const double most = 8.0 * bound;
        const ur5e_pose pose = pose_from(ur5e_vector_poses[k]);
        ur5e_real all[UR5E_BRANCHES][UR5E_JOINTS];
        ur5e_real one[UR5E_JOINTS];
        const int count = ur5e_inverse_all(&pose, all);
        int found = 0;
        int named = 0;
        expect((count > 0) && (count <= UR5E_BRANCHES), "count of all branches", k);
        for (int row = 0; row < count; ++row) {
            ur5e_pose again;
            expect(ur5e_direct(all[row], &again) == UR5E_OK, "direct of a branch", k);
            for (int i = 0; i < 3; ++i) {
                expect(fabs((double)again.position[i] - (double)pose.position[i]) <= 3.8e-09,
                    "a branch's position", k);
            }
            for (int i = 0; i < 4; ++i) {
                const double off = fabs(fabs((double)again.quaternion[i])
                    - fabs((double)pose.quaternion[i]));
                expect((double)UR5E_SIZE * off <= 3.8e-09, "a branch's quaternion", k);
            }
            found += same_joints(all[row], ur5e_vector_inverse[k], most);
        }
        expect(found == 1, "one branch is the arm", k);
        for (unsigned int branch = 0U; branch < UR5E_BRANCHES; ++branch) {
            if (ur5e_inverse_branch(&pose, branch, one) == UR5E_OK) {
                expect((named < count) && same_joints(one, all[named], most),
                    "a branch by its name", k);
                ++named;
            }
        }
        expect(named == count, "count of the branches by name", k);
        expect(ur5e_inverse_nearest(&pose, ur5e_vector_guesses[k], one) == UR5E_OK,
            "nearest branch", k);
        for (int i = 0; i < UR5E_JOINTS; ++i) {
            expect(fabs((double)one[i] - (double)ur5e_vector_inverse[k][i]) <= most
                * 0.0023702423295015184, "nearest branch's joints", k);
        }
    }
}

/* What is no pose, no branch or out of reach is refused, results untouched. */
static void closed_refusals(void)
{
    const ur5e_pose pose = pose_from(ur5e_vector_poses[0]);
    ur5e_pose wrong = pose;
    ur5e_real all[UR5E_BRANCHES][UR5E_JOINTS];
    ur5e_real joints[UR5E_JOINTS];
    ur5e_real guess[UR5E_JOINTS];
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        joints[i] = 4.0;
        guess[i] = ur5e_vector_guesses[0][i];
    }
    expect(ur5e_inverse_branch(&pose, UR5E_BRANCHES, joints) == UR5E_OUT_OF_RANGE,
        "no such branch", 0);
    guess[0] = (ur5e_real)NAN;
    expect(ur5e_inverse_nearest(&pose, guess, joints) == UR5E_NONFINITE,
        "NaN guess of the closed form", 0);
    guess[0] = ur5e_vector_guesses[0][0];
    wrong.position[2] = (ur5e_real)INFINITY;
    expect(ur5e_inverse_nearest(&wrong, guess, joints) == UR5E_NONFINITE,
        "infinite pose of the closed form", 0);
    expect(ur5e_inverse_branch(&wrong, 0U, joints) == UR5E_NONFINITE,
        "infinite pose of the closed form", 1);
    expect(ur5e_inverse_all(&wrong, all) == 0, "infinite pose of the closed form", 2);
    wrong = pose;
    wrong.quaternion[1] = 2.0;
    expect(ur5e_inverse_nearest(&wrong, guess, joints) == UR5E_OUT_OF_RANGE,
        "quaternion of length 2 of the closed form", 0);
    wrong = pose;
    wrong.position[0] = 8437955.795096347;
    wrong.position[1] = 8437955.795096347;
    wrong.position[2] = 8437955.795096347;
    (void)ur5e_inverse_nearest(&wrong, guess, joints);
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        expect(joints[i] == 4.0, "result of the closed form untouched on failure", i);
    }
}
int main(void)
{
    solve_all();
    refuse_all();
    closed_form();
    closed_refusals();
    (void)printf("ur5e: %d cases, %d failures\n", UR5E_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
