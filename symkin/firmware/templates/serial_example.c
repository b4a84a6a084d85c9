/* How a control loop uses @{p}: from joint values to a pose and back from a guess.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <stdio.h>

int main(void)
{
@{nominal}
    @{p}_pose pose;
    @{p}_real joints[@{P}_JOINTS];
    @{p}_info info;
    if (@{p}_direct(@{ga}@{p}_vector_joints[0], &pose) != @{P}_OK) {
        return 1;
    }
    /* Anything but OK: joints are untouched, do not move. */
    if (@{p}_inverse(@{ga}NULL, &pose, @{p}_vector_guesses[0], joints, &info) != @{P}_OK) {
        return 1;
    }
    (void)printf("first joint %.6f after %d steps\n", (double)joints[0], (int)info.iterations);
    return 0;
}
