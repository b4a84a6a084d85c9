/* The pose of world coordinates: the orientation is that of home. */
static @{p}_pose @{p}_pose_of(const EmcPose *world)
{
    @{p}_pose pose = @{p}_home;
@{positions}
    return pose;
}

/* World angles of a pose. */
static void @{p}_world_of(const @{p}_pose *pose, EmcPose *world)
{
    (void)pose;
    world->a = 0.0;
    world->b = 0.0;
    world->c = 0.0;
}

