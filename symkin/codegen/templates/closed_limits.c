/* Whether a joint may come to a limit from which it is `spare` away at the nearer of two points (over the size of a slide), by a way
 * that is no longer than the root of twice way2. */
static bool @{p}_may_reach(@{real} spare, @{real} way2)
{
    return @{four} * spare * spare < way2;
}

/* Whether a function keeps its sign between two points: it bends away from its chord by no more than the second derivative allows. */
static bool @{p}_keeps_sign(@{real} a, @{real} b, @{real} bend)
{
    const @{real} first = @{fabs}(a);
    const @{real} second = @{fabs}(b);
    const @{real} lesser = (first < second) ? first : second;
    return ((a > @{zero}) == (b > @{zero})) && (bend < @{two} * (first + second) + @{four} * lesser);
}

/* Of each limit a function that is zero where a solution of the joint's step has that value, and one that is negative where it is the
 * other solution (README.md). */
static void @{p}_limit_values(const @{real} joints[@{nn}], @{real} at[@{values}])
{
    @{real} u[@{turns}];
@{turned}
@{read}
}

/* The first joint, from 0, that is not proved to keep its limits between two points a and b of the line, both within them; the number
 * of joints where all are. */
static uint8_t @{p}_first_leaving(const @{real} a[@{nn}], const @{real} b[@{nn}], @{real} place, @{real} turn, const @{real} moved[@{nn}], @{real} way2)
{
    static const @{real} low[@{nn}] = { @{lows} };
    static const @{real} high[@{nn}] = { @{highs} };
    static const @{real} per_length[@{nn}] = { @{per_lengths} };
    @{real} below[@{nn}];
    @{real} above[@{nn}];
    bool near = false;
    uint8_t joint = @{p}_first_beyond(b);
    (void)place;
    (void)turn;
    (void)moved;
    for (int i = 0; i < @{nn}; ++i) {
        below[i] = (((a[i] < b[i]) ? a[i] : b[i]) - low[i]) * per_length[i];
        above[i] = (high[i] - ((a[i] > b[i]) ? a[i] : b[i])) * per_length[i];
        near = near || @{p}_may_reach(below[i], way2) || @{p}_may_reach(above[i], way2);
    }
    if (near && (joint == @{nn}U)) {
        @{real} at_a[@{values}];
        @{real} at_b[@{values}];
        @{p}_limit_values(a, at_a);
        @{p}_limit_values(b, at_b);
@{tests}
    }
    return joint;
}

