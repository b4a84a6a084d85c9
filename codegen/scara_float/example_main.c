/* A control loop with scara: joint values of poses, cycle after cycle, and what to do when there
 * are none.
 * SPDX-License-Identifier: MIT */
#include "scara.h"
#include "scara_vectors.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    scara_real joints[SCARA_JOINTS]; /* the last ones that were answered */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without one: the arm must not move */
} loop_state;

/* One cycle: the joint values of the pose that is wanted, from the last ones. */
static void cycle(loop_state *state, const scara_pose *pose)
{
    scara_info info;
    scara_real joints[SCARA_JOINTS];
    bool known = false;
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        joints[i] = state->joints[i];
    }
    if ((scara_track(pose, joints, &info) == SCARA_OK) && (info.residual <= SCARA_TRACK_LIMIT)) {
        ++state->tracked;
        known = true;
    } else if (scara_inverse(NULL, pose, state->joints, joints, &info) == SCARA_OK) {
        /* too long a step, as after a gap between poses */
        ++state->recovered;
        known = true;
    } else {
        /* joint info.joint is to blame, if it is below SCARA_JOINTS; the joint values stay the last
         * good ones */
        ++state->held;
    }
    for (int i = 0; known && (i < SCARA_JOINTS); ++i) {
        state->joints[i] = joints[i];
    }
}

int main(void)
{
    loop_state state = { { 0.0f }, 0, 0, 0 };
    scara_pose from;
    scara_pose to;
    for (int i = 0; i < SCARA_JOINTS; ++i) {
        state.joints[i] = scara_vector_guesses[0][i];
    }
    if ((scara_direct(state.joints, &from) != SCARA_OK)
        || (scara_direct(scara_vector_joints[0], &to) != SCARA_OK)) {
        (void)fprintf(stderr, "no pose to begin with; the arm must not move\n");
        return 1;
    }
    /* the tool moves in a straight line; poses 40 to 69 are lost, pose 80 is not a number */
    for (int k = 1; k <= CYCLES; ++k) {
        const double part = (double)k / CYCLES;
        double cosine = 0.0;
        double squared = 0.0;
        scara_pose pose;
        for (int i = 0; i < 4; ++i) {
            cosine += (double)from.quaternion[i] * (double)to.quaternion[i];
        }
        for (int i = 0; i < 4; ++i) {
            const double other = (cosine < 0.0) ? -(double)to.quaternion[i]
                : (double)to.quaternion[i];
            const double q = (1.0 - part) * (double)from.quaternion[i] + part * other;
            pose.quaternion[i] = (scara_real)q;
            squared += q * q;
        }
        for (int i = 0; i < 4; ++i) {
            pose.quaternion[i] = (scara_real)((double)pose.quaternion[i] / sqrt(squared));
        }
        for (int i = 0; i < 3; ++i) {
            pose.position[i] = (scara_real)((1.0 - part) * (double)from.position[i]
                + part * (double)to.position[i]);
        }
        if (k == 80) {
            pose.position[0] = (scara_real)NAN;
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
