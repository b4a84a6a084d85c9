/* The angle from one direction to another; up to an eighth of a turn by a polynomial, never less and by at most 7e-5 of it more. */
static name_real solver_turn(const name_real a[2], const name_real b[2])
{
    const name_real s = (b[1] * a[0]) - (b[0] * a[1]);
    const name_real c = (b[0] * a[0]) + (b[1] * a[1]);
    name_real way;
    if (fabs(s) < c) {
        const name_real ratio = s / c;
        const name_real square = ratio * ratio;
        way = ratio * (@near_arctangent);
    } else {
        way = atan2(s, c);
    }
    return way;
}

