/* Test of scara.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "scara.h"
#include "scara_vectors.h"

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

static scara_pose pose_from(const scara_real numbers[7])
{
    scara_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* An inverse call that must not succeed: the status, with the joints untouched and info written. */
static scara_status refused(const scara_config *config, const scara_pose *pose,
    const scara_real guess[SCARA_JOINTS], const char *what)
{
    scara_real joints[SCARA_JOINTS];
    scara_info info;
    scara_status status;
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        joints[i] = 4.0;
    }
    info.iterations = 255U;
    status = scara_inverse(config, pose, guess, joints, &info);
    expect(status != SCARA_OK, what, 0);
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        expect(joints[i] == 4.0, "result untouched on failure", i);
    }
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < SCARA_VECTORS; ++k) {
        const double bound = scara_vector_bounds[k];
        scara_pose pose;
        scara_info info;
        scara_real joints[SCARA_JOINTS];
        expect(scara_direct(scara_vector_joints[k], &pose) == SCARA_OK, "direct", k);
        for (int i = 0; i < 3; ++i) {
            expect(fabs((double)pose.position[i] - (double)scara_vector_poses[k][i]) <= bound,
                "direct's position", k);
        }
        for (int i = 0; i < 4; ++i) {
            const double off = fabs((double)pose.quaternion[i] - (double)scara_vector_poses[k][3
                + i]);
            expect((double)SCARA_SIZE * off <= bound, "direct's quaternion", k);
        }
        pose = pose_from(scara_vector_poses[k]);
        expect(scara_inverse(NULL, &pose, scara_vector_guesses[k], joints, &info) == SCARA_OK,
            "inverse", k);
        expect((double)info.residual <= 16.0 * bound, "inverse's residual", k);
        for (int i = 0; i < SCARA_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)scara_vector_inverse[k][i]) <= bound * 1.0,
                "inverse's joints", k);
        }
        expect(scara_inverse(NULL, &pose, joints, joints, &info) == SCARA_OK, "standing still", k);
        if (k < SCARA_VECTOR_JACOBIANS) {
            scara_real jacobian[6 * SCARA_JOINTS];
            expect(scara_jacobian(scara_vector_joints[k], jacobian) == SCARA_OK, "jacobian", k);
            for (int i = 0; i < 6 * SCARA_JOINTS; ++i) {
                const double wanted = (double)scara_vector_jacobians[k][i];
                const double scale = fmax((double)SCARA_SIZE, 1.0) * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-8 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const scara_pose *pose, const scara_real guess[SCARA_JOINTS])
{
    const scara_real wrong[4] = { 0.0, -1.0, (scara_real)NAN, (scara_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const scara_real other = wrong[i % 4];
        const scara_config config = { (i < 4) ? other : SCARA_TOLERANCE, SCARA_MAX_STEPS,
            (i < 4) ? SCARA_MAX_STEP : other };
        const scara_status wanted = (i % 4 < 2) ? SCARA_OUT_OF_RANGE : SCARA_NONFINITE;
        expect(refused(&config, pose, guess, "wrong config") == wanted, "status of a wrong config",
            i);
    }
}

static void refuse_all(void)
{
    const scara_config none = { SCARA_TOLERANCE, 0U, SCARA_MAX_STEP };
    scara_pose pose = pose_from(scara_vector_poses[0]);
    scara_pose wrong = pose;
    scara_real joints[SCARA_JOINTS];
    scara_real other[SCARA_JOINTS];
    scara_info info;
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        joints[i] = scara_vector_guesses[0][i];
    }
    expect(refused(&none, &pose, joints, "no step is not enough") == SCARA_MAX_ITERATIONS,
        "MAX_ITERATIONS", 0);
    refuse_configs(&pose, joints);
    joints[SCARA_JOINTS - 1] = (scara_real)NAN;
    (void)scara_inverse(NULL, &pose, joints, other, &info);
    expect(info.joint == SCARA_JOINTS - 1U, "joint of a NaN guess", 0);
    joints[SCARA_JOINTS - 1] = scara_vector_guesses[0][SCARA_JOINTS - 1];
    expect((scara_inverse(NULL, &pose, joints, other, &info) == SCARA_OK)
        && (info.joint == SCARA_JOINTS), "no joint to blame", 0);
    joints[0] = (scara_real)NAN;
    expect(refused(NULL, &pose, joints, "NaN guess") == SCARA_NONFINITE, "NONFINITE", 0);
    expect(scara_direct(joints, &wrong) == SCARA_NONFINITE, "NONFINITE of direct", 0);
    joints[0] = 4000000.0;
    expect(scara_direct(joints, &wrong) == SCARA_OUT_OF_RANGE, "OUT_OF_RANGE of direct", 0);
    joints[0] = scara_vector_guesses[0][0];
    wrong.position[2] = (scara_real)INFINITY;
    expect(refused(NULL, &wrong, joints, "infinite pose") == SCARA_NONFINITE, "NONFINITE", 1);
    wrong = pose;
    wrong.quaternion[0] = 2.0;
    expect(refused(NULL, &wrong, joints, "quaternion of length 2") == SCARA_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    wrong = pose;
    wrong.position[0] = 4000000.0;
    (void)refused(NULL, &wrong, joints, "pose out of reach");
#if SCARA_VECTOR_PAST > 0
    for (int k = 0; k < SCARA_VECTOR_PAST; ++k) {
        expect(scara_direct(scara_vector_past[k], &wrong) == SCARA_OUT_OF_RANGE,
            "OUT_OF_RANGE of a limit", k);
        expect(refused(NULL, &pose, scara_vector_past[k],
            "a guess beyond a limit") == SCARA_OUT_OF_RANGE, "guess beyond a limit", k);
        (void)scara_inverse(NULL, &pose, scara_vector_past[k], other, &info);
        expect(info.joint == (unsigned int)scara_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
#if SCARA_VECTOR_SINGULAR > 0
    for (int k = 0; k < SCARA_VECTOR_SINGULAR; ++k) {
        expect(refused(NULL, &pose, scara_vector_singular[k], "singular start") == SCARA_SINGULAR,
            "SINGULAR", k);
    }
#endif
}


/* Whether two lists of joint values are the same within a bound, whole turns left aside. */
static int same_joints(const scara_real a[SCARA_JOINTS], const scara_real b[SCARA_JOINTS],
    double bound)
{
    static const int angular[SCARA_JOINTS] = { 1, 1, 1, 0 };
    int same = 1;
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? fabs(remainder(gap, 6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name, the guess's is
 * the nearest. */
static void closed_form(void)
{
    for (int k = 0; k < SCARA_VECTORS; ++k) {
        const double bound = scara_vector_bounds[k];
        const double most = 8.0 * bound * 1.0;
        const scara_pose pose = pose_from(scara_vector_poses[k]);
        scara_real all[SCARA_BRANCHES][SCARA_JOINTS];
        scara_real one[SCARA_JOINTS];
        const int count = scara_inverse_all(&pose, all);
        int found = 0;
        int named = 0;
        expect((count > 0) && (count <= SCARA_BRANCHES), "count of all branches", k);
        for (int row = 0; row < count; ++row) {
            scara_pose again;
            expect(scara_direct(all[row], &again) == SCARA_OK, "direct of a branch", k);
            for (int i = 0; i < 3; ++i) {
                expect(fabs((double)again.position[i] - (double)pose.position[i]) <= 1.8e-09,
                    "a branch's position", k);
            }
            for (int i = 0; i < 4; ++i) {
                const double off = fabs(fabs((double)again.quaternion[i])
                    - fabs((double)pose.quaternion[i]));
                expect((double)SCARA_SIZE * off <= 1.8e-09, "a branch's quaternion", k);
            }
            found += same_joints(all[row], scara_vector_inverse[k], most);
        }
        expect(found == 1, "one branch is the arm", k);
        for (unsigned int branch = 0U; branch < SCARA_BRANCHES; ++branch) {
            if (scara_inverse_branch(&pose, branch, one) == SCARA_OK) {
                expect((named < count) && same_joints(one, all[named], most),
                    "a branch by its name", k);
                ++named;
            }
        }
        expect(named == count, "count of the branches by name", k);
        expect(scara_inverse_nearest(&pose, scara_vector_guesses[k], one) == SCARA_OK,
            "nearest branch", k);
        for (int i = 0; i < SCARA_JOINTS; ++i) {
            expect(fabs((double)one[i] - (double)scara_vector_inverse[k][i]) <= most,
                "nearest branch's joints", k);
        }
    }
}

/* What is no pose, no branch or out of reach is refused, results untouched. */
static void closed_refusals(void)
{
    const scara_pose pose = pose_from(scara_vector_poses[0]);
    scara_pose wrong = pose;
    scara_real all[SCARA_BRANCHES][SCARA_JOINTS];
    scara_real joints[SCARA_JOINTS];
    scara_real guess[SCARA_JOINTS];
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        joints[i] = 4.0;
        guess[i] = scara_vector_guesses[0][i];
    }
    expect(scara_inverse_branch(&pose, SCARA_BRANCHES, joints) == SCARA_OUT_OF_RANGE,
        "no such branch", 0);
    guess[0] = (scara_real)NAN;
    expect(scara_inverse_nearest(&pose, guess, joints) == SCARA_NONFINITE,
        "NaN guess of the closed form", 0);
    guess[0] = scara_vector_guesses[0][0];
    wrong.position[2] = (scara_real)INFINITY;
    expect(scara_inverse_nearest(&wrong, guess, joints) == SCARA_NONFINITE,
        "infinite pose of the closed form", 0);
    expect(scara_inverse_branch(&wrong, 0U, joints) == SCARA_NONFINITE,
        "infinite pose of the closed form", 1);
    expect(scara_inverse_all(&wrong, all) == 0, "infinite pose of the closed form", 2);
    wrong = pose;
    wrong.quaternion[1] = 2.0;
    expect(scara_inverse_nearest(&wrong, guess, joints) == SCARA_OUT_OF_RANGE,
        "quaternion of length 2 of the closed form", 0);
    wrong = pose;
    wrong.position[0] = 4000000.0;
    wrong.position[1] = 4000000.0;
    wrong.position[2] = 4000000.0;
    (void)scara_inverse_nearest(&wrong, guess, joints);
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        expect(joints[i] == 4.0, "result of the closed form untouched on failure", i);
    }
}
int main(void)
{
    solve_all();
    refuse_all();
    closed_form();
    closed_refusals();
    (void)printf("scara: %d cases, %d failures\n", SCARA_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
