/* The angle from one direction to another; up to an eighth of a turn by a polynomial, never less and by at most 7e-5 of it more. */
static @{real} @{k}_turn(const @{real} a[2], const @{real} b[2])
{
    const @{real} s = (b[1] * a[0]) - (b[0] * a[1]);
    const @{real} c = (b[0] * a[0]) + (b[1] * a[1]);
    @{real} way;
    if (@{fabs}(s) < c) {
        const @{real} ratio = s / c;
        const @{real} square = ratio * ratio;
        way = ratio * (@{near_arctangent});
    } else {
        way = @{arctangent2}(s, c);
    }
    return way;
}

