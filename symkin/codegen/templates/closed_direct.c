/* What the formulas of the direct problem read and give. `at`, `u`: given values at the guess and where formulas are evaluated, each
 * angle by cosine and sine; sign: the guess's side of each choice; left, guard: what must stay above zero, where the line is done
 * and at u; y: the unknowns; share: the smallest root over its usual size; bent, most: how far a part that is too long bends, and may. */
typedef struct {
    name_real at[@nu];
    name_real u[@nu];
    name_real sign[@nk];
    name_real y[@ny];
    name_real share;
    @guard_members
} name_direct_work;

/* Reads the guess: its joints by the limbs' formulas, and the signs of the direct problem's. */
static name_status name_read_guess(name_direct_work *w, const name_pose *guess)
{
    name_real x[7];
    name_status status = name_normalise_pose(guess, x);
    IF_OK {
        @guess_lines
    }
    return status;
}

/* The formulas (README.md) at w->u: unknowns and guards. */
static void name_direct_formulas(name_direct_work *w)
{
    @formula_lines
}

/* Sets w->u to joint values. */
static void name_direct_set(name_direct_work *w, JOINTS_GIVEN)
{
    @set_lines
}

@walk/* Follows the line from the guess that was read to joint values: the formulas there with the guess's signs, where the line keeps them. */
static NAME_SHARED name_status name_direct_line(name_direct_work *w, JOINTS_GIVEN, unsigned int most, unsigned int *count)
{
    name_status status = NAME_OK;
    w->share = 0.0;
    @span_lines
    IF_OK {
        name_real change[@nq];
        bool kept = false;
        if (most > 0U) {
            name_direct_set(w, joints);
            name_direct_formulas(w);
            *count = 1U;
            /* squares of changes, of an angle by its chord's, up to a right angle */
            kept = @near;
            @change_lines
            kept = kept && solver_keeps(w, change);
        }
        if (!kept) {
            name_real at[@nq];
            name_real given[@nq];
            @at_lines
            status = solver_walk(w, at, given, joints, most, count);
        }
    }
    return status;
}

/* Whether an answer, read as a guess, stands still: so near to a fold or a dead centre rounding may put it on the other side, or
 * where no guess is read. */
static NAME_COLD name_status name_direct_stays(const name_direct_work *w, JOINTS_GIVEN, const name_pose *answer)
{
    name_direct_work again;
    unsigned int count = 0U;
    name_status status = name_read_guess(&again, answer);
    IF_OK {
        status = name_direct_line(&again, joints, 2U, &count);
    }
    @same_signs
    return (status == NAME_OK) ? NAME_OK : NAME_WRONG_BRANCH;
}

/* Checks the answer in w->y, residual of all rows and sides of the limbs' dead centres, and writes its pose. *is_firm: whether it is so far
 * from folds and dead centres that rounding does not reach them. */
static name_status name_direct_answer(const name_direct_work *w, name_real tolerance, name_pose *pose, name_real *residual, bool *is_firm)
{
    name_status status = NAME_OK;
    @half_lines
    @residual_lines
    if (!(*residual <= tolerance + @rounding)) {
        status = NAME_SINGULAR;
    }
    @firm_lines
    @side_lines
    *is_firm = firm;
    IF_OK {
        @pose_lines
    }
    return status;
}

/* The answer at joint values. */
static name_status name_direct_reach(JOINTS_GIVEN, const name_pose *guess, name_pose *pose, CONFIG_AND_INFO)
{
    USUAL_CONFIG
    name_direct_work w;
    unsigned int count = 0U;
    name_real residual = HUGE_VAL;
    name_status status = name_limit_joints(name_read_guess(&w, guess), joints);
    w.share = 0.0;
    if (config == NULL) {
        config = &usual;
    } else {
        status = name_check_config(config, status);
    }
    IF_OK {
        const unsigned int most = config->max_iterations;
        status = name_direct_line(&w, joints, most, &count);
    }
    IF_OK {
        name_pose answer;
        bool firm = true;
        status = name_direct_answer(&w, config->tolerance, &answer, &residual, &firm);
        if ((status == NAME_OK) && !firm) {
            status = name_direct_stays(&w, joints, &answer);
        }
        @check_answer
        IF_OK {
            *pose = answer;
        }
    }
    if (count > 0U) {
        if (info != NULL) {
            info->iterations = (uint8_t)count;
            info->residual = (residual >= 0.0) ? residual : HUGE_VAL;
            info->step = 0.0;
            info->min_pivot = (w.share >= 0.0) ? w.share : 0.0;
            info->joint = @{nq}U;
        }
    } else {
        name_write_no_step(info, joints);
    }
    return status;
}

name_status name_direct(const name_config *config, JOINTS_GIVEN, const name_pose *guess, name_pose *pose, name_info *info)
{
    return name_direct_reach(joints, guess, pose, config, info);
}

name_status name_track(JOINTS_GIVEN, name_pose *pose, name_info *info)
{
    /* @evaluations */
    static const name_config once = { NAME_TOLERANCE, @{evaluation_count}U, NAME_MAX_STEP };
    const name_status status = name_direct_reach(joints, pose, pose, &once, info);
    return (status == NAME_MAX_ITERATIONS) ? NAME_WRONG_BRANCH : status;
}
