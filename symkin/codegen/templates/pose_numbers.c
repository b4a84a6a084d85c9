static name_pose pose_from(const name_real *numbers)
{
    name_pose pose;
    copy(numbers, pose.position, 3);
    copy(&numbers[3], pose.quaternion, 4);
    return pose;
}

static void numbers_of(const name_pose *pose, name_real *numbers)
{
    copy(pose->position, numbers, 3);
    copy(pose->quaternion, &numbers[3], 4);
}

