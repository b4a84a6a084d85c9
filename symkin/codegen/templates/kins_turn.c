/* The pose of world coordinates: what the platform cannot do is as at home. */
POSE_OF_WORLD
{
    const double half = 0.5 * world->c / NAME_DEGREES;
    name_pose pose = name_home;
    @positions
    pose.quaternion[0] = cos(half) * name_home.quaternion[0] - sin(half) * name_home.quaternion[3];
    pose.quaternion[1] = cos(half) * name_home.quaternion[1] - sin(half) * name_home.quaternion[2];
    pose.quaternion[2] = cos(half) * name_home.quaternion[2] + sin(half) * name_home.quaternion[1];
    pose.quaternion[3] = cos(half) * name_home.quaternion[3] + sin(half) * name_home.quaternion[0];
    return pose;
}

/* World angles of a pose, C its turn from home about z. */
WORLD_OF_POSE
{
    const double *const q = pose->quaternion;
    const double *const home = name_home.quaternion;
    const double cosine = DOT3(q, home) + q[3] * home[3];
    const double sine = q[3] * home[0] - q[0] * home[3] + q[2] * home[1] - q[1] * home[2];
    world->a = 0.0;
    world->b = 0.0;
    world->c = 2.0 * atan2((cosine < 0.0) ? -sine : sine, fabs(cosine)) * NAME_DEGREES;
}

