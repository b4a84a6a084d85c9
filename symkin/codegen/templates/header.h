/* @title
 * @stamp
 * SPDX-License-Identifier: MIT
 *
@about
 */
#ifndef NAME_H
#define NAME_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef @ctype name_real;

/* What a call came to. Results are written with NAME_OK only. */
typedef enum {
    NAME_OK = 0,
    NAME_MAX_ITERATIONS, /* not settled within the iterations allowed */
    NAME_SINGULAR, /* the linear system lost rank on the way */
    NAME_NONFINITE, /* NaN or infinity among the inputs */
    NAME_OUT_OF_RANGE, /* joint values or results outside their ranges, or a pose that cannot be taken */
    NAME_WRONG_BRANCH /* not assured that the machine reaches the answer from the guess along the line */
} name_status;
@pose_type

/* tolerance: predicted error of the answer (@unit, angles times the size); max_iterations: steps of any kind;
 * max_step: longest single step (@unit, angles times the size). Both are above 0 and
 * their sum at most @farthest (a thousand sizes), else the status is NAME_OUT_OF_RANGE, of NaN and infinity NAME_NONFINITE;
 * 0 iterations are NAME_MAX_ITERATIONS. NULL in place of a config means the values below. */
typedef struct {
    name_real tolerance;
    uint8_t max_iterations;
    name_real max_step;
} name_config;

#define NAME_SIZE ((name_real)@size) /* largest distance of joint points at the reference, @unit */
#define NAME_TOLERANCE ((name_real)@tolerance) /* @unit */
#define NAME_MAX_STEPS (100U)
#define NAME_MAX_STEP ((name_real)@max_step) /* @unit */
#define NAME_JOINTS (@nq)

/* iterations: steps taken; residual: largest closure error of the answer@of_track, in
 * @unit; step: @pivot_words; joint: the first joint, from 0, whose value is outside its range or not finite, NAME_JOINTS where it is none
 * of them. Written by every call, whatever its status. */
typedef struct {
    uint8_t iterations;
    name_real residual;
    name_real step;
    name_real min_pivot;
    uint8_t joint;
} name_info;

@geometry
@declarations
#ifdef __cplusplus
}
#endif

#endif
