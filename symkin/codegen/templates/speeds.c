/* @{about}: the Jacobian times the @{given}. */
@{p}_status @{p}_@{function}(@{gp}@{at}, const @{real} @{given}[@{columns}], @{real} @{function}[@{rows}])
{
    @{real} jacobian[@{nq} * 6];
    @{real} found[@{rows}];
    const @{p}_status status = @{p}_check_speeds(@{given}, @{columns}, @{p}_jacobian(@{ga}@{at_name}, jacobian));
    if (status == @{P}_OK) {
        for (int i = 0; i < @{rows}; ++i) {
            @{real} sum = @{zero};
            for (int j = 0; j < @{columns}; ++j) {
                sum += jacobian[@{columns} * i + j] * @{given}[j];
            }
            found[i] = sum;
        }
        /* twist and rates may be the same array */
        for (int i = 0; i < @{rows}; ++i) {
            @{function}[i] = found[i];
        }
    }
    return status;
}

/* The largest factor, up to 1, by which a twist keeps all joint rates within their limits. */
@{p}_status @{p}_feed(@{gp}@{at}, const @{real} twist[6], const @{real} rate_limits[@{nq}], @{real} *feed)
{
    @{real} rates[@{nq}];
    @{p}_status status = @{p}_check_finite(rate_limits, @{nq}, @{p}_rates(@{ga}@{at_name}, twist, rates@{no_info}));
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

