int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags)
{
    static const double unit[@{nq}] = { @{joint_units} };
    double joints[@{nq}];
    @{p}_pose pose;
    @{p}_status status;
@{geometry}
    (void)fflags;
    (void)iflags;
    for (int i = 0; i < @{nq}; ++i) {
        joints[i] = joint[i] / unit[i];
    }
    /* the line from the last pose, else the one from home */
    status = @{p}_direct(@{ga}0, joints, &@{p}_last, &pose, 0);
    if (status != @{P}_OK) {
        status = @{p}_direct(@{ga}0, joints, &@{p}_home, &pose, 0);
    }
    if (status != @{P}_OK) {
        return -1;
    }
    @{p}_last = pose;
    @{p}_world_of(&pose, world);
    return 0;
}

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags, KINEMATICS_FORWARD_FLAGS *fflags)
{
    static const double unit[@{nq}] = { @{joint_units} };
    const @{p}_pose pose = @{p}_pose_of(world);
    double joints[@{nq}];
@{geometry}
    (void)iflags;
    (void)fflags;
    if (@{p}_inverse(@{ga}&pose, joints) != @{P}_OK) {
        return -1;
    }
    for (int i = 0; i < @{nq}; ++i) {
        joint[i] = joints[i] * unit[i];
    }
    @{p}_last = pose;
    return 0;
}

