/* The step from w->f into w->f. */
static void solver_solve(solver_work *w)
{
    name_lu_solve(w->a, w->order, w->f, @n);
}

