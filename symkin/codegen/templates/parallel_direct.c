/* Reads joints and guess: checks both and sets the state to the guess's. What passes is finite and within bounds. */
static @{SHARED} @{p}_status @{p}_read_guess(@{gp}@{p}_direct_work *w, const @{real} joints[@{nq}], const @{p}_pose *guess)
{
    const @{p}_status limits = @{p}_check_limits(@{ga}joints);
    @{p}_status status;
@{enter}
    /* NaN or infinity anywhere comes first */
    return ((status == @{P}_OK) || (limits == @{P}_NONFINITE)) ? limits : status;
}

/* Writes the pose of the state. */
static @{SHARED} void @{p}_write_pose(@{gp}const @{p}_direct_work *w, @{p}_pose *pose)
{
@{use}
@{leave}
}

@{p}_status @{p}_direct(@{gp}const @{p}_config *config, const @{real} joints[@{nq}], const @{p}_pose *guess, @{p}_pose *pose, @{p}_info *info)
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    @{p}_direct_work w;
    @{p}_status status = @{p}_read_guess(@{ga}&w, joints, guess);
    if (config != NULL) {
        status = @{p}_check_config(config, status);
    }
    if (status == @{P}_OK) {
@{unwrap}
        status = @{p}_direct_newton(@{ga}&w, @{to}, (config != NULL) ? config : &usual, info);
@{check_branch}
@{stand}
@{direct_passive}
        if (status == @{P}_OK) {
            @{p}_write_pose(@{ga}&w, pose);
        }
    } else {
        @{p}_write_no_step(@{ga}info, joints);
    }
    return status;
}

@{p}_status @{p}_track(@{gp}const @{real} joints[@{nq}], @{p}_pose *pose, @{p}_info *info)
{
    @{p}_direct_work w;
    @{p}_status status = @{p}_read_guess(@{ga}&w, joints, pose);
    bool stepped = false;
    if (status == @{P}_OK) {
@{unwrap}
        /* one step of Newton's method from the last pose */
        @{p}_direct_set_target(@{ga}&w, @{to}@{whole});
@{keep_known}
        @{p}_direct_rows(@{ga}&w);
        if (@{track_factor}) {
            status = @{P}_SINGULAR;
        } else {
            stepped = true;
            @{p}_direct_solve(&w);
            const @{real} size = @{p}_direct_apply_step(@{ga}&w);
            @{p}_write_info(info, 1U, @{kappa} * size, size, w.spread);
            if (size <= @{track2}) {
@{write_tracked}
            } else {
                status = @{P}_WRONG_BRANCH;
            }
        }
    }
    if (!stepped) {
        @{p}_write_no_step(@{ga}info, joints);
    }
    return status;
}
