
/* Solves for the step and adds it to the state: lengths and joint values are added to, quaternions are turned. Returns the
 * squared length of the step, angles times the size. */
static name_real solver_step(GEOMETRY_GIVEN solver_work *w)
{
    name_real s[@n];
@use
    solver_solve(w, s);
    @move
    return @squared;
}

