/* @{title}
 * @{stamp}
 * SPDX-License-Identifier: MIT
 *
@{about}
 */
#ifndef @{P}_H
#define @{P}_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef @{ctype} @{p}_real;

/* What a call came to. Results are written with @{P}_OK only. */
typedef enum {
    @{P}_OK = 0,
    @{P}_MAX_ITERATIONS, /* not settled within the iterations allowed */
    @{P}_SINGULAR, /* the linear system lost rank on the way */
    @{P}_NONFINITE, /* NaN or infinity among the inputs */
    @{P}_OUT_OF_RANGE, /* joint values or results outside their ranges, or a pose that cannot be taken */
    @{P}_WRONG_BRANCH /* not assured that the machine reaches the answer from the guess along the line */
} @{p}_status;
@{pose_type}

/* tolerance: predicted error of the answer (@{unit}, angles times the size); max_iterations: steps of any kind;
 * max_step: longest single step (@{unit}, angles times the size). Both are above 0 and
 * their sum at most @{farthest} (a thousand sizes), else the status is @{P}_OUT_OF_RANGE, of NaN and infinity @{P}_NONFINITE;
 * 0 iterations are @{P}_MAX_ITERATIONS. NULL in place of a config means the values below. */
typedef struct {
    @{p}_real tolerance;
    uint8_t max_iterations;
    @{p}_real max_step;
} @{p}_config;

#define @{P}_SIZE ((@{p}_real)@{size}) /* largest distance of joint points at the reference, @{unit} */
#define @{P}_TOLERANCE ((@{p}_real)@{tolerance}) /* @{unit} */
#define @{P}_MAX_STEPS (100U)
#define @{P}_MAX_STEP ((@{p}_real)@{max_step}) /* @{unit} */
#define @{P}_JOINTS (@{nq})

/* iterations: steps taken; residual: largest closure error of the answer@{of_track}, in
 * @{unit}; step: @{pivot_words}; joint: the first joint, from 0, whose value is outside its range or not finite, @{P}_JOINTS where it is none
 * of them. Written by every call, whatever its status. */
typedef struct {
    uint8_t iterations;
    @{p}_real residual;
    @{p}_real step;
    @{p}_real min_pivot;
    uint8_t joint;
} @{p}_info;

@{geometry}
@{declarations}
#ifdef __cplusplus
}
#endif

#endif
