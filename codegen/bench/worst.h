/* Searches the inputs that take most instructions without a config: every second is the dearest so far of one function with some of its numbers
 * changed, until MOST_TICKS of all calls together. Of each function ticks and bytes of stack touched; how many inputs there were. */
#define PAINTED 16384
#define PAINT 0xA5u

static uint32_t begun_at;
static uint32_t last;
static uint32_t most[MOST_FUNCTIONS][2];
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

static void finish(void)
{
    last = (board_ticks() - begun_at) & 0xFFFFFFu;
}

static uint32_t touched(void)
{
    uint32_t deepest = PAINTED - 1;
    while ((deepest > 64u) && (*(top - deepest) == PAINT)) {
        --deepest;
    }
    return deepest;
}

static void end(int function, int status, int finite, long number, double error)
{
    (void)status, (void)finite, (void)number, (void)error;
    total += last;
    if (painting) {
        const uint32_t depth = touched();
        most[function][1] = (depth > most[function][1]) ? depth : most[function][1];
    } else if (last > most[function][0]) {
        most[function][0] = last;
        dearest[function] = *current;
    }
}

static void vary(inputs *in, int function)
{
    const int turns = below(2);
    *in = dearest[function];
    EACH(s, i, SLOTS)
    {
        if ((below(3) == 0) && ((s != POSE) || (i < 3) || turns)) {
            const unsigned long long digits = 1ULL << (next() % 24ULL);
            real *const v = &in->v[s][i];
            *v += (real)(uniform() / (double)digits) * (real)fmax(fabs((double)*v), 0.01);
        }
    }
    if ((POSES > 0) && turns) {
        unit_length(&in->v[POSE][3]);
    }
}

static int next_input(inputs *in, long k)
{
    current = in;
    if ((k % 2L == 0L) || (functions == 0)) {
        fill(in);
    } else {
        vary(in, (int)((k / 2L) % functions));
    }
    in->usual = 1;
    return (k < COUNT) && (total < MOST_TICKS);
}

static void report(long count)
{
    const uint32_t inputs_told[2] = { (uint32_t)count, 0u };
    painting = 1;
    for (int f = 0; f < functions; ++f) {
        call_all(&dearest[f], 0);
    }
    for (int f = 0; f < functions; ++f) {
        tell(names[f], most[f], 2);
    }
    tell("inputs", inputs_told, 2);
}
