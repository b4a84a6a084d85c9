/* How a control loop uses zhang2009: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "zhang2009.h"
#include "zhang2009_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, zhang2009_status status)
{
    static const char *const names[] = {
        "ZHANG2009_OK", "ZHANG2009_MAX_ITERATIONS", "ZHANG2009_SINGULAR", "ZHANG2009_NONFINITE", "ZHANG2009_OUT_OF_RANGE", "ZHANG2009_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    zhang2009_pose pose;
    zhang2009_real joints[ZHANG2009_JOINTS];
    zhang2009_info info;
    zhang2009_status status;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = zhang2009_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = zhang2009_vector_home[3 + i];
    }
    status = zhang2009_inverse(&pose, joints);
    if (status != ZHANG2009_OK) {
        return stopped("zhang2009_inverse", status);
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        joints[i] = zhang2009_vector_joints[0][i];
    }
    status = zhang2009_direct(NULL, joints, &pose, &pose, &info);
    if (status != ZHANG2009_OK) {
        return stopped("zhang2009_direct", status);
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for zhang2009_direct. */
    status = zhang2009_track(joints, &pose, &info);
    if (status != ZHANG2009_OK) {
        return stopped("zhang2009_track", status);
    }
    if (info.residual > ZHANG2009_TRACK_LIMIT) {
        (void)fprintf(stderr, "zhang2009_track: predicted error %g; call zhang2009_direct\n", (double)info.residual);
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
