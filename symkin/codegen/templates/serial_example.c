/* A control loop with @{p}: joint values of poses, cycle after cycle, and what to do when there are none.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    @{p}_real joints[@{P}_JOINTS]; /* the last ones that were answered */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last pose */
    int held; /* cycles without one: the arm must not move */
} loop_state;

/* One cycle: the joint values of the pose that is wanted, from the last ones. */
static void cycle(@{gpe}loop_state *state, const @{p}_pose *pose)
{
    @{p}_info info;
    @{p}_real joints[@{P}_JOINTS];
    bool known = false;
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = state->joints[i];
    }
    if ((@{p}_track(@{ga}pose, joints, &info) == @{P}_OK) && (info.residual <= @{P}_TRACK_LIMIT)) {
        ++state->tracked;
        known = true;
    } else if (@{p}_inverse(@{ga}NULL, pose, state->joints, joints, &info) == @{P}_OK) {
        /* too long a step, as after a gap between poses */
        ++state->recovered;
        known = true;
    } else {
        /* joint info.joint is to blame, if it is below @{P}_JOINTS; the joint values stay the last good ones */
        ++state->held;
    }
    for (int i = 0; known && (i < @{P}_JOINTS); ++i) {
        state->joints[i] = joints[i];
    }
}

int main(void)
{
@{nominal}
    loop_state state = { { @{zero} }, 0, 0, 0 };
    @{p}_pose from;
    @{p}_pose to;
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        state.joints[i] = @{p}_vector_guesses[0][i];
    }
    if ((@{p}_direct(@{ga}state.joints, &from) != @{P}_OK) || (@{p}_direct(@{ga}@{p}_vector_joints[0], &to) != @{P}_OK)) {
        (void)fprintf(stderr, "no pose to begin with; the arm must not move\n");
        return 1;
    }
    /* the tool moves in a straight line; poses 40 to 69 are lost, pose 80 is not a number */
    for (int k = 1; k <= CYCLES; ++k) {
        const double part = (double)k / CYCLES;
        double cosine = 0.0;
        double squared = 0.0;
        @{p}_pose pose;
        for (int i = 0; i < 4; ++i) {
            cosine += (double)from.quaternion[i] * (double)to.quaternion[i];
        }
        for (int i = 0; i < 4; ++i) {
            const double other = (cosine < 0.0) ? -(double)to.quaternion[i] : (double)to.quaternion[i];
            const double q = (1.0 - part) * (double)from.quaternion[i] + part * other;
            pose.quaternion[i] = (@{p}_real)q;
            squared += q * q;
        }
        for (int i = 0; i < 4; ++i) {
            pose.quaternion[i] = (@{p}_real)((double)pose.quaternion[i] / sqrt(squared));
        }
        for (int i = 0; i < 3; ++i) {
            pose.position[i] = (@{p}_real)((1.0 - part) * (double)from.position[i] + part * (double)to.position[i]);
        }
        if (k == 80) {
            pose.position[0] = (@{p}_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(@{ga}&state, &pose);
        }
    }
    (void)printf("first joint %.6f: %d tracked, %d recovered, %d held\n", (double)state.joints[0], state.tracked,
        state.recovered, state.held);
    return 0;
}
