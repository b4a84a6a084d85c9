/* @{title}
 * @{stamp}
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#if defined(__GNUC__)
#define @{P}_COLD __attribute__((noinline, cold, unused))
#define @{P}_SHARED __attribute__((noinline))
#else
#define @{P}_COLD
#define @{P}_SHARED
#endif
#if defined(__GNUC__) && !defined(__clang__) && (__GNUC__ >= 8)
/* GCC 12 takes what nested loops of such a function store to be less than it is */
#define @{P}_ALONE __attribute__((noipa))
#else
#define @{P}_ALONE
#endif

/* The status of refused input: NONFINITE where one of the values is NaN or infinite, else `otherwise`. */
static @{P}_COLD @{p}_status @{p}_check_finite(const @{real} values[], int count, @{p}_status otherwise)
{
    @{p}_status status = otherwise;
    for (int i = 0; i < count; ++i) {
        const @{real} none = values[i] - values[i]; /* 0, but NaN for NaN and infinities */
        if (!(none <= @{zero})) {
            status = @{P}_NONFINITE;
        }
    }
    return status;
}

