/* The twist of joint rates: the closure's linear system at the pose. */
@{static_own}@{p}_status @{twist}(@{gp}const @{p}_pose *pose, const @{real} rates[@{nq}], @{real} twist[6])
{
    @{k}_work work;
    @{k}_work *const w = &work;
    @{real} c[@{nc}];
    @{real} passive[@{np}] = { @{zero} };
    @{p}_status status = @{p}_pose_coordinates(@{ga}pose, c);
    if (status == @{P}_OK) {
        status = (@{p}_solve_limbs(@{ga}c, @{into}, passive@{feasible}) == @{P}_OK) ? @{P}_OK : @{P}_OUT_OF_RANGE;
    }
    status = @{p}_check_speeds(rates, @{nq}, status);
    if (status == @{P}_OK) {
@{state}
        if (@{singular_there}) {
            status = @{P}_SINGULAR;
        } else {
@{sides}
            @{k}_solve(w);
            status = @{p}_check_finite(w->f, @{nf}, @{P}_OK);
        }
    }
    if (status == @{P}_OK) {
@{store}
    }
    return status;
}

