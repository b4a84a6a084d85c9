/* The pose of pose coordinates. */
static void name_pose_from_coordinates(GEOMETRY_GIVEN const name_real c[@count], name_pose *pose)
{
@use
    @body
}

