/* LU in loops of the n x n matrix a, row by row, with partial pivoting: reciprocals of pivots on the diagonal, `order` the exchanges of
 * rows. The sign of the determinant, 0 where no entry of a column is above its `least`. */
static NAME_COLD int name_lu(name_real *a, uint8_t *order, const name_real *least, int n)
{
    int sign = 1;
    EACH(c, n) {
        /* the largest entry of the column becomes the pivot */
        int best = c;
        name_real largest = 0.0;
        EACH_FROM(r, c, n) {
            const name_real size = fabs(a[n * r + c]);
            if (size > largest) {
                largest = size;
                best = r;
            }
        }
        if (!(largest > least[c])) {
            return 0;
        }
        order[c] = (uint8_t)best;
        if (best != c) {
            sign = -sign;
            EACH_FROM(j, c, n) {
                const name_real t = a[n * c + j];
                a[n * c + j] = a[n * best + j];
                a[n * best + j] = t;
            }
        }
        if (a[n * c + c] < 0.0) {
            sign = -sign;
        }
        /* reduce the rows below */
        const name_real inverse = 1.0 / a[n * c + c];
        a[n * c + c] = inverse;
        EACH_FROM(r, c + 1, n) {
            const name_real factor = a[n * r + c] * inverse;
            a[n * r + c] = factor;
            EACH_FROM(j, c + 1, n) {
                a[n * r + j] -= factor * a[n * c + j];
            }
        }
    }
    return sign;
}

/* Solves for the right side f with the factors of name_lu: s, which may be f; f is lost. */
static NAME_COLD void name_lu_solve(const name_real *a, const uint8_t *order, name_real *f, name_real *s, int n)
{
    /* forward substitution with the exchanges of rows */
    EACH(c, n) {
        const int best = (int)order[c];
        const name_real t = f[best];
        f[best] = f[c];
        f[c] = t;
        EACH_FROM(r, c + 1, n) {
            f[r] -= a[n * r + c] * t;
        }
    }
    /* back substitution */
    for (int c = n - 1; c >= 0; --c) {
        const name_real t = f[c] * a[n * c + c];
        s[c] = t;
        EACH(r, c) {
            f[r] -= a[n * r + c] * t;
        }
    }
}

