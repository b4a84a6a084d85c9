
/* The matrix -df/dstep into w->a, row by row: the fallback's start. */
static void @{k}_matrix(@{gp}@{k}_work *w)
{
@{use}
@{matrix}
}

/* The factors in loops; the sign of the determinant, 0 where the matrix is singular. */
static @{COLD} int @{k}_pivoted(@{gp}@{k}_work *w)
{
    static const @{real} scale[@{n}] = { @{column_scales} };
    static const @{real} least[@{n}] = { @{least_pivots} };
    @{k}_matrix(@{ga}w);
    w->pivoted = true;
    w->spread = @{zero};
    const int sign = @{p}_lu(w->a, w->order, least, @{n});
    for (int c = 0; (c < @{n}) && (sign != 0); ++c) {
        const @{real} inverse = w->a[@{n1} * c] * scale[c];
        w->spread += inverse * inverse;
    }
    return sign;
}
