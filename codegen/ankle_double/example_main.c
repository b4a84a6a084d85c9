/* How a loop of 1 kHz uses ankle: the joints' values come from the found ones that are wanted, and
 * what the joints have reached tells the found values.
 * SPDX-License-Identifier: MIT */
#include "ankle.h"
#include "ankle_vectors.h"

#include <stdio.h>

#define N ANKLE_JOINTS
#define CYCLES 1000
#define PART ((ankle_real)CYCLES)

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, ankle_status status)
{
    static const char *const names[] = {
        "ANKLE_OK", "ANKLE_MAX_ITERATIONS", "ANKLE_SINGULAR", "ANKLE_NONFINITE",
            "ANKLE_OUT_OF_RANGE", "ANKLE_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

/* The found values of the joints that were read: one step from the last ones, and the whole line
 * where that is not enough. */
static ankle_status read_found(const ankle_real joints[N], ankle_real found[N])
{
    ankle_info info;
    ankle_status status = ankle_track(joints, found, &info);
    if ((status != ANKLE_OK) || (info.residual > ANKLE_TRACK_LIMIT)) {
        status = ankle_direct(NULL, joints, found, found, &info);
    }
    return status;
}

/* The joints of the found values that are wanted, in the same way. */
static ankle_status command_joints(const ankle_real wanted[N], ankle_real joints[N])
{
    ankle_info info;
    ankle_status status = ankle_track_inverse(wanted, joints, &info);
    if ((status != ANKLE_OK) || (info.residual > ANKLE_TRACK_LIMIT)) {
        status = ankle_inverse(NULL, wanted, joints, joints, &info);
    }
    return status;
}

int main(void)
{
    const ankle_real *const home = ankle_vector_home_found;
    const ankle_real *const goal = ankle_vector_found[0];
    ankle_real joints[N];
    ankle_real found[N];
    ankle_real wanted[N];
    ankle_real torques[N];
    ankle_real load[N];
    ankle_status status;
    for (int i = 0; i < N; ++i) {
        joints[i] = ankle_vector_home_joints[i];
        found[i] = home[i];
        load[i] = (ankle_real)1;
    }
    /* Power-up: the joints as they are read, home as the guess. Anything but OK: do not move. */
    status = ankle_direct(NULL, joints, found, found, NULL);
    if (status != ANKLE_OK) {
        return stopped("ankle_direct", status);
    }
    for (int cycle = 1; cycle <= CYCLES; ++cycle) {
        for (int i = 0; i < N; ++i) {
            wanted[i] = home[i] + ((ankle_real)cycle / PART) * (goal[i] - home[i]);
        }
        status = command_joints(wanted, joints);
        if (status != ANKLE_OK) {
            return stopped("command_joints", status);
        }
        /* here the motors move, and `joints` are what their encoders say */
        status = read_found(joints, found);
        if (status != ANKLE_OK) {
            return stopped("read_found", status);
        }
        /* what the motors must hold where the found coordinates bear one unit of torque each */
        status = ankle_torques(joints, found, load, torques);
        if (status != ANKLE_OK) {
            return stopped("ankle_torques", status);
        }
    }
    for (int i = 0; i < N; ++i) {
        (void)printf("joint %.6f found %.6f torque %.6f\n", (double)joints[i], (double)found[i],
            (double)torques[i]);
    }
    return 0;
}
