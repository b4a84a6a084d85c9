/* Solves the limb for pose coordinates c, from the reference configuration along the line of poses to c. */
static name_status solver_follow_pose(GEOMETRY_GIVEN solver_work *w, const name_real c[@nc])
{
    USUAL_CONFIG
    /* state and pose of the reference configuration */
    @begin
    return solver_newton(GEOMETRY w, c, &usual, NULL);
}

