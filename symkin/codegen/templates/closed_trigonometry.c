/* Sine of a guess's angle to 1e-6, by which the nearest solution is told; 0 for angles of too many turns. */
static @{real} @{p}_sine(@{real} angle)
{
    const @{real} number = angle * @{per_turn};
    @{real} sine = @{zero};
    if (@{fabs}(number) < @{many}) {
        @{real} x = angle - @{turn} * (@{real})(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
        if (x > @{quarter}) {
            x = @{half_turn} - x;
        } else if (x < -@{quarter}) {
            x = -@{half_turn} - x;
        } else {
            /* within a quarter turn */
        }
        const @{real} square = x * x;
        sine = x * (@{sine});
    }
    return sine;
}

