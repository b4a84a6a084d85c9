/* An angle moved by whole turns: the one next to `near` within the limits, where they hold one. */
static NAME_SHARED name_real name_turned(name_real angle, name_real near, name_real low, name_real high)
{
    name_real moved = angle;
    if (@{fabs}(near - angle) > @{half_turn}) {
        const name_real number = (near - angle) * @{per_turn};
        moved += @{turn} * (name_real)(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
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

