/* @about */
static void @columns(@gp const solver_work *w, @{given}name_real sides[@nsides])
{
    (void)w;
    @unused
@use
    @sides
}

