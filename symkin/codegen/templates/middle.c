/* Whether the middle of the part that is tried is reached as its end is: three steps from the part's begin with its factors, each
 * judged by the next. Where known values turn, the rows' change is bent: both ends of a part may have a configuration, and
 * points between them none. */
static NAME_COLD bool solver_reaches_middle(GEOMETRY_GIVEN solver_work *w, const name_real to[@nto], name_real middle, name_real still2)
{
    name_real end[@ns];
    name_real size[3];
    @aimed_at
    @to_begin
    solver_set_target(GEOMETRY w, to, middle);
    EACH(i, 3) {
        solver_rows(GEOMETRY w);
        size[i] = solver_step(GEOMETRY w);
    }
    @to_end
    return (size[2] <= still2) || ((size[1] <= @contraction2 * size[0]) && (size[2] <= @later2 * size[1]));
}

