/* Joint values of a pose, limb by limb. */
@{p}_status @{p}_inverse(@{gp}const @{p}_pose *pose, @{real} joints[@{nq}])
{
    @{real} c[@{nc}];
    @{real} q[@{nq}] = { @{zero} };
    @{real} passive[@{np}] = { @{zero} };
    @{p}_status status = @{p}_pose_coordinates(@{ga}pose, c);
    if (status == @{P}_OK) {
        status = @{p}_solve_limbs(@{ga}c, q, passive@{feasible});
        if (status != @{P}_OK) {
            status = @{P}_OUT_OF_RANGE;
        } else {
@{within_middle}
            status = @{p}_check_limits(@{ga}q);
        }
@{inverse_passive}
        if (status == @{P}_OK) {
@{copy_joints}
        }
    }
    return status;
}

/* Joint rates by the platform's twist, limb by limb: each limb's matrix solved for its right-hand sides. */
@{static_own}@{p}_status @{jacobian}(@{gp}const @{p}_pose *pose, @{real} rates[@{nq} * 6])
{
    @{real} c[@{nc}];
    @{real} jacobian[@{nq} * 6] = { @{zero} };
    @{p}_status status = @{p}_pose_coordinates(@{ga}pose, c);
    if (status == @{P}_OK) {
@{rates}
        if ((status == @{P}_OK) && (@{p}_check_finite(jacobian, @{nq} * 6, @{P}_OK) != @{P}_OK)) {
            status = @{P}_SINGULAR;
        }
        if (status == @{P}_OK) {
            for (int i = 0; i < @{nq} * 6; ++i) {
                rates[i] = jacobian[i];
            }
        } else if (status != @{P}_SINGULAR) {
            status = @{P}_OUT_OF_RANGE;
        } else {
            /* singular */
        }
    }
    return status;
}
