/* Takes a length, the root of a guard, that changes by at most `speed`: what it is at least, which is never below `always`. */
static name_real solver_least_length(solver_work *w, int k, name_real rounding, name_real speed, name_real always)
{
    GUARD_ENDS
    const name_real ends = above ? (sqrt(left) + sqrt(guard)) : 0.0;
    const name_real moves = @raised * speed;
    const name_real least = 0.5 * (ends - moves);
    if (!(always > 0.0)) {
        solver_take(w, moves * moves, ends * ends);
    }
    return (least > always) ? least : ((always > 0.0) ? always : 1.0);
}

