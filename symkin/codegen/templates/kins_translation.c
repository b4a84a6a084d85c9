/* The pose of world coordinates: the orientation is that of home. */
POSE_OF_WORLD
{
    name_pose pose = name_home;
    @positions
    return pose;
}

/* World angles of a pose. */
WORLD_OF_POSE
{
    (void)pose;
    world->a = 0.0;
    world->b = 0.0;
    world->c = 0.0;
}

