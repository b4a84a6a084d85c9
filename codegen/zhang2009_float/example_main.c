/* A control loop with zhang2009: where the platform is, cycle after cycle, and what to do when that
 * is not known.
 * SPDX-License-Identifier: MIT */
#include "zhang2009.h"
#include "zhang2009_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    zhang2009_pose pose; /* the last one that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle: the pose at the joint values that were read. */
static void cycle(loop_state *state, const zhang2009_real joints[ZHANG2009_JOINTS])
{
    zhang2009_pose pose = state->pose;
    zhang2009_info info;
    if ((zhang2009_track(joints, &pose, &info) == ZHANG2009_OK)
        && (info.residual <= ZHANG2009_TRACK_LIMIT)) {
        ++state->tracked;
        state->pose = pose;
    } else if (zhang2009_direct(NULL, joints, &state->pose, &pose, &info) == ZHANG2009_OK) {
        /* too long a step, as after a gap in the readings */
        ++state->recovered;
        state->pose = pose;
    } else {
        /* joint info.joint is to blame, if it is below ZHANG2009_JOINTS; the pose stays the last
         * good one */
        ++state->held;
    }
}

int main(void)
{
    loop_state state = { { { 0.0f }, { 0.0f } }, 0, 0, 0 };
    zhang2009_real begin[ZHANG2009_JOINTS];
    for (int i = 0; i < 3; ++i) {
        state.pose.position[i] = zhang2009_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        state.pose.quaternion[i] = zhang2009_vector_home[3 + i];
    }
    if (zhang2009_inverse(&state.pose, begin) != ZHANG2009_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\n");
        return 1;
    }
    /* the joints move from home in a straight line; readings 40 to 69 are lost, reading 80 is not a
     * number */
    for (int k = 1; k <= CYCLES; ++k) {
        const zhang2009_real part = (zhang2009_real)k / (zhang2009_real)CYCLES;
        zhang2009_real joints[ZHANG2009_JOINTS];
        for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
            joints[i] = begin[i] + part * (zhang2009_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            joints[0] = (zhang2009_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, joints);
        }
    }
    (void)printf("position %.6f %.6f %.6f: %d tracked, %d recovered, %d held\n",
        (double)state.pose.position[0],
        (double)state.pose.position[1], (double)state.pose.position[2], state.tracked,
            state.recovered, state.held);
    return 0;
}
