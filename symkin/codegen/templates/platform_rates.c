/* Joint rates of a twist: the Jacobian times the twist. */
@{p}_status @{p}_rates(@{gp}const @{p}_pose *pose, const @{real} twist[6], @{real} rates[@{nq}])
{
    @{real} jacobian[@{nq} * 6];
    @{real} found[@{nq}];
    const @{p}_status status = @{p}_check_speeds(twist, 6, @{p}_jacobian(@{ga}pose, jacobian));
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nq}; ++i) {
            @{real} sum = @{zero};
            for (int j = 0; j < 6; ++j) {
                sum += jacobian[6 * i + j] * twist[j];
            }
            found[i] = sum;
        }
        /* twist and rates may be the same array */
        for (int i = 0; i < @{nq}; ++i) {
            rates[i] = found[i];
        }
    }
    return status;
}

/* The largest factor, up to 1, by which a twist keeps all joint rates within their limits. */
@{p}_status @{p}_feed(@{gp}const @{p}_pose *pose, const @{real} twist[6], const @{real} rate_limits[@{nq}], @{real} *feed)
{
    @{real} rates[@{nq}];
    @{p}_status status = @{p}_check_finite(rate_limits, @{nq}, @{p}_rates(@{ga}pose, twist, rates));
    @{real} most = @{one};
    for (int i = 0; (i < @{nq}) && (status == @{P}_OK); ++i) {
        const @{real} rate = @{fabs}(rates[i]);
        if (rate_limits[i] < @{zero}) {
            status = @{P}_OUT_OF_RANGE;
        } else if (rate * most > rate_limits[i]) {
            most = rate_limits[i] / rate;
        } else {
            /* within its limit */
        }
    }
    if (status == @{P}_OK) {
        *feed = most;
    }
    return status;
}

