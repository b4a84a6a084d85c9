/* Whether @{what} are finite and within their @{ranges_word}: NONFINITE comes before what was found so far, OUT_OF_RANGE after. */
static name_status name_@{function}(name_status before, const name_real values[@{nq}])
{
    name_status status = before;
    if (!(@{within})) {
        status = name_check_finite(values, @{nq}, (before == NAME_OK) ? NAME_OUT_OF_RANGE : before);
    }
    return status;
}

