/* A control loop with yao2020: joint values of poses, cycle after cycle, and what to do when there
 * are none.
 * SPDX-License-Identifier: MIT */
#include "yao2020.h"
#include "yao2020_vectors.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    yao2020_real joints[YAO2020_JOINTS]; /* the last ones that were answered */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without one: the arm must not move */
} loop_state;

/* One cycle: the joint values of the pose that is wanted, from the last ones. */
static void cycle(loop_state *state, const yao2020_pose *pose)
{
    yao2020_info info;
    yao2020_real joints[YAO2020_JOINTS];
    bool known = false;
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        joints[i] = state->joints[i];
    }
    if ((yao2020_track(pose, joints, &info) == YAO2020_OK)
        && (info.residual <= YAO2020_TRACK_LIMIT)) {
        ++state->tracked;
        known = true;
    } else if (yao2020_inverse(NULL, pose, state->joints, joints, &info) == YAO2020_OK) {
        /* too long a step, as after a gap between poses */
        ++state->recovered;
        known = true;
    } else {
        /* joint info.joint is to blame, if it is below YAO2020_JOINTS; the joint values stay the
         * last good ones */
        ++state->held;
    }
    for (int i = 0; known && (i < YAO2020_JOINTS); ++i) {
        state->joints[i] = joints[i];
    }
}

int main(void)
{
    loop_state state = { { 0.0f }, 0, 0, 0 };
    yao2020_pose from;
    yao2020_pose to;
    for (int i = 0; i < YAO2020_JOINTS; ++i) {
        state.joints[i] = yao2020_vector_guesses[0][i];
    }
    if ((yao2020_direct(state.joints, &from) != YAO2020_OK)
        || (yao2020_direct(yao2020_vector_joints[0], &to) != YAO2020_OK)) {
        (void)fprintf(stderr, "no pose to begin with; the arm must not move\n");
        return 1;
    }
    /* the tool moves in a straight line; poses 40 to 69 are lost, pose 80 is not a number */
    for (int k = 1; k <= CYCLES; ++k) {
        const double part = (double)k / CYCLES;
        double cosine = 0.0;
        double squared = 0.0;
        yao2020_pose pose;
        for (int i = 0; i < 4; ++i) {
            cosine += (double)from.quaternion[i] * (double)to.quaternion[i];
        }
        for (int i = 0; i < 4; ++i) {
            const double other = (cosine < 0.0) ? -(double)to.quaternion[i]
                : (double)to.quaternion[i];
            const double q = (1.0 - part) * (double)from.quaternion[i] + part * other;
            pose.quaternion[i] = (yao2020_real)q;
            squared += q * q;
        }
        for (int i = 0; i < 4; ++i) {
            pose.quaternion[i] = (yao2020_real)((double)pose.quaternion[i] / sqrt(squared));
        }
        for (int i = 0; i < 3; ++i) {
            pose.position[i] = (yao2020_real)((1.0 - part) * (double)from.position[i]
                + part * (double)to.position[i]);
        }
        if (k == 80) {
            pose.position[0] = (yao2020_real)NAN;
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
