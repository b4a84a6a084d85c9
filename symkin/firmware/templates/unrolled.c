/* LU of the matrix, unrolled in an order of pivots chosen over sampled poses; the sign of the determinant, 0 where the
 * matrix is singular. A pivot far below its usual size is left to @{k}_pivoted. */
static int @{k}_factor(@{gp}@{k}_work *w)
{
    @{real} det;
    w->pivoted = false;
@{factor}
    if (!(w->spread < @{guard})) {
        return @{k}_pivoted(@{ga}w);
    }
    return (det @{sign} @{zero}) ? 1 : -1;
}

/* The step from w->f into w->f. */
static void @{k}_solve(@{k}_work *w)
{
    if (w->pivoted) {
        @{k}_pivoted_solve(w);
        return;
    }
@{solve}
}

