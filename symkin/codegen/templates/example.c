/* A control loop with @p: @about, cycle after cycle, and what to do when there is none.
 * SPDX-License-Identifier: MIT */
#include "@p.h"
#include "name_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    @answer; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(@{gpe}loop_state *state, const name_real values[NAME_JOINTS])
{
    loop_state next = *state;
    name_info info;
@pose
    if ((name_@track(@ga@known, @next, &info) == NAME_OK) && (info.residual <= NAME_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (name_@solve(@{ga}NULL, @known, @last, @next, &info) == NAME_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below NAME_JOINTS; the answer stays the last good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const name_real *const home = @home;
@nominal
    loop_state state = { @first, 0, 0, 0 };
@begin
    /* @way; values 40 to 69 are lost, of value 80 a number is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const name_real part = (name_real)k / (name_real)CYCLES;
        name_real values[NAME_JOINTS];
        EACH(i, NAME_JOINTS) {
            values[i] = begin[i] + part * (@goal[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (name_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(@ga&state, values);
        }
    }
@end
    (void)printf("@told: %d tracked, %d recovered, %d held\n", @numbers, state.tracked, state.recovered, state.held);
    return 0;
}
