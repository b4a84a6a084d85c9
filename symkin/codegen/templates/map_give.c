/* Copies results that are finite. */
static @{SHARED} @{p}_status @{p}_give(const @{real} *result, @{real} *given, int count)
{
    const @{p}_status status = (@{p}_check_finite(result, count, @{P}_OK) == @{P}_OK) ? @{P}_OK : @{P}_OUT_OF_RANGE;
    if (status == @{P}_OK) {
        for (int i = 0; i < count; ++i) {
            given[i] = result[i];
        }
    }
    return status;
}

