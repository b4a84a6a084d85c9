/* Sets w->k, the known values aimed at@aimed. */
static NAME_SHARED void solver_set_target(GEOMETRY_GIVEN solver_work *w, const name_real to[@nto]@part)
{
@use
    @target
}

