/* Normalises a pose: (x, y, z, qw, qx, qy, qz) with a quaternion of unit length. Lengths off by more than 1e-2 are refused,
 * and positions so far away that squares could overflow. */
static name_status name_normalise_pose(GEOMETRY_GIVEN const name_pose *pose, name_real x[7])
{
    const name_real *const q = pose->quaternion;
    name_status status = NAME_OK;
    name_real squared = 0.0;
    name_real inverse = 1.0;
    x[0] = pose->position[0];
    x[1] = pose->position[1];
    x[2] = pose->position[2];
    if (@bounded) {
        squared = DOT3(q, q) + q[3] * q[3];
    }
    if ((squared >= 0.98) && (squared <= 1.0201)) {
        inverse = 1.0 / sqrt(squared);
    } else {
        status = name_check_finite(q, 4, name_check_finite(x, 3, NAME_OUT_OF_RANGE));
    }
    x[3] = q[0] * inverse;
    x[4] = q[1] * inverse;
    x[5] = q[2] * inverse;
    x[6] = q[3] * inverse;
    @taken
    return @checked;
}

