/* @{about} */
@{p}_status @{p}_@{function}(const @{real} joints[@{nq}], const @{real} found[@{nq}], @{written})
{
    @{k}_work w;
    @{real} sides[@{most_sides}];
    @{real} rates[@{nrates}];
@{y}
@{kept}
    @{p}_status status = @{p}_limit_joints(@{P}_OK, joints);
    status = @{p}_limit_found(status, found);
@{state}
    if (status == @{P}_OK) {
@{set}
        @{k}_rows(&w);
        if (!(@{k}_residual(&w) <= @{near})) {
            status = @{P}_OUT_OF_RANGE; /* no configuration has both */
        } else if (@{singular}) {
            status = @{P}_SINGULAR;
        } else {
            @{p}_@{columns}(&w, sides);
            for (int j = 0; j < @{nq}; ++j) {
                for (int i = 0; i < @{m}; ++i) {
                    w.f[i] = sides[@{nq} * i + j];
                }
                @{k}_solve(&w);
@{rates}
            }
@{more}
            status = (@{p}_check_finite(rates, @{nrates}, @{P}_OK) == @{P}_OK) ? @{P}_OK : @{P}_SINGULAR;
        }
    }
    if (status == @{P}_OK) {
@{store}
    }
    return status;
}

