/* Every vector of the folder, from where its own test starts. Of each call its name, the vector, ticks, and how far the result is from the answer in
 * 1e-12 and 1e-6. */
static uint32_t begun_at;
static uint32_t last;

static void begin(void)
{
    begun_at = board_ticks();
}

static void finish(void)
{
    last = (board_ticks() - begun_at) & 0xFFFFFFu;
}

static void end(int function, int status, int finite, long number, double error)
{
    const double off_by = (status == 0) ? error : 4e9;
    const uint32_t told[4] = { (uint32_t)number, last, (uint32_t)fmin(off_by * 1e12, 4e9), (uint32_t)fmin(off_by * 1e6, 4e9) };
    (void)finite;
    tell(names[function], told, 4);
}

static int next_input(inputs *in, long k)
{
    if (k >= VECTORS) {
        return 0;
    }
    of_vectors(in, (int)k, 0.0);
    EACH(s, i, SLOTS)
    {
        if (starts[s] != NULL) {
            in->v[s][i] = starts[s][counts[s] * k + i];
        }
    }
    in->usual = 1;
    return 1;
}

static void report(long count)
{
    (void)count;
}
