/* A control loop with @{p}: @{about}, cycle after cycle, and what to do when there is none.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <math.h>
#include <stdio.h>

#define CYCLES (100)

/* What the loop keeps from one cycle to the next. */
typedef struct {
    @{answer}; /* the last that was known */
    int tracked; /* cycles answered by one step */
    int recovered; /* cycles answered by the whole line from the last answer */
    int held; /* cycles without an answer: the machine must not move */
} loop_state;

/* One cycle. */
static void cycle(@{gpe}loop_state *state, const @{p}_real values[@{P}_JOINTS])
{
    loop_state next = *state;
    @{p}_info info;
@{pose}
    if ((@{p}_@{track}(@{ga}@{known}, @{next}, &info) == @{P}_OK) && (info.residual <= @{P}_TRACK_LIMIT)) {
        ++next.tracked;
    } else {
        /* too long a step, as after a gap */
        next = *state;
        if (@{p}_@{solve}(@{ga}NULL, @{known}, @{last}, @{next}, &info) == @{P}_OK) {
            ++next.recovered;
        } else {
            /* joint info.joint is to blame, if it is below @{P}_JOINTS; the answer stays the last good one */
            ++next.held;
        }
    }
    *state = next;
}

int main(void)
{
    const @{p}_real *const home = @{home};
@{nominal}
    loop_state state = { @{first}, 0, 0, 0 };
@{begin}
    /* @{way}; values 40 to 69 are lost, of value 80 a number is none */
    for (int k = 1; k <= CYCLES; ++k) {
        const @{p}_real part = (@{p}_real)k / (@{p}_real)CYCLES;
        @{p}_real values[@{P}_JOINTS];
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            values[i] = begin[i] + part * (@{goal}[0][i] - begin[i]);
        }
        if (k == 80) {
            values[0] = (@{p}_real)NAN;
        }
        if ((k < 40) || (k >= 70)) {
            cycle(@{ga}&state, values);
        }
    }
@{end}
    (void)printf("@{told}: %d tracked, %d recovered, %d held\n", @{numbers}, state.tracked, state.recovered, state.held);
    return 0;
}
