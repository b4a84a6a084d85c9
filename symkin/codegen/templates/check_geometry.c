/* NONFINITE where a number of the geometry is NaN or infinite, else `otherwise`. */
static name_status name_check_geometry(const name_geometry *geometry, name_status otherwise)
{
    const name_real values[@count] = {
        @members
    };
    return name_check_finite(values, @count, otherwise);
}

