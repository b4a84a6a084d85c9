/* Aims at another part of the line from the guess's joint values; the state is put back to the part that is done. */
static @{COLD} void @{p}_direct_again(@{gp}@{p}_direct_work *w, const @{real} to[6], @{real} part, @{real} done)
{
    const @{real} *goal = to;
    if (part < @{one}) {
        (void)@{p}_unit(w->guess, w->x);
@{legs}
        for (int i = 0; i < 6; ++i) {
            w->f[i] = w->k[i] + part * (to[i] - w->k[i]);
        }
        goal = w->f;
    }
    @{p}_direct_target(@{ga}w, goal);
    if (done > @{zero}) {
        for (int i = 0; i < 7; ++i) {
            w->x[i] = w->x0[i];
        }
    }
}

