/* A point of the line: joints where it is done, which begin at the guess, those found where it is tried, and the squares left and guard of
 * the closed form's steps at both; way: how far each joint goes from one to the other (angles; slides over the size), way2: the sum of the
 * squares. Of the part between: bounds of the joints' speeds and of how these change, and whether it is kept. */
typedef struct {
    @{real} joints[@{nn}];
    @{real} found[1][@{nn}];
    @{real} way[@{nn}];
    @{real} way2;
    @{real} speed[@{nn}];
    @{real} change[@{nn}];
    bool kept;
@{members}
} @{k}_work;

/* Tool pose (x, y, z, qw, qx, qy, qz) of joint values, the squares `margin` of the closed form's steps there (README.md), and the
 * bits of the branch on which they lie. */
static unsigned int @{p}_read_joints(const @{real} joints[@{nn}], @{real} x[7], @{real} margin[@{margins}])
{
    @{real} u[@{turns}];
    unsigned int wanted = 0U;
    @{p}_half_turns(joints, u);
    @{p}_pose_of_turns(u, x);
@{read}
    return wanted;
}

/* The joints at a tool pose x of the line, angles within half a turn of where it is done, and their ways; SINGULAR or OUT_OF_RANGE where
 * the guess's branch does not reach it. */
static @{p}_status @{k}_aim(@{k}_work *w, const @{real} x[7], unsigned int wanted)
{
    static const @{real} per_length[@{nn}] = { @{per_lengths} };
    static const bool angular[@{nn}] = { @{angular} };
    static const @{real} near[@{nears}] = { @{zero} };
    bool undecided = false;
    if (@{p}_branches(x, near, wanted, w->found, &undecided, w->guard) != 1) {
        return undecided ? @{P}_SINGULAR : @{P}_OUT_OF_RANGE;
    }
    w->way2 = @{zero};
    for (int i = 0; i < @{nn}; ++i) {
        @{real} way = w->found[0][i] - w->joints[i];
        const @{real} number = way * @{per_turn};
        if (angular[i] && (@{fabs}(number) > @{half})) {
            way -= @{turn} * (@{real})(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
        }
        w->found[0][i] = w->joints[i] + way;
        w->way[i] = @{fabs}(way) * per_length[i];
        w->way2 += w->way[i] * w->way[i];
    }
    return @{P}_OK;
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
    w->way2 = @{zero};
    w->left[0] = @{one};
    w->guard[0] = @{one};
    const unsigned int wanted = @{p}_read_joints(joints, at, w->left);
    for (int i = 0; i < @{nn}; ++i) {
        w->joints[i] = joints[i];
    }
    for (int k = 0; k < @{margins}; ++k) {
        if (!(w->left[k] > @{least})) {
            status = @{P}_SINGULAR;
        }
    }
@{guess_beyond}
    if (status == @{P}_OK) {
        const @{real} most2 = config->max_step * config->max_step * @{per_size2};
        status = @{k}_walk(w, at, to, wanted, most2, (unsigned int)config->max_iterations, &count);
    }
    for (int k = 0; k < @{margins}; ++k) {
        least = (w->left[k] < least) ? w->left[k] : least;
    }
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nn}; ++i) {
            joints[i] = w->joints[i];
        }
        status = @{p}_hold(to, joints, &residual);
    }
    @{p}_write_info(info, count, residual, w->way2 * @{size2}, (least > @{least}) ? (@{one} / least) : @{zero});
@{blame}
    return status;
}

