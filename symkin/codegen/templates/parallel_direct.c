/* Reads joints and guess: checks both and sets the state to the guess's. What passes is finite and within bounds. */
static NAME_SHARED name_status name_read_guess(GEOMETRY_GIVEN name_direct_work *w, JOINTS_GIVEN, const name_pose *guess)
{
    name_status status;
    @enter
    /* NaN or infinity anywhere comes first */
    return name_limit_joints(GEOMETRY status, joints);
}

/* Writes the pose of the state. */
static NAME_SHARED void name_write_pose(GEOMETRY_GIVEN const name_direct_work *w, name_pose *pose)
{
@use
    @leave
}

name_status name_direct(GEOMETRY_GIVEN const name_config *config, JOINTS_GIVEN, const name_pose *guess, name_pose *pose, name_info *info)
{
    USUAL_CONFIG
    name_direct_work w;
    name_status status = name_read_guess(GEOMETRY &w, joints, guess);
    CHECK_CONFIG
    IF_OK {
        @unwrap
        status = name_direct_newton(GEOMETRY &w, @to, (config != NULL) ? config : &usual, info);
        @reached
        @check_branch
        @direct_passive
        @stand
        IF_OK {
            @written
        }
    } else {
        name_write_no_step(GEOMETRY info, joints);
    }
    return status;
}

name_status name_track(GEOMETRY_GIVEN JOINTS_GIVEN, name_pose *pose, name_info *info)
{
    name_direct_work w;
    name_status status = name_read_guess(GEOMETRY &w, joints, pose);
    bool stepped = false;
    IF_OK {
        @unwrap
        /* one step of Newton's method from the last pose */
        name_direct_set_target(GEOMETRY &w, @to@whole);
        @keep_known
        name_direct_rows(GEOMETRY &w);
        if (@track_factor) {
            status = NAME_SINGULAR;
        } else {
            stepped = true;
            const name_real size = name_direct_step(GEOMETRY &w);
            name_write_info(info, 1U, @kappa * size, size, w.spread);
            if (size <= @track2) {
                @write_tracked
            } else {
                status = NAME_WRONG_BRANCH;
            }
        }
    }
    if (!stepped) {
        name_write_no_step(GEOMETRY info, joints);
    }
    return status;
}
