/* The matrix -df/dstep into w->a, row by row: the fallback's start. */
static void @{k}_matrix(@{gp}@{k}_work *w)
{
@{use}
@{matrix}
}

/* LU in loops with partial pivoting; the sign of the determinant, 0 where the matrix is singular. */
static @{COLD} int @{k}_pivoted(@{gp}@{k}_work *w)
{
    static const @{real} scale[@{n}] = { @{column_scales} };
    int sign = 1;
    @{k}_matrix(@{ga}w);
    w->pivoted = true;
    w->spread = @{zero};
    for (int c = 0; c < @{n}; ++c) {
        /* the largest entry of the column becomes the pivot */
        int best = c;
        @{real} largest = @{zero};
        for (int r = c; r < @{n}; ++r) {
            const @{real} size = @{fabs}(w->a[@{n} * r + c]);
            if (size > largest) {
                largest = size;
                best = r;
            }
        }
        if (!(largest > @{singular} * scale[c])) {
            w->spread = @{zero};
            return 0;
        }
        w->order[c] = (uint8_t)best;
        if (best != c) {
            sign = -sign;
            for (int j = c; j < @{n}; ++j) {
                const @{real} t = w->a[@{n} * c + j];
                w->a[@{n} * c + j] = w->a[@{n} * best + j];
                w->a[@{n} * best + j] = t;
            }
        }
        if (w->a[@{n} * c + c] < @{zero}) {
            sign = -sign;
        }
        /* reduce the rows below */
        const @{real} inverse = @{one} / w->a[@{n} * c + c];
        w->a[@{n} * c + c] = inverse;
        w->spread += (inverse * scale[c]) * (inverse * scale[c]);
        for (int r = c + 1; r < @{n}; ++r) {
            const @{real} factor = w->a[@{n} * r + c] * inverse;
            w->a[@{n} * r + c] = factor;
            for (int j = c + 1; j < @{n}; ++j) {
                w->a[@{n} * r + j] -= factor * w->a[@{n} * c + j];
            }
        }
    }
    return sign;
}

/* The step from w->f into w->f with the factors of @{k}_pivoted. */
static @{COLD} void @{k}_pivoted_solve(@{k}_work *w)
{
    /* forward substitution with the exchanges of rows */
    for (int c = 0; c < @{n}; ++c) {
        const int best = (int)w->order[c];
        const @{real} t = w->f[best];
        w->f[best] = w->f[c];
        w->f[c] = t;
        for (int r = c + 1; r < @{n}; ++r) {
            w->f[r] -= w->a[@{n} * r + c] * t;
        }
    }
    /* back substitution */
    for (int c = @{last}; c >= 0; --c) {
        const @{real} t = w->f[c] * w->a[@{n} * c + c];
        w->f[c] = t;
        for (int r = 0; r < c; ++r) {
            w->f[r] -= w->a[@{n} * r + c] * t;
        }
    }
}
