/* How a control loop uses scara: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "scara.h"
#include "scara_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, scara_status status)
{
    static const char *const names[] = {
        "SCARA_OK", "SCARA_MAX_ITERATIONS", "SCARA_SINGULAR", "SCARA_NONFINITE", "SCARA_OUT_OF_RANGE", "SCARA_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    scara_pose pose;
    scara_real joints[SCARA_JOINTS];
    scara_info info;
    scara_status status;
    status = scara_direct(scara_vector_joints[0], &pose);
    if (status != SCARA_OK) {
        return stopped("scara_direct", status);
    }
    /* Anything but OK: joints are untouched, do not move. */
    status = scara_inverse(NULL, &pose, scara_vector_guesses[0], joints, &info);
    if (status != SCARA_OK) {
        return stopped("scara_inverse", status);
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
