/* How a control loop uses zhao2000: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "zhao2000.h"
#include "zhao2000_vectors.h"

#include <stdio.h>

int main(void)
{
    zhao2000_pose pose;
    zhao2000_real joints[ZHAO2000_JOINTS];
    zhao2000_info info;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = zhao2000_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = zhao2000_vector_home[3 + i];
    }
    if (zhao2000_inverse(&pose, joints) != ZHAO2000_OK) {
        return 1;
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < ZHAO2000_JOINTS; ++i) {
        joints[i] = zhao2000_vector_joints[0][i];
    }
    if (zhao2000_direct(NULL, joints, &pose, &pose, &info) != ZHAO2000_OK) {
        return 1;
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for zhao2000_direct. */
    if ((zhao2000_track(joints, &pose, &info) != ZHAO2000_OK) || (info.residual > ZHAO2000_SIZE)) {
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
