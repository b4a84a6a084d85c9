/* Calls every function of a generated folder with many inputs.
 *
 * HOOKS names a header that says what for. It defines what is done with a call: `begin` before it, `finish` after it, `end` with what it gave;
 * `next_input`, which makes input number k and returns 0 where there is none; `report`, at the end. Here: cases.h (each vector of the folder),
 * worst.h (the dearest inputs), fuzz.h (floating-point traps). calls.h (calls.py) has the folder's vectors and CALLS, the calls. Macros: SEED,
 * COUNT (inputs), ONLY (one function's name). Results are said by `board.h`, on boards and hosts. */
#define _GNU_SOURCE
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include "board.h"
#include "calls.h"

#ifndef ONLY
#define ONLY ""
#endif
#ifndef SEED
#define SEED 0
#endif
#define KINDS 10
#define MOST_FUNCTIONS 12
#define MOST_RESULTS 600 /* numbers of a result: branches of an arm times its joints */
#define WANTED(name) ((ONLY[0] == '\0') || (strcmp(ONLY, name) == 0))

/* What a call is given; the first ones as in `vectors`. */
enum { JOINTS, GUESS, POSE, FOUND, FOUND_GUESS, TO, TWIST, RATES, LIMITS, FOUND_RATES, SLOTS };
#define GIVEN TO /* slots that are varied */
#define WIDEST 24
static const int counts[SLOTS] = { N, N, POSES, FOUND_COUNT, FOUND_COUNT, POSES, 6, N, N, FOUND_COUNT };
#define EACH(s, i, slots)             \
    for (int s = 0; s < (slots); ++s) \
        for (int i = 0; i < counts[s]; ++i)

typedef struct {
    real v[SLOTS][WIDEST];
    config settings;
    int usual; /* whether the call has no config */
} inputs;

static const char *names[MOST_FUNCTIONS];
static int functions;
static int of_finite; /* whether this input has finite numbers only */
static int reads; /* slots that a function reads, as bits */

static void begin(void);
static void finish(void);
/* finite: whether what OK came with is; error: how far the first result is from the vector's answer. */
static void end(int function, int status, int finite, long number, double error);
static int next_input(inputs *in, long k);
static void report(long count);

static void tell(const char *name, const uint32_t *numbers, int count)
{
    board_text(name);
    for (int i = 0; i < count; ++i) {
        board_text(" ");
        board_number(numbers[i]);
    }
    board_text("\n");
}

/* --- random numbers --- */

static unsigned long long state;

