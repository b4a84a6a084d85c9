/* Takes a guard that bends by at most `bend` times t (1 - t) below its chord: what is left of it at least. */
static name_real solver_least(solver_work *w, int k, name_real rounding, name_real bend)
{
    const bool falls = w->guard[k] < w->left[k];
    const name_real lesser = falls ? w->guard[k] : w->left[k];
    const name_real rise = falls ? (w->left[k] - lesser) : (w->guard[k] - lesser);
    const name_real over = @{raised} * bend - rise;
    const name_real least = (lesser - rounding) - ((over > @{zero}) ? (@{quarter_part} * over) : @{zero});
    solver_take(w, @{raised} * bend, @{four} * (lesser - rounding) + rise);
    w->kept = w->kept && (least > @{zero});
    return (least > @{zero}) ? least : @{one};
}

