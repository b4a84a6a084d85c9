int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags)
{
    static const double unit[@{nq}] = { @{joint_units} };
    double joints[@{nq}];
    @{p}_pose pose;
@{geometry}
    (void)fflags;
    (void)iflags;
    for (int i = 0; i < @{nq}; ++i) {
        joints[i] = joint[i] / unit[i];
    }
    if (@{p}_direct(@{ga}joints, &pose) != @{P}_OK) {
        return -1;
    }
    @{p}_world_of(&pose, world);
    return 0;
}

/* The joints that are there when it is called are the guess. */
int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags, KINEMATICS_FORWARD_FLAGS *fflags)
{
    static const double unit[@{nq}] = { @{joint_units} };
    const @{p}_pose pose = @{p}_pose_of(world);
    double joints[@{nq}];
@{geometry}
    (void)iflags;
    (void)fflags;
    for (int i = 0; i < @{nq}; ++i) {
        joints[i] = joint[i] / unit[i];
    }
    if (@{p}_inverse(@{ga}0, &pose, joints, joints, 0) != @{P}_OK) {
        return -1;
    }
    for (int i = 0; i < @{nq}; ++i) {
        joint[i] = joints[i] * unit[i];
    }
    return 0;
}

