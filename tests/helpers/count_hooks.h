/* Hooks of codegen/bench/drive.c, in C++: the most operations of any kind in one call without a config, as counted.h counts them. */
static uint32_t most[MOST_FUNCTIONS][OPERATIONS];
static tally last;

static void begin(void)
{
    counted = tally();
}

static void finish(void)
{
    last = counted;
}

static void end(int function, int, int, long, double)
{
    for (int k = 0; k < OPERATIONS; ++k) {
        most[function][k] = (last.of[k] > most[function][k]) ? last.of[k] : most[function][k];
    }
}

static int next_input(inputs *in, long k)
{
    fill(in);
    in->usual = 1;
    return k < COUNT;
}

static void report(long)
{
    for (int f = 0; f < functions; ++f) {
        tell(names[f], most[f], OPERATIONS);
    }
}
