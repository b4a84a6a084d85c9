/* A control loop with yao2020: joint values of tool poses, cycle after cycle, and what to do when
 * there is none.
 * SPDX-License-Identifier: MIT */
#include "yao2020.h"
#include "yao2020_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    yao2020_real joints[YAO2020_JOINTS]; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(loop_state *state, const yao2020_real values[YAO2020_JOINTS])
{
    loop_state next = *state;
    yao2020_info info;
    /* the pose that is wanted: that of joint values here */
    yao2020_pose pose = { { (yao2020_real)NAN }, { (yao2020_real)NAN } };
    (void)yao2020_direct(values, &pose);
    if ((yao2020_track(&pose, next.joints, &info) == YAO2020_OK)
        && (info.residual <= YAO2020_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (yao2020_inverse(NULL, &pose, state->joints, next.joints, &info) == YAO2020_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below YAO2020_JOINTS; the answer stays the
             * last good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const yao2020_real *const home = yao2020_vector_guesses[0];
    loop_state state = { { home[0], home[1], home[2], home[3], home[4], home[5] }, 0, 0, 0 };
    const yao2020_real *const begin = home;
    /* the tool moves to another pose; values 40 to 69 are lost, of value 80 a number is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const yao2020_real part = (yao2020_real)k / (yao2020_real)CYCLES;
        yao2020_real values[YAO2020_JOINTS];
        for (int i = 0; i < YAO2020_JOINTS; ++i) {
            values[i] = begin[i] + part * (yao2020_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (yao2020_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(&state, values);
        }
    }
    (void)printf("first joint %.6f: %d tracked, %d recovered, %d held\n", (double)state.joints[0],
        state.tracked, state.recovered, state.held);
    return 0;
}
