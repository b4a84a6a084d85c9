/* A control loop with zhao2000_links: where the platform is, cycle after cycle, and what to do when
 * that is not known.
 * SPDX-License-Identifier: MIT */
#include "zhao2000_links.h"
#include "zhao2000_links_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    zhao2000_links_pose pose; /* the last one that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle: the pose at the joint values that were read. */
static void cycle(loop_state *state, const zhao2000_links_real joints[ZHAO2000_LINKS_JOINTS])
{
    zhao2000_links_pose pose = state->pose;
    zhao2000_links_info info;
    if ((zhao2000_links_track(joints, &pose, &info) == ZHAO2000_LINKS_OK)
        && (info.residual <= ZHAO2000_LINKS_TRACK_LIMIT)) {
        ++state->tracked;
        state->pose = pose;
    } else if (zhao2000_links_direct(NULL, joints, &state->pose, &pose,
        &info) == ZHAO2000_LINKS_OK) {
        /* too long a step, as after a gap in the readings */
        ++state->recovered;
        state->pose = pose;
    } else {
        /* joint info.joint is to blame, if it is below ZHAO2000_LINKS_JOINTS; the pose stays the
         * last good one */
        ++state->held;
    }
}

int main(void)
{
    loop_state state = { { { 0.0f }, { 0.0f } }, 0, 0, 0 };
    zhao2000_links_real begin[ZHAO2000_LINKS_JOINTS];
    for (int i = 0; i < 3; ++i) {
        state.pose.position[i] = zhao2000_links_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        state.pose.quaternion[i] = zhao2000_links_vector_home[3 + i];
    }
    if (zhao2000_links_inverse(&state.pose, begin) != ZHAO2000_LINKS_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\n");
        return 1;
    }
    /* the joints move from home in a straight line; readings 40 to 69 are lost, reading 80 is not a
     * number */
    for (int k = 1; k <= CYCLES; ++k) {
        const zhao2000_links_real part = (zhao2000_links_real)k / (zhao2000_links_real)CYCLES;
        zhao2000_links_real joints[ZHAO2000_LINKS_JOINTS];
        for (int i = 0; i < ZHAO2000_LINKS_JOINTS; ++i) {
            joints[i] = begin[i] + part * (zhao2000_links_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            joints[0] = (zhao2000_links_real)NAN;
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
