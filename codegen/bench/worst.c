/* Searches the inputs that take most instructions in each function of a generated folder, on a board of `targets/`: random ones of all
 * kinds (inputs.h) and, every second, the dearest so far of one function with some of its numbers changed. Without a config.
 *
 * Macros: inputs.h, SEED, MOST_INPUTS, MOST_TICKS (of all calls together). Prints a line of ticks and bytes of stack touched for each function, and
 * how many inputs. */
#include "inputs.h"
#include "board.h"

#define PAINTED 16384
#define PAINT 0xA5u

static int functions;
static const char *names[MOST_FUNCTIONS];
static uint32_t most[MOST_FUNCTIONS];
static uint32_t touched[MOST_FUNCTIONS];
static inputs dearest[MOST_FUNCTIONS];
static const inputs *current;
static uint32_t begun;
static uint32_t last;
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
    begun = board_ticks();
}

static void __attribute__((noinline)) finish(void)
{
    last = (board_ticks() - begun) & 0xFFFFFFu;
}

static void end(int function, const char *name, int status, int finite, long number)
{
    (void)status;
    (void)finite;
    (void)number;
    names[function] = name;
    functions = (function >= functions) ? function + 1 : functions;
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

static void changed(real *values, int count)
{
    for (int i = 0; i < count; ++i) {
        if (next() % 3ULL == 0ULL) {
            const unsigned long long digits = 1ULL << (next() % 24ULL);
            values[i] += (real)(uniform() / (double)digits) * (real)fmax(fabs((double)values[i]), 0.01);
        }
    }
}

/* The dearest input of a function with some of its numbers changed. */
static void vary(inputs *in, int function)
{
    *in = dearest[function];
    changed(in->joints, N);
    changed(in->guess, N);
    changed(in->found, FOUND);
    changed(in->found_guess, FOUND);
    changed(in->twist, 6);
    changed(in->rates, N);
    changed(in->limits, N);
#ifndef MAP
    changed(in->pose.position, 3);
    if (next() % 2ULL == 0ULL) {
        double squared = 0.0;
        changed(in->pose.quaternion, 4);
        for (int i = 0; i < 4; ++i) {
            squared += (double)in->pose.quaternion[i] * (double)in->pose.quaternion[i];
        }
        for (int i = 0; (i < 4) && (squared > 0.01); ++i) {
            in->pose.quaternion[i] = (real)((double)in->pose.quaternion[i] / sqrt(squared));
        }
    }
#endif
}

int main(void)
{
    static inputs in;
    long count = 0;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)SEED;
    current = &in;
    board_start_counter();
    while ((count < MOST_INPUTS) && (total < MOST_TICKS)) {
        if ((count % 2L == 0L) || (functions == 0)) {
            fill(&in, (int)(next() % (unsigned long long)KINDS));
        } else {
            vary(&in, (int)((count / 2L) % functions));
        }
        in.usual = 1;
        call_all(&in, count);
        ++count;
    }
    painting = 1;
    for (int f = 0; f < functions; ++f) {
        call_all(&dearest[f], 0);
    }
    for (int f = 0; f < functions; ++f) {
        board_text(names[f]);
        board_text(" ");
        board_number(most[f]);
        board_text(" ");
        board_number(touched[f]);
        board_text("\n");
    }
    board_text("inputs ");
    board_number((uint32_t)count);
    board_text("\n");
    return 0;
}
