/* A control loop with delta: where the platform is, cycle after cycle, and what to do when there is
 * none.
 * SPDX-License-Identifier: MIT */
#include "delta.h"
#include "delta_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    delta_pose pose; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const delta_real values[DELTA_JOINTS])
{
    loop_state next = *state;
    delta_info info;
    if ((delta_track(values, &next.pose, &info) == DELTA_OK)
        && (info.residual <= DELTA_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (delta_direct(NULL, values, &state->pose, &next.pose, &info) == DELTA_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below DELTA_JOINTS; the answer stays the last
             * good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const delta_real *const home = delta_vector_home;
    loop_state state = { { { home[0], home[1], home[2] }, { home[3], home[4], home[5], home[6] } },
        0, 0, 0 };
    delta_real begin[DELTA_JOINTS];
    if (delta_inverse(&state.pose, begin) != DELTA_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\n");
        return 1;
    }
    /* the joints move from home in a straight line; values 40 to 69 are lost, of value 80 a number
     * is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const delta_real part = (delta_real)k / (delta_real)CYCLES;
        delta_real values[DELTA_JOINTS];
        for (int i = 0; i < DELTA_JOINTS; ++i) {
            values[i] = begin[i] + part * (delta_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (delta_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, values);
        }
    }
    (void)printf("position %.6f %.6f %.6f: %d tracked, %d recovered, %d held\n",
        (double)state.pose.position[0], (double)state.pose.position[1],
        (double)state.pose.position[2], state.tracked, state.recovered, state.held);
    return 0;
}
