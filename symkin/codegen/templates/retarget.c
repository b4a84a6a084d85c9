/* Aims anew at a part of the line from the guess's joint values to the given ones, and puts the state back to the part
 * that is done. The guess's joint values are computed again, which takes less room than to keep them. */
static @{COLD} void @{p}_direct_retarget(@{gp}@{p}_direct_work *w, const @{real} to[6], @{real} part, @{real} done)
{
    const @{real} *goal = to;
    (void)@{p}_normalise_pose(@{ga}w->guess, w->x);
    if (part < @{one}) {
        /* joint values at the guess into w->k, the part of the line into w->f */
        @{p}_rod_values(@{ga}w);
        for (int i = 0; i < 6; ++i) {
            w->f[i] = w->k[i] + part * (to[i] - w->k[i]);
        }
        goal = w->f;
    }
    @{p}_direct_set_target(@{ga}w, goal);
    if (done > @{zero}) {
        for (int i = 0; i < 7; ++i) {
            w->x[i] = w->x0[i];
        }
    }
}

