/* Brings joint values of the nearly equal arm, whose axes are parallel or meet as they should, to the tool pose x of this one by
 * Newton's method, near by. */
static name_status name_finish(const name_real x[7], name_real joints[@nn])
{
    OWN_WORK
    name_real residual;
    name_real size = 0.0;
    int turn = 1;
    COPY(w->x, joints, @nn)
    w->spread = 0.0;
    name_forward(w->x, w->at);
    solver_set_target(w, x, 1.0);
    solver_rows(w);
    residual = solver_residual(w);
    EACH_WHILE(step, @most_steps, (turn != 0) && (size <= @longest2) && (residual > NAME_TOLERANCE + @rounding)) {
        @factor
        if (turn != 0) {
            size = solver_step(w);
            solver_rows(w);
            residual = solver_residual(w);
        }
    }
    COPY(joints, w->x, @nn)
    return (residual <= NAME_TOLERANCE + @rounding) ? NAME_OK : ((turn == 0) ? NAME_SINGULAR : NAME_OUT_OF_RANGE);
}

/* Brings the joint values of a branch to where they are wanted: this arm's pose, whole turns, and their ranges. */
static name_status name_settle(const name_real x[7], ABOUT_AND_JOINTS)
{
    name_status status = name_finish(x, joints);
    IF_OK {
        status = name_turn_near(about, joints);
    }
    return status;
}
