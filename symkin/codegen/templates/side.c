/* The sign of the determinant beside the one where the line began, 0 where it is not decided. Of more rows than unknowns it is that of
 * Q0^T Q, Q0 the factors of the part that is done: where branches meet a column of the matrix goes through 0 and comes back reversed.
 * keep: these factors are those of the part that is done. */
static int @{k}_side(@{k}_work *w, bool keep)
{
    @{real} d[@{n}][@{n}] = { { @{zero} } };
    int side = (w->side == 0) ? 1 : (int)w->side;
    for (int i = 0; (i < @{n}) && (w->side != 0); ++i) {
        for (int j = 0; j < @{n}; ++j) {
            d[i][j] = @{zero};
            for (int row = 0; row < @{m}; ++row) {
                d[i][j] += w->q[@{n} * row + i] * w->a[@{n} * row + j];
            }
        }
    }
    for (int c = 0; (c < @{n}) && (w->side != 0) && (side != 0); ++c) {
        int best = c;
        for (int i = c + 1; i < @{n}; ++i) {
            best = (@{fabs}(d[i][c]) > @{fabs}(d[best][c])) ? i : best;
        }
        if (!(@{fabs}(d[best][c]) > @{singular})) {
            side = 0;
        } else {
            side = ((best != c) != (d[best][c] < @{zero})) ? -side : side;
            for (int j = c; j < @{n}; ++j) {
                const @{real} t = d[c][j];
                d[c][j] = d[best][j];
                d[best][j] = t;
            }
            for (int i = c + 1; i < @{n}; ++i) {
                const @{real} factor = d[i][c] / d[c][c];
                for (int j = c; j < @{n}; ++j) {
                    d[i][j] -= factor * d[c][j];
                }
            }
        }
    }
    if (keep) {
        for (int i = 0; i < @{na}; ++i) {
            w->q[i] = w->a[i];
        }
        w->side = (int8_t)side;
    }
    return side;
}

