/* How a control loop uses gluon_6l3: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "gluon_6l3.h"
#include "gluon_6l3_vectors.h"

#include <stdio.h>

/* Says on stderr why the example ends: the status by its name. */
static int stopped(const char *call, gluon_6l3_status status)
{
    static const char *const names[] = {
        "GLUON_6L3_OK", "GLUON_6L3_MAX_ITERATIONS", "GLUON_6L3_SINGULAR", "GLUON_6L3_NONFINITE", "GLUON_6L3_OUT_OF_RANGE", "GLUON_6L3_WRONG_BRANCH"
    };
    (void)fprintf(stderr, "%s: %s; the machine must not move\n", call, names[status]);
    return 1;
}

int main(void)
{
    gluon_6l3_pose pose;
    gluon_6l3_real joints[GLUON_6L3_JOINTS];
    gluon_6l3_info info;
    gluon_6l3_status status;
    status = gluon_6l3_direct(gluon_6l3_vector_joints[0], &pose);
    if (status != GLUON_6L3_OK) {
        return stopped("gluon_6l3_direct", status);
    }
    /* Anything but OK: joints are untouched, do not move. */
    status = gluon_6l3_inverse(NULL, &pose, gluon_6l3_vector_guesses[0], joints, &info);
    if (status != GLUON_6L3_OK) {
        return stopped("gluon_6l3_inverse", status);
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
