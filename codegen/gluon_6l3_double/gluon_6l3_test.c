/* Test of gluon_6l3.c against vectors from Python. Prints what failed; exit status 0 when nothing
 * did.
 * SPDX-License-Identifier: MIT */
#include "gluon_6l3.h"
#include "gluon_6l3_vectors.h"

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

static gluon_6l3_pose pose_from(const gluon_6l3_real numbers[7])
{
    gluon_6l3_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = numbers[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = numbers[3 + i];
    }
    return pose;
}

/* An inverse call that must not succeed: the status, with the joints untouched and info written. */
static gluon_6l3_status refused(const gluon_6l3_config *config, const gluon_6l3_pose *pose,
    const gluon_6l3_real guess[GLUON_6L3_JOINTS], const char *what)
{
    gluon_6l3_real joints[GLUON_6L3_JOINTS];
    gluon_6l3_info info;
    gluon_6l3_status status;
    for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
        joints[i] = 4.0;
    }
    info.iterations = 255U;
    status = gluon_6l3_inverse(config, pose, guess, joints, &info);
    expect(status != GLUON_6L3_OK, what, 0);
    for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
        expect(joints[i] == 4.0, "result untouched on failure", i);
    }
    expect(info.iterations != 255U, "info written on failure", 0);
    return status;
}

static void solve_all(void)
{
    for (int k = 0; k < GLUON_6L3_VECTORS; ++k) {
        const double bound = gluon_6l3_vector_bounds[k];
        gluon_6l3_pose pose;
        gluon_6l3_info info;
        gluon_6l3_real joints[GLUON_6L3_JOINTS];
        expect(gluon_6l3_direct(gluon_6l3_vector_joints[k], &pose) == GLUON_6L3_OK, "direct", k);
        for (int i = 0; i < 3; ++i) {
            expect(fabs((double)pose.position[i] - (double)gluon_6l3_vector_poses[k][i]) <= bound,
                "direct's position", k);
        }
        for (int i = 0; i < 4; ++i) {
            const double off = fabs((double)pose.quaternion[i]
                - (double)gluon_6l3_vector_poses[k][3 + i]);
            expect((double)GLUON_6L3_SIZE * off <= bound, "direct's quaternion", k);
        }
        pose = pose_from(gluon_6l3_vector_poses[k]);
        expect(gluon_6l3_inverse(NULL, &pose, gluon_6l3_vector_guesses[k], joints,
            &info) == GLUON_6L3_OK, "inverse", k);
        expect((double)info.residual <= 16.0 * bound, "inverse's residual", k);
        for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
            expect(fabs((double)joints[i] - (double)gluon_6l3_vector_inverse[k][i]) <= bound
                * 0.003708554213012941, "inverse's joints", k);
        }
        expect(gluon_6l3_inverse(NULL, &pose, joints, joints, &info) == GLUON_6L3_OK,
            "standing still", k);
        if (k < GLUON_6L3_VECTOR_JACOBIANS) {
            gluon_6l3_real jacobian[6 * GLUON_6L3_JOINTS];
            expect(gluon_6l3_jacobian(gluon_6l3_vector_joints[k], jacobian) == GLUON_6L3_OK,
                "jacobian", k);
            for (int i = 0; i < 6 * GLUON_6L3_JOINTS; ++i) {
                const double wanted = (double)gluon_6l3_vector_jacobians[k][i];
                const double scale = 539.2937207125631 * (1.0 + fabs(wanted));
                expect(fabs((double)jacobian[i] - wanted) <= 1e-8 * scale, "jacobian's entry", i);
            }
        }
    }
}

static void refuse_configs(const gluon_6l3_pose *pose, const gluon_6l3_real guess[GLUON_6L3_JOINTS])
{
    const gluon_6l3_real wrong[4] = { 0.0, -1.0, (gluon_6l3_real)NAN, (gluon_6l3_real)INFINITY };
    for (int i = 0; i < 8; ++i) {
        const gluon_6l3_real other = wrong[i % 4];
        const gluon_6l3_config config = { (i < 4) ? other : GLUON_6L3_TOLERANCE,
            GLUON_6L3_MAX_STEPS, (i < 4) ? GLUON_6L3_MAX_STEP : other };
        const gluon_6l3_status wanted = (i % 4 < 2) ? GLUON_6L3_OUT_OF_RANGE : GLUON_6L3_NONFINITE;
        expect(refused(&config, pose, guess, "wrong config") == wanted, "status of a wrong config",
            i);
    }
}

