/* An angle moved by whole turns: the one next to `near` within the limits, where they hold one. */
static @{SHARED} @{real} @{p}_turned(@{real} angle, @{real} near, @{real} low, @{real} high)
{
    @{real} moved = angle;
    if (@{fabs}(near - angle) > @{half_turn}) {
        const @{real} number = (near - angle) * @{per_turn};
        moved += @{turn} * (@{real})(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
    }
    if (moved > high) {
        moved -= @{turn};
    } else if (moved < low) {
        moved += @{turn};
    } else {
        /* within */
    }
    return moved;
}

