/* The first joint, from 0, whose value is outside its range or not finite; the number of joints where none is. */
static NAME_SHARED uint8_t name_first_beyond(GEOMETRY_GIVEN JOINTS_GIVEN)
{
    @tables
    uint8_t joint = 0U;
@use
    while ((joint < @{nq}U) && @inside) {
        ++joint;
    }
    return joint;
}

