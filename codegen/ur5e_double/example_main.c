/* How a control loop uses ur5e: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "ur5e.h"
#include "ur5e_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, ur5e_status status)
{
    static const char *const names[] = {
        "UR5E_OK", "UR5E_MAX_ITERATIONS", "UR5E_SINGULAR", "UR5E_NONFINITE", "UR5E_OUT_OF_RANGE", "UR5E_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    ur5e_pose pose;
    ur5e_real joints[UR5E_JOINTS];
    ur5e_info info;
    ur5e_status status;
    status = ur5e_direct(ur5e_vector_joints[0], &pose);
    if (status != UR5E_OK) {
        return stopped("ur5e_direct", status);
    }
    /* Anything but OK: joints are untouched, do not move. */
    status = ur5e_inverse(NULL, &pose, ur5e_vector_guesses[0], joints, &info);
    if (status != UR5E_OK) {
        return stopped("ur5e_inverse", status);
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
