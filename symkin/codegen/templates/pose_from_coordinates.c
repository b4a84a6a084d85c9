/* The pose of pose coordinates. */
static void @{p}_pose_from_coordinates(@{gp}const @{real} c[@{count}], @{p}_pose *pose)
{
@{use}
@{body}
}

