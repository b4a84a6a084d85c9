/* Sends random inputs to every function of a generated folder, or its vectors, as one of four:
 *
 * FUZZ, `drive COUNT SEED trap|division|count`: with floating-point traps, on processors that have them; fuzz.py builds it under sanitizers, a
 *   trap ends it with the place in the source. `division` traps no overflow, `count` nothing. Says what should not have been answered, and how
 *   often each function raises which exception.
 * COUNTS, `drive COUNT SEED` (C++, SOURCE: the folder's source, whose numbers are counted.h's): the most operations of any kind in one call
 *   without a config: additions, multiplications, divisions, sqrt, sin, cos, atan2.
 * CASES (ONLY: one function's name, or ""), on any processor with `board.h`: every vector of the folder, from where its own test starts. Of each
 *   call its name, the vector, ticks, and how far the result is from the answer in 1e-12 and 1e-6.
 * WORST (SEED, MOST_INPUTS, MOST_TICKS of all calls together), on a board of `targets/`: searches the inputs that take most instructions without
 *   a config; every second is the dearest so far of one function with some of its numbers changed. Ticks and bytes of stack touched, and how many
 *   inputs there were. */
#define _GNU_SOURCE
#ifdef COUNTS
#include "counted.h"
#include SOURCE
#endif
#include "inputs.h"
#include <stdio.h>
#include <stdlib.h>

static const char *names[MOST_FUNCTIONS];
static int functions;

static void named(int function, const char *name)
{
    names[function] = name;
    functions = (function >= functions) ? function + 1 : functions;
}

#ifdef FUZZ
#include <fenv.h>

static int trapping;
static long raised[MOST_FUNCTIONS][3];
static long answered[MOST_FUNCTIONS];

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
static void end(int function, const char *name, int status, int finite, long number, double error)
{
    (void)error;
    named(function, name);
    raised[function][0] += fetestexcept(FE_DIVBYZERO) != 0;
    raised[function][1] += fetestexcept(FE_OVERFLOW) != 0;
    raised[function][2] += of_finite && (fetestexcept(FE_INVALID) != 0);
    answered[function] += (status == 0);
    if ((status < 0) || (status > 5) || ((status == 0) && !finite)) {
        (void)printf("input %ld, %s: status %d%s\n", number, name, status, finite ? "" : " with a result that is not finite");
        exit(1);
    }
}

static void tell(int f)
{
    (void)printf("%s: %ld answered; division %ld, overflow %ld, invalid %ld\n", names[f], answered[f], raised[f][0], raised[f][1], raised[f][2]);
}
#elif defined(COUNTS)
static tally most[MOST_FUNCTIONS];
static tally last;

static void begin(void)
{
    counted = tally();
}

static void finish(void)
{
    last = counted;
}

static void end(int function, const char *name, int, int, long, double)
{
    named(function, name);
    for (int k = 0; k < OPERATIONS; ++k) {
        most[function].of[k] = (last.of[k] > most[function].of[k]) ? last.of[k] : most[function].of[k];
    }
}

static void tell(int f)
{
    (void)printf("%s", names[f]);
    for (int k = 0; k < OPERATIONS; ++k) {
        (void)printf(" %ld", most[f].of[k]);
    }
    (void)printf("\n");
}
#else
#include "board.h"

static uint32_t begun_at;
static uint32_t last;
#ifdef CASES
static void begin(void)
{
    begun_at = board_ticks();
}
#else
#define PAINTED 16384
#define PAINT 0xA5u

static uint32_t most[MOST_FUNCTIONS];
static uint32_t touched[MOST_FUNCTIONS];
static inputs dearest[MOST_FUNCTIONS];
static const inputs *current;
static uint64_t total;
static int painting;
static volatile uint8_t *top;

static void __attribute__((noinline)) begin(void)
{
    if (painting) {
        top = (volatile uint8_t *)__builtin_frame_address(0);
        for (int i = 64; i < PAINTED; ++i) {
            *(top - i) = PAINT;
        }
    }
    begun_at = board_ticks();
}

