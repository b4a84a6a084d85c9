/* The pose of world coordinates. */
POSE_OF_WORLD
{
    const double a = 0.5 * world->a / NAME_DEGREES;
    const double b = 0.5 * world->b / NAME_DEGREES;
    const double c = 0.5 * world->c / NAME_DEGREES;
    name_pose pose;
    @from_home
    @positions
    pose.quaternion[0] = cos(a) * cos(b) * cos(c) + sin(a) * sin(b) * sin(c);
    pose.quaternion[1] = sin(a) * cos(b) * cos(c) - cos(a) * sin(b) * sin(c);
    pose.quaternion[2] = cos(a) * sin(b) * cos(c) + sin(a) * cos(b) * sin(c);
    pose.quaternion[3] = cos(a) * cos(b) * sin(c) - sin(a) * sin(b) * cos(c);
    return pose;
}

/* World angles of a pose; where B is a right angle, C is 0. */
WORLD_OF_POSE
{
    const double *const q = pose->quaternion;
    const double zx = 2.0 * (q[1] * q[3] - q[0] * q[2]);
    const double cosine = sqrt(fmax(0.0, 1.0 - zx * zx));
    world->b = atan2(-zx, cosine) * NAME_DEGREES;
    if (cosine > 1e-7) {
        world->a = atan2(2.0 * (q[2] * q[3] + q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2])) * NAME_DEGREES;
        world->c = atan2(2.0 * (q[1] * q[2] + q[0] * q[3]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3])) * NAME_DEGREES;
    } else {
        world->a = ((zx < 0.0) ? 2.0 : -2.0) * atan2(q[1], q[0]) * NAME_DEGREES;
        world->c = 0.0;
    }
}

