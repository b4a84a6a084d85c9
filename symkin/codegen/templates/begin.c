/* @title
 * @stamp
 * SPDX-License-Identifier: MIT */
#include "@p.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#if defined(__GNUC__)
#define NAME_COLD __attribute__((noinline, cold, unused))
#define NAME_SHARED __attribute__((noinline))
#else
#define NAME_COLD
#define NAME_SHARED
#endif
#if defined(__GNUC__) && !defined(__clang__) && (__GNUC__ >= 8)
/* GCC 12 takes what nested loops of such a function store to be less than it is */
#define NAME_ALONE __attribute__((noipa))
#else
#define NAME_ALONE
#endif

/* The status of refused input: NONFINITE where one of the values is NaN or infinite, else `otherwise`. */
static NAME_COLD name_status name_check_finite(const name_real values[], int count, name_status otherwise)
{
    name_status status = otherwise;
    EACH(i, count) {
        const name_real none = values[i] - values[i]; /* 0, but NaN for NaN and infinities */
        if (!(none <= 0.0)) {
            status = NAME_NONFINITE;
        }
    }
    return status;
}

