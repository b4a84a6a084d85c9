/* The status of rates or of a twist: NONFINITE, or OUT_OF_RANGE for numbers whose products could overflow. */
static name_status name_check_speeds(const name_real speeds[], int count, name_status status)
{
    name_status found = name_check_finite(speeds, count, status);
    for (int i = 0; i < count; ++i) {
        if ((found == NAME_OK) && (@{fabs}(speeds[i]) > @{fastest})) {
            found = NAME_OUT_OF_RANGE;
        }
    }
    return found;
}

