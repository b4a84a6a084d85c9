/* @about */
static void @columns(GEOMETRY_GIVEN const solver_work *w, @{given}name_real sides[@nsides])
{
    (void)w;
    @unused
@use
    @sides
}

