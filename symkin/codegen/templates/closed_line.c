/* A point of the line: joints where it is done, which begin at the guess, those found where it is tried, turned and aimed: cosine and sine of each
 * angle from its zero, up to a factor above zero, or the slide and 0, and the squares left and guard of the closed form's steps at both; sign: the
 * guess's branch; way: how far each joint goes from one to the other (angles; slides over the size), way2: the sum of the squares. Of the part
 * between: bounds of the joints' speeds and of how these change, and whether it is kept. */
typedef struct {
    name_real joints[@nn];
    name_real found[@nn];
    name_real turned[@nn][2];
    name_real aimed[@nn][2];
    name_real sign[@choices];
    name_real way[@nn];
    name_real way2;
    name_real speed[@nn];
    name_real change[@nn];
    bool kept;
    @members
} solver_work;

/* Begins a line at joint values: their tool pose x (x, y, z, qw, qx, qy, qz), the squares of the closed form's steps there (README.md), and the
 * branch on which they lie. */
static void solver_begin(solver_work *w, const name_real joints[@nn], name_real x[7])
{
    name_real u[@turns];
    name_half_turns(joints, u);
    name_pose_of_turns(u, x);
    COPY(w->joints, joints, @nn)
    w->way2 = 0.0;
    w->left[0] = 1.0;
    w->guard[0] = 1.0;
    @read
}

@joint@turn_between/* The closed form at a tool pose x of the line, on the guess's branch; SINGULAR or OUT_OF_RANGE where that does not reach it. */
static name_status solver_reach(solver_work *w, const name_real x[7])
{
    name_status status = NAME_OUT_OF_RANGE;
    @reach
    return status;
}

/* The joints at a tool pose x of the line, angles within half a turn of where it is done, and their ways; slides and joints with limits are exact,
 * other angles go on by their ways. */
static name_status solver_aim(solver_work *w, const name_real x[7])
{
    const name_status status = solver_reach(w, x);
    IF_OK {
        @way_lines
    }
    return status;
}

@helpers@limits/* Whether the joints' last way is within what the config allows@and_within. */
static bool solver_follows(solver_work *w, name_real most2)
{
    const bool follows = (w->way2 <= most2);
    if (!follows) {
        w->bent = w->way2;
        w->most = most2;
    }
    @limits_kept
}

@walk/* The closed form along the line of tool poses from the guess's to the given one, on the guess's branch. Angles go on from part to part,
 * whole turns included. */
static name_status solver_along(const name_real to[7], const name_config *config, name_real joints[@nn], name_info *info)
{
    OWN_WORK
    name_real at[7];
    name_real least = 1.0;
    name_real residual = HUGE_VAL;
    unsigned int count = 0U;
    name_status status = NAME_OK;
    solver_begin(w, joints, at);
    EACH(k, @margins) {
        if (!(w->left[k] > @least)) {
            status = NAME_SINGULAR;
        }
    }
    @guess_beyond
    IF_OK {
        const name_real most2 = config->max_step * config->max_step * @per_size2;
        status = solver_walk(w, at, to, most2, (unsigned int)config->max_iterations, &count);
    }
    EACH(k, @margins) {
        least = (w->left[k] < least) ? w->left[k] : least;
    }
    IF_OK {
        EACH(i, @nn) {
            joints[i] = solver_joint(i, w->turned[i], w->joints[i]);
        }
        status = name_hold(to, joints, &residual);
    }
    name_write_info(info, count, residual, w->way2 * @size2, (least > @least) ? (1.0 / least) : 0.0);
    @blame
    return status;
}

