/* @about */
name_status name_@function(const name_real joints[@nq], const name_real found[@nq], const name_real @given[@nq], name_real @asked[@count])
{
    name_real @matrix[@nj];
    name_status status = name_check_sizes(@given, @nq, @least, NAME_OK);
    IF_OK {
        status = name_@matrix(joints, found, @matrix);
    }
    IF_OK {
        name_real result[@count];
        EACH(i, @count) {
            @body
        }
        status = name_give(result, @asked, @count);
    }
    return status;
}

