/* Copies results that are finite. */
static NAME_SHARED name_status name_give(const name_real *result, name_real *given, int count)
{
    const name_status status = (name_check_finite(result, count, NAME_OK) == NAME_OK) ? NAME_OK : NAME_OUT_OF_RANGE;
    IF_OK {
        COPY(given, result, count)
    }
    return status;
}

