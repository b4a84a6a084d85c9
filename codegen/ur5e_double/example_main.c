/* A control loop with ur5e: joint values of tool poses, cycle after cycle, and what to do when
 * there is none.
 * SPDX-License-Identifier: MIT */
#include "ur5e.h"
#include "ur5e_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    ur5e_real joints[UR5E_JOINTS]; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const ur5e_real values[UR5E_JOINTS])
{
    loop_state next = *state;
    ur5e_info info;
    /* the pose that is wanted: that of joint values here */
    ur5e_pose pose = { { (ur5e_real)NAN }, { (ur5e_real)NAN } };
    (void)ur5e_direct(values, &pose);
    if ((ur5e_track(&pose, next.joints, &info) == UR5E_OK) && (info.residual <= UR5E_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (ur5e_inverse(NULL, &pose, state->joints, next.joints, &info) == UR5E_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below UR5E_JOINTS; the answer stays the last
             * good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const ur5e_real *const home = ur5e_vector_guesses[0];
    loop_state state = { { home[0], home[1], home[2], home[3], home[4], home[5] }, 0, 0, 0 };
    const ur5e_real *const begin = home;
    /* the tool moves to another pose; values 40 to 69 are lost, of value 80 a number is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const ur5e_real part = (ur5e_real)k / (ur5e_real)CYCLES;
        ur5e_real values[UR5E_JOINTS];
        for (int i = 0; i < UR5E_JOINTS; ++i) {
            values[i] = begin[i] + part * (ur5e_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (ur5e_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, values);
        }
    }
    (void)printf("first joint %.6f: %d tracked, %d recovered, %d held\n", (double)state.joints[0],
        state.tracked, state.recovered, state.held);
    return 0;
}
