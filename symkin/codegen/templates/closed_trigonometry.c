/* Sine of a guess's angle to 1e-6, by which the nearest solution is told; 0 for angles of too many turns. */
static name_real name_sine(name_real angle)
{
    const name_real number = angle * 0.15915494309189535;
    name_real sine = 0.0;
    if (fabs(number) < @many) {
        name_real x = angle - 6.283185307179586 * (name_real)NEAREST_WHOLE(number);
        if (x > 1.5707963267948966) {
            x = 3.141592653589793 - x;
        } else if (x < -1.5707963267948966) {
            x = -3.141592653589793 - x;
        } else {
            /* within a quarter turn */
        }
        const name_real square = x * x;
        sine = x * (@sine);
    }
    return sine;
}

