/* The least-squares step s from w->f. */
static NAME_ALONE void solver_solve(solver_work *w, name_real s[@n])
{
    name_real y[@n];
    /* y = Q^T f, and f less its part along each column */
    EACH(c, @n) {
        y[c] = 0.0;
        EACH(i, @m) {
            y[c] += w->a[@n * i + c] * w->f[i];
        }
        EACH(i, @m) {
            w->f[i] -= y[c] * w->a[@n * i + c];
        }
    }
    /* back substitution with R */
    for (int c = @last; c >= 0; --c) {
        @above
        s[c] = y[c] * w->r[@n * c + c];
    }
}

