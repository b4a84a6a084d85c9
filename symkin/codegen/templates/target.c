/* Sets w->k, the known values aimed at@aimed. */
static NAME_SHARED void solver_set_target(@gp solver_work *w, const name_real to[@nto]@part)
{
@use
    @target
}

