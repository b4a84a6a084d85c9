/* Sine of a guess's angle to 1e-6, by which the nearest solution is told; 0 for angles of too many turns. */
static name_real name_sine(name_real angle)
{
    const name_real number = angle * @{per_turn};
    name_real sine = @{zero};
    if (@{fabs}(number) < @{many}) {
        name_real x = angle - @{turn} * (name_real)(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
        if (x > @{quarter}) {
            x = @{half_turn} - x;
        } else if (x < -@{quarter}) {
            x = -@{half_turn} - x;
        } else {
            /* within a quarter turn */
        }
        const name_real square = x * x;
        sine = x * (@{sine});
    }
    return sine;
}

