/* The pose of world coordinates: the orientation is that of home. */
static name_pose name_pose_of(const EmcPose *world)
{
    name_pose pose = name_home;
    @positions
    return pose;
}

/* World angles of a pose. */
static void name_world_of(const name_pose *pose, EmcPose *world)
{
    (void)pose;
    world->a = 0.0;
    world->b = 0.0;
    world->c = 0.0;
}

