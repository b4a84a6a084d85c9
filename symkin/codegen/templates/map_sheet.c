/* Whether known values are near those of the reference configuration, where polynomials, held against rays through it, come near
 * the wanted ones. */
static NAME_SHARED bool solver_near_home(const name_real values[@nto], name_real wanted[@count])
{
    @lines
    return @within;
}

