/* Counts what calls without a config do, of a generated folder whose numbers are counted.h's: the most operations of any kind in one call of each
 * function, over random inputs of all kinds.
 *
 *     counts COUNT SEED
 *
 * Macros: inputs.h, NUMBER, SOURCE (the folder's source). Prints for each function its name, additions, multiplications, divisions, sqrt, sin, cos,
 * atan2. */
#include "counted.h"
#include SOURCE
#include "inputs.h"
#include <stdio.h>
#include <stdlib.h>

static const char *names[MOST_FUNCTIONS];
static tally most[MOST_FUNCTIONS];
static int functions;
static tally last;

static void begin(void)
{
    counted = tally();
}

static void finish(void)
{
    last = counted;
}

static void raise(long *value, long found)
{
    *value = (found > *value) ? found : *value;
}

static void end(int function, const char *name, int status, int finite, long number)
{
    tally *const m = &most[function];
    (void)status;
    (void)finite;
    (void)number;
    names[function] = name;
    functions = (function >= functions) ? function + 1 : functions;
    raise(&m->additions, last.additions);
    raise(&m->multiplications, last.multiplications);
    raise(&m->divisions, last.divisions);
    raise(&m->sqrt, last.sqrt);
    raise(&m->sin, last.sin);
    raise(&m->cos, last.cos);
    raise(&m->atan2, last.atan2);
}

int main(int argc, char **argv)
{
    const long count = (argc > 1) ? atol(argv[1]) : 1000L;
    static inputs in;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)((argc > 2) ? atol(argv[2]) : 0L);
    for (long k = 0; k < count; ++k) {
        fill(&in, (int)(next() % (unsigned long long)KINDS));
        in.usual = 1;
        call_all(&in, k);
    }
    for (int f = 0; f < functions; ++f) {
        const tally m = most[f];
        (void)printf("%s %ld %ld %ld %ld %ld %ld %ld\n", names[f], m.additions, m.multiplications, m.divisions, m.sqrt, m.sin, m.cos, m.atan2);
    }
    return 0;
}
