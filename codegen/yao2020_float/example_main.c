/* How a control loop uses yao2020: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "yao2020.h"
#include "yao2020_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, yao2020_status status)
{
    static const char *const names[] = {
        "YAO2020_OK", "YAO2020_MAX_ITERATIONS", "YAO2020_SINGULAR", "YAO2020_NONFINITE", "YAO2020_OUT_OF_RANGE", "YAO2020_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    yao2020_pose pose;
    yao2020_real joints[YAO2020_JOINTS];
    yao2020_info info;
    yao2020_status status;
    status = yao2020_direct(yao2020_vector_joints[0], &pose);
    if (status != YAO2020_OK) {
        return stopped("yao2020_direct", status);
    }
    /* Anything but OK: joints are untouched, do not move. */
    status = yao2020_inverse(NULL, &pose, yao2020_vector_guesses[0], joints, &info);
    if (status != YAO2020_OK) {
        return stopped("yao2020_inverse", status);
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
