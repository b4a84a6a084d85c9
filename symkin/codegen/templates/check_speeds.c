/* The status of rates or of a twist: NONFINITE, or OUT_OF_RANGE for numbers whose products could overflow. */
static @{p}_status @{p}_check_speeds(const @{real} speeds[], int count, @{p}_status status)
{
    @{p}_status found = @{p}_check_finite(speeds, count, status);
    for (int i = 0; i < count; ++i) {
        if ((found == @{P}_OK) && (@{fabs}(speeds[i]) > @{fastest})) {
            found = @{P}_OUT_OF_RANGE;
        }
    }
    return found;
}

