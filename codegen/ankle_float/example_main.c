/* A control loop with ankle: joints of found values that are wanted, and what they must hold, cycle
 * after cycle, and what to do when there is none.
 * SPDX-License-Identifier: MIT */
#include "ankle.h"
#include "ankle_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    ankle_real joints[ANKLE_JOINTS]; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const ankle_real values[ANKLE_JOINTS])
{
    loop_state next = *state;
    ankle_info info;
    if ((ankle_track_inverse(values, next.joints, &info) == ANKLE_OK)
        && (info.residual <= ANKLE_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (ankle_inverse(NULL, values, state->joints, next.joints, &info) == ANKLE_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below ANKLE_JOINTS; the answer stays the last
             * good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const ankle_real *const home = ankle_vector_home_joints;
    loop_state state = { { home[0], home[1] }, 0, 0, 0 };
    const ankle_real *const begin = ankle_vector_home_found;
    /* the found values move from home in a straight line; values 40 to 69 are lost, of value 80 a
     * number is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const ankle_real part = (ankle_real)k / (ankle_real)CYCLES;
        ankle_real values[ANKLE_JOINTS];
        for (int i = 0; i < ANKLE_JOINTS; ++i) {
            values[i] = begin[i] + part * (ankle_vector_found[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (ankle_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, values);
        }
    }
    /* where they have come to, and what the joints hold of one unit at each found coordinate */
    ankle_real found[ANKLE_FOUND];
    ankle_real load[ANKLE_FOUND];
    ankle_real torques[ANKLE_JOINTS];
    for (int i = 0; i < ANKLE_JOINTS; ++i) {
        load[i] = (ankle_real)1;
    }
    if ((ankle_direct(NULL, state.joints, begin, found, NULL) != ANKLE_OK)
        || (ankle_torques(state.joints, found, load, torques) != ANKLE_OK)) {
        (void)fprintf(stderr, "no answer; the machine must not move\n");
        return 1;
    }
    (void)printf("joint %.6f found %.6f torque %.6f: %d tracked, %d recovered, %d held\n",
        (double)state.joints[0], (double)found[0], (double)torques[0], state.tracked,
        state.recovered, state.held);
    return 0;
}
