/* The first joint, from 0, that is not proved to keep its limits on the part of the line between two points a and b; the number of joints
 * where all are. A joint that is beyond them at b goes before one that bends too much. */
static uint8_t name_first_leaving(solver_work *w, const name_real a[@nn], const name_real b[@nn])
{
    TABLE(low, @nn, @lows)
    TABLE(high, @nn, @highs)
    TABLE(per_length, @nn, @per_lengths)
    static const bool limited[@nn] = { @limited };
    uint8_t joint = @{nn}U;
    for (int i = @last; i >= 0; --i) {
        if (limited[i]) {
            const bool rises = (a[i] < b[i]);
            const name_real below = ((rises ? a[i] : b[i]) - low[i]) * per_length[i];
            const name_real above = (high[i] - (rises ? b[i] : a[i])) * per_length[i];
            const name_real spare = (below < above) ? below : above;
            /* one that goes too little to come there and back, or bends too little */
            if (!(@raised * w->speed[i] < 2.0 * spare + w->way[i])) {
                solver_take(w, @raised * 0.5 * w->change[i], 4.0 * spare + w->way[i]);
                joint = w->kept ? joint : (uint8_t)i;
                w->kept = true;
            }
        }
    }
    if (joint < @{nn}U) {
        const uint8_t beyond = name_first_beyond(b);
        joint = (beyond < @{nn}U) ? beyond : joint;
    }
    return joint;
}

