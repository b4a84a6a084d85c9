/* Pose coordinates of a pose. */
static name_status name_pose_coordinates(GEOMETRY_GIVEN const name_pose *pose, name_real c[@count])
{
    name_real x[7];
    name_status status = name_normalise_pose(GEOMETRY pose, x);
    IF_OK {
        @body
    }
    return status;
}

