/* The first joint, from 0, that is not proved to keep its limits on the part of the line between two points a and b; the number of joints
 * where all are. A joint that is beyond them at b goes before one that bends too much. */
static uint8_t @{p}_first_leaving(@{k}_work *w, const @{real} a[@{nn}], const @{real} b[@{nn}])
{
    static const @{real} low[@{nn}] = { @{lows} };
    static const @{real} high[@{nn}] = { @{highs} };
    static const @{real} per_length[@{nn}] = { @{per_lengths} };
    static const bool limited[@{nn}] = { @{limited} };
    uint8_t joint = @{nn}U;
    for (int i = @{last}; i >= 0; --i) {
        if (limited[i]) {
            const bool rises = (a[i] < b[i]);
            const @{real} below = ((rises ? a[i] : b[i]) - low[i]) * per_length[i];
            const @{real} above = (high[i] - (rises ? b[i] : a[i])) * per_length[i];
            const @{real} spare = (below < above) ? below : above;
            /* one that goes too little to come there and back, or bends too little */
            if (!(@{raised} * w->speed[i] < @{two} * spare + w->way[i])) {
                @{k}_take(w, @{raised} * @{half} * w->change[i], @{four} * spare + w->way[i]);
                joint = w->kept ? joint : (uint8_t)i;
                w->kept = true;
            }
        }
    }
    if (joint < @{nn}U) {
        const uint8_t beyond = @{p}_first_beyond(b);
        joint = (beyond < @{nn}U) ? beyond : joint;
    }
    return joint;
}

