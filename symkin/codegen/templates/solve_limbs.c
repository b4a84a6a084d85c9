/* Solves the limbs for pose coordinates: actuated and passive joints, on the branches of the reference configuration. */
static name_status name_solve_limbs(GEOMETRY_GIVEN const name_real c[@nc], name_real q[@nq], name_real passive[@np]@within)
{
    name_status status = NAME_OK;
    (void)passive;
@use
    @limbs
    return status;
}

