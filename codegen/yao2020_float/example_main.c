/* How a control loop uses yao2020: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "yao2020.h"
#include "yao2020_vectors.h"

#include <stdio.h>

int main(void)
{
    yao2020_pose pose;
    yao2020_real joints[YAO2020_JOINTS];
    yao2020_info info;
    if (yao2020_direct(yao2020_vector_joints[0], &pose) != YAO2020_OK) {
        return 1;
    }
    /* Anything but OK: joints are untouched, do not move. */
    if (yao2020_inverse(NULL, &pose, yao2020_vector_guesses[0], joints, &info) != YAO2020_OK) {
        return 1;
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
