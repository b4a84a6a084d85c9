static int @{k}_factor(@{gp}@{k}_work *w)
{
    return @{k}_pivoted(@{ga}w);
}

static void @{k}_solve(@{k}_work *w)
{
    @{k}_pivoted_solve(w);
}

