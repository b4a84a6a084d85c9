/* A control loop with ur5e: joint values of poses, cycle after cycle, and what to do when there are
 * none.
 * SPDX-License-Identifier: MIT */
#include "ur5e.h"
#include "ur5e_vectors.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    ur5e_real joints[UR5E_JOINTS]; /* the last ones that were answered */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without one: the arm must not move */
} loop_state;

/* One cycle: the joint values of the pose that is wanted, from the last ones. */
static void cycle(loop_state *state, const ur5e_pose *pose)
{
    ur5e_info info;
    ur5e_real joints[UR5E_JOINTS];
    bool known = false;
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        joints[i] = state->joints[i];
    }
    if ((ur5e_track(pose, joints, &info) == UR5E_OK) && (info.residual <= UR5E_TRACK_LIMIT)) {
        ++state->tracked;
        known = true;
    } else if (ur5e_inverse(NULL, pose, state->joints, joints, &info) == UR5E_OK) {
        /* too long a step, as after a gap between poses */
        ++state->recovered;
        known = true;
    } else {
        /* joint info.joint is to blame, if it is below UR5E_JOINTS; the joint values stay the last
         * good ones */
        ++state->held;
    }
    for (int i = 0; known && (i < UR5E_JOINTS); ++i) {
        state->joints[i] = joints[i];
    }
}

int main(void)
{
    loop_state state = { { 0.0f }, 0, 0, 0 };
    ur5e_pose from;
    ur5e_pose to;
    for (int i = 0; i < UR5E_JOINTS; ++i) {
        state.joints[i] = ur5e_vector_guesses[0][i];
    }
    if ((ur5e_direct(state.joints, &from) != UR5E_OK)
        || (ur5e_direct(ur5e_vector_joints[0], &to) != UR5E_OK)) {
        (void)fprintf(stderr, "no pose to begin with; the arm must not move\n");
        return 1;
    }
    /* the tool moves in a straight line; poses 40 to 69 are lost, pose 80 is not a number */
    for (int k = 1; k <= CYCLES; ++k) {
        const double part = (double)k / CYCLES;
        double cosine = 0.0;
        double squared = 0.0;
        ur5e_pose pose;
        for (int i = 0; i < 4; ++i) {
            cosine += (double)from.quaternion[i] * (double)to.quaternion[i];
        }
        for (int i = 0; i < 4; ++i) {
            const double other = (cosine < 0.0) ? -(double)to.quaternion[i]
                : (double)to.quaternion[i];
            const double q = (1.0 - part) * (double)from.quaternion[i] + part * other;
            pose.quaternion[i] = (ur5e_real)q;
            squared += q * q;
        }
        for (int i = 0; i < 4; ++i) {
            pose.quaternion[i] = (ur5e_real)((double)pose.quaternion[i] / sqrt(squared));
        }
        for (int i = 0; i < 3; ++i) {
            pose.position[i] = (ur5e_real)((1.0 - part) * (double)from.position[i]
                + part * (double)to.position[i]);
        }
        if (k == 80) {
            pose.position[0] = (ur5e_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, &pose);
        }
    }
    (void)printf("first joint %.6f: %d tracked, %d recovered, %d held\n", (double)state.joints[0],
        state.tracked,
        state.recovered, state.held);
    return 0;
}
