/* Checks whether joint values are within their ranges@{positive}. */
static @{shared}@{p}_status @{p}_check_limits(@{gp}const @{real} joints[@{nq}])
{
    @{p}_status status = @{P}_OK;
@{use}
    if (!(@{ranges})) {
        status = @{p}_check_finite(joints, @{nq}, @{P}_OUT_OF_RANGE);
    }
    return @{checked};
}

