/* Joint values of branches with the tool pose x (unit quaternion); returns how many. wanted: two bits a choice, 1 for its first
 * solution, 2 for its second, 0 for the one nearest to the guess; near: cosine and sine of the guess's angle, or its slide and 0, of
 * each choice. *undecided is set where nothing decides a joint; margin: squares that vanish where steps decide nothing or two solutions
 * meet. */
static int @{p}_branches(const @{real} x[7], const @{real} near[@{nears}], unsigned int wanted, @{real} found[][@{nn}], bool *undecided,
    @{real} margin[@{margins}])
{
    int count = 0;
    (void)margin;
    (void)near;
    (void)wanted;
@{body}
    return count;
}

/* Turns angles to within half a turn of `about`, and, where that is out of range, of the middle of the range. */
static @{p}_status @{p}_turn_near(const @{real} about[@{nn}], @{real} joints[@{nn}])
{
    static const bool angular[@{nn}] = { @{angular} };
    static const @{real} middle[@{nn}] = { @{middles} };
    @{p}_status status = @{P}_OUT_OF_RANGE;
    for (int round = 0; (round < 2) && (status == @{P}_OUT_OF_RANGE); ++round) {
        const @{real} *const goal = (round == 0) ? about : middle;
        for (int i = 0; i < @{nn}; ++i) {
            const @{real} number = (goal[i] - joints[i]) * @{per_turn};
            if (angular[i] && (@{fabs}(number) > @{half}) && (@{fabs}(number) < @{many})) {
                const int whole = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
                joints[i] += @{turn} * (@{real})whole;
            }
        }
        status = @{p}_check_limits(joints);
    }
    return status;
}

@{finish}
/* The branch that the bits `wanted` and the guess name; results are written with OK only. */
static @{p}_status @{p}_one_branch(const @{p}_pose *pose, const @{real} near[@{nears}], unsigned int wanted, const @{real} about[@{nn}], @{real} joints[@{nn}])
{
    @{real} x[7];
    @{real} found[1][@{nn}];
    @{real} margin[@{margins}];
    bool undecided = false;
    @{p}_status status = @{p}_normalise_pose(pose, x);
    if (status == @{P}_OK) {
        if (@{p}_branches(x, near, wanted, found, &undecided, margin) == 1) {
            status = @{p}_settle(x, about, found[0]);
        } else {
            status = undecided ? @{P}_SINGULAR : @{P}_OUT_OF_RANGE;
        }
    }
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nn}; ++i) {
            joints[i] = found[0][i];
        }
    }
    return status;
}

/* All branches with the given tool pose. */
int @{p}_inverse_all(const @{p}_pose *pose, @{real} joints[@{branches}][@{nn}])
{
    static const @{real} near[@{nears}] = { @{zero} };
    static const @{real} middle[@{nn}] = { @{middles} };
    @{real} x[7];
    int count = 0;
    @{real} margin[@{margins}];
    bool undecided = false;
    @{p}_status status = @{p}_normalise_pose(pose, x);
    if (status == @{P}_OK) {
        const int all = @{p}_branches(x, near, @{both}, joints, &undecided, margin);
        for (int k = 0; k < all; ++k) {
            if (@{p}_settle(x, middle, joints[k]) == @{P}_OK) {
                for (int i = 0; i < @{nn}; ++i) {
                    joints[count][i] = joints[k][i];
                }
                ++count;
            }
        }
    }
    return count;
}

/* The branch named by the choices' bits. */
@{p}_status @{p}_inverse_branch(const @{p}_pose *pose, unsigned int branch, @{real} joints[@{nn}])
{
    static const @{real} near[@{nears}] = { @{zero} };
    static const @{real} middle[@{nn}] = { @{middles} };
    @{p}_status status = @{P}_OUT_OF_RANGE;
    if (branch < @{branches}U) {
        unsigned int wanted = 0U;
@{named}
        status = @{p}_one_branch(pose, near, wanted, middle, joints);
    }
    return status;
}

/* The branch nearest to the guess, choice by choice. */
@{p}_status @{p}_inverse_nearest(const @{p}_pose *pose, const @{real} guess[@{nn}], @{real} joints[@{nn}])
{
    @{p}_status status = @{p}_check_finite(guess, @{nn}, @{P}_OK);
    if (status == @{P}_OK) {
        @{real} near[@{nears}] = { @{zero} };
@{near}
        status = @{p}_one_branch(pose, near, 0U, guess, joints);
    }
    return status;
}

