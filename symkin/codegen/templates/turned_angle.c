/* An angle moved by whole turns: the one next to `near`, or the next one where the limits hold that and not the first. */
static name_real name_turned(name_real angle, name_real near, name_real low, name_real high)
{
    const name_real moved = name_nearest(angle, near);
    const name_real other = moved + ((moved > high) ? -6.283185307179586 : ((moved < low) ? 6.283185307179586 : 0.0));
    return ((other >= low) && (other <= high)) ? other : moved;
}