static unsigned long long next(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static int below(int count)
{
    return (int)(next() % (unsigned long long)count);
}

/* -1 to 1 */
static double uniform(void)
{
    return (double)(next() >> 11) * 0x1p-53 * 2.0 - 1.0;
}

static real ordinary(double scale)
{
    return (real)(scale * uniform());
}

/* A finite number of any size. */
static real any_size(double scale)
{
    const double most = log10(sizeof(real) == 4 ? (double)FLT_MAX : DBL_MAX);
    const double least = log10(sizeof(real) == 4 ? 1e-45 : 5e-324);
    const double size = pow(10.0, least + (most - least) * 0.4999 * (uniform() + 1.0));
    (void)scale;
    return (real)((below(2) == 0) ? size : -size);
}

/* NaN, infinities, zeros, the largest and least numbers, or a number of any size. */
static real special(void)
{
    const double most = sizeof(real) == 4 ? (double)FLT_MAX : DBL_MAX;
    const double least = sizeof(real) == 4 ? 1e-45 : 5e-324;
    const double values[10] = { NAN, INFINITY, -INFINITY, 0.0, -0.0, most, -most, least, -least, 1.0 };
    const int kind = below(14);
    return (kind < 10) ? (real)values[kind] : any_size(0.0);
}

static real ordinary_or_special(double scale)
{
    return (below(4) == 0) ? special() : ordinary(scale);
}

/* Multiples of an eighth turn or of a quarter of the size: where linear systems lose rank. */
static real lattice(double step)
{
    const double off = (below(2) == 0) ? 0.0 : pow(10.0, -8.0 - 8.0 * fabs(uniform())) * uniform();
    return (real)(step * (double)(below(17) - 8) + off);
}

/* --- random inputs --- */

static double vector(int slot, int k, int i)
{
    return (double)vectors[slot][k * counts[slot] + i];
}

/* A vector, its numbers off by a share of them, positions of the size; another goal of lines. */
static void of_vectors(inputs *in, int k, double relative)
{
    EACH(s, i, GIVEN + 1)
    {
        const double value = vector(s, (s == TO) ? below(VECTORS) : k, i);
        const double unit = (s == POSE && i < 3) ? (double)SIZE * relative : (s == POSE) ? fmin(relative, 2e-3) : (fabs(value) + 0.1) * relative;
        in->v[s][i] = (real)(value + ((s == TO) ? 0.0 : unit * uniform()));
    }
}

static void of_vector(inputs *in, double relative)
{
    of_vectors(in, below(VECTORS), relative);
}

static void unit_length(real *q)
{
    double squared = 0.0;
    for (int i = 0; i < 4; ++i) {
        squared += (double)q[i] * (double)q[i];
    }
    for (int i = 0; i < 4; ++i) {
        q[i] = (real)((squared > 1e-6 && squared < 1e6) ? (double)q[i] / sqrt(squared) : (double)(i == 0));
    }
}

/* Every number of the joints, the guess and the position by a function of its scale, the quaternion of unit length or not. */
static void all_by(inputs *in, real (*number)(double), double angle, double length, int is_unit)
{
    EACH(s, i, GIVEN)
    {
        const int is_length = (s == POSE) ? (i < 3) : (s == JOINTS || s == FOUND) && below((FOUND_COUNT > 0) ? 4 : 2) == 0;
        in->v[s][i] = number(is_length ? length : (s == POSE) ? 1.0 : angle);
    }
    if (is_unit) {
        unit_length(&in->v[POSE][3]);
    }
}

/* Values on the line from one vector's to another's and up to some times its length beyond, so that many lines end where the machine
 * cannot go and are cut until a config's iterations are used up. */
static void of_line(inputs *in)
{
    const int a = below(VECTORS), b = below(VECTORS), c = below(VECTORS);
    const double reach = 4.0 * pow(10.0, -2.0 * fabs(uniform())) * uniform();
    EACH(s, i, GIVEN)
    {
        const double from = vector(s, a, i), way = reach * (vector(s, b, i) - from);
        const int is_third = (s == POSE) || (s == FOUND_GUESS) || (s == GUESS && below(2) == 0);
        in->v[s][i] = (real)(is_third ? vector(s, c, i) : (s == GUESS) ? from - way : from + way);
    }
}

/* Whole turns away from a vector's values: sines of large angles take longest. */
static void of_turns(inputs *in)
{
    of_vector(in, pow(10.0, -6.0 * fabs(uniform())));
    EACH(s, i, GIVEN)
    {
        if (s != POSE) {
            in->v[s][i] += (real)(6.283185307179586 * floor(160.0 * uniform()));
        }
    }
}

/* One number that is not finite, or as large or small as can be. */
static void of_one_special(inputs *in)
{
    int s = below(GIVEN);
    of_vector(in, 1e-3);
    s = (counts[s] > 0) ? s : JOINTS;
    in->v[s][below(counts[s])] = special();
}

static void of_other_guess(inputs *in)
{
    of_vector(in, pow(10.0, -3.0 * fabs(uniform())));
    for (int i = 0; i < N; ++i) {
        in->v[GUESS][i] = (below(2) == 0) ? in->v[JOINTS][i] : lattice(0.78539816339744831);
    }
}

static void fill(inputs *in)
{
    const int kind = below(KINDS);
    const double size = (double)SIZE;
    of_vector(in, 0.0);
    switch (kind) {
    case 0:
    case 1: all_by(in, ordinary_or_special, 3.2, 2.0 * size, kind); break;
    case 2: of_vector(in, pow(10.0, -12.0 * fabs(uniform()))); break;
    case 3: of_one_special(in); break;
    case 4: all_by(in, ordinary, 3.2, 1.5 * size, 1); break;
    case 5: all_by(in, lattice, 0.78539816339744831, 0.25 * size, 1); break;
    case 6: all_by(in, any_size, 1.0, 1.0, 1); break;
    case 8: of_line(in); break;
    case 9: of_turns(in); break;
    default: of_other_guess(in); break;
    }
    for (int s = TWIST; s < SLOTS; ++s) {
        for (int i = 0; i < counts[s]; ++i) {
            in->v[s][i] = (kind % 2 == 0) ? ordinary_or_special(size) : (s == LIMITS) ? (real)(0.1 * size * fabs(uniform())) : ordinary(size);
        }
    }
    in->usual = (below(4) != 0);
    in->settings.tolerance = (below(2) == 0) ? TOLERANCE : special();
    in->settings.max_iterations = (uint8_t)((below(2) == 0) ? MAX_STEPS : next() % 256ULL);
    in->settings.max_step = (below(2) == 0) ? MAX_STEP : special();
}

/* --- calls --- */

static int all_finite(const real *v, int n)
{
    int found = 1;
    for (int i = 0; i < n; ++i) {
        found = found && isfinite(v[i]);
    }
    return found;
}

/* Results begin as the values that functions move from, or as zeros. */
static void begun(real *result, const real *from, int count)
{
    for (int i = 0; i < count; ++i) {
        result[i] = (from != NULL && i < WIDEST) ? from[i] : (real)0;
    }
}

/* How far a result is from a vector's answer, of poses their positions, of lists the nearest row. */
static inline double off(const real *result, int slot, long number, int rows)
{
    double least = (slot < 0 || answers[slot] == NULL) ? 0.0 : 4e9;
    for (int row = 0; (least > 0.0) && (row < rows); ++row) {
        double most = 0.0;
        for (int i = 0; i < ((slot == POSE) ? 3 : counts[slot]); ++i) {
            const int at = counts[slot] * row + i;
            most = fmax(most, fabs((double)result[at] - (double)answers[slot][counts[slot] * (number % VECTORS) + i]));
        }
        least = fmin(least, most);
    }
    return least;
}

static void call_all(const inputs *in, long number)
{
    const config *const settings = in->usual ? NULL : &in->settings;
    static real result[2][MOST_RESULTS];
    INFO info;
    int function = 0;
    int status;
    of_finite = isfinite(in->settings.tolerance) && isfinite(in->settings.max_step);
    for (int s = 0; s < SLOTS; ++s) {
        of_finite = of_finite && all_finite(in->v[s], counts[s]);
    }
    CALLS
    functions = function;
}

#include HOOKS

int main(void)
{
    static inputs in;
    long k = 0;
    state = 88172645463325252ULL + 7919ULL * (unsigned long long)SEED;
    board_start_counter();
    for (; next_input(&in, k) != 0; ++k) {
        call_all(&in, k);
    }
    report(k);
    return 0;
}
