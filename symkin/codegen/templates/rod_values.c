/* Joint values at the state, into w->k. */
static NAME_SHARED void name_rod_values(GEOMETRY_GIVEN name_direct_work *w)
{
    @lines
}

