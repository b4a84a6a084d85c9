/* Cosine and sine of an angle: polynomials of least error within an eighth of a turn of the next quarter. */
static void name_cosine_and_sine(name_real angle, name_real u[2])
{
    int quarter = 0;
    name_real x = angle;
    if (fabs(angle) > @eighth) {
        const name_real number = angle * @per_quarter;
        quarter = NEAREST_WHOLE(number);
        /* the quarter turn in three parts, the first of which have few digits, so that their products are exact */
        const name_real k = (name_real)quarter;
        x = ((angle - k * @quarter1) - k * @quarter2) - k * @quarter3;
    }
    const name_real square = x * x;
    const name_real s = x + x * square * (@sine);
    const name_real c = (1.0 - 0.5 * square) + square * square * (@cosine);
    u[0] = c;
    u[1] = s;
    if (quarter != 0) {
        const bool odd = ((unsigned int)quarter & 1U) != 0U;
        const name_real cosine = odd ? s : c;
        const name_real sine = odd ? c : s;
        u[0] = ((((unsigned int)quarter + 1U) & 2U) != 0U) ? -cosine : cosine;
        u[1] = (((unsigned int)quarter & 2U) != 0U) ? -sine : sine;
    }
}

