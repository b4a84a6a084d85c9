/* The least-squares step from w->f into the first @n entries of w->f. */
static NAME_ALONE void solver_solve(solver_work *w)
{
    name_real y[@n];
    /* y = Q^T f, and f less its part along each column */
    for (int c = 0; c < @n; ++c) {
        y[c] = 0.0;
        for (int i = 0; i < @m; ++i) {
            y[c] += w->a[@n * i + c] * w->f[i];
        }
        for (int i = 0; i < @m; ++i) {
            w->f[i] -= y[c] * w->a[@n * i + c];
        }
    }
    /* back substitution with R */
    for (int c = @last; c >= 0; --c) {
        @above
        w->f[c] = y[c] * w->r[@n * c + c];
    }
}

