/* Takes a guard that bends by at most `bend` times t (1 - t) below its chord: what is left of it at least. */
static @{real} @{k}_least(@{k}_work *w, int k, @{real} rounding, @{real} bend)
{
    const bool falls = w->guard[k] < w->left[k];
    const @{real} lesser = falls ? w->guard[k] : w->left[k];
    const @{real} rise = falls ? (w->left[k] - lesser) : (w->guard[k] - lesser);
    const @{real} over = @{raised} * bend - rise;
    const @{real} least = (lesser - rounding) - ((over > @{zero}) ? (@{quarter_part} * over) : @{zero});
    @{k}_take(w, @{raised} * bend, @{four} * (lesser - rounding) + rise);
    w->kept = w->kept && (least > @{zero});
    return (least > @{zero}) ? least : @{one};
}

