/* NONFINITE where a number of the geometry is NaN or infinite, OUT_OF_RANGE where one is beyond @largest@or_short, else `otherwise`. */
static name_status name_check_geometry(const name_geometry *geometry, name_status otherwise)
{
    const name_real values[@count] = {
        @members
    };
    name_status status = otherwise;
    EACH_WHILE(i, @count, (status == NAME_OK)) {
        status = (fabs(values[i]) <= @largest) ? NAME_OK : NAME_OUT_OF_RANGE;
    }
    @directed
    return name_check_finite(values, @count, status);
}

