/* An angle moved by whole turns next to another one. */
static NAME_SHARED name_real name_nearest(name_real angle, name_real near)
{
    const name_real number = (near - angle) * 0.15915494309189535;
    name_real moved = angle;
    if ((fabs(number) > 0.5) && (fabs(number) < @many)) {
        moved += 6.283185307179586 * (name_real)NEAREST_WHOLE(number);
    }
    return moved;
}

