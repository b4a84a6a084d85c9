/* Pose coordinates of a pose. */
static @{p}_status @{p}_pose_coordinates(@{gp}const @{p}_pose *pose, @{real} c[@{count}])
{
    @{real} x[7];
    @{p}_status status = @{p}_normalise_pose(@{ga}pose, x);
    if (status == @{P}_OK) {
@{body}
    }
    return status;
}

