/* LU of the matrix, unrolled in an order of pivots chosen over sampled poses; the sign of the determinant, 0 where a
 * pivot is far below its usual size, which is left to solver_pivoted. What is added to pivots is below the rounding of any other, and
 * keeps divisions by zero away. */
static int solver_factor(GEOMETRY_GIVEN solver_work *w)
{
    name_real det;
@use
    w->pivoted = false;
    @factor
    return (w->spread < @guard) ? ((det @sign 0.0) ? 1 : -1) : 0;
}

/* The step s from w->f: forward and back substitution. */
static void solver_solve(solver_work *w, name_real s[@n])
{
    if (w->pivoted) {
        name_lu_solve(w->a, w->order, w->f, s, @n);
        return;
    }
    @solve
}

