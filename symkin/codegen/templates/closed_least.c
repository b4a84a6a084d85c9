/* Takes a guard that bends by at most `bend` times t (1 - t) below its chord: what is left of it at least. */
static name_real solver_least(solver_work *w, int k, name_real rounding, name_real bend)
{
    const bool falls = w->guard[k] < w->left[k];
    const name_real lesser = falls ? w->guard[k] : w->left[k];
    const name_real rise = falls ? (w->left[k] - lesser) : (w->guard[k] - lesser);
    const name_real bends = @raised * bend;
    const name_real over = bends - rise;
    const name_real least = (lesser - rounding) - ((over > 0.0) ? (0.25 * over) : 0.0);
    solver_take(w, bends, 4.0 * (lesser - rounding) + rise);
    w->kept = w->kept && (least > 0.0);
    return (least > 0.0) ? least : 1.0;
}

