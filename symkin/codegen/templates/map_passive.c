/* Whether the joints that are neither given nor found are within their limits in a state w of known values. */
static NAME_SHARED name_status solver_check_passive(const solver_work *w, VALUES_GIVEN)
{
    name_status status = NAME_OK;
    (void)w;
    (void)@values;
    @lines
    return status;
}

