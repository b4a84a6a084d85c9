/* How a control loop uses ren2008: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "ren2008.h"
#include "ren2008_vectors.h"

#include <stdio.h>

int main(void)
{
    ren2008_pose pose;
    ren2008_real joints[REN2008_JOINTS];
    ren2008_info info;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = ren2008_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = ren2008_vector_home[3 + i];
    }
    if (ren2008_inverse(&pose, joints) != REN2008_OK) {
        return 1;
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < REN2008_JOINTS; ++i) {
        joints[i] = ren2008_vector_joints[0][i];
    }
    if (ren2008_direct(NULL, joints, &pose, &pose, &info) != REN2008_OK) {
        return 1;
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for ren2008_direct. */
    if ((ren2008_track(joints, &pose, &info) != REN2008_OK) || (info.residual > REN2008_SIZE)) {
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
