/* Derivatives of the rows by the joints, row by row. */
static void @{p}_joint_columns(const @{p}_direct_work *w, @{real} sides[@{nsides}])
{
    (void)w;
@{sides}
}

/* Rates of the found coordinates by those of the joints: the matrix solved for each joint's column. */
@{p}_status @{p}_jacobian(const @{real} joints[@{nq}], const @{real} found[@{nq}], @{real} jacobian[@{nj}])
{
    @{p}_direct_work w;
    @{real} sides[@{nsides}];
    @{real} rates[@{nj}];
@{y}
    @{p}_status status = @{p}_limit_joints(@{P}_OK, joints);
    status = @{p}_limit_found(status, found);
@{state}
    if (status == @{P}_OK) {
@{set}
        @{p}_direct_rows(&w);
        if (!(@{p}_direct_residual(&w) <= @{near})) {
            status = @{P}_OUT_OF_RANGE; /* no configuration has both */
        } else if (@{singular}) {
            status = @{P}_SINGULAR;
        } else {
            @{p}_joint_columns(&w, sides);
            for (int j = 0; j < @{nq}; ++j) {
                for (int i = 0; i < @{m}; ++i) {
                    w.f[i] = sides[@{nq} * i + j];
                }
                @{p}_direct_solve(&w);
@{rates}
            }
            status = (@{p}_check_finite(rates, @{nj}, @{P}_OK) == @{P}_OK) ? @{P}_OK : @{P}_SINGULAR;
        }
    }
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nj}; ++i) {
            jacobian[i] = rates[i];
        }
    }
    return status;
}

/* found_rates = J joint_rates. */
@{p}_status @{p}_rates(const @{real} joints[@{nq}], const @{real} found[@{nq}], const @{real} joint_rates[@{nq}], @{real} found_rates[@{nq}])
{
    @{real} jacobian[@{nj}];
    @{p}_status status = @{p}_check_finite(joint_rates, @{nq}, @{P}_OK);
    if (status == @{P}_OK) {
        status = @{p}_jacobian(joints, found, jacobian);
    }
    if (status == @{P}_OK) {
        @{real} result[@{nq}];
        for (int i = 0; i < @{nq}; ++i) {
            result[i] = @{zero};
            for (int j = 0; j < @{nq}; ++j) {
                result[i] += jacobian[@{nq} * i + j] * joint_rates[j];
            }
        }
        status = @{p}_give(result, found_rates);
    }
    return status;
}

/* joint_torques = J^T found_torques: the power of the joints is that of the found coordinates. */
@{p}_status @{p}_torques(const @{real} joints[@{nq}], const @{real} found[@{nq}], const @{real} found_torques[@{nq}], @{real} joint_torques[@{nq}])
{
    @{real} jacobian[@{nj}];
    @{p}_status status = @{p}_check_finite(found_torques, @{nq}, @{P}_OK);
    if (status == @{P}_OK) {
        status = @{p}_jacobian(joints, found, jacobian);
    }
    if (status == @{P}_OK) {
        @{real} result[@{nq}];
        for (int j = 0; j < @{nq}; ++j) {
            result[j] = @{zero};
            for (int i = 0; i < @{nq}; ++i) {
                result[j] += jacobian[@{nq} * i + j] * found_torques[i];
            }
        }
        status = @{p}_give(result, joint_torques);
    }
    return status;
}
