/* Sets known values and state: @values as they are given, and @source. */
static NAME_SHARED void solver_place(solver_work *w, VALUES_GIVEN, const name_real @from[@nfrom])
{
    @lines
}