static void refuse_all(void)
{
    const gluon_6l3_config none = { GLUON_6L3_TOLERANCE, 0U, GLUON_6L3_MAX_STEP };
    gluon_6l3_pose pose = pose_from(gluon_6l3_vector_poses[0]);
    gluon_6l3_pose wrong = pose;
    gluon_6l3_real joints[GLUON_6L3_JOINTS];
    gluon_6l3_real other[GLUON_6L3_JOINTS];
    gluon_6l3_info info;
    for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
        joints[i] = gluon_6l3_vector_guesses[0][i];
    }
    expect(refused(&none, &pose, joints, "no step is not enough") == GLUON_6L3_MAX_ITERATIONS,
        "MAX_ITERATIONS", 0);
    refuse_configs(&pose, joints);
    joints[GLUON_6L3_JOINTS - 1] = (gluon_6l3_real)NAN;
    (void)gluon_6l3_inverse(NULL, &pose, joints, other, &info);
    expect(info.joint == GLUON_6L3_JOINTS - 1U, "joint of a NaN guess", 0);
    joints[GLUON_6L3_JOINTS - 1] = gluon_6l3_vector_guesses[0][GLUON_6L3_JOINTS - 1];
    expect((gluon_6l3_inverse(NULL, &pose, joints, other, &info) == GLUON_6L3_OK)
        && (info.joint == GLUON_6L3_JOINTS), "no joint to blame", 0);
    joints[0] = (gluon_6l3_real)NAN;
    expect(refused(NULL, &pose, joints, "NaN guess") == GLUON_6L3_NONFINITE, "NONFINITE", 0);
    expect(gluon_6l3_direct(joints, &wrong) == GLUON_6L3_NONFINITE, "NONFINITE of direct", 0);
    joints[0] = 5392937.207125631;
    expect(gluon_6l3_direct(joints, &wrong) == GLUON_6L3_OUT_OF_RANGE, "OUT_OF_RANGE of direct", 0);
    joints[0] = gluon_6l3_vector_guesses[0][0];
    wrong.position[2] = (gluon_6l3_real)INFINITY;
    expect(refused(NULL, &wrong, joints, "infinite pose") == GLUON_6L3_NONFINITE, "NONFINITE", 1);
    wrong = pose;
    wrong.quaternion[0] = 2.0;
    expect(refused(NULL, &wrong, joints, "quaternion of length 2") == GLUON_6L3_OUT_OF_RANGE,
        "OUT_OF_RANGE", 0);
    wrong = pose;
    wrong.position[0] = 5392937.207125631;
    (void)refused(NULL, &wrong, joints, "pose out of reach");
#if GLUON_6L3_VECTOR_PAST > 0
    for (int k = 0; k < GLUON_6L3_VECTOR_PAST; ++k) {
        expect(gluon_6l3_direct(gluon_6l3_vector_past[k], &wrong) == GLUON_6L3_OUT_OF_RANGE,
            "OUT_OF_RANGE of a limit", k);
        expect(refused(NULL, &pose, gluon_6l3_vector_past[k],
            "a guess beyond a limit") == GLUON_6L3_OUT_OF_RANGE, "guess beyond a limit", k);
        (void)gluon_6l3_inverse(NULL, &pose, gluon_6l3_vector_past[k], other, &info);
        expect(info.joint == (unsigned int)gluon_6l3_vector_blamed[k], "joint beyond a limit", k);
    }
#endif
#if GLUON_6L3_VECTOR_SINGULAR > 0
    for (int k = 0; k < GLUON_6L3_VECTOR_SINGULAR; ++k) {
        expect(refused(NULL, &pose, gluon_6l3_vector_singular[k],
            "singular start") == GLUON_6L3_SINGULAR, "SINGULAR", k);
    }
#endif
}


/* Whether two lists of joint values are the same within a bound (of angles times half of the size),
 * whole turns left aside. */
