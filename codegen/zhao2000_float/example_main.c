/* How a control loop uses zhao2000: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "zhao2000.h"
#include "zhao2000_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, zhao2000_status status)
{
    static const char *const names[] = {
        "ZHAO2000_OK", "ZHAO2000_MAX_ITERATIONS", "ZHAO2000_SINGULAR", "ZHAO2000_NONFINITE", "ZHAO2000_OUT_OF_RANGE", "ZHAO2000_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    zhao2000_pose pose;
    zhao2000_real joints[ZHAO2000_JOINTS];
    zhao2000_info info;
    zhao2000_status status;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = zhao2000_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = zhao2000_vector_home[3 + i];
    }
    status = zhao2000_inverse(&pose, joints);
    if (status != ZHAO2000_OK) {
        return stopped("zhao2000_inverse", status);
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        joints[i] = zhao2000_vector_joints[0][i];
    }
    status = zhao2000_direct(NULL, joints, &pose, &pose, &info);
    if (status != ZHAO2000_OK) {
        return stopped("zhao2000_direct", status);
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for zhao2000_direct. */
    status = zhao2000_track(joints, &pose, &info);
    if (status != ZHAO2000_OK) {
        return stopped("zhao2000_track", status);
    }
    if (info.residual > ZHAO2000_TRACK_LIMIT) {
        (void)fprintf(stderr, "zhao2000_track: predicted error %g; call zhao2000_direct\n", (double)info.residual);
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
