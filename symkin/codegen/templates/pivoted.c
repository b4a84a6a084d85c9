
/* The matrix -df/dstep into w->a, row by row: the fallback's start. */
static void solver_matrix(GEOMETRY_GIVEN solver_work *w)
{
@use
    @matrix
}

/* The factors in loops; the sign of the determinant, 0 where the matrix is singular. */
static NAME_COLD int solver_pivoted(GEOMETRY_GIVEN solver_work *w)
{
    TABLE(scale, @n, @column_scales)
    TABLE(least, @n, @least_pivots)
    solver_matrix(GEOMETRY w);
    w->pivoted = true;
    w->spread = 0.0;
    const int sign = name_lu(w->a, w->order, least, @n);
    EACH_WHILE(c, @n, (sign != 0)) {
        const name_real inverse = w->a[@n1 * c] * scale[c];
        w->spread += inverse * inverse;
    }
    return sign;
}
