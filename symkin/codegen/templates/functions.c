/* The rows f(x; k) into w->f, and what the matrix shares with them. */
static void solver_rows(GEOMETRY_GIVEN solver_work *w)
{
@use
    @rows
}

/* Norm of the rows in w->f as a length: no row is further from zero. */
static NAME_SHARED name_real solver_residual(const solver_work *w)
{
    @residual
}

/* Adds the step in w->f to the state: lengths and joint values are added to, quaternions are turned. Returns the squared
 * length of the step, angles times the size. */
static name_real solver_apply_step(GEOMETRY_GIVEN solver_work *w)
{
@use
    @move
}

