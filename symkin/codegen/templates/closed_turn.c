/* Cosine and sine of an angle: polynomials of least error within an eighth of a turn of the next quarter. */
static void @{p}_cosine_and_sine(@{real} angle, @{real} u[2])
{
    int quarter = 0;
    @{real} x = angle;
    if (@{fabs}(angle) > @{eighth}) {
        const @{real} number = angle * @{per_quarter};
        quarter = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
        /* the quarter turn in three parts, the first of which have few digits, so that their products are exact */
        const @{real} k = (@{real})quarter;
        x = ((angle - k * @{quarter1}) - k * @{quarter2}) - k * @{quarter3};
    }
    const @{real} square = x * x;
    const @{real} s = x + x * square * (@{sine});
    const @{real} c = (@{one} - @{half} * square) + square * square * (@{cosine});
    u[0] = c;
    u[1] = s;
    if (quarter != 0) {
        const bool odd = ((unsigned int)quarter & 1U) != 0U;
        const @{real} cosine = odd ? s : c;
        const @{real} sine = odd ? c : s;
        u[0] = ((((unsigned int)quarter + 1U) & 2U) != 0U) ? -cosine : cosine;
        u[1] = (((unsigned int)quarter & 2U) != 0U) ? -sine : sine;
    }
}

