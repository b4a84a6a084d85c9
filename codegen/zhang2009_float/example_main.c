/* A control loop with zhang2009: where the platform is, cycle after cycle, and what to do when
 * there is none.
 * SPDX-License-Identifier: MIT */
#include "zhang2009.h"
#include "zhang2009_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    zhang2009_pose pose; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const zhang2009_real values[ZHANG2009_JOINTS])
{
    loop_state next = *state;
    zhang2009_info info;
    if ((zhang2009_track(values, &next.pose, &info) == ZHANG2009_OK)
        && (info.residual <= ZHANG2009_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (zhang2009_direct(NULL, values, &state->pose, &next.pose, &info) == ZHANG2009_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below ZHANG2009_JOINTS; the answer stays the
             * last good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const zhang2009_real *const home = zhang2009_vector_home;
    loop_state state = { { { home[0], home[1], home[2] }, { home[3], home[4], home[5], home[6] } },
        0, 0, 0 };
    zhang2009_real begin[ZHANG2009_JOINTS];
    if (zhang2009_inverse(&state.pose, begin) != ZHANG2009_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\n");
        return 1;
    }
    /* the joints move from home in a straight line; values 40 to 69 are lost, of value 80 a number
     * is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const zhang2009_real part = (zhang2009_real)k / (zhang2009_real)CYCLES;
        zhang2009_real values[ZHANG2009_JOINTS];
        for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
            values[i] = begin[i] + part * (zhang2009_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (zhang2009_real)NAN;
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
