/* Hooks of codegen/bench/drive.c: each number in turn is no number, or so large that its square overflows, among good ones (the first vector) and
 * among wrong ones. Says what a function that reads it answered otherwise than NONFINITE, or by OK. */
#include <stdlib.h>

#define NONFINITE 3
static int slot;
static int bad;
static int failures;

static void begin(void)
{
}

static void finish(void)
{
}

static void end(int function, int status, int finite, long number, double error)
{
    /* of these one says how many there are, of one the branch may be wrong too */
    const int is_other = (strcmp(names[function], "inverse_all") == 0) || (strcmp(names[function], "inverse_branch") == 0);
    /* answers next to a guess may be as large as that; rates and limits may be of any size */
    const int may_be_ok = (slot >= TWIST) || (strcmp(names[function], "inverse_nearest") == 0 && slot == GUESS);
    const int refused = (bad < 3) ? (status == NONFINITE) : (status > 0) || may_be_ok;
    const uint32_t told[4] = { (uint32_t)slot, (uint32_t)bad, (uint32_t)number, (uint32_t)status };
    (void)error;
    if ((((reads >> slot) & 1) != 0 && !is_other && !refused) || (status == 0 && !finite)) {
        ++failures;
        tell(names[function], told, 4);
    }
}

static int next_input(inputs *in, long k)
{
    const double huge = sizeof(real) == 4 ? 3e38 : 1e200;
    const double values[5] = { NAN, INFINITY, -INFINITY, huge, 1e20 };
    int at = (int)(k / 10);
    bad = (int)(k / 2 % 5);
    of_vectors(in, 0, 0.0);
    in->usual = 1;
    in->settings.tolerance = TOLERANCE;
    EACH(s, i, SLOTS)
    {
        in->v[s][i] = (k % 2 == 0) ? ((s >= TWIST) ? (real)0 : in->v[s][i]) : (real)9e9;
    }
    for (slot = 0; (slot < SLOTS) && (at >= counts[slot]); ++slot) {
        at -= counts[slot];
    }
    if (slot < SLOTS) {
        in->v[slot][at] = (real)values[bad];
    }
    return slot < SLOTS;
}

static void report(long count)
{
    (void)count;
    if (failures != 0) {
        exit(1);
    }
}
