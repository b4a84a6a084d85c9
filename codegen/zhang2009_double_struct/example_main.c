/* How a control loop uses zhang2009: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "zhang2009.h"
#include "zhang2009_vectors.h"

#include <stdio.h>

int main(void)
{
    const zhang2009_geometry nominal = ZHANG2009_NOMINAL;
    const zhang2009_geometry *const geometry = &nominal;
    zhang2009_pose pose;
    zhang2009_real joints[ZHANG2009_JOINTS];
    zhang2009_info info;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = zhang2009_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = zhang2009_vector_home[3 + i];
    }
    if (zhang2009_inverse(geometry, &pose, joints) != ZHANG2009_OK) {
        return 1;
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < ZHANG2009_JOINTS; ++i) {
        joints[i] = zhang2009_vector_joints[0][i];
    }
    if (zhang2009_direct(geometry, NULL, joints, &pose, &pose, &info) != ZHANG2009_OK) {
        return 1;
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for zhang2009_direct. */
    if ((zhang2009_track(geometry, joints, &pose, &info) != ZHANG2009_OK) || (info.residual > ZHANG2009_SIZE)) {
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
