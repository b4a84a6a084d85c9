/* The tool's pose, its quaternion of unit length and with w >= 0. */
@{p}_status @{p}_direct(@{gp}const @{real} joints[@{nq}], @{p}_pose *pose)
{
    @{p}_status status = @{p}_check_limits(@{ga}joints);
    if (status == @{P}_OK) {
        @{real} x[7];
        @{p}_forward(@{ga}joints, x);
@{told}
        const @{real} sign = (x[3] < @{zero}) ? -@{one} : @{one};
        const @{real} inverse = sign / @{sqrt}(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6]);
        pose->position[0] = x[0];
        pose->position[1] = x[1];
        pose->position[2] = x[2];
        pose->quaternion[0] = x[3] * inverse;
        pose->quaternion[1] = x[4] * inverse;
        pose->quaternion[2] = x[5] * inverse;
        pose->quaternion[3] = x[6] * inverse;
    }
    return status;
}

/* @{how} along the line of tool poses from the guess's to the given one. */
@{p}_status @{p}_inverse(@{gp}const @{p}_config *config, const @{p}_pose *pose, const @{real} guess[@{nq}], @{real} joints[@{nq}], @{p}_info *info)
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    @{work}
    @{real} to[7];
    @{p}_status status = @{p}_check_finite(guess, @{nq}, @{p}_normalise_pose(@{ga}pose, to));
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    for (int i = @{last_joint}; i >= 0; --i) {
        if (!(@{fabs}(guess[i]) <= @{farthest_joint})) {
            status = (status == @{P}_OK) ? @{P}_OUT_OF_RANGE : status;
            if (info != NULL) {
                info->joint = (uint8_t)i;
            }
        }
    }
    if (config != NULL) {
        status = @{p}_check_config(config, status);
    }
    if (status == @{P}_OK) {
@{to_x}
@{solve}
        if (status == @{P}_OK) {
            status = @{p}_check_limits(@{ga}@{at});
            if (info != NULL) {
                info->joint = @{p}_first_beyond(@{ga}@{at});
            }
        }
        if (status == @{P}_OK) {
@{out}
        }
    }
    return status;
}

/* Twist of the tool by joint rates, from the derivative of the tool's pose@{in_own}. */
@{static_own}@{p}_status @{own_jacobian}(@{gp}const @{real} joints[@{nq}], @{real} jacobian[@{nj}])
{
    @{p}_status status = @{p}_check_limits(@{ga}joints);
@{use}
    if (status == @{P}_OK) {
@{jacobian}
    }
    return status;
}
