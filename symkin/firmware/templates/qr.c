/* The matrix into w->a, row by row. */
static void @{k}_matrix(@{gp}@{k}_work *w)
{
@{matrix}
}

/* QR of the @{m} x @{n} matrix by modified Gram-Schmidt: Q in w->a, R in w->r with reciprocals on the diagonal; 0 where
 * its columns are dependent. Steps are least squares over all rows. */
static int @{k}_factor(@{gp}@{k}_work *w)
{
    @{k}_matrix(@{ga}w);
    w->spread = @{zero};
    for (int c = 0; c < @{n}; ++c) {
        @{real} squared = @{zero};
        for (int i = 0; i < @{m}; ++i) {
            squared += w->a[@{n} * i + c] * w->a[@{n} * i + c];
        }
        if (!(squared > @{singular} * @{singular})) {
            return 0;
        }
        const @{real} inverse = @{one} / @{sqrt}(squared);
        w->r[@{n} * c + c] = inverse;
        w->spread += inverse * inverse;
        for (int i = 0; i < @{m}; ++i) {
            w->a[@{n} * i + c] *= inverse;
        }
@{others}
    }
    return 1;
}

/* The least-squares step from w->f into the first @{n} entries of w->f. */
static void @{k}_solve(@{k}_work *w)
{
    @{real} y[@{n}];
    for (int c = 0; c < @{n}; ++c) {
        y[c] = @{zero};
        for (int i = 0; i < @{m}; ++i) {
            y[c] += w->a[@{n} * i + c] * w->f[i];
        }
        for (int i = 0; i < @{m}; ++i) {
            w->f[i] -= y[c] * w->a[@{n} * i + c];
        }
    }
    for (int c = @{n} - 1; c >= 0; --c) {
@{above}
        w->f[c] = y[c] * w->r[@{n} * c + c];
    }
}

