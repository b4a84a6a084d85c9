/* The twist of joint rates: the Jacobian's linear system, lengths and angles times the size. */
@{static_own}@{p}_status @{twist}(@{gp}const @{p}_pose *pose, const @{real} rates[@{nq}], @{real} twist[6])
{
    static const @{real} row_scale[@{nq}] = { @{row_scales} };
    static const @{real} column_scale[@{nq}] = { @{column_scales} };
    static const uint8_t column[@{nq}] = { @{columns} };
    static const @{real} least[@{nq}] = { @{least_pivots} };
    @{real} jacobian[@{nq} * 6];
    @{real} a[@{nq} * @{nq}];
    @{real} f[@{nq}];
    uint8_t order[@{nq}];
    @{p}_status status = @{p}_check_speeds(rates, @{nq}, @{jacobian}(@{ga}pose, jacobian));
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nq}; ++i) {
            for (int j = 0; j < @{nq}; ++j) {
                a[@{nq} * i + j] = jacobian[6 * i + (int)column[j]] * row_scale[i] * column_scale[j];
            }
            f[i] = rates[i] * row_scale[i];
        }
        if (@{p}_lu(a, order, least, @{nq}) == 0) {
            status = @{P}_SINGULAR;
        }
    }
    if (status == @{P}_OK) {
        @{p}_lu_solve(a, order, f, @{nq});
@{others}
        for (int i = 0; i < @{nq}; ++i) {
            twist[column[i]] = f[i] * column_scale[i];
        }
    }
    return status;
}

