/* How a control loop uses @{p}: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <stdio.h>

int main(void)
{
@{nominal}
    @{p}_pose pose;
    @{p}_real joints[@{P}_JOINTS];
    @{p}_info info;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = @{p}_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = @{p}_vector_home[3 + i];
    }
    if (@{p}_inverse(@{ga}&pose, joints) != @{P}_OK) {
        return 1;
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = @{p}_vector_joints[0][i];
    }
    if (@{p}_direct(@{ga}NULL, joints, &pose, &pose, &info) != @{P}_OK) {
        return 1;
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for @{p}_direct. */
    if ((@{p}_track(@{ga}joints, &pose, &info) != @{P}_OK) || (info.residual > @{P}_SIZE)) {
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