#endif

static void finish(void)
{
    last = (board_ticks() - begun_at) & 0xFFFFFFu;
}

#ifdef CASES
static void end(int function, const char *name, int status, int finite, long number, double error)
{
    const double off_by = (status == 0) ? error : 4e9;
    const uint32_t told[] = { (uint32_t)number, last, (uint32_t)fmin(off_by * 1e12, 4e9), (uint32_t)fmin(off_by * 1e6, 4e9) };
    (void)finite;
    named(function, name);
    board_text(name);
    for (int i = 0; i < 4; ++i) {
        board_text(" ");
        board_number(told[i]);
    }
    board_text("\n");
}
#else

static void end(int function, const char *name, int status, int finite, long number, double error)
{
    (void)status;
    (void)finite;
    (void)number;
    (void)error;
    named(function, name);
    total += last;
    if (painting) {
        uint32_t deepest = PAINTED - 1;
        while ((deepest > 64u) && (*(top - deepest) == PAINT)) {
            --deepest;
        }
        touched[function] = (deepest > touched[function]) ? deepest : touched[function];
    } else if (last > most[function]) {
        most[function] = last;
        dearest[function] = *current;
    }
}

/* The dearest input of a function with some of its numbers changed. */
static void vary(inputs *in, int function)
{
    const int turns = below(2);
    *in = dearest[function];
    for (int s = 0; s < SLOTS; ++s) {
        real *const v = in->v[s];
        for (int i = 0; i < counts[s]; ++i) {
            if ((below(3) == 0) && ((s != POSE) || (i < 3) || turns)) {
                const unsigned long long digits = 1ULL << (next() % 24ULL);
                v[i] += (real)(uniform() / (double)digits) * (real)fmax(fabs((double)v[i]), 0.01);
            }
        }
    }
    if ((POSES > 0) && turns) {
        unit_length(&in->v[POSE][3]);
    }
}
#endif
#endif

#if defined(CASES)
int main(void)
{
    static inputs in;
    in.usual = 1;
    board_start_counter();
    for (int k = 0; k < VECTORS; ++k) {
        of_vectors(&in, k, 0.0);
        for (int s = 0; s < SLOTS; ++s) {
            for (int i = 0; (starts[s] != NULL) && (i < counts[s]); ++i) {
                in.v[s][i] = starts[s][counts[s] * k + i];
            }
        }
        call_all(&in, k);
    }
    return 0;
}
#elif defined(WORST)
int main(void)
{
    static inputs in;
    long count = 0;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)SEED;
    current = &in;
    board_start_counter();
    for (; (count < MOST_INPUTS) && (total < MOST_TICKS); ++count) {
        if ((count % 2L == 0L) || (functions == 0)) {
            fill(&in, below(KINDS));
        } else {
            vary(&in, (int)((count / 2L) % functions));
        }
        in.usual = 1;
        call_all(&in, count);
    }
    painting = 1;
    for (int f = 0; f < functions; ++f) {
        call_all(&dearest[f], 0);
    }
    for (int f = 0; f <= functions; ++f) {
        board_text((f < functions) ? names[f] : "inputs");
        board_text(" ");
        board_number((f < functions) ? most[f] : (uint32_t)count);
        board_text(" ");
        board_number((f < functions) ? touched[f] : 0u);
        board_text("\n");
    }
    return 0;
}
#else
int main(int argc, char **argv)
{
    const long count = (argc > 1) ? atol(argv[1]) : 1000L;
    static inputs in;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)((argc > 2) ? atol(argv[2]) : 0L);
#ifdef FUZZ
    trapping = ((argc <= 3) || (strcmp(argv[3], "trap") == 0)) ? 2 : (strcmp(argv[3], "division") == 0) ? 1 : 0;
#endif
    for (long k = 0; k < count; ++k) {
        fill(&in, below(KINDS));
#ifdef COUNTS
        in.usual = 1;
#endif
        call_all(&in, k);
    }
    for (int f = 0; f < functions; ++f) {
        tell(f);
    }
    return 0;
}
#endif
