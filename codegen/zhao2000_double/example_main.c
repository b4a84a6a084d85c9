/* A control loop with zhao2000: where the platform is, cycle after cycle, and what to do when there
 * is none.
 * SPDX-License-Identifier: MIT */
#include "zhao2000.h"
#include "zhao2000_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    zhao2000_pose pose; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const zhao2000_real values[ZHAO2000_JOINTS])
{
    loop_state next = *state;
    zhao2000_info info;
    if ((zhao2000_track(values, &next.pose, &info) == ZHAO2000_OK)
        && (info.residual <= ZHAO2000_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (zhao2000_direct(NULL, values, &state->pose, &next.pose, &info) == ZHAO2000_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below ZHAO2000_JOINTS; the answer stays the
             * last good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const zhao2000_real *const home = zhao2000_vector_home;
    loop_state state = { { { home[0], home[1], home[2] }, { home[3], home[4], home[5], home[6] } },
        0, 0, 0 };
    zhao2000_real begin[ZHAO2000_JOINTS];
    if (zhao2000_inverse(&state.pose, begin) != ZHAO2000_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\n");
        return 1;
    }
    /* the joints move from home in a straight line; values 40 to 69 are lost, of value 80 a number
     * is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const zhao2000_real part = (zhao2000_real)k / (zhao2000_real)CYCLES;
        zhao2000_real values[ZHAO2000_JOINTS];
        for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
            values[i] = begin[i] + part * (zhao2000_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (zhao2000_real)NAN;
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
