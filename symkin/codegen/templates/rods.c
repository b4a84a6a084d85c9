@{p}_status @{p}_inverse(@{gp}const @{p}_pose *pose, @{real} joints[6])
{
    @{p}_direct_work w;
    @{p}_status status = @{p}_unit(pose, w.x);
    if (status == @{P}_OK) {
        @{p}_legs(@{ga}&w);
        status = @{p}_check(@{ga}w.k);
        if (status == @{P}_OK) {
@{copy_joints}
        } else {
            status = @{p}_verdict(w.x, 3, status);
        }
    }
    return status;
}

@{p}_status @{p}_jacobian(@{gp}const @{p}_pose *pose, @{real} jacobian[36])
{
    @{real} x[7];
    @{p}_status status = @{p}_unit(pose, x);
    if (status == @{P}_OK) {
@{jacobian}
        if (!(shortest > @{zero})) {
            status = @{p}_verdict(x, 3, @{P}_SINGULAR);
        } else {
@{store_jacobian}
        }
    }
    return status;
}

