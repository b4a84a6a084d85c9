/* How a control loop uses @{p}: from joint values to a pose and back from a guess.
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
    status = @{p}_direct(@{ga}@{p}_vector_joints[0], &pose);
    if (status != @{P}_OK) {
        return stopped("@{p}_direct", status);
    }
    /* Anything but OK: joints are untouched, do not move. */
    status = @{p}_inverse(@{ga}NULL, &pose, @{p}_vector_guesses[0], joints, &info);
    if (status != @{P}_OK) {
        return stopped("@{p}_inverse", status);
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
