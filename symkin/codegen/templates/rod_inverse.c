/* Joint values of a pose: lengths of the rod vectors, less the offsets. */
@{p}_status @{p}_inverse(@{gp}const @{p}_pose *pose, @{real} joints[6])
{
    @{p}_direct_work w;
    @{p}_status status = @{p}_normalise_pose(@{ga}pose, w.x);
    if (status == @{P}_OK) {
        @{p}_rod_values(@{ga}&w);
        status = @{p}_check_limits(@{ga}w.k);
        if (status == @{P}_OK) {
@{copy_joints}
        }
    }
    return status;
}

/* Rows (u_i, (R a_i) x u_i), u_i the unit vector along rod i: its rate by the platform's twist. */
@{p}_status @{p}_jacobian(@{gp}const @{p}_pose *pose, @{real} jacobian[36])
{
    @{real} x[7];
    @{p}_status status = @{p}_normalise_pose(@{ga}pose, x);
    if (status == @{P}_OK) {
@{jacobian}
        /* where a rod has no length there is no direction */
        if (!(shortest > @{zero})) {
            status = @{P}_SINGULAR;
        } else {
@{store_jacobian}
        }
    }
    return status;
}

