/* Floating-point traps, of division by zero (TRAPS at least 1), of overflow (2), and of invalid operations where all inputs are finite; a trap ends the
 * program with the place in the source, as a result that should not have been answered does. Of each function how often it was answered, divided by
 * zero, overflowed, was invalid. */
#include <fenv.h>
#include <stdlib.h>

static uint32_t seen[MOST_FUNCTIONS][4];

static void begin(void)
{
    (void)feclearexcept(FE_ALL_EXCEPT);
    if (TRAPS > 0) {
        (void)feenableexcept(FE_DIVBYZERO | ((TRAPS > 1) ? FE_OVERFLOW : 0) | (of_finite ? FE_INVALID : 0));
    }
}

static void finish(void)
{
    (void)fedisableexcept(FE_ALL_EXCEPT);
}

static void end(int function, int status, int finite, long number, double error)
{
    const uint32_t told[2] = { (uint32_t)number, (uint32_t)status };
    (void)error;
    seen[function][0] += (status == 0);
    seen[function][1] += fetestexcept(FE_DIVBYZERO) != 0;
    seen[function][2] += fetestexcept(FE_OVERFLOW) != 0;
    seen[function][3] += of_finite && (fetestexcept(FE_INVALID) != 0);
    if ((status < 0) || (status > 5) || ((status == 0) && !finite)) {
        board_text("input and status (of OK: a result is not finite), ");
        tell(names[function], told, 2);
        exit(1);
    }
}

static int next_input(inputs *in, long k)
{
    fill(in);
    return k < COUNT;
}

static void report(long count)
{
    (void)count;
    for (int f = 0; f < functions; ++f) {
        tell(names[f], seen[f], 4);
    }
}
