/* The least-squares step from w->f into the first @{n} entries of w->f. */
static void @{k}_solve(@{k}_work *w)
{
    @{real} y[@{n}];
    @{real} left[@{m}];
    for (int i = 0; i < @{m}; ++i) {
        left[i] = w->f[i];
    }
    /* y = Q^T f, and what is left of f less its part along each column */
    for (int c = 0; c < @{n}; ++c) {
        y[c] = @{zero};
        for (int i = 0; i < @{m}; ++i) {
            y[c] += w->a[@{n} * i + c] * left[i];
        }
        for (int i = 0; i < @{m}; ++i) {
            left[i] -= y[c] * w->a[@{n} * i + c];
        }
    }
    /* back substitution with R */
    for (int c = @{last}; c >= 0; --c) {
@{above}
        w->f[c] = y[c] * w->r[@{n} * c + c];
    }
}

