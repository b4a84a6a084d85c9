/* How a control loop uses zhao2000_links: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "zhao2000_links.h"
#include "zhao2000_links_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, zhao2000_links_status status)
{
    static const char *const names[] = {
        "ZHAO2000_LINKS_OK", "ZHAO2000_LINKS_MAX_ITERATIONS", "ZHAO2000_LINKS_SINGULAR", "ZHAO2000_LINKS_NONFINITE", "ZHAO2000_LINKS_OUT_OF_RANGE", "ZHAO2000_LINKS_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    zhao2000_links_pose pose;
    zhao2000_links_real joints[ZHAO2000_LINKS_JOINTS];
    zhao2000_links_info info;
    zhao2000_links_status status;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = zhao2000_links_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = zhao2000_links_vector_home[3 + i];
    }
    status = zhao2000_links_inverse(&pose, joints);
    if (status != ZHAO2000_LINKS_OK) {
        return stopped("zhao2000_links_inverse", status);
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < ZHAO2000_LINKS_JOINTS; ++i) {
        joints[i] = zhao2000_links_vector_joints[0][i];
    }
    status = zhao2000_links_direct(NULL, joints, &pose, &pose, &info);
    if (status != ZHAO2000_LINKS_OK) {
        return stopped("zhao2000_links_direct", status);
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for zhao2000_links_direct. */
    status = zhao2000_links_track(joints, &pose, &info);
    if (status != ZHAO2000_LINKS_OK) {
        return stopped("zhao2000_links_track", status);
    }
    if (info.residual > ZHAO2000_LINKS_TRACK_LIMIT) {
        (void)fprintf(stderr, "zhao2000_links_track: predicted error %g; call zhao2000_links_direct\n", (double)info.residual);
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
