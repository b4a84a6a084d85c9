/* How a control loop uses ren2008_true: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "ren2008_true.h"
#include "ren2008_true_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, ren2008_true_status status)
{
    static const char *const names[] = {
        "REN2008_TRUE_OK", "REN2008_TRUE_MAX_ITERATIONS", "REN2008_TRUE_SINGULAR", "REN2008_TRUE_NONFINITE", "REN2008_TRUE_OUT_OF_RANGE", "REN2008_TRUE_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    ren2008_true_pose pose;
    ren2008_true_real joints[REN2008_TRUE_JOINTS];
    ren2008_true_info info;
    ren2008_true_status status;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = ren2008_true_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = ren2008_true_vector_home[3 + i];
    }
    status = ren2008_true_inverse(&pose, joints);
    if (status != REN2008_TRUE_OK) {
        return stopped("ren2008_true_inverse", status);
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < REN2008_TRUE_JOINTS; ++i) {
        joints[i] = ren2008_true_vector_joints[0][i];
    }
    status = ren2008_true_direct(NULL, joints, &pose, &pose, &info);
    if (status != REN2008_TRUE_OK) {
        return stopped("ren2008_true_direct", status);
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for ren2008_true_direct. */
    status = ren2008_true_track(joints, &pose, &info);
    if (status != REN2008_TRUE_OK) {
        return stopped("ren2008_true_track", status);
    }
    if (info.residual > REN2008_TRUE_TRACK_LIMIT) {
        (void)fprintf(stderr, "ren2008_true_track: predicted error %g; call ren2008_true_direct\n", (double)info.residual);
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
