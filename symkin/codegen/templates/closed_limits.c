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
    @{real} x[7];
    @{p}_half_turns(joints, u);
    @{p}_pose_of_turns(u, x);
@{read}
}

/* The first joint, from 0, that is not proved to keep its limits between two points a and b of the line; the number of joints where all
 * are. */
static uint8_t @{p}_first_leaving(const @{real} a[@{nn}], const @{real} b[@{nn}], const @{real} change[@{nto}], @{real} way2)
{
    static const @{real} low[@{nn}] = { @{lows} };
    static const @{real} high[@{nn}] = { @{highs} };
    static const @{real} per_length[@{nn}] = { @{per_lengths} };
    static const bool limited[@{nn}] = { @{limited} };
    @{real} below[@{nn}] = { @{zero} };
    @{real} above[@{nn}] = { @{zero} };
    bool near = false;
    uint8_t joint = @{nn}U;
    (void)change;
    for (int i = @{last}; i >= 0; --i) {
        if (limited[i]) {
            const bool rises = (a[i] < b[i]);
            below[i] = ((rises ? a[i] : b[i]) - low[i]) * per_length[i];
            above[i] = (high[i] - (rises ? b[i] : a[i])) * per_length[i];
            const @{real} spare = (below[i] < above[i]) ? below[i] : above[i];
            near = near || @{p}_may_reach(spare, way2);
            joint = (spare < @{zero}) ? (uint8_t)i : joint;
        }
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

