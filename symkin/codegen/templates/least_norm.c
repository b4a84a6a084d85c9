/* The shortest step s among those that solve the @n rows, from w->f: Q y with y R = the rows. */
static NAME_ALONE void solver_solve(solver_work *w, name_real s[@m])
{
    name_real y[@n];
    /* forward substitution with R transposed */
    EACH(c, @n) {
        y[c] = w->f[c];
        EACH(j, c) {
            y[c] -= w->r[@n * j + c] * y[j];
        }
        y[c] *= w->r[@n * c + c];
    }
    /* the step Q y */
    EACH(i, @m) {
        s[i] = 0.0;
        EACH(c, @n) {
            s[i] += w->a[@n * i + c] * y[c];
        }
    }
}

