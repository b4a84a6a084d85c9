/* The step from w->f into w->f. */
static void @{k}_solve(@{k}_work *w)
{
    @{k}_pivoted_solve(w);
}

