/* How a control loop uses @{p}: from a pose to joint values and back, then tracking.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, @{p}_status status)
{
    static const char *const names[] = {
        "@{P}_OK", "@{P}_MAX_ITERATIONS", "@{P}_SINGULAR", "@{P}_NONFINITE", "@{P}_OUT_OF_RANGE", "@{P}_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
@{nominal}
    @{p}_pose pose;
    @{p}_real joints[@{P}_JOINTS];
    @{p}_info info;
    @{p}_status status;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = @{p}_vector_home[i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = @{p}_vector_home[3 + i];
    }
    status = @{p}_inverse(@{ga}&pose, joints);
    if (status != @{P}_OK) {
        return stopped("@{p}_inverse", status);
    }
    /* Power-up: the machine's joints as they are read, home as the guess. Anything but OK: do not move. */
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = @{p}_vector_joints[0][i];
    }
    status = @{p}_direct(@{ga}NULL, joints, &pose, &pose, &info);
    if (status != @{P}_OK) {
        return stopped("@{p}_direct", status);
    }
    /* Each cycle: one step from the last pose; a predicted error that is too large asks for @{p}_direct. */
    status = @{p}_track(@{ga}joints, &pose, &info);
    if (status != @{P}_OK) {
        return stopped("@{p}_track", status);
    }
    if (info.residual > @{P}_TRACK_LIMIT) {
        (void)fprintf(stderr, "@{p}_track: predicted error %g; call @{p}_direct\n", (double)info.residual);
        return 1;
    }
    (void)printf("position %.6f %.6f %.6f\n", (double)pose.position[0], (double)pose.position[1], (double)pose.position[2]);
    return 0;
}
