/* The angle in (-pi, pi] of a direction that is not zero, to 4e-8 and rounding: the polynomial of least error for atan up to 1. */
static name_real name_angle(name_real s, name_real c)
{
    const name_real x = fabs(c);
    const name_real y = fabs(s);
    const bool steep = y > x;
    const name_real ratio = steep ? (x / y) : (y / x);
    const name_real square = ratio * ratio;
    name_real angle = ratio * (@arctangent);
    if (steep) {
        angle = 1.5707963267948966 - angle;
    }
    if (c < 0.0) {
        angle = 3.141592653589793 - angle;
    }
    return (s < 0.0) ? -angle : angle;
}

