/* What the rows read of the known values: coefficients, by the numbers of these. */
static NAME_SHARED void solver_coefficients(const name_real numbers[@numbers], name_real k[@nk])
{
    @lines
}

