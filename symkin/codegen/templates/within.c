/* Whether @what are within their @bounds@positive: NONFINITE comes before what was found so far, OUT_OF_RANGE after. */
static @{shared}name_status name_@check(GEOMETRY_GIVEN name_status before, JOINTS_GIVEN)
{
    name_status status = before;
@use
    if (!(@ranges)) {
        status = name_check_finite(joints, @nq, (before == NAME_OK) ? NAME_OUT_OF_RANGE : before);
    }
    return @checked;
}

