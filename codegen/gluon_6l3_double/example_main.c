/* A control loop with gluon_6l3: joint values of tool poses, cycle after cycle, and what to do when
 * there is none.
 * SPDX-License-Identifier: MIT */
#include "gluon_6l3.h"
#include "gluon_6l3_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    gluon_6l3_real joints[GLUON_6L3_JOINTS]; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const gluon_6l3_real values[GLUON_6L3_JOINTS])
{
    loop_state next = *state;
    gluon_6l3_info info;
    /* the pose that is wanted: that of joint values here */
    gluon_6l3_pose pose = { { (gluon_6l3_real)NAN }, { (gluon_6l3_real)NAN } };
    (void)gluon_6l3_direct(values, &pose);
    if ((gluon_6l3_track(&pose, next.joints, &info) == GLUON_6L3_OK)
        && (info.residual <= GLUON_6L3_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (gluon_6l3_inverse(NULL, &pose, state->joints, next.joints, &info) == GLUON_6L3_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below GLUON_6L3_JOINTS; the answer stays the
             * last good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const gluon_6l3_real *const home = gluon_6l3_vector_guesses[0];
    loop_state state = { { home[0], home[1], home[2], home[3], home[4], home[5] }, 0, 0, 0 };
    const gluon_6l3_real *const begin = home;
    /* the tool moves to another pose; values 40 to 69 are lost, of value 80 a number is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const gluon_6l3_real part = (gluon_6l3_real)k / (gluon_6l3_real)CYCLES;
        gluon_6l3_real values[GLUON_6L3_JOINTS];
        for (int i = 0; i < GLUON_6L3_JOINTS; ++i) {
            values[i] = begin[i] + part * (gluon_6l3_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (gluon_6l3_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, values);
        }
    }
    (void)printf("first joint %.6f: %d tracked, %d recovered, %d held\n", (double)state.joints[0],
        state.tracked, state.recovered, state.held);
    return 0;
}
