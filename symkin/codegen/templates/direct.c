/* The state at the guess, and whether joints and guess can be used. */
static @{SHARED} @{p}_status @{p}_enter(@{gp}@{p}_direct_work *w, const @{real} joints[@{nq}], const @{p}_pose *guess)
{
    @{p}_status status = @{p}_check(@{ga}joints);
    if (status == @{P}_OK) {
@{enter}
    }
    return status;
}

/* The pose of the state. */
static @{SHARED} void @{p}_leave(@{gp}const @{p}_direct_work *w, @{p}_pose *pose)
{
@{use}
@{leave}
}

/* The status of a call that failed: whether its inputs are finite comes first. */
static @{COLD} @{p}_status @{p}_failed(const @{real} joints[@{nq}], const @{p}_pose *guess, @{p}_status status)
{
    return @{p}_verdict(guess->position, 3, @{p}_verdict(joints, @{nq}, status));
}

@{p}_status @{p}_direct(@{gp}const @{p}_config *config, const @{real} joints[@{nq}], const @{p}_pose *guess, @{p}_pose *pose, @{p}_info *info)
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    @{p}_direct_work w;
    @{p}_status status = @{p}_enter(@{ga}&w, joints, guess);
    if (status == @{P}_OK) {
@{towards}
        status = @{p}_direct_newton(@{ga}&w, @{to}, (config != NULL) ? config : &usual, info);
@{agrees}
        if (status == @{P}_OK) {
            @{p}_leave(@{ga}&w, pose);
        } else {
            status = @{p}_failed(joints, guess, status);
        }
    } else {
        @{p}_tell(info, 0U, @{huge}, @{zero}, @{zero});
    }
    return status;
}

@{p}_status @{p}_track(@{gp}const @{real} joints[@{nq}], @{p}_pose *pose, @{p}_info *info)
{
    @{p}_direct_work w;
    @{p}_status status = @{p}_enter(@{ga}&w, joints, pose);
    if (status == @{P}_OK) {
@{towards}
        @{p}_direct_target(@{ga}&w, @{to}@{whole});
        @{p}_direct_rows(@{ga}&w);
        if (@{track_factor}) {
            @{p}_tell(info, 0U, @{huge}, @{zero}, @{zero});
            status = @{p}_failed(joints, pose, @{P}_SINGULAR);
        } else {
            @{p}_direct_solve(&w);
            const @{real} size = @{p}_direct_move(@{ga}&w);
            @{p}_tell(info, 1U, @{kappa} * size, size, w.spread);
            if (size <= @{track2}) {
                @{p}_leave(@{ga}&w, pose);
            } else {
                status = @{p}_failed(joints, pose, @{P}_WRONG_BRANCH);
            }
        }
    } else {
        @{p}_tell(info, 0U, @{huge}, @{zero}, @{zero});
    }
    return status;
}
