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
