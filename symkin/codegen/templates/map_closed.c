/* Formulas of the @which problem (README.md): numbers x of the unknowns for known numbers k, by a sign for each choice between two
 * values. Conditions d are above 0 where all is real and nothing vanishes that is divided by; they are 1 at a usual place. */
static NAME_SHARED void solver_formulas(const name_real k[@nk], const name_real sign[@signs], name_real x[@ns], name_real d[@conditions])
{
    (void)k;
    (void)sign;
    (void)d;
    @formulas
}

/* The signs of a configuration in the formulas, and their conditions there: what tells a sign is its root. */
static NAME_SHARED void solver_signs(const name_real k[@nk], const name_real x[@ns], name_real sign[@signs], name_real d[@conditions])
{
    (void)k;
    (void)x;
    (void)d;
    @told
}
@walk/* The end of the straight line of known values from w->at, where the state is w->x at w->k, to `to`, if no condition vanishes on the way.
 * Then the rows are held against the answer. */
static name_status solver_follow(solver_work *w, const name_real to[@nto], CONFIG_AND_INFO)
{
    name_real least = 1.0;
    unsigned int count = 0U;
    @reach
    solver_signs(w->k, w->x, w->sign, w->left);
    name_status status = solver_walk(w, w->at, to, (unsigned int)config->max_iterations, &count);
    IF_OK {
        EACH(i, @conditions) {
            least = (w->guard[i] < least) ? w->guard[i] : least;
        }
        status = solver_finish(w, count, least, config, info);
    } else {
        name_write_info(info, count, HUGE_VAL, 0.0, 0.0);
    }
    return status;
}

