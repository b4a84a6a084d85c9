/* The step s from w->f. */
static void solver_solve(solver_work *w, name_real s[@n])
{
    name_lu_solve(w->a, w->order, w->f, s, @n);
}

