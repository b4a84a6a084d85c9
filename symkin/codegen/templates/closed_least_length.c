/* Takes a length, the root of a guard, that changes by at most `speed`: what it is at least, which is never below `always`. */
static @{real} @{k}_least_length(@{k}_work *w, int k, @{real} rounding, @{real} speed, @{real} always)
{
    const @{real} left = w->left[k] - rounding;
    const @{real} guard = w->guard[k] - rounding;
    const @{real} ends = ((left > @{zero}) && (guard > @{zero})) ? (@{sqrt}(left) + @{sqrt}(guard)) : @{zero};
    const @{real} least = @{half} * (ends - @{raised} * speed);
    if (!(always > @{zero})) {
        @{k}_take(w, @{raised} * @{raised} * speed * speed, ends * ends);
    }
    return (least > always) ? least : ((always > @{zero}) ? always : @{one});
}

