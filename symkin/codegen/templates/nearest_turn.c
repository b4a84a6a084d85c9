/* An angle moved by whole turns next to another one. */
static NAME_SHARED name_real name_nearest(name_real angle, name_real near)
{
    const name_real number = (near - angle) * @{per_turn};
    name_real moved = angle;
    if ((@{fabs}(number) > @{half}) && (@{fabs}(number) < @{many})) {
        moved += @{turn} * (name_real)(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
    }
    return moved;
}

