/* How a control loop uses delta: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "delta.h"
#include "delta_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, delta_status status)
{
    static const char *const names[] = {
        "DELTA_OK", "DELTA_MAX_ITERATIONS", "DELTA_SINGULAR", "DELTA_NONFINITE", "DELTA_OUT_OF_RANGE", "DELTA_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    delta_pose pose;
    delta_real joints[DELTA_JOINTS];
    delta_info info;
    delta_status status;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = delta_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = delta_vector_home[3 + i];
    }
    status = delta_inverse(&pose, joints);
    if (status != DELTA_OK) {
        return stopped("delta_inverse", status);
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < DELTA_JOINTS; ++i) {
        joints[i] = delta_vector_joints[0][i];
    }
    status = delta_direct(NULL, joints, &pose, &pose, &info);
    if (status != DELTA_OK) {
        return stopped("delta_direct", status);
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for delta_direct. */
    status = delta_track(joints, &pose, &info);
    if (status != DELTA_OK) {
        return stopped("delta_track", status);
    }
    if (info.residual > DELTA_TRACK_LIMIT) {
        (void)fprintf(stderr, "delta_track: predicted error %g; call delta_direct\n", (double)info.residual);
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
