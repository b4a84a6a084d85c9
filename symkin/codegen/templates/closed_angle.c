/* The angle in (-pi, pi] of a direction that is not zero, to 4e-8 and rounding: the polynomial of least error for atan up to 1. */
static @{real} @{p}_angle(@{real} s, @{real} c)
{
    const @{real} x = @{fabs}(c);
    const @{real} y = @{fabs}(s);
    const bool steep = y > x;
    const @{real} ratio = steep ? (x / y) : (y / x);
    const @{real} square = ratio * ratio;
    @{real} angle = ratio * (@{arctangent});
    if (steep) {
        angle = @{quarter} - angle;
    }
    if (c < @{zero}) {
        angle = @{half_turn} - angle;
    }
    return (s < @{zero}) ? -angle : angle;
}