static int same_joints(const gluon_6l3_real a[GLUON_6L3_JOINTS],
    const gluon_6l3_real b[GLUON_6L3_JOINTS], double bound)
{
    static const int angular[GLUON_6L3_JOINTS] = { 1, 1, 1, 1, 1, 1 };
    int same = 1;
    for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)GLUON_6L3_SIZE * fabs(remainder(gap,
            6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name, the guess's is
 * the nearest. */
static void closed_form(void)
{
    for (int k = 0; k < GLUON_6L3_VECTORS; ++k) {
        const double bound = gluon_6l3_vector_bounds[k];
        const double most = 8.0 * bound;
        const gluon_6l3_pose pose = pose_from(gluon_6l3_vector_poses[k]);
        gluon_6l3_real all[GLUON_6L3_BRANCHES][GLUON_6L3_JOINTS];
        gluon_6l3_real one[GLUON_6L3_JOINTS];
        const int count = gluon_6l3_inverse_all(&pose, all);
        int found = 0;
        int named = 0;
        expect((count > 0) && (count <= GLUON_6L3_BRANCHES), "count of all branches", k);
        for (int row = 0; row < count; ++row) {
            gluon_6l3_pose again;
            expect(gluon_6l3_direct(all[row], &again) == GLUON_6L3_OK, "direct of a branch", k);
            for (int i = 0; i < 3; ++i) {
                expect(fabs((double)again.position[i] - (double)pose.position[i]) <= 2.4e-09,
                    "a branch's position", k);
            }
            for (int i = 0; i < 4; ++i) {
                const double off = fabs(fabs((double)again.quaternion[i])
                    - fabs((double)pose.quaternion[i]));
                expect((double)GLUON_6L3_SIZE * off <= 2.4e-09, "a branch's quaternion", k);
            }
            found += same_joints(all[row], gluon_6l3_vector_inverse[k], most);
        }
        expect(found == 1, "one branch is the arm", k);
        for (unsigned int branch = 0U; branch < GLUON_6L3_BRANCHES; ++branch) {
            if (gluon_6l3_inverse_branch(&pose, branch, one) == GLUON_6L3_OK) {
                expect((named < count) && same_joints(one, all[named], most),
                    "a branch by its name", k);
                ++named;
            }
        }
        expect(named == count, "count of the branches by name", k);
        expect(gluon_6l3_inverse_nearest(&pose, gluon_6l3_vector_guesses[k], one) == GLUON_6L3_OK,
            "nearest branch", k);
        for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
            expect(fabs((double)one[i] - (double)gluon_6l3_vector_inverse[k][i]) <= most
                * 0.003708554213012941, "nearest branch's joints", k);
        }
    }
}

/* What is no pose, no branch or out of reach is refused, results untouched. */
static void closed_refusals(void)
{
    const gluon_6l3_pose pose = pose_from(gluon_6l3_vector_poses[0]);
    gluon_6l3_pose wrong = pose;
    gluon_6l3_real all[GLUON_6L3_BRANCHES][GLUON_6L3_JOINTS];
    gluon_6l3_real joints[GLUON_6L3_JOINTS];
    gluon_6l3_real guess[GLUON_6L3_JOINTS];
    for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
        joints[i] = 4.0;
        guess[i] = gluon_6l3_vector_guesses[0][i];
    }
    expect(gluon_6l3_inverse_branch(&pose, GLUON_6L3_BRANCHES, joints) == GLUON_6L3_OUT_OF_RANGE,
        "no such branch", 0);
    guess[0] = (gluon_6l3_real)NAN;
    expect(gluon_6l3_inverse_nearest(&pose, guess, joints) == GLUON_6L3_NONFINITE,
        "NaN guess of the closed form", 0);
    guess[0] = gluon_6l3_vector_guesses[0][0];
    wrong.position[2] = (gluon_6l3_real)INFINITY;
    expect(gluon_6l3_inverse_nearest(&wrong, guess, joints) == GLUON_6L3_NONFINITE,
        "infinite pose of the closed form", 0);
    expect(gluon_6l3_inverse_branch(&wrong, 0U, joints) == GLUON_6L3_NONFINITE,
        "infinite pose of the closed form", 1);
    expect(gluon_6l3_inverse_all(&wrong, all) == 0, "infinite pose of the closed form", 2);
    wrong = pose;
    wrong.quaternion[1] = 2.0;
    expect(gluon_6l3_inverse_nearest(&wrong, guess, joints) == GLUON_6L3_OUT_OF_RANGE,
        "quaternion of length 2 of the closed form", 0);
    wrong = pose;
    wrong.position[0] = 5392937.207125631;
    wrong.position[1] = 5392937.207125631;
    wrong.position[2] = 5392937.207125631;
    (void)gluon_6l3_inverse_nearest(&wrong, guess, joints);
    for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
        expect(joints[i] == 4.0, "result of the closed form untouched on failure", i);
    }
}
int main(void)
{
    solve_all();
    refuse_all();
    closed_form();
    closed_refusals();
    (void)printf("gluon_6l3: %d cases, %d failures\n", GLUON_6L3_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
