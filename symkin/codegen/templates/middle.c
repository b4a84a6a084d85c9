/* Whether the middle of the part that is tried is reached as its end is: three steps from the part's begin with its factors, each
 * judged by the next. Where known values turn, the rows' change is bent: both ends of a part may have a configuration, and
 * points between them none. */
static @{COLD} bool @{k}_reaches_middle(@{gp}@{k}_work *w, const @{real} to[@{nto}], @{real} middle, @{real} still2)
{
    @{real} end[@{ns}];
    @{real} size[3];
@{aimed_at}
@{to_begin}
    @{k}_set_target(@{ga}w, to, middle);
    for (int i = 0; i < 3; ++i) {
        @{k}_rows(@{ga}w);
        @{k}_solve(w);
        size[i] = @{k}_apply_step(@{ga}w);
    }
@{to_end}
    return (size[2] <= still2) || ((size[1] <= @{contraction2} * size[0]) && (size[2] <= @{later2} * size[1]));
}

