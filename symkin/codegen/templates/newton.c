/* Newton's method along the straight line from the known values of the guess to the given ones (to).
 *
 * kappa2 is the square of kappa: a step s leaves an error of kappa |s|^2. @first_try.
 * Where the second step is longer than a quarter of the first (of a far one, a sixth to an eighth), or a later one than three eighths of
 * the one before (two twenty-fifths after new factors), the theorem of Newton and Kantorovich does not tie the point to the part that is done (README.md says what
 * is proved): the state is put back and a nearer point of the line is aimed at. Factors are kept for one more step where that is predicted to
 * reach the tolerance. The answer's rows are evaluated before it is called OK. */
static name_status solver_newton(GEOMETRY_GIVEN solver_work *w, const name_real to[@nto], CONFIG_AND_INFO)
{
    /* squares of lengths and of ratios of lengths, so that no step needs a root; ratio2: the largest ones that are accepted, of the
     * second step, of later ones after new factors, and of others, as the first step is near, far or very far */
    static const name_real ratio2[3][3] = {
        { @contraction2, @later_fresh2, @later2 }, { @far2, @later_fresh2, @later2 }, { @very_far2, @very_far_fresh2, @very_far_later2 }
    };
    const name_real tolerance2 = config->tolerance * config->tolerance;
    const name_real longest2 = config->max_step * config->max_step;
    name_status status = NAME_MAX_ITERATIONS;
    /* parts of the line, 0 to 1: where the state is known to lie, and what is aimed at */
    name_real done = 0.0;
    name_real aim = 1.0;
    /* squares of: the last step, kappa, the longest step allowed */
    name_real size = 0.0;
    name_real kappa2 = @kappa2;
    name_real limit;
    name_real residual = HUGE_VAL;
    name_real room = @noise_of_rows; /* residual that rounding is allowed; after one more step, of new factors, that of any matrix */
    @still_variable
    int sign = 0; /* of the determinant: a change at the part that is done means that a singularity lies between */
    bool beside = false; /* whether the last step has led beyond a singularity: it is refused, as one that is too long */
    unsigned int count = 0U;
    unsigned int taken = 0U; /* steps towards the aim: each is judged by the next */
    bool fresh = true; /* whether this step needs new factors */
    bool was_fresh = false; /* whether the step before had new factors */
    @quick_variable
    bool kept = false; /* whether the factors are those of the part that is done */
    unsigned int far = 0U; /* 1: the first step is long beside the way to a singularity, as the least pivot tells it; 2: very long */
    bool stayed = false; /* whether the whole line has been taken for rounding */
    bool verify = false; /* whether the tolerance should be reached: the rows are evaluated once more */
    w->spread = 0.0;
@no_side
    @turn
    @begin_target
    @save0
    for (;;) {
        solver_rows(GEOMETRY w);
        if (verify) {
            residual = solver_residual(w);
            if (residual <= config->tolerance + room) {
                status = NAME_OK;
                break;
            }
            room = @rounding;
            verify = false;
            fresh = true;
        }
        if (count >= (unsigned int)config->max_iterations) {
            break;
        }
        ++count;
        if (fresh) {
            /* matrix and factors, and the sign of the determinant */
            @at_done
            int turn = @first_factor;
            @second_factor
            @side
            @at_aim
            kept = (taken == 0U);
            if (turn == 0) {
                status = NAME_SINGULAR;
                break;
            }
            beside = (turn + sign == 0);
            if (beside && kept) {
                status = NAME_WRONG_BRANCH;
                break;
            }
            sign = beside ? sign : turn;
            @noise
        }
        /* the step, and the longest that is accepted: theta = |step| / |step before| at most 1/4 to 1/8, later 3/8 to 3/10 (README.md) */
        const name_real before = size;
        size = solver_step(GEOMETRY w);
        if (taken == 0U) {
            limit = longest2;
            const name_real reach = size * w->spread;
            far = (reach > @size2) ? ((reach > 10.0 * @size2) ? 2U : 1U) : 0U;
        } else {
            int later = was_fresh ? 1 : 2;
            if (taken == 1U) {
                /* every second step, also one that is rounding, tells how long the next part is */
                @set_quick
                later = 0;
            }
            limit = ratio2[far][later] * before;
            @set_stretch
        }
        if (beside) {
            limit = -1.0;
        }
        bool accepted = (size <= limit) || (!beside && (taken > 0U) && (size <= @still2));
        @check_middle
        if (accepted) {
            if (aim >= 1.0) {
                /* accepted at the end of the line: predict the error, decide on new factors */
                name_real error2;
                name_real gain2 = size;
                if ((taken > 0U) && (before > 0.0)) {
                    /* divided by twice: in float the square of `before` vanishes for a tiny machine */
                    gain2 /= before;
                    kappa2 = (was_fresh@moved) ? (gain2 / before) : kappa2;
                    if (fresh) {
                        gain2 = kappa2 * size;
                    }
                } else {
                    gain2 *= kappa2;
                }
                gain2 *= 4.0;
                error2 = gain2 * size;
                verify = ((taken > 0U) && (error2 <= tolerance2)) || @still;
                was_fresh = fresh;
                fresh = (gain2 * error2 > tolerance2) && ((taken > 0U) || (gain2 < 0.3));
                ++taken;
            } else if ((taken == 0U) || ((size > @still2)
                && ((taken == 1U) || ((far > 0U) && (taken == 2U) && (size * @sure > before))))) {
                /* towards a point of the line: the next step judges this one; of a far point whose third step is not far
                 * shorter than its second, a fourth one judges that */
                was_fresh = fresh;
                fresh = false;
                ++taken;
            } else {
                /* accepted at a point of the line: go on from here, by up to twice the part where convergence was quick */
                const name_real part = aim - done;
                done = aim;
                aim += @next_part;
                if (aim > 0.999) {
                    aim = 1.0;
                }
                @advance
                taken = 0U;
                fresh = true;
            }
        } else if (!stayed && (taken > 0U) && (aim - done >= 1.0) && (before <= @row_noise2 * w->spread)) {
            /* the whole line may be rounding, which small pivots have made long: the state stays where it was, if its rows vanish there */
            @stay
            stayed = true;
            room = @rounding;
            verify = true;
            fresh = true;
            taken = 0U;
        } else if (aim - done > @least_part) {
            /* refused: back to the part that is done, and aim nearer */
            @nearer
            @retreat
            fresh = !kept;
            taken = 0U;
        } else {
            /* parts have become too short: the line is not assured to be regular */
            status = NAME_WRONG_BRANCH;
            break;
        }
    }
    name_write_info(info, count, residual, size, w->spread);
    return status;
}
