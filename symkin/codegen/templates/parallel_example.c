/* A control loop with @{p}: where the platform is, cycle after cycle, and what to do when that is not known.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    @{p}_pose pose; /* the last one that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle: the pose at the joint values that were read. */
static void cycle(@{gpe}loop_state *state, const @{p}_real joints[@{P}_JOINTS])
{
    @{p}_pose pose = state->pose;
    @{p}_info info;
    if ((@{p}_track(@{ga}joints, &pose, &info) == @{P}_OK) && (info.residual <= @{P}_TRACK_LIMIT)) {
        ++state->tracked;
        state->pose = pose;
    } else if (@{p}_direct(@{ga}NULL, joints, &state->pose, &pose, &info) == @{P}_OK) {
        /* too long a step, as after a gap in the readings */
        ++state->recovered;
        state->pose = pose;
    } else {
        /* joint info.joint is to blame, if it is below @{P}_JOINTS; the pose stays the last good one */
        ++state->held;
    }
}

int main(void)
{
@{nominal}
    loop_state state = { { { @{zero} }, { @{zero} } }, 0, 0, 0 };
    @{p}_real begin[@{P}_JOINTS];
    for (int i = 0; i < 3; ++i) {
        state.pose.position[i] = @{p}_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        state.pose.quaternion[i] = @{p}_vector_home[3 + i];
    }
    if (@{p}_inverse(@{ga}&state.pose, begin) != @{P}_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\n");
        return 1;
    }
    /* the joints move from home in a straight line; readings 40 to 69 are lost, reading 80 is not a number */
    for (int k = 1; k <= CYCLES; ++k) {
        const @{p}_real part = (@{p}_real)k / (@{p}_real)CYCLES;
        @{p}_real joints[@{P}_JOINTS];
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            joints[i] = begin[i] + part * (@{p}_vector_joints[0][i] - begin[i]);
        }
        if (k == 80) {
            joints[0] = (@{p}_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(@{ga}&state, joints);
        }
    }
    (void)printf("position %.6f %.6f %.6f: %d tracked, %d recovered, %d held\n", (double)state.pose.position[0],
        (double)state.pose.position[1], (double)state.pose.position[2], state.tracked, state.recovered, state.held);
    return 0;
}
