/* How a control loop uses gluon_6l3: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "gluon_6l3.h"
#include "gluon_6l3_vectors.h"

#include <stdio.h>

int main(void)
{
    gluon_6l3_pose pose;
    gluon_6l3_real joints[GLUON_6L3_JOINTS];
    gluon_6l3_info info;
    if (gluon_6l3_direct(gluon_6l3_vector_joints[0], &pose) != GLUON_6L3_OK) {
        return 1;
    }
    /* Anything but OK: joints are untouched, do not move. */
    if (gluon_6l3_inverse(NULL, &pose, gluon_6l3_vector_guesses[0], joints, &info) != GLUON_6L3_OK) {
        return 1;
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
