/* The twist of joint rates: the Jacobian's linear system, lengths and angles times the size, by elimination with row exchanges. */
@{static_own}@{p}_status @{twist}(@{gp}const @{p}_pose *pose, const @{real} rates[@{nq}], @{real} twist[6])
{
    static const @{real} row_scale[@{nq}] = { @{row_scales} };
    static const @{real} column_scale[@{nq}] = { @{column_scales} };
    static const uint8_t column[@{nq}] = { @{columns} };
    @{real} jacobian[@{nq} * 6];
    @{real} a[@{nq}][@{nq} + 1];
    @{p}_status status = @{p}_check_speeds(rates, @{nq}, @{jacobian}(@{ga}pose, jacobian));
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nq}; ++i) {
            for (int j = 0; j < @{nq}; ++j) {
                a[i][j] = jacobian[6 * i + (int)column[j]] * row_scale[i] * column_scale[j];
            }
            a[i][@{nq}] = rates[i] * row_scale[i];
        }
        for (int c = 0; (c < @{nq}) && (status == @{P}_OK); ++c) {
            /* the largest entry of the column becomes the pivot */
            int best = c;
            for (int i = c + 1; i < @{nq}; ++i) {
                best = (@{fabs}(a[i][c]) > @{fabs}(a[best][c])) ? i : best;
            }
            if (!(@{fabs}(a[best][c]) > @{singular})) {
                status = @{P}_SINGULAR;
            } else {
                for (int j = c; j <= @{nq}; ++j) {
                    const @{real} t = a[c][j];
                    a[c][j] = a[best][j];
                    a[best][j] = t;
                }
                /* clear the column in all other rows */
                for (int i = 0; i < @{nq}; ++i) {
                    const @{real} factor = a[i][c] / a[c][c];
                    for (int j = c; (i != c) && (j <= @{nq}); ++j) {
                        a[i][j] -= factor * a[c][j];
                    }
                }
            }
        }
    }
    if (status == @{P}_OK) {
@{others}
        for (int i = 0; i < @{nq}; ++i) {
            twist[column[i]] = a[i][@{nq}] / a[i][i] * column_scale[i];
        }
    }
    return status;
}

