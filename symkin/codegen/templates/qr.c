/* The @which into w->a, row by row. */
static void solver_matrix(GEOMETRY_GIVEN solver_work *w)
{
@use
    @matrix
}

/* QR of the @m x @n @which by modified Gram-Schmidt: Q in w->a, R in w->r with reciprocals on the diagonal; 0 where
 * its columns are dependent. */
static int solver_factor(GEOMETRY_GIVEN solver_work *w)
{
    solver_matrix(GEOMETRY w);
    w->spread = 0.0;
    EACH(c, @n) {
        /* the length of the column, its reciprocal on R's diagonal */
        name_real squared = 0.0;
        EACH(i, @m) {
            squared += w->a[@n * i + c] * w->a[@n * i + c];
        }
        if (!(squared > @singular * @singular)) {
            w->spread = 0.0;
            return 0;
        }
        const name_real inverse = 1.0 / sqrt(squared);
        w->r[@n * c + c] = inverse;
        w->spread += inverse * inverse;
        EACH(i, @m) {
            w->a[@n * i + c] *= inverse;
        }
        @others
    }
    return 1;
}

