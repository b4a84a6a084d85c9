/* Checks the answer in w->y, residual of all rows and sides of the limbs' dead centres, and writes its pose. *is_firm: whether it is so far
 * from folds and dead centres that rounding does not reach them. */
static name_status name_direct_answer(const name_direct_work *w, name_real tolerance, name_pose *pose, name_real *residual, bool *is_firm)
{
    name_status status = NAME_OK;
    @half_lines
    @residual_lines
    if (!(*residual <= tolerance + @rounding)) {
        status = NAME_SINGULAR;
    }
    @firm_lines
    @side_lines
    *is_firm = firm;
    if (status == NAME_OK) {
        @pose_lines
    }
    return status;
}

