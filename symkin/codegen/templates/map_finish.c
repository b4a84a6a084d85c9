/* Holds the rows against the formulas' answer; one step of Newton's method where rounding has left more than the tolerance. */
static NAME_SHARED name_status solver_finish(solver_work *w, unsigned int count, name_real least, CONFIG_AND_INFO)
{
    name_real size = 0.0;
    solver_rows(w);
    name_real residual = solver_residual(w);
    if (!(residual <= config->tolerance + @noise)) {
        if (@singular) {
            name_write_info(info, count, residual, 0.0, 0.0);
            return NAME_SINGULAR;
        }
        size = solver_step(w);
        solver_rows(w);
        residual = solver_residual(w);
    }
    name_write_info(info, count, residual, size, (least > 0.0) ? (1.0 / least) : 0.0);
    return (residual <= config->tolerance + @rounding) ? NAME_OK : NAME_MAX_ITERATIONS;
}

