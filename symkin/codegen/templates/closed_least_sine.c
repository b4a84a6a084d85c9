/* The same of a length that is the sine of an angle, which changes by at most `speed`, by the first terms of arc sine and sine. */
static name_real solver_least_sine(solver_work *w, int k, name_real rounding, name_real speed)
{
    GUARD_ENDS
    const name_real ends = above ? (sqrt(left) * (1.0 + @sixth * left) + sqrt(guard) * (1.0 + @sixth * guard)) : 0.0;
    const name_real moves = @raised * speed;
    const name_real least = 0.5 * (ends - moves);
    solver_take(w, moves * moves, ends * ends);
    return (least > 0.0) ? (least * (1.0 - @sixth * least * least)) : 1.0;
}

