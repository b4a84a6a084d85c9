/* The pose of world coordinates. */
POSE_OF_WORLD
{
    const double half = 0.5 / NAME_DEGREES;
    const double a = cos(half * world->a);
    const double b = cos(half * world->b);
    const double c = cos(half * world->c);
    const double x = sin(half * world->a);
    const double y = sin(half * world->b);
    const double z = sin(half * world->c);
    name_pose pose;
    @from_home
    @positions
    pose.quaternion[0] = a * b * c + x * y * z;
    pose.quaternion[1] = x * b * c - a * y * z;
    pose.quaternion[2] = a * y * c + x * b * z;
    pose.quaternion[3] = a * b * z - x * y * c;
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

