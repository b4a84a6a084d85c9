/* Checks whether joint values are within their ranges@{positive}. */
static @{shared}name_status name_check_limits(@{gp}const name_real joints[@{nq}])
{
    name_status status = NAME_OK;
@{use}
    if (!(@{ranges})) {
        status = name_check_finite(joints, @{nq}, NAME_OUT_OF_RANGE);
    }
    return @{checked};
}

