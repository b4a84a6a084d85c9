/* Writes the info of a call that takes no step: no number is known but which joint is the first that is outside its range or not
 * finite. */
static NAME_COLD void name_write_no_step(GEOMETRY_GIVEN name_info *info, JOINTS_GIVEN)
{
    NO_INFO
    BLAME(name_first_beyond(GEOMETRY joints))
}

