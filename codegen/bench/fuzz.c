/* Sends random inputs to every function of a generated folder, with floating-point traps, and says what should not have been
 * answered. fuzz.py builds it under sanitizers; a trap ends it with the place in the source.
 *
 *     fuzz COUNT SEED trap|division|count
 *
 * Macros: inputs.h. `division` traps no overflow; `count` traps nothing. All print how often each function raises which exception. */
#define _GNU_SOURCE
#include "inputs.h"
#include <fenv.h>
#include <stdio.h>
#include <stdlib.h>

static int trapping;
static long raised[MOST_FUNCTIONS][3];
static long answered[MOST_FUNCTIONS];
static const char *names[MOST_FUNCTIONS];

static void begin(void)
{
    (void)feclearexcept(FE_ALL_EXCEPT);
    if (trapping) {
        (void)feenableexcept(FE_DIVBYZERO | ((trapping > 1) ? FE_OVERFLOW : 0) | (of_finite ? FE_INVALID : 0));
    }
}

static void finish(void)
{
    (void)fedisableexcept(FE_ALL_EXCEPT);
}

/* Ends a call: its exceptions, and whether OK came with finite results; anything else ends the program. */
static void end(int function, const char *name, int status, int finite, long number)
{
    names[function] = name;
    raised[function][0] += fetestexcept(FE_DIVBYZERO) != 0;
    raised[function][1] += fetestexcept(FE_OVERFLOW) != 0;
    raised[function][2] += of_finite && (fetestexcept(FE_INVALID) != 0);
    answered[function] += (status == 0);
    if ((status < 0) || (status > 5) || ((status == 0) && !finite)) {
        (void)printf("input %ld, %s: status %d%s\n", number, name, status, finite ? "" : " with a result that is not finite");
        exit(1);
    }
}

int main(int argc, char **argv)
{
    const long count = (argc > 1) ? atol(argv[1]) : 1000L;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)((argc > 2) ? atol(argv[2]) : 0L);
    trapping = ((argc <= 3) || (strcmp(argv[3], "trap") == 0)) ? 2 : (strcmp(argv[3], "division") == 0) ? 1 : 0;
    for (long k = 0; k < count; ++k) {
        inputs in;
        fill(&in, (int)(next() % (unsigned long long)KINDS));
        call_all(&in, k);
    }
    for (int f = 0; (f < MOST_FUNCTIONS) && (names[f] != NULL); ++f) {
        (void)printf("%s: %ld answered; division %ld, overflow %ld, invalid %ld\n", names[f], answered[f], raised[f][0], raised[f][1], raised[f][2]);
    }
    return 0;
}
