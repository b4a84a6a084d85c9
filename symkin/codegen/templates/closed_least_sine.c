/* The same of a length that is the sine of an angle, which changes by at most `speed`, by the first terms of arc sine and sine. */
static @{real} @{k}_least_sine(@{k}_work *w, int k, @{real} rounding, @{real} speed)
{
    const @{real} left = w->left[k] - rounding;
    const @{real} guard = w->guard[k] - rounding;
    const bool above = (left > @{zero}) && (guard > @{zero});
    const @{real} ends = above ? (@{sqrt}(left) * (@{one} + @{sixth} * left) + @{sqrt}(guard) * (@{one} + @{sixth} * guard)) : @{zero};
    const @{real} least = @{half} * (ends - @{raised} * speed);
    @{k}_take(w, @{raised} * @{raised} * speed * speed, ends * ends);
    return (least > @{zero}) ? (least * (@{one} - @{sixth} * least * least)) : @{one};
}

