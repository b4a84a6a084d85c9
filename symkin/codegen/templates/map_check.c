/* Whether @{what} are finite and within their @{ranges_word}: NONFINITE comes before what was found so far, OUT_OF_RANGE after. */
static @{p}_status @{p}_@{function}(@{p}_status before, const @{real} values[@{nq}])
{
    @{p}_status status = before;
    if (!(@{within})) {
        status = @{p}_check_finite(values, @{nq}, (before == @{P}_OK) ? @{P}_OUT_OF_RANGE : before);
    }
    return status;
}

