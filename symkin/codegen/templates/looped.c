static void @{k}_solve(@{k}_work *w)
{
    @{k}_pivoted_solve(w);
}

