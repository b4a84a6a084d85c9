/* @about */
name_status name_@function(GEOMETRY_GIVEN @at, const name_real @given[@taken], name_real @asked[@count])
{
    name_real @matrix[@nj];
    name_real result[@count];
    name_status status = name_check_sizes(@given, @taken, @least, @before);
    @then
    IF_OK {
        EACH(i, @count) {
            @body
        }
        @give
    }
    return status;
}

