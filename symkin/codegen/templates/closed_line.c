/* A point of the line: joints where it is done, which begin at the guess, those found where it is tried, turned and aimed: cosine and sine of each
 * angle from its zero, up to a factor above zero, or the slide and 0, and the squares left and guard of the closed form's steps at both; sign: the
 * guess's branch; way: how far each joint goes from one to the other (angles; slides over the size), way2: the sum of the squares. Of the part
 * between: bounds of the joints' speeds and of how these change, and whether it is kept. */
typedef struct {
    @{real} joints[@{nn}];
    @{real} found[@{nn}];
    @{real} turned[@{nn}][2];
    @{real} aimed[@{nn}][2];
    @{real} sign[@{choices}];
    @{real} way[@{nn}];
    @{real} way2;
    @{real} speed[@{nn}];
    @{real} change[@{nn}];
    bool kept;
@{members}
} @{k}_work;

/* Begins a line at joint values: their tool pose x (x, y, z, qw, qx, qy, qz), the squares of the closed form's steps there (README.md), and the
 * branch on which they lie. */
static void @{k}_begin(@{k}_work *w, const @{real} joints[@{nn}], @{real} x[7])
{
    @{real} u[@{turns}];
    @{p}_half_turns(joints, u);
    @{p}_pose_of_turns(u, x);
    for (int i = 0; i < @{nn}; ++i) {
        w->joints[i] = joints[i];
    }
    w->way2 = @{zero};
    w->left[0] = @{one};
    w->guard[0] = @{one};
@{read}
}

@{joint}@{turn_between}/* The closed form at a tool pose x of the line, on the guess's branch; SINGULAR or OUT_OF_RANGE where that does not reach it. */
static @{p}_status @{k}_reach(@{k}_work *w, const @{real} x[7])
{
    @{p}_status status = @{P}_OUT_OF_RANGE;
@{reach}
    return status;
}

/* The joints at a tool pose x of the line, angles within half a turn of where it is done, and their ways; slides and joints with limits are exact,
 * other angles go on by their ways. */
static @{p}_status @{k}_aim(@{k}_work *w, const @{real} x[7])
{
    const @{p}_status status = @{k}_reach(w, x);
    if (status == @{P}_OK) {
@{way_lines}
    }
    return status;
}

@{helpers}@{limits}/* Whether the joints' last way is within what the config allows@{and_within}. */
static bool @{k}_follows(@{k}_work *w, @{real} most2)
{
    const bool follows = (w->way2 <= most2);
    if (!follows) {
        w->bent = w->way2;
        w->most = most2;
    }
@{limits_kept}
}

@{walk}/* The closed form along the line of tool poses from the guess's to the given one, on the guess's branch. Angles go on from part to part,
 * whole turns included. */
static @{p}_status @{k}_along(const @{real} to[7], const @{p}_config *config, @{real} joints[@{nn}], @{p}_info *info)
{
    @{k}_work work;
    @{k}_work *const w = &work;
    @{real} at[7];
    @{real} least = @{one};
    @{real} residual = @{huge};
    unsigned int count = 0U;
    @{p}_status status = @{P}_OK;
    @{k}_begin(w, joints, at);
    for (int k = 0; k < @{margins}; ++k) {
        if (!(w->left[k] > @{least})) {
            status = @{P}_SINGULAR;
        }
    }
@{guess_beyond}
    if (status == @{P}_OK) {
        const @{real} most2 = config->max_step * config->max_step * @{per_size2};
        status = @{k}_walk(w, at, to, most2, (unsigned int)config->max_iterations, &count);
    }
    for (int k = 0; k < @{margins}; ++k) {
        least = (w->left[k] < least) ? w->left[k] : least;
    }
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nn}; ++i) {
            joints[i] = @{k}_joint(i, w->turned[i], w->joints[i]);
        }
        status = @{p}_hold(to, joints, &residual);
    }
    @{p}_write_info(info, count, residual, w->way2 * @{size2}, (least > @{least}) ? (@{one} / least) : @{zero});
@{blame}
    return status;
}

