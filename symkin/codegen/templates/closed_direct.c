/* What the formulas of the direct problem read and give. `at`, `u`: given values at the guess and where formulas are evaluated, each
 * angle by cosine and sine; sign: the guess's side of each choice; left, guard: what must stay above zero, where the line is done
 * and at u; y: the unknowns; share: the smallest root over its usual size; bent, most: how far a part that is too long bends, and may. */
typedef struct {
    @{real} at[@{nu}];
    @{real} u[@{nu}];
    @{real} sign[@{nk}];
    @{real} y[@{ny}];
    @{real} share;
    @{guard_members}
} @{p}_direct_work;

/* Reads the guess: its joints by the limbs' formulas, and the signs of the direct problem's. */
static @{p}_status @{p}_read_guess(@{p}_direct_work *w, const @{p}_pose *guess)
{
    @{real} x[7];
    @{p}_status status = @{p}_normalise_pose(guess, x);
    if (status == @{P}_OK) {
        @{guess_lines}
    }
    return status;
}

/* The formulas (README.md) at w->u: unknowns and guards. */
static void @{p}_direct_formulas(@{p}_direct_work *w)
{
    @{formula_lines}
}

/* Sets w->u to joint values. */
static void @{p}_direct_set(@{p}_direct_work *w, const @{real} joints[@{nq}])
{
    @{set_lines}
}

@{walk}/* Follows the line from the guess that was read to joint values: the formulas there with the guess's signs, where the line keeps them. */
static @{SHARED} @{p}_status @{p}_direct_line(@{p}_direct_work *w, const @{real} joints[@{nq}], unsigned int most, unsigned int *count)
{
    @{p}_status status = @{P}_OK;
    w->share = @{zero};
    @{span_lines}
    if (status == @{P}_OK) {
        @{real} change[@{nq}];
        bool kept = false;
        if (most > 0U) {
            @{p}_direct_set(w, joints);
            @{p}_direct_formulas(w);
            *count = 1U;
            /* squares of changes, of an angle by its chord's, up to a right angle */
            kept = @{near};
            @{change_lines}
            kept = kept && @{k}_keeps(w, change);
        }
        if (!kept) {
            @{real} at[@{nq}];
            @{real} given[@{nq}];
            @{at_lines}
            status = @{k}_walk(w, at, given, joints, most, count);
        }
    }
    return status;
}

/* Whether an answer, read as a guess, stands still: so near to a fold or a dead centre rounding may put it on the other side, or
 * where no guess is read. */
static @{COLD} @{p}_status @{p}_direct_stays(const @{p}_direct_work *w, const @{real} joints[@{nq}], const @{p}_pose *answer)
{
    @{p}_direct_work again;
    unsigned int count = 0U;
    @{p}_status status = @{p}_read_guess(&again, answer);
    if (status == @{P}_OK) {
        status = @{p}_direct_line(&again, joints, 2U, &count);
    }
    @{same_signs}
    return (status == @{P}_OK) ? @{P}_OK : @{P}_WRONG_BRANCH;
}

/* The answer at joint values. */
static @{p}_status @{p}_direct_reach(const @{real} joints[@{nq}], const @{p}_pose *guess, @{p}_pose *pose, const @{p}_config *config, @{p}_info *info)
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    @{p}_direct_work w;
    unsigned int count = 0U;
    @{real} residual = @{huge};
    @{p}_status status = @{p}_read_guess(&w, guess);
    const @{p}_status limits = @{p}_check_limits(joints);
    w.share = @{zero};
    /* NaN or infinity anywhere comes first */
    if ((status == @{P}_OK) || (limits == @{P}_NONFINITE)) {
        status = limits;
    }
    if (config == NULL) {
        config = &usual;
    } else {
        status = @{p}_check_config(config, status);
    }
    if (status == @{P}_OK) {
        const unsigned int most = config->max_iterations;
        status = @{p}_direct_line(&w, joints, most, &count);
    }
    if (status == @{P}_OK) {
        @{p}_pose answer;
        bool firm = true;
        status = @{p}_direct_answer(&w, config->tolerance, &answer, &residual, &firm);
        if ((status == @{P}_OK) && !firm) {
            status = @{p}_direct_stays(&w, joints, &answer);
        }
        @{check_answer}
        if (status == @{P}_OK) {
            *pose = answer;
        }
    }
    if (count > 0U) {
        if (info != NULL) {
            info->iterations = (uint8_t)count;
            info->residual = (residual >= @{zero}) ? residual : @{huge};
            info->step = @{zero};
            info->min_pivot = (w.share >= @{zero}) ? w.share : @{zero};
            info->joint = @{nq}U;
        }
    } else {
        @{p}_write_no_step(info, joints);
    }
    return status;
}

@{p}_status @{p}_direct(const @{p}_config *config, const @{real} joints[@{nq}], const @{p}_pose *guess, @{p}_pose *pose, @{p}_info *info)
{
    return @{p}_direct_reach(joints, guess, pose, config, info);
}

@{p}_status @{p}_track(const @{real} joints[@{nq}], @{p}_pose *pose, @{p}_info *info)
{
    /* @{evaluations} */
    static const @{p}_config once = { @{P}_TOLERANCE, @{evaluation_count}U, @{P}_MAX_STEP };
    const @{p}_status status = @{p}_direct_reach(joints, pose, pose, &once, info);
    return (status == @{P}_MAX_ITERATIONS) ? @{P}_WRONG_BRANCH : status;
}
