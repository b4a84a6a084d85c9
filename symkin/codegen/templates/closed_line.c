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

/* How much of what would keep the steps of the closed form from their singularities between two points of the line is used up, 1 being
 * all: a and b are the squares `margin` there, and a square bends away from its chord by no more than the squares of the tool's way
 * (place over the size, turn) and of the joints' (angles; slides over the size) allow (README.md). */
static @{real} @{p}_line_share(const @{real} a[@{margins}], const @{real} b[@{margins}], @{real} place, @{real} turn, const @{real} moved[@{nn}])
{
    @{real} largest = @{zero};
    (void)a;
    (void)b;
    (void)place;
    (void)turn;
    (void)moved;
@{bends}
    return largest;
}

/* The closed form along the line of tool poses from the guess's to the given one, on the guess's branch, in parts that are kept and
 * halved where they are not. Angles go on from part to part, whole turns included. */
static @{p}_status @{p}_inverse_along(const @{real} to[7], const @{p}_config *config, @{real} joints[@{nn}], @{p}_info *info)
{
    static const @{real} per_length[@{nn}] = { @{per_lengths} };
    static const bool angular[@{nn}] = { @{angular} };
    static const @{real} near[@{nears}] = { @{zero} };
    const @{real} most2 = config->max_step * config->max_step * @{per_size2};
    @{real} at[7];
    @{real} x[7];
    @{real} left[@{margins}] = { @{one} };
    @{real} margin[@{margins}] = { @{one} };
    @{real} found[1][@{nn}];
    @{real} done = @{zero};
    @{real} part = @{one};
    @{real} moved[@{nn}];
    @{real} way2 = @{zero};
    @{real} least = @{one};
    unsigned int count = 0U;
@{blamed}
    const unsigned int wanted = @{p}_read_joints(joints, at, left);
    /* of q and -q, one rotation, the one on the guess's side */
    const @{real} cosine = at[3] * to[3] + at[4] * to[4] + at[5] * to[5] + at[6] * to[6];
    const @{real} side = (cosine < @{zero}) ? -@{one} : @{one};
    const @{real} turn2 = @{eight} * ((@{one} - side * cosine) + @{turn_noise});
    @{real} place2 = @{zero};
    @{p}_status status = @{P}_MAX_ITERATIONS;
    for (int i = 0; i < 3; ++i) {
        place2 += (to[i] - at[i]) * (to[i] - at[i]) * @{per_size2};
    }
    for (int k = 0; k < @{margins}; ++k) {
        if (!(left[k] > @{least})) {
            status = @{P}_SINGULAR;
        }
    }
@{guess_beyond}
    while ((status == @{P}_MAX_ITERATIONS) && (count < (unsigned int)config->max_iterations)) {
        const @{real} end = (done + part < @{near_one}) ? (done + part) : @{one};
        bool undecided = false;
        ++count;
        for (int i = 0; i < 7; ++i) {
            const @{real} goal = (i < 3) ? to[i] : (side * to[i]);
            x[i] = (end < @{one}) ? (at[i] + end * (goal - at[i])) : goal;
        }
        if (end < @{one}) {
            const @{real} inverse = @{one} / @{sqrt}(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6]);
            for (int i = 3; i < 7; ++i) {
                x[i] *= inverse;
            }
        }
        if (@{p}_branches(x, near, wanted, found, &undecided, margin) != 1) {
            /* the guess's branch does not reach this point of the line */
            status = undecided ? @{P}_SINGULAR : ((end < @{one}) ? @{P}_WRONG_BRANCH : @{P}_OUT_OF_RANGE);
        } else {
            way2 = @{zero};
            for (int i = 0; i < @{nn}; ++i) {
                @{real} way = found[0][i] - joints[i];
                const @{real} number = way * @{per_turn};
                if (angular[i] && (@{fabs}(number) > @{half})) {
                    way -= @{turn} * (@{real})(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
                }
                found[0][i] = joints[i] + way;
                moved[i] = (way * per_length[i]) * (way * per_length[i]);
                way2 += moved[i];
            }
            const @{real} share = @{p}_line_share(left, margin, part * part * place2, part * part * turn2, moved);
@{limits_kept}
            if (@{kept}) {
                for (int i = 0; i < @{nn}; ++i) {
                    joints[i] = found[0][i];
                }
                for (int k = 0; k < @{margins}; ++k) {
                    left[k] = margin[k];
                }
                done = end;
                part *= (share < @{quick}) ? @{two} : ((share < @{usual}) ? @{one} : @{shorter});
                if (done >= @{one}) {
                    status = @{P}_OK;
                }
            } else {
                part *= (share < @{four}) ? @{half} : @{far_shorter};
                if (part < @{least_part}) {
                    status = @{refused};
                }
            }
        }
    }
    for (int k = 0; k < @{margins}; ++k) {
        least = (left[k] < least) ? left[k] : least;
    }
    @{real} residual = @{huge};
    if (status == @{P}_OK) {
        status = @{p}_hold(to, joints, &residual);
    }
    @{p}_write_info(info, count, residual, way2 * @{size2}, (least > @{least}) ? (@{one} / least) : @{zero});
@{blame}
    return status;
}

