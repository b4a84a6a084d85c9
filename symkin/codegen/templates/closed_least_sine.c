/* The same of a length that is the sine of an angle, which changes by at most `speed`, by the first terms of arc sine and sine. */
static name_real solver_least_sine(solver_work *w, int k, name_real rounding, name_real speed)
{
    const name_real left = w->left[k] - rounding;
    const name_real guard = w->guard[k] - rounding;
    const bool above = (left > @{zero}) && (guard > @{zero});
    const name_real ends = above ? (@{sqrt}(left) * (@{one} + @{sixth} * left) + @{sqrt}(guard) * (@{one} + @{sixth} * guard)) : @{zero};
    const name_real least = @{half} * (ends - @{raised} * speed);
    solver_take(w, @{raised} * @{raised} * speed * speed, ends * ends);
    return (least > @{zero}) ? (least * (@{one} - @{sixth} * least * least)) : @{one};
}

