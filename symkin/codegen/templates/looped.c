/* The step from w->f into w->f. */
static void @{k}_solve(@{k}_work *w)
{
    @{p}_lu_solve(w->a, w->order, w->f, @{n});
}

