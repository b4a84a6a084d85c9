static int @{k}_factor(@{gp}@{k}_work *w)
{
    return @{k}_pivoted(@{ga}w);
}

static void @{k}_solve(@{k}_work *w)
{
    @{k}_pivoted_solve(w);
}

/* Smallest pivot of the matrix with rows and columns scaled. */
static @{real} @{k}_min_pivot(const @{k}_work *w)
{
    @{real} largest = @{zero};
    for (int i = 0; i < @{n}; ++i) {
        const @{real} size = @{fabs}(w->a[@{n1} * i]);
        if (size > largest) {
            largest = size;
        }
    }
    return @{one} / largest;
}
