/* The shortest step among those that solve the @n rows, from w->f into w->f: Q y with y R = the rows. */
static NAME_ALONE void solver_solve(solver_work *w)
{
    name_real y[@n];
    /* forward substitution with R transposed */
    for (int c = 0; c < @n; ++c) {
        y[c] = w->f[c];
        for (int j = 0; j < c; ++j) {
            y[c] -= w->r[@n * j + c] * y[j];
        }
        y[c] *= w->r[@n * c + c];
    }
    /* the step Q y */
    for (int i = 0; i < @m; ++i) {
        w->f[i] = 0.0;
        for (int c = 0; c < @n; ++c) {
            w->f[i] += w->a[@n * i + c] * y[c];
        }
    }
}

