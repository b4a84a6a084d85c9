static @{p}_pose pose_from(const @{p}_real *numbers)
{
    @{p}_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const @{p}_pose *pose, @{p}_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}

