
/* Whether joints that are not actuated @asked. */
static name_status name_check_passive(GEOMETRY_GIVEN const name_real c[@nc], const name_real q[@nq], const name_real passive[@np]@still)
{
    name_status status = NAME_OK;
    (void)c;
    (void)q;
    (void)passive;
@use
    @lines
    return status;
}
