/* @about */
name_status name_@function(JOINTS_GIVEN, const name_real found[@nq], @written)
{
    solver_work w;
    name_real sides[@most_sides];
    name_real rates[@nrates];
    @y
    @kept
    name_status status = name_limit_joints(NAME_OK, joints);
    status = name_limit_found(status, found);
    @state
    IF_OK {
        @set
        solver_rows(&w);
        if (!(solver_residual(&w) <= @near)) {
            status = NAME_OUT_OF_RANGE; /* no configuration has both */
        } else if (@singular) {
            status = NAME_SINGULAR;
        } else {
            @rates
            @more
            status = (name_check_finite(rates, @nrates, NAME_OK) == NAME_OK) ? NAME_OK : NAME_SINGULAR;
        }
    }
    IF_OK {
        @store
    }
    return status;
}

