/* How a loop of 1 kHz uses @{p}: the joints' values come from the found ones that are wanted, and what the joints have reached tells
 * the found values.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <stdio.h>

#define N @{P}_JOINTS
#define CYCLES 1000
#define PART ((@{p}_real)CYCLES)

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, @{p}_status status)
{
    static const char *const names[] = {
        "@{P}_OK", "@{P}_MAX_ITERATIONS", "@{P}_SINGULAR", "@{P}_NONFINITE", "@{P}_OUT_OF_RANGE", "@{P}_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

/* The found values of the joints that were read: one step from the last ones, and the whole line where that is not enough. */
static @{p}_status read_found(const @{p}_real joints[N], @{p}_real found[N])
{
    @{p}_info info;
    @{p}_status status = @{p}_track(joints, found, &info);
    if ((status != @{P}_OK) || (info.residual > @{P}_TRACK_LIMIT)) {
        status = @{p}_direct(NULL, joints, found, found, &info);
    }
    return status;
}

/* The joints of the found values that are wanted, in the same way. */
static @{p}_status command_joints(const @{p}_real wanted[N], @{p}_real joints[N])
{
    @{p}_info info;
    @{p}_status status = @{p}_track_inverse(wanted, joints, &info);
    if ((status != @{P}_OK) || (info.residual > @{P}_TRACK_LIMIT)) {
        status = @{p}_inverse(NULL, wanted, joints, joints, &info);
    }
    return status;
}

int main(void)
{
    const @{p}_real *const home = @{p}_vector_home_found;
    const @{p}_real *const goal = @{p}_vector_found[0];
    @{p}_real joints[N];
    @{p}_real found[N];
    @{p}_real wanted[N];
    @{p}_real torques[N];
    @{p}_real load[N];
    @{p}_status status;
    for (int i = 0; i < N; ++i) {
        joints[i] = @{p}_vector_home_joints[i];
        found[i] = home[i];
        load[i] = (@{p}_real)1;
    }
    /* Power-up: the joints as they are read, home as the guess. Anything but OK: do not move. */
    status = @{p}_direct(NULL, joints, found, found, NULL);
    if (status != @{P}_OK) {
        return stopped("@{p}_direct", status);
    }
    for (int cycle = 1; cycle <= CYCLES; ++cycle) {
        for (int i = 0; i < N; ++i) {
            wanted[i] = home[i] + ((@{p}_real)cycle / PART) * (goal[i] - home[i]);
        }
        status = command_joints(wanted, joints);
        if (status != @{P}_OK) {
            return stopped("command_joints", status);
        }
        /* here the motors move, and `joints` are what their encoders say */
        status = read_found(joints, found);
        if (status != @{P}_OK) {
            return stopped("read_found", status);
        }
        /* what the motors must hold where the found coordinates bear one unit of torque each */
        status = @{p}_torques(joints, found, load, torques);
        if (status != @{P}_OK) {
            return stopped("@{p}_torques", status);
        }
    }
    for (int i = 0; i < N; ++i) {
        (void)printf("joint %.6f found %.6f torque %.6f\n", (double)joints[i], (double)found[i], (double)torques[i]);
    }
    return 0;
}
